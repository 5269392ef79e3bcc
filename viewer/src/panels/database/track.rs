//! Data of a clip for a timeline: runs of frames and marks.

use super::list::states_within;
use crate::panels::glitches::{self, GlitchMark};
use crate::{bundle::OpenBundle, document::RawMotion};
use std::ops::Range;
use throng_core::Contacts;
use throng_precompute::{abilities::played_frames, clip};

/// The four parts of the feet, from the top lane to the bottom one.
pub const FEET: [(Contacts, &str); 4] = [
    (Contacts::LEFT_HEEL, "left heel"),
    (Contacts::LEFT_TOE, "left toe"),
    (Contacts::RIGHT_HEEL, "right heel"),
    (Contacts::RIGHT_TOE, "right toe"),
];

/// A named run of frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedRun {
    /// The name, or the reason.
    pub name: String,
    /// The frames.
    pub frames: Range<u32>,
    /// Lane in which it does not overlap another one.
    pub lane: usize,
}

/// A state of the motion graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateMark {
    /// Number of the state.
    pub state: u32,
    /// Frame of the state within the clip.
    pub frame: u32,
    /// The character stands.
    pub standing: bool,
}

/// Data of a clip for a timeline. Frames are numbered from the clip's start at the database rate.
#[derive(Clone, Debug, PartialEq)]
pub struct TimelineTrack {
    /// Name.
    pub name: String,
    /// File it came from.
    pub source: String,
    /// A copy with left and right exchanged.
    pub mirrored: bool,
    /// Frames a second (Hz).
    pub rate_hz: f32,
    /// Number of frames (> 0).
    pub num_frames: u32,
    /// Contacts of every frame.
    pub contacts: Vec<Contacts>,
    /// Runs of contact of each of [`FEET`].
    pub planted: [Vec<Range<u32>>; 4],
    /// Tags.
    pub tags: Vec<NamedRun>,
    /// Excluded runs with their reasons.
    pub excluded: Vec<NamedRun>,
    /// Glitches of the recording.
    pub glitches: Vec<GlitchMark>,
    /// Runs that the motion graph plays; none if there is no graph.
    pub played: Option<Vec<Range<u32>>>,
    /// States, ascending by frame.
    pub states: Vec<StateMark>,
}

impl TimelineTrack {
    /// A clip of a bundle.
    pub fn from_bundle(bundle: &OpenBundle, clip: usize) -> Option<Self> {
        let (record, meta) = bundle.clips().nth(clip)?;
        let rows = record.first_frame..record.first_frame + record.num_frames;
        let within = rows.start as usize..rows.end as usize;
        let mark = |state: usize| {
            let record = &bundle.tables().graph().states[state];
            let (frame, standing) = (record.frame - rows.start, record.standing != 0);
            StateMark { state: state as u32, frame, standing }
        };
        let played = played_frames(bundle.tables());
        let contacts = bundle.tables().contacts()[within.clone()].to_vec();
        Some(Self {
            name: meta.name.clone(),
            source: meta.source.clone(),
            mirrored: record.mirrored != 0,
            rate_hz: bundle.rate_hz(),
            num_frames: record.num_frames,
            planted: planted(&contacts),
            tags: in_lanes(meta.tags.iter().map(|t| (t.0.clone(), t.1..t.2)), record.num_frames),
            excluded: in_lanes(meta.excluded.iter().map(|e| (e.0.clone(), e.1..e.2)), record.num_frames),
            glitches: glitches::clip_glitches(meta),
            played: Some(runs(&played[within], |p| *p)),
            states: states_within(bundle, &rows).map(mark).collect(),
            contacts,
        })
    }

    /// The clip that a build would make of a motion file.
    pub fn from_raw(raw: &RawMotion) -> Option<Self> {
        let clip = raw.clips.clips.first().filter(|c| c.num_frames() > 0)?;
        let n = clip.num_frames() as u32;
        let range = |r: &Range<usize>| r.start as u32..r.end as u32;
        Some(Self {
            name: clip.name.clone(),
            source: clip.source.clone(),
            mirrored: clip.mirrored,
            rate_hz: clip.rate_hz as f32,
            num_frames: n,
            planted: planted(&clip.contacts),
            tags: in_lanes(clip.tags.iter().map(|t| (t.name.clone(), range(&t.range))), n),
            excluded: in_lanes(clip.excluded.iter().map(|e| (e.reason.to_string(), range(&e.range))), n),
            glitches: glitches::raw_glitches(raw).into_iter().map(|m| glitch_at_clip_rate(m, raw)).collect(),
            played: None,
            states: Vec::new(),
            contacts: clip.contacts.clone(),
        })
    }

    /// Length (s).
    pub fn duration_s(&self) -> f64 {
        f64::from(self.num_frames) / f64::from(self.rate_hz)
    }

    /// The state of a frame, or the next one after it.
    pub fn state_from(&self, frame: u32) -> Option<StateMark> {
        self.states.get(self.states.partition_point(|s| s.frame < frame)).copied()
    }

    /// Lanes that tags need.
    pub fn tag_lanes(&self) -> usize {
        self.tags.iter().map(|t| t.lane + 1).max().unwrap_or(0)
    }
}

/// A glitch of a motion file, in frames of the clip that a build would make of it.
fn glitch_at_clip_rate(mark: GlitchMark, raw: &RawMotion) -> GlitchMark {
    let [first, last] = [mark.frames.start, mark.frames.end.saturating_sub(1)].map(|f| raw.clip_frame(f as f32) as u32);
    GlitchMark { frames: first..last + 1, ..mark }
}

fn planted(contacts: &[Contacts]) -> [Vec<Range<u32>>; 4] {
    FEET.map(|(part, _)| runs(contacts, |c| c.any(part)))
}

/// The longest runs of items for which `holds` is true, in order.
fn runs<T>(items: &[T], holds: impl Fn(&T) -> bool) -> Vec<Range<u32>> {
    let runs = clip::runs_where(0..items.len(), |i| holds(&items[i]));
    runs.into_iter().map(|r| r.start as u32..r.end as u32).collect()
}

/// Sorts runs by their start and lays each into the first lane that is free.
fn in_lanes(runs: impl Iterator<Item = (String, Range<u32>)>, num_frames: u32) -> Vec<NamedRun> {
    let mut out: Vec<NamedRun> = runs
        .map(|(name, r)| NamedRun { name, frames: r.start.min(num_frames)..r.end.min(num_frames), lane: 0 })
        .filter(|n| !n.frames.is_empty())
        .collect();
    out.sort_by(|a, b| (a.frames.start, a.frames.end, &a.name).cmp(&(b.frames.start, b.frames.end, &b.name)));
    let mut ends: Vec<u32> = Vec::new();
    for named in &mut out {
        named.lane = ends.iter().position(|e| *e <= named.frames.start).unwrap_or(ends.len());
        ends.resize(ends.len().max(named.lane + 1), 0);
        ends[named.lane] = named.frames.end;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::golden;

    #[test]
    fn runs_are_the_longest_ones() {
        assert_eq!(runs(&[1, 1, 0, 1, 0, 0, 1], |v| *v == 1), [0..2, 3..4, 6..7]);
        assert_eq!(runs(&[0; 4], |v| *v == 1), []);
    }

    #[test]
    fn overlapping_names_get_lanes_of_their_own() {
        let named = in_lanes(
            [("a", 0..10), ("b", 5..8), ("c", 8..99), ("d", 50..60)].map(|(n, r)| (n.into(), r)).into_iter(),
            20,
        );
        let got: Vec<_> = named.iter().map(|n| (n.name.as_str(), n.frames.clone(), n.lane)).collect();
        assert_eq!(got, [("a", 0..10, 0), ("b", 5..8, 1), ("c", 8..20, 1)]);
    }

    #[test]
    fn contacts_and_states_of_the_track_are_those_of_the_tables() {
        let bundle = golden();
        let tables = bundle.tables();
        for (i, record) in tables.clips().iter().enumerate() {
            let track = TimelineTrack::from_bundle(&bundle, i).unwrap();
            for f in 0..track.num_frames {
                let row = record.first_frame + f;
                for ((part, _), runs) in FEET.iter().zip(&track.planted) {
                    let planted = tables.contacts()[row as usize].any(*part);
                    assert_eq!(runs.iter().any(|r| r.contains(&f)), planted);
                }
                let expected = tables.graph().states.iter().position(|s| s.frame >= row);
                let expected =
                    expected.filter(|s| tables.graph().states[*s].frame < record.first_frame + track.num_frames);
                assert_eq!(track.state_from(f).map(|s| s.state as usize), expected);
            }
        }
        assert_eq!(TimelineTrack::from_bundle(&bundle, tables.clips().len()), None);
    }
}
