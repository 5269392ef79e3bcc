//! Per-frame data of a clip for embedding: root, pose group, standing.

use crate::{cluster::PoseGroups, stages::stage_error};
use std::collections::BTreeMap;
use throng_base::thresholds::STANDING_MPS;
use throng_core::{NUM_JOINTS, Planar, patch::Placement, planar::wrap_angle};
use throng_motion::{Clip, ClipSet, FrameId, FrameRange, Result, runs_where};

/// Largest speed of a standing joint (rad/s).
const STANDING_RADPS: f32 = 1.0;
/// Most names of tags of a clip set, as links store 15 bits.
const MOST_TAGS: usize = 1000;
/// Shortest stand (frames).
const STANDING_FRAMES: usize = 10;

/// One clip, ready to be embedded in patches.
pub(super) struct PatchTrack {
    /// Frame row of the first frame.
    pub first_row: u32,
    /// Planar roots; headings count full turns (num_frames).
    pub places: Vec<Planar>,
    /// Distance that the root has travelled since the first frame (m, num_frames).
    pub travelled: Vec<f32>,
    /// Height of the support (m, num_frames).
    pub support: Vec<f32>,
    /// Pose groups; [`PoseGroups::NO_GROUP`] for excluded frames (num_frames).
    pub groups: Vec<u32>,
    /// End of the run of usable frames of each frame; 0 for excluded frames (num_frames).
    pub run_end: Vec<usize>,
    /// Runs of frames in which the character stands still.
    pub standing: Vec<FrameRange>,
    /// Number of standing frames before each frame (num_frames + 1).
    pub stood: Vec<u32>,
    /// For each tag of the clip set, the number of frames before each frame that carry it; empty if the clip has none
    /// of it.
    pub tagged: Vec<Vec<u32>>,
}

impl PatchTrack {
    /// Tracks of all clips, and the names of all tags, rarest first, as it says most.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Stage`] for clips with too many tags.
    pub fn new_all(clips: &ClipSet, groups: &PoseGroups) -> Result<(Vec<Self>, Vec<String>)> {
        let mut frames: BTreeMap<&str, usize> = BTreeMap::new();
        for tag in clips.clips.iter().flat_map(|c| &c.tags) {
            *frames.entry(&tag.name).or_default() += tag.range.len();
        }
        let mut tags: Vec<String> = frames.keys().map(|name| (*name).to_owned()).collect();
        tags.sort_by_key(|name| frames[name.as_str()]);
        if tags.len() > MOST_TAGS {
            let (count, one) = (tags.len(), &tags[0]);
            let message = format!("the clips have {count} tags, such as `{one}`; expected {MOST_TAGS} at most");
            return Err(stage_error("patch", message, "Give the same name to what is the same in their sidecar files"));
        }
        let tracks = clips.clips.iter().zip(clips.frame_starts());
        Ok((tracks.map(|(c, first_row)| Self::new(c, first_row, groups, &tags)).collect(), tags))
    }

    fn new(clip: &Clip, first_row: u32, groups: &PoseGroups, tags: &[String]) -> Self {
        let places = unwrap_angles(clip);
        let mut travelled = vec![0.0; places.len()];
        for f in 1..places.len() {
            let (a, b) = (places[f - 1], places[f]);
            travelled[f] = travelled[f - 1] + (b.x - a.x).hypot(b.z - a.z);
        }
        let group = |f| groups.group_of(FrameId(first_row + f as u32)).unwrap_or(PoseGroups::NO_GROUP);
        let mut run_end = vec![0; places.len()];
        for run in clip.usable_ranges() {
            run_end[run.clone()].fill(run.end);
        }
        let standing = standing_ranges(clip, &places);
        let stood = prefix_counts(places.len(), &standing);
        let tagged = tags.iter().map(|name| tag_ranges(clip, name)).collect();
        Self {
            first_row,
            travelled,
            support: if clip.support.is_empty() { vec![0.0; places.len()] } else { clip.support.clone() },
            groups: (0..places.len()).map(group).collect(),
            places,
            run_end,
            standing,
            stood,
            tagged,
        }
    }

    /// Root at a frame, at the height of the support.
    pub fn footing(&self, frame: usize) -> Placement {
        Placement::from_planar(self.places[frame], self.support[frame])
    }

    /// Tag carried by most of the frames `range`, on a tie the rarest, as 1 + its number; 0 if no tag covers more than
    /// half.
    pub fn tag_of(&self, range: &FrameRange) -> u16 {
        let covered = |counts: &[u32]| counts.get(range.end).map_or(0, |end| end - counts[range.start]) as usize;
        let best =
            (0..self.tagged.len()).map(|t| (covered(&self.tagged[t]), t)).max_by_key(|&(n, t)| (n, usize::MAX - t));
        best.filter(|&(n, _)| 2 * n > range.len()).map_or(0, |(_, t)| t as u16 + 1)
    }
}

/// Planar roots with unwrapped headings.
fn unwrap_angles(clip: &Clip) -> Vec<Planar> {
    let mut out: Vec<Planar> = Vec::with_capacity(clip.num_frames());
    for f in 0..clip.num_frames() {
        let mut place = clip.planar(f);
        if let Some(before) = out.last() {
            place.heading = before.heading + wrap_angle(place.heading - before.heading);
        }
        out.push(place);
    }
    out
}

/// Runs in which neither the root nor any joint moves much.
fn standing_ranges(clip: &Clip, places: &[Planar]) -> Vec<FrameRange> {
    let usable = clip.usable_ranges().into_iter().filter(|r| r.len() > 1);
    let found = usable.flat_map(|r| runs_where(r, |f| is_slow(clip, places, f)));
    found.filter(|r| r.len() >= STANDING_FRAMES).collect()
}

/// True if neither the root nor any joint moves much from the frame before.
pub(super) fn is_slow(clip: &Clip, places: &[Planar], frame: usize) -> bool {
    let (rate, g) = (clip.rate_hz as f32, frame.max(1));
    let (a, b) = (places[g - 1], places[g]);
    let speed = (b.x - a.x).hypot(b.z - a.z) * rate;
    let (before, after) = (clip.frame_rotations(g - 1), clip.frame_rotations(g));
    let turning = |j: usize| before[j].angle_between(after[j]) * rate;
    speed < STANDING_MPS && (0..NUM_JOINTS).all(|j| turning(j) < STANDING_RADPS)
}

/// Number of frames before each frame that lie in one of the ranges (len + 1).
fn prefix_counts(len: usize, ranges: &[FrameRange]) -> Vec<u32> {
    let mut within = vec![0u32; len + 1];
    for r in ranges {
        within[r.start + 1..=r.end].fill(1);
    }
    for f in 1..=len {
        within[f] += within[f - 1];
    }
    within
}

fn tag_ranges(clip: &Clip, name: &str) -> Vec<u32> {
    let len = clip.num_frames();
    let of = clip.tags.iter().filter(|t| t.name == name);
    let ranges: Vec<_> = of.map(|t| t.range.start.min(len)..t.range.end.min(len)).filter(|r| !r.is_empty()).collect();
    if ranges.is_empty() { Vec::new() } else { prefix_counts(len, &ranges) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};
    use throng_core::Skeleton;
    use throng_motion::clip::ClipTag;

    #[test]
    fn a_run_of_frames_has_the_tag_that_says_most_about_it() {
        let tag = |name: &str, range| ClipTag { name: name.into(), range };
        let clip = Clip {
            source: "one".into(),
            tags: vec![tag("sit", 10..80), tag("slide", 30..60)],
            ..Clip::new("one", 30.0, vec![Vec3::Y; 100], vec![Quat::IDENTITY; 100 * NUM_JOINTS])
        };
        let clips = ClipSet {
            skeleton: Skeleton { offsets: [Vec3::ZERO; NUM_JOINTS], tips: [Vec3::ZERO; 3] },
            clips: vec![clip],
        };
        let groups = PoseGroups { groups: vec![0; 100], ..PoseGroups::default() };
        let (tracks, tags) = PatchTrack::new_all(&clips, &groups).unwrap();
        assert_eq!(tags, ["slide", "sit"]);
        let named = |range| match tracks[0].tag_of(&range) {
            0 => "",
            n => tags[usize::from(n) - 1].as_str(),
        };
        assert_eq!(named(0..20), "");
        assert_eq!(named(12..28), "sit");
        // Both cover all of it, and sliding is the rarer.
        assert_eq!(named(32..52), "slide");
        assert_eq!(named(50..78), "sit");
    }

    #[test]
    fn clips_of_too_many_tags_are_refused() {
        let clip = Clip::new("one", 30.0, vec![Vec3::Y; 2], vec![Quat::IDENTITY; 2 * NUM_JOINTS]);
        let skeleton = Skeleton { offsets: [Vec3::ZERO; NUM_JOINTS], tips: [Vec3::ZERO; 3] };
        let groups = PoseGroups { groups: vec![0; 2], ..PoseGroups::default() };
        let with = |n: usize| {
            let tags = (0..n).map(|k| ClipTag { name: format!("t{k}"), range: 0..2 }).collect();
            PatchTrack::new_all(
                &ClipSet { skeleton: skeleton.clone(), clips: vec![Clip { tags, ..clip.clone() }] },
                &groups,
            )
        };
        assert!(with(MOST_TAGS).is_ok());
        let e = with(MOST_TAGS + 1).err().unwrap().to_string();
        assert!(e.contains("1001 tags, such as `t0`; expected 1000 at most"), "{e}");
    }
}
