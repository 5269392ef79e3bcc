//! The motion graph as it is stored: states, the actions each may take, and the segments of motion they play.

use crate::{format::Table, planar::Planar};
use bytemuck::{Pod, Zeroable};

/// A frame at which a character may choose.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct StateRecord {
    /// Frame row of the state.
    pub frame: u32,
    /// 1 where the character stands still, else 0.
    pub standing: u32,
}

/// Motion between two choices: the frames `start ..= start + num_frames` of one clip.
///
/// The first frame takes the place of the state's frame that is left, the last one is the frame of the state `end`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct MotionSegment {
    /// First frame row.
    pub start: u32,
    /// Frames played (> 0).
    pub num_frames: u32,
    /// State at the end.
    pub end: u32,
    /// Clip it lies in.
    pub clip: u32,
    /// Planar root of the last frame as seen from the first: x, z, heading (m, m, rad).
    pub displacement: [f32; 3],
    /// Frames from `start` on in which the body stands at ease, feet and hips in place; 0 where it does not up to the
    /// last frame.
    pub idle: u32,
}

impl MotionSegment {
    /// Planar root of the last frame as seen from the first.
    pub fn displacement(&self) -> Planar {
        Planar::from_array(self.displacement)
    }
}

/// A motion graph. Clones share the rows.
#[derive(Clone, Debug)]
pub struct MotionGraph {
    /// States, ascending by frame.
    pub states: Table<StateRecord>,
    /// Segments, ascending by start.
    pub segments: Table<MotionSegment>,
    /// Actions of state s are `action_offsets[s]..action_offsets[s + 1]` (num_states + 1).
    pub action_offsets: Table<u32>,
    /// Segment of each action.
    pub action_segments: Table<u32>,
    /// Difference between the state's frame and the segment's first frame; 0 where a clip simply continues.
    pub action_errors: Table<f32>,
}

impl MotionGraph {
    /// Segments of a state's actions (1 to 255, state < num_states).
    pub fn segments_of(&self, state: u32) -> &[u32] {
        self.actions_of(state).0
    }

    /// Segments of a state's actions and their errors (1 to 255, state < num_states).
    pub fn actions_of(&self, state: u32) -> (&[u32], &[f32]) {
        let s = state as usize;
        let actions = self.action_offsets[s] as usize..self.action_offsets[s + 1] as usize;
        (&self.action_segments[actions.clone()], &self.action_errors[actions])
    }
}
