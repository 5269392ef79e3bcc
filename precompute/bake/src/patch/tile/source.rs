//! Source motion of a tile.

use crate::patch::track::PatchTrack;
use std::collections::BTreeMap;
use throng_base::maths::quantile;
use throng_core::patch::Placement;
use throng_motion::clip::{ClipSet, FrameRange};

/// Height of the hips, as a share of the usual one, below which a body sits or lies.
const SEATED: f32 = 0.85;

/// Source motion of a tile.
pub(in crate::patch) struct TileSource<'a> {
    /// Tracks of all clips.
    pub tracks: &'a [PatchTrack],
    /// Clips that are used, by number.
    pub clips: Vec<usize>,
    /// Copies of a rising tile that the clips were captured on: clip and placement. Level ground has none: motion
    /// captured on it may be placed anywhere.
    pub copies: Vec<(usize, Placement)>,
    /// Frame rate (Hz).
    pub rate_hz: f32,
    /// For each clip and frame, the end of its run of usable frames; 0 outside.
    run_end: Vec<Vec<usize>>,
    by_group: BTreeMap<u32, Vec<(usize, usize)>>,
    tag_ranges: Vec<Vec<FrameRange>>,
}

impl<'a> TileSource<'a> {
    /// The motion of some clips, on copies of a tile.
    pub fn new(set: &ClipSet, tracks: &'a [PatchTrack], clips: Vec<usize>, copies: Vec<(usize, Placement)>) -> Self {
        let mut run_end: Vec<Vec<usize>> = tracks.iter().map(|t| t.run_end.clone()).collect();
        if copies.is_empty() {
            leave_out_seats(set, tracks, &clips, &mut run_end);
        }
        let mut by_group = BTreeMap::<u32, Vec<(usize, usize)>>::new();
        for &c in &clips {
            for (f, &group) in tracks[c].groups.iter().enumerate().filter(|(f, _)| run_end[c][*f] > 0) {
                by_group.entry(group).or_default().push((c, f));
            }
        }
        let ranges = |c: &throng_motion::Clip| {
            let within = |t: &throng_motion::clip::ClipTag| t.range.start..t.range.end.min(c.num_frames());
            c.tags.iter().map(within).collect()
        };
        let rate_hz = clips.first().map_or(30.0, |&c| set.clips[c].rate_hz as f32);
        let tag_ranges = set.clips.iter().map(ranges).collect();
        Self { tracks, clips, copies, rate_hz, run_end, by_group, tag_ranges }
    }

    /// End of the run of usable frames of a frame; 0 outside.
    pub fn run_end(&self, clip: usize, frame: usize) -> usize {
        self.run_end[clip][frame]
    }

    /// All usable frames of a pose group: clip and frame, in order.
    pub fn frames_in(&self, group: u32) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.by_group.get(&group).into_iter().flatten().copied()
    }

    /// Ranges of a clip that tags cover.
    pub fn tag_ranges(&self, clip: usize) -> &[FrameRange] {
        &self.tag_ranges[clip]
    }

    /// Number of stops.
    pub fn stops(&self) -> usize {
        self.clips.iter().map(|&c| self.tracks[c].standing.len()).sum()
    }

    /// Duration of the motion (min).
    pub fn minutes(&self) -> f32 {
        let frames: usize = self.clips.iter().map(|&c| self.tracks[c].places.len()).sum();
        frames as f32 / self.rate_hz / 60.0
    }
}

/// Removes frames of sitting on a missing seat from runs: low, and still.
fn leave_out_seats(set: &ClipSet, tracks: &[PatchTrack], clips: &[usize], run_end: &mut [Vec<usize>]) {
    let height = |c: usize, f: usize| set.clips[c].root_positions[f].y - tracks[c].support[f];
    let all = clips.iter().flat_map(|&c| (0..run_end[c].len()).map(move |f| (c, f)));
    let Some(usual) = quantile(all.map(|(c, f)| height(c, f)), [1, 2]) else { return };
    for &c in clips {
        let mut end = 0;
        for f in (0..run_end[c].len()).rev() {
            let run = run_end[c][f];
            end = match (run, f + 1 == run) {
                (0, _) => 0,
                _ if tracks[c].is_standing(f) && height(c, f) < SEATED * usual => 0,
                (_, true) => run,
                _ if end == 0 => f + 1,
                _ => end,
            };
            run_end[c][f] = end;
        }
    }
}
