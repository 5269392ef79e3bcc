//! Report of the graph stage, for people and for machines.

use super::{MotionApart, MotionLeftOut, RawMotionGraph};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_motion::annotate::classes::named_manner;
use throng_motion::clip::{ClipSet, FrameId};

/// Least, mean and largest of some values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MinMeanMax {
    /// The least.
    pub min: f64,
    /// The mean.
    pub mean: f64,
    /// The largest.
    pub max: f64,
}

impl MinMeanMax {
    /// Computed from values; all 0 if there are none.
    pub fn from_values(values: impl IntoIterator<Item = f64>) -> Self {
        let (mut n, mut sum, mut min, mut max) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
        for v in values {
            (n, sum, min, max) = (n + 1.0, sum + v, v.min(min), v.max(max));
        }
        if n == 0.0 { Self::default() } else { Self { min, mean: sum / n, max } }
    }
}

/// Figures of [`super::connect`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct GraphReport {
    /// Usable frames of all clips.
    pub frames_in: usize,
    /// Frames that some action plays.
    pub frames_kept: usize,
    /// Frames at which a transition might leave or enter.
    pub event_frames: usize,
    /// States.
    pub states: usize,
    /// States in which a character may stand for long.
    pub standing_states: usize,
    /// Actions of all states.
    pub actions: usize,
    /// Segments that actions play.
    pub segments: usize,
    /// Distance up to which frames match, the largest of all manners; some transitions are farther, as
    /// `MotionGraphConfig::max_error` explains (rad).
    pub threshold: f64,
    /// Distances of the transitions; natural continuations do not count (rad).
    pub transition_error: MinMeanMax,
    /// Actions of a state.
    pub branching: MinMeanMax,
    /// Duration of the segments (s).
    pub segment_s: MinMeanMax,
    /// Clips without a played frame.
    pub unused_clips: Vec<String>,
    /// Motion of classes that the graph does not take.
    pub left_out: Vec<MotionLeftOut>,
    /// Motion that the graph takes and that no action plays, a second or longer, with the reasons.
    pub apart: Vec<MotionApart>,
    /// Manners that transitions beyond `graph.max_error` join, as they would be lost else, each with the farthest one (rad).
    pub joined: BTreeMap<String, f64>,
    /// Neutral and all upright standing, where so little of it is neutral that gestures are taken as well (s).
    pub scarce_neutral_s: Option<[f64; 2]>,
    /// Upright motion with a load and all that goes, where so much of it carries one that it is taken as well (s).
    pub mostly_carrying_s: Option<[f64; 2]>,
    /// Manners with too little motion to go and stand in them alone: people come to them and leave them unasked. Empty for
    /// motion of no manner.
    pub thin_manners: Vec<String>,
}

/// True for every frame that some action plays (clips.num_frames()).
pub(crate) fn played_frames(graph: &RawMotionGraph, clips: &ClipSet) -> Vec<bool> {
    let mut played = vec![false; clips.num_frames()];
    for s in &graph.segments {
        let first = s.start.0 as usize + 1;
        played[first..first + s.num_frames as usize].fill(true);
    }
    played
}

/// Measures a graph.
pub(super) fn report(graph: &RawMotionGraph, clips: &ClipSet, event_frames: usize, threshold: f32) -> GraphReport {
    let played = played_frames(graph, clips);
    let starts = clips.frame_starts();
    let clip_frames = |c: usize| &played[starts[c] as usize..starts[c + 1] as usize];
    let unused = |c: &usize| !clip_frames(*c).contains(&true);
    let rate_hz = clips.clips.first().map_or(1.0, |c| c.rate_hz);
    GraphReport {
        frames_in: clips.clips.iter().flat_map(|c| c.usable_ranges()).map(|r| r.len()).sum(),
        frames_kept: played.iter().filter(|p| **p).count(),
        event_frames,
        states: graph.states.len(),
        standing_states: graph.standing.iter().filter(|s| **s).count(),
        actions: graph.actions.len(),
        segments: graph.segments.len(),
        threshold: f64::from(threshold),
        transition_error: MinMeanMax::from_values(transition_errors(graph).map(f64::from)),
        branching: MinMeanMax::from_values(graph.action_offsets.windows(2).map(|w| f64::from(w[1] - w[0]))),
        segment_s: MinMeanMax::from_values(graph.segments.iter().map(|s| f64::from(s.num_frames) / rate_hz)),
        unused_clips: (0..clips.clips.len()).filter(unused).map(|c| clips.clips[c].name.clone()).collect(),
        left_out: Vec::new(),
        apart: Vec::new(),
        joined: BTreeMap::new(),
        scarce_neutral_s: None,
        mostly_carrying_s: None,
        thin_manners: graph.manners.thin.clone(),
    }
}

/// Manners to or from which transitions are farther than a limit, with the farthest of each; of two manners, both where
/// neither is the usual one.
pub(super) fn joined_manners(graph: &RawMotionGraph, clips: &ClipSet, limit: f64) -> BTreeMap<String, f64> {
    let starts = clips.frame_starts();
    let manner = |frame: FrameId| {
        let c = starts.partition_point(|&s| s <= frame.0) - 1;
        let class = clips.clips[c].class_at((frame.0 - starts[c]) as usize);
        class.map_or("", |c| named_manner(&c.manner))
    };
    let mut out = BTreeMap::<String, f64>::new();
    for (state, w) in graph.states.iter().zip(graph.action_offsets.windows(2)) {
        for action in &graph.actions[w[0] as usize..w[1] as usize] {
            let error = f64::from(action.error);
            if error > limit {
                let ends = [*state, graph.segments[action.segment.0 as usize].start].map(manner);
                let is_one = ends.iter().all(|m| graph.manners.is_usual(m));
                for m in ends.iter().filter(|m| is_one || !graph.manners.is_usual(m)) {
                    let most = out.entry((*m).to_owned()).or_default();
                    *most = most.max(error);
                }
            }
        }
    }
    out
}

/// Errors of the actions that leave the course of their clip.
fn transition_errors(graph: &RawMotionGraph) -> impl Iterator<Item = f32> {
    graph.states.iter().zip(graph.action_offsets.windows(2)).flat_map(|(state, w)| {
        let actions = &graph.actions[w[0] as usize..w[1] as usize];
        actions.iter().filter(|a| graph.segments[a.segment.0 as usize].start != *state).map(|a| a.error)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_of_nothing_is_zero() {
        assert_eq!(MinMeanMax::from_values([]), MinMeanMax::default());
        assert_eq!(MinMeanMax::from_values([1.0, 5.0, 3.0]), MinMeanMax { min: 1.0, mean: 3.0, max: 5.0 });
    }
}
