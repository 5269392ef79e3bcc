//! Views of a bundle that a step reads, checked once.

use super::idle::{PathsToStand, TurnToStand, find_turns};
use super::{answer::StandEntries, manner::Gaits, manner::Manners};
use crate::body::{ClipRows, FramePosition, LaneBody, WINDOW, sample_number};
use crate::format::{ClipRecord, FrameRow, RotationCode, Table};
use crate::skeleton::{Joint, Skeleton};
use crate::{bundle::Bundle, contacts::Contacts, hits::HitRecord, planar::Planar, stops::StopTables};
use crate::{graph::MotionGraph, policy::PolicyTable};

use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use std::sync::Arc;
use throng_base::maths;

/// Everything of a bundle that characters need to move. Owned: it keeps the bundle's file open; clones are cheap.
///
/// ```no_run
/// use throng_core::Bundle;
/// use throng_core::characters::MotionSet;
///
/// let motion_set = MotionSet::new(&Bundle::open("people.throng")?);
/// let (policies, states) = (motion_set.num_policies(), motion_set.graph().states.len());
/// println!("{policies} behaviours in {states} states; the first frame is at {:?}", motion_set.planar_root(0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MotionSet {
    /// Frames of the bundle, padded with zeros to a window's length.
    pub(crate) frames: Table<FrameRow>,
    pub(crate) rotation_code: Arc<RotationCode>,
    pub(crate) contacts: Table<Contacts>,
    pub(crate) clips: Table<ClipRecord>,
    /// Frames that the clip has after each, 255 where there are more (frames).
    frames_after: Arc<[u8]>,
    pub(crate) hits: Table<HitRecord>,
    /// First hit of each segment, and the hit after its last (number of segments).
    segment_hits: Table<[u32; 2]>,
    pub(crate) graph: MotionGraph,
    pub(crate) stops: StopTables,
    /// The stand to which each segment leads as its clip goes on (number of segments).
    pub(super) turns: Arc<[TurnToStand]>,
    pub(super) paths_to_stand: Arc<PathsToStand>,
    /// Frames at which characters leave what they play when they are ordered to stand.
    pub(super) entries: Arc<StandEntries>,
    pub(super) manners: Arc<Manners>,
    pub(super) gaits: Arc<Gaits>,
    pub(crate) policies: Arc<[PolicyTable]>,
    pub(crate) skeleton: Skeleton,
    /// The skeleton, in all lanes.
    pub(crate) body: Arc<LaneBody>,
    /// What layers may show.
    pub(crate) rows: ClipRows,
    /// Bundle that all views are taken from.
    pub(crate) bundle: Bundle,
    /// Frames a second (Hz).
    pub rate_hz: f32,
}

impl MotionSet {
    /// Takes the needed views of an open bundle.
    pub fn new(tables: &Bundle) -> Self {
        let rate_hz = tables.meta().rate_hz as f32;
        let (turns, manners) = (find_turns(tables.graph(), rate_hz), Manners::find(tables));
        let mut out = Self {
            frames: ensure_length(tables.frames(), WINDOW),
            rotation_code: Arc::new(*tables.rotation_code()),
            contacts: tables.contacts().clone(),
            clips: tables.clips().clone(),
            frames_after: count_frames_after(tables.clips(), tables.frames().len()),
            hits: tables.hits().clone(),
            segment_hits: segment_hits(tables.graph(), tables.hits()).into(),
            graph: tables.graph().clone(),
            stops: tables.stops().clone(),
            paths_to_stand: PathsToStand::find(tables.graph(), &manners, &turns, rate_hz).into(),
            turns: turns.into(),
            entries: Arc::default(),
            gaits: Gaits::find(tables, &manners).into(),
            manners: manners.into(),
            policies: tables.policies().clone(),
            skeleton: tables.skeleton().clone(),
            body: Arc::new(LaneBody::from_skeleton(tables.skeleton())),
            rows: tables.clip_rows(),
            bundle: tables.clone(),
            rate_hz,
        };
        out.entries = StandEntries::find(&out).into();
        out
    }

    /// Number of frames that the bundle has: [`MotionSet::frames`] may have more rows.
    pub(crate) fn num_frames(&self) -> usize {
        self.contacts.len()
    }

    /// Planted parts of the frame that is nearest to a time after a row (frames, within one clip).
    pub fn contacts_at(&self, first: u32, frames: f32) -> Contacts {
        let row = first as usize + (frames.max(0.0) + 0.5) as usize;
        self.contacts.get(row).copied().unwrap_or(Contacts::NONE)
    }

    /// Number of policies; an [`super::PolicyOrder`] names one of them.
    pub fn num_policies(&self) -> usize {
        self.policies.len()
    }

    /// A policy, by number.
    pub fn policy(&self, index: usize) -> Option<&PolicyTable> {
        self.policies.get(index)
    }

    /// Names of the manners that orders may have; none where all motion is alike.
    pub fn manners(&self) -> impl Iterator<Item = &str> {
        self.manners.known()
    }

    /// The motion graph.
    pub fn graph(&self) -> &MotionGraph {
        &self.graph
    }

    /// Effective hits, ascending by frame; a [`super::Blow`] names one of them.
    pub fn hits(&self) -> &[HitRecord] {
        &self.hits
    }

    /// Numbers of the hits that a segment passes: those on its start belong to the segment before.
    /// (segment < number of segments)
    pub fn hits_of(&self, segment: u32) -> std::ops::Range<u32> {
        let [first, end] = self.segment_hits[segment as usize];
        first..end
    }

    /// Hits of a segment after a time since its start (frames).
    pub(crate) fn hits_after(&self, segment: u32, time: f32) -> std::ops::Range<u32> {
        let (start, all) = (self.graph.segments[segment as usize].start, self.hits_of(segment));
        let hits = &self.hits[all.start as usize..all.end as usize];
        all.start + hits.partition_point(|h| (h.frame - start) as f32 <= time) as u32..all.end
    }

    /// The skeleton of all characters.
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// Number of the clip that a frame belongs to (frame < number of frames).
    pub(crate) fn clip_of(&self, frame: u32) -> usize {
        self.clips.partition_point(|c| c.first_frame <= frame) - 1
    }

    /// Ankles in a frame, as seen from its planar root.
    pub(super) fn ankles(&self, frame: u32) -> [Vec2; 2] {
        let root = self.planar_root(frame);
        [Joint::LeftFoot, Joint::RightFoot].map(|j| {
            let at = self.joint_point(frame, j, Vec3::ZERO);
            root.inverse_transform_point(Vec2::new(at.x, at.z))
        })
    }

    /// Position of a point of a joint in a frame, within its clip (m).
    ///
    /// - `offset`: of the point, in the joint's own frame (m).
    pub fn joint_point(&self, frame: u32, joint: Joint, offset: Vec3) -> Vec3 {
        let row = &self.frames[frame as usize];
        let (mut at, mut point) = (joint, offset);
        while let Some(parent) = at.parent() {
            point =
                maths::rotate(self.rotation_code.rotation(row, at.index()), point) + self.skeleton.offsets[at.index()];
            at = parent;
        }
        let point =
            maths::rotate(self.rotation_code.rotation(row, at.index()), point) + Vec3::new(0.0, row.height, 0.0);
        let root = self.planar_root(frame);
        maths::rotate(root.rotation(), point) + root.translation()
    }

    /// A place between a frame and the next one.
    ///
    /// - `is_within`: both have neighbours in their clip; otherwise it is looked up.
    #[inline]
    pub(crate) fn frame_position(&self, frame: u32, ratio: f32, is_within: bool) -> FramePosition {
        let has = if is_within { [true; 2] } else { self.has_neighbours(frame) };
        FramePosition { frame: frame as usize, ratio, has }
    }

    /// Whether the clip has a frame before one, and one after the next.
    #[inline]
    fn has_neighbours(&self, frame: u32) -> [bool; 2] {
        let goes_on = |at: usize| self.frames_after.get(at).is_some_and(|&left| left > 0);
        [frame > 0 && goes_on(frame as usize - 1), goes_on(frame as usize + 1)]
    }

    /// Frames that the clip has after one, 255 where there are more; 0 for a frame that there is not.
    #[inline]
    pub(crate) fn frames_after(&self, frame: u32) -> u32 {
        self.frames_after.get(frame as usize).copied().unwrap_or(0).into()
    }

    /// The frames before and after one in its clip; the frame itself where there is none.
    pub(crate) fn adjacent_frames(&self, frame: u32) -> [u32; 2] {
        let has_before = frame > 0 && self.frames_after[frame as usize - 1] > 0;
        [frame - u32::from(has_before), frame + u32::from(self.frames_after[frame as usize] > 0)]
    }

    /// Planar root within its clip, some frames after one; the last frame is not passed.
    pub fn planar_at(&self, first: u32, frames: f32) -> Planar {
        let whole = frames.max(0.0) as u32;
        let share = frames - whole as f32;
        if share <= 0.0 {
            return self.planar_root(first + whole);
        }
        let spot = self.frame_position(first + whole, share, false);
        let of = |k: usize| sample_number(spot, self.frames.len(), |row| self.frames[row].planar[k]);
        Planar::new(of(0), of(1), of(2))
    }

    /// Planar root of a frame within its clip.
    pub fn planar_root(&self, frame: u32) -> Planar {
        let [x, z, heading] = self.frames[frame as usize].planar;
        Planar::new(x, z, heading)
    }
}

/// Frames that its clip has after each frame, at most 255.
fn count_frames_after(clips: &[ClipRecord], num_frames: usize) -> Arc<[u8]> {
    let mut out = vec![u8::MAX; num_frames];
    for clip in clips {
        for k in 0..clip.num_frames {
            out[(clip.first_frame + k) as usize] = (clip.num_frames - 1 - k).min(255) as u8;
        }
    }
    out.into()
}

/// The rows of a database, or so many where it has fewer: poses are made of a window of rows.
fn ensure_length(frames: &Table<FrameRow>, num: usize) -> Table<FrameRow> {
    if frames.len() >= num {
        return frames.clone();
    }
    let mut rows = frames.to_vec();
    rows.resize(num, FrameRow::zeroed());
    rows.into()
}

/// The hits in `(start, start + num_frames]` of every segment.
fn segment_hits(graph: &MotionGraph, hits: &[HitRecord]) -> Vec<[u32; 2]> {
    let up_to = |frame: u32| hits.partition_point(|h| h.frame <= frame) as u32;
    graph.segments.iter().map(|s| [up_to(s.start), up_to(s.start + s.num_frames)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Mat3x4;
    use crate::characters::block::{BodyBlock, MotionBlock};
    use crate::characters::tests::tables;
    use crate::characters::{Characters, CharactersConfig, SampleJob, ScheduledClip};
    use crate::skeleton::NUM_JOINTS;

    #[test]
    fn rows_that_only_fill_a_window_are_no_frames() {
        let whole = MotionSet::new(&tables());
        let clips = Table::from(vec![ClipRecord { num_frames: 3, ..whole.clips[0] }]);
        let r = MotionSet {
            frames: ensure_length(&whole.frames.part(0..3).unwrap(), WINDOW),
            contacts: whole.contacts.part(0..3).unwrap(),
            frames_after: count_frames_after(&clips, 3),
            clips,
            ..whole
        };
        let clip = |num_frames| [ScheduledClip { num_frames, ..ScheduledClip::default() }];
        assert!(Characters::new_scheduled(&r, CharactersConfig::default(), &clip(3)).is_err());
        let mut scheduled = Characters::new_scheduled(&r, CharactersConfig::default(), &clip(2)).unwrap();
        scheduled.step(&r, 1.0, &[]).unwrap();
        let kept = scheduled.snapshot();
        scheduled.restore(&r, &kept).unwrap();
        let bad: [fn(&mut MotionBlock, &mut BodyBlock); 2] = [|b, _| b.length[0] = 3, |b, _| b.change = [[3; 8]; 2]];
        for spoil in bad {
            let mut kept = kept.clone();
            kept.spoil_first_block(spoil);
            assert!(scheduled.restore(&r, &kept).is_err());
        }
        let sample = |frame| {
            let matrices = &mut [Mat3x4::default(); NUM_JOINTS];
            SampleJob { motion_set: &r, frames: &[frame], ratios: &[0.0], matrices }.run()
        };
        assert!(sample(2).is_ok() && sample(3).is_err());
    }
}
