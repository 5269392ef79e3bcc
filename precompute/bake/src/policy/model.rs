//! State-action model that a policy is solved on: the motion graph without its poses (Lee and Lee 2004, section 3).

use super::costs::{ActionTraits, action_traits};
use crate::{graph::RawMotionGraph, stages::stage_error};
use glam::Vec2;
use std::ops::Range;
use throng_core::planar::{Planar, wrap_angle};
use throng_core::policy::{ActionTable, MAX_ACTIONS};
use throng_motion::{ClipSet, Result};

/// Motion of a segment, for behaviours.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentMotion {
    /// State at the end.
    pub end: u32,
    /// Frames played (> 0).
    pub num_frames: u32,
    /// Planar root at the end, relative to the start.
    pub displacement: Planar,
    /// Planar root at every frame from start to end, relative to the start (num_frames + 1).
    pub path: Vec<Planar>,
}

impl SegmentMotion {
    /// Root position (x, z) at a moment in [0, num_frames], interpolated between frames (m).
    pub fn position_at(&self, moment: f32) -> Vec2 {
        let last = self.path.len() - 1;
        let frame = (moment.max(0.0) as usize).min(last);
        let [a, b] = [frame, (frame + 1).min(last)].map(|f| Vec2::new(self.path[f].x, self.path[f].z));
        a.lerp(b, moment - frame as f32)
    }

    /// Speed of the body during a frame: the root's ground speed, plus that of a point beside it as it turns (m/s,
    /// frame < num_frames).
    pub fn speed(&self, frame: usize, rate_hz: f64) -> f64 {
        let step = self.path[frame].to_local(self.path[frame + 1]);
        let turn = wrap_angle(step.heading) * TURN_LEVER;
        f64::from((step.x * step.x + step.z * step.z + turn * turn).sqrt()) * rate_hz
    }
}

/// Distance from the vertical axis at which turning counts as speed: about that of a foot (m).
const TURN_LEVER: f32 = 0.3;

/// States, actions and the motion of the segments they share.
#[derive(Clone, Debug, PartialEq)]
pub struct ActionModel {
    /// Frame rate (Hz).
    pub rate_hz: f64,
    /// Actions of state s are `action_offsets[s]..action_offsets[s + 1]` (num_states + 1).
    pub action_offsets: Vec<u32>,
    /// Segment of each action.
    pub action_segments: Vec<u32>,
    /// Distance of each action's transition, 0 if the clip continues (rad).
    pub action_errors: Vec<f32>,
    /// What each action shows, for costs; may be empty.
    pub action_traits: Vec<ActionTraits>,
    /// The segments.
    pub segments: Vec<SegmentMotion>,
}

impl ActionModel {
    /// Extracts the model from a motion graph.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Stage`] if a state has more than 255 actions or clips have different frame
    /// rates.
    pub fn new(clips: &ClipSet, graph: &RawMotionGraph) -> Result<Self> {
        let rate_hz = clips.clips.first().map_or(30.0, |c| c.rate_hz);
        if let Some(c) = clips.clips.iter().find(|c| c.rate_hz != rate_hz) {
            let message = format!("clip {} has {} Hz, others {rate_hz} Hz", c.name, c.rate_hz);
            return Err(stage_error("policy", message, "Resample all clips to one rate."));
        }
        for (s, pair) in graph.action_offsets.windows(2).enumerate() {
            let n = pair[1].saturating_sub(pair[0]) as usize;
            if n == 0 || n > MAX_ACTIONS {
                let message = format!("state {s} has {n} actions, expected 1 to {MAX_ACTIONS}");
                return Err(stage_error(
                    "policy",
                    message,
                    "Lower the branching or the transition threshold of the graph.",
                ));
            }
        }
        let starts = clips.frame_starts();
        let segments = graph.segments.iter().map(|segment| {
            let clip = starts.partition_point(|&s| s <= segment.start.0) - 1;
            let first = (segment.start.0 - starts[clip]) as usize;
            let root = clips.clips[clip].planar(first);
            let place = |f: usize| root.to_local(clips.clips[clip].planar(first + f));
            let (end, path) = (segment.end.0, (0..=segment.num_frames as usize).map(place).collect());
            SegmentMotion { end, num_frames: segment.num_frames, displacement: segment.displacement, path }
        });
        Ok(Self {
            rate_hz,
            action_offsets: graph.action_offsets.clone(),
            action_segments: graph.actions.iter().map(|a| a.segment.0).collect(),
            action_errors: graph.actions.iter().map(|a| a.error).collect(),
            action_traits: action_traits(clips, graph),
            segments: segments.collect(),
        })
    }

    /// Number of states.
    pub fn num_states(&self) -> usize {
        self.action_offsets.len() - 1
    }

    /// Segments of the actions of some states (below num_states).
    pub fn segments_of(&self, states: Range<usize>) -> &[u32] {
        &self.action_segments[self.actions_of(states)]
    }

    /// Actions of some states (below num_states).
    pub fn actions_of(&self, states: Range<usize>) -> Range<usize> {
        self.action_offsets[states.start] as usize..self.action_offsets[states.end] as usize
    }

    /// The runtime's view of the actions.
    ///
    /// # Errors
    /// [`throng_core::Error`] for an inconsistent model.
    pub fn action_table(&self) -> throng_core::Result<ActionTable> {
        ActionTable::new(&self.action_offsets, &self.action_segments, &self.action_errors, self.segments.len())
    }

    /// Frames of the shortest segment.
    pub fn least_frames(&self) -> u32 {
        self.segments.iter().map(|s| s.num_frames).min().unwrap_or(1)
    }
}
