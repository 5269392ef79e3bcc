//! The motion that a tile is made from.

use crate::patch::track::Track;
use std::collections::BTreeMap;
use throng_core::patch::Placement;
use throng_motion::clip::{ClipSet, FrameRange};

/// The motion that a tile is made from.
pub(in crate::patch) struct Source<'a> {
    /// Tracks of all clips.
    pub tracks: &'a [Track],
    /// Clips that are used, by number.
    pub clips: Vec<usize>,
    /// Copies of a rising tile that the clips were captured on: clip, and where it stands. Level ground has none: what
    /// was captured on it may be laid anywhere.
    pub copies: Vec<(usize, Placement)>,
    /// Frames a second (Hz).
    pub rate_hz: f32,
    by_group: BTreeMap<u32, Vec<(usize, usize)>>,
    tag_ranges: Vec<Vec<FrameRange>>,
}

impl<'a> Source<'a> {
    /// The motion of some clips, on copies of a tile.
    pub fn new(set: &ClipSet, tracks: &'a [Track], clips: Vec<usize>, copies: Vec<(usize, Placement)>) -> Self {
        let mut by_group = BTreeMap::<u32, Vec<(usize, usize)>>::new();
        for &c in &clips {
            for (f, &group) in tracks[c].groups.iter().enumerate().filter(|(f, _)| tracks[c].run_end[*f] > 0) {
                by_group.entry(group).or_default().push((c, f));
            }
        }
        let ranges = |c: &throng_motion::Clip| {
            let within = |t: &throng_motion::clip::Tag| t.range.start..t.range.end.min(c.num_frames());
            c.tags.iter().map(within).collect()
        };
        let rate_hz = clips.first().map_or(30.0, |&c| set.clips[c].rate_hz as f32);
        let tag_ranges = set.clips.iter().map(ranges).collect();
        Self { tracks, clips, copies, rate_hz, by_group, tag_ranges }
    }

    /// All usable frames of a pose group: clip and frame, in order.
    pub fn frames_in(&self, group: u32) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.by_group.get(&group).into_iter().flatten().copied()
    }

    /// What the tags of a clip cover.
    pub fn tag_ranges(&self, clip: usize) -> &[FrameRange] {
        &self.tag_ranges[clip]
    }

    /// How often somebody stands still.
    pub fn stops(&self) -> usize {
        self.clips.iter().map(|&c| self.tracks[c].standing.len()).sum()
    }

    /// Length of the motion (min).
    pub fn minutes(&self) -> f32 {
        let frames: usize = self.clips.iter().map(|&c| self.tracks[c].places.len()).sum();
        frames as f32 / self.rate_hz / 60.0
    }
}
