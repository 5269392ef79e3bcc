//! Motion graph: possible successions of frames, collapsed to states and actions (Lee and Lee 2004, sections 3 and 6).

mod apart;
mod bridge;
mod choose;
mod collapse;
mod component;
mod config;
mod connect;
mod events;
mod export;
mod manners;
mod matches;
mod report;
mod take;
mod tree;

pub use apart::MotionApart;
pub use config::{MakeMotion, MotionGraphConfig};
pub use connect::{connect, empty_graph};
pub(crate) use events::{holds_arm_out, is_held_out, standing_runs_of};
pub use export::{ActionRow, DisplacementRow, GraphRows, StateRow, graph_rows, write_graph_json};
pub use manners::KeptManners;
pub(crate) use report::played_frames;
pub use report::{GraphReport, MinMeanMax};
pub use take::{MotionLeftOut, TakenMotion};

use throng_core::Planar;
use throng_motion::clip::FrameId;

/// A frame with several successors. Index into [`RawMotionGraph::states`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct StateId(pub u32);

/// Index into [`RawMotionGraph::segments`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct SegmentId(pub u32);

/// A run of frames inside one clip that ends in a state: the motion of an action.
///
/// Actions of different states share segments: a transition i -> j replaces frame i by frame j - 1 (Lee and Lee 2004,
/// section 6), so its continuation does not depend on i.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GraphSegment {
    /// Frame j - 1, which replaces the frame of the state that the action leaves.
    pub start: FrameId,
    /// Frames played: the segment ends at `start + num_frames`, the frame of `end` (> 0).
    pub num_frames: u32,
    /// State at the end.
    pub end: StateId,
    /// Planar root of the last frame relative to the first.
    pub displacement: Planar,
}

/// A choice in a state.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GraphAction {
    /// Segment that is played.
    pub segment: SegmentId,
    /// Distance between the state's frame and the segment's first one; 0 if the clip continues.
    pub error: f32,
}

/// States, actions and the segments they share. Every state has at least one action, every segment ends in a
/// state, and every state can be reached from every other.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RawMotionGraph {
    /// Frame of each state, ascending.
    pub states: Vec<FrameId>,
    /// True for standing states (states.len()).
    pub standing: Vec<bool>,
    /// Segments, ascending by start frame.
    pub segments: Vec<GraphSegment>,
    /// Actions of state s are `actions[action_offsets[s]..action_offsets[s + 1]]`, best match first.
    /// (states.len() + 1)
    pub action_offsets: Vec<u32>,
    /// Actions of all states.
    pub actions: Vec<GraphAction>,
    /// Manners that people keep.
    pub manners: KeptManners,
}

impl RawMotionGraph {
    /// Actions of a state.
    pub fn actions_of(&self, s: StateId) -> &[GraphAction] {
        let s = s.0 as usize;
        &self.actions[self.action_offsets[s] as usize..self.action_offsets[s + 1] as usize]
    }
}

#[cfg(test)]
mod tests;
