//! Stop tables: the ground that a character covers while it plays a segment, and its path to a stand from every state.
//!
//! With them a character can reserve the ground that it needs for an action and for the stop that may have to follow
//! it, as the agents of event-driven crowds do (Kim, Kim and Shin 2003, section 2).

use crate::{format::Table, graph::MotionSegment};
use bytemuck::{Pod, Zeroable};

/// A body takes a disc of this radius about its planar root, or a larger one where trunk and head reach beyond it (m).
pub use throng_base::thresholds::BODY_RADIUS_M;

/// Pieces of an action that is bent are no longer (frames).
pub(crate) const PIECE_FRAMES: u32 = 4;
/// Furthest that the root is from the line between two nodes of a sweep; radii contain it (m).
pub const SWEEP_TOLERANCE_M: f32 = 0.01;

/// Area that a segment sweeps: a disc whose centre moves from node to node, evenly in time.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SweepRecord {
    /// First [`SweepNode`] of the sweep.
    pub first_node: u32,
    /// Number of nodes: one at its first frame, one at its last, and others between (> 1).
    pub num_nodes: u32,
    /// Radius of the disc about the root that holds trunk and head (m, at least [`BODY_RADIUS_M`]).
    pub radius: f32,
}

/// A place of the root on a segment.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SweepNode {
    /// Frames after the segment's first one.
    pub frame: u32,
    /// Position of the root relative to the first frame (m).
    pub x: f32,
    /// See `x` (m).
    pub z: f32,
}

/// Next action on the way from a state to a stand.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct StopRecord {
    /// Segment of the action to take.
    pub segment: u32,
    /// [`REST`], [`WALK_ON`] or [`SLOW_DOWN`].
    pub kind: u32,
    /// Time until the character stands (frames).
    pub frames: u32,
    /// Largest radius of the disc that holds trunk and head, from here on (m).
    pub radius: f32,
    /// Radius for the state's own pose, from which a transition leads into an action's (m, at most `radius`).
    pub pose_radius: f32,
}

/// Kind of a stand: the segment is played in place and ends in a state of the same kind, for any length of time.
pub const REST: u32 = 0;
/// The segment leads to the next state on the way to a stand.
pub const WALK_ON: u32 = 1;
/// Kind of a stop by slowing down: the segment is played ever more slowly, in twice its time, and the character is held
/// in the state at its end; for data without stands, or with few.
pub const SLOW_DOWN: u32 = 2;

/// The stop tables of a motion graph. Clones share the rows.
#[derive(Clone, Debug)]
pub struct StopTables {
    /// Sweep of each segment (num_segments).
    pub sweeps: Table<SweepRecord>,
    /// Nodes of all sweeps.
    pub nodes: Table<SweepNode>,
    /// Stop of each state (num_states).
    pub stops: Table<StopRecord>,
}

impl StopTables {
    /// Nodes of a segment's sweep (segment < num_segments).
    pub fn nodes_of(&self, segment: u32) -> &[SweepNode] {
        let s = &self.sweeps[segment as usize];
        &self.nodes[s.first_node as usize..][..s.num_nodes as usize]
    }

    /// Most nodes that the sweeps of all segments on the way from any state to a stand have together, and one more for each
    /// segment.
    pub fn most_nodes(&self, segments: &[MotionSegment]) -> usize {
        let mut of_state = vec![0; self.stops.len()];
        let mut order: Vec<usize> = (0..self.stops.len()).collect();
        order.sort_by_key(|&s| self.stops[s].frames);
        for s in order {
            let stop = &self.stops[s];
            let sweep = self.sweeps[stop.segment as usize].num_nodes as usize;
            of_state[s] = match stop.kind {
                REST => 0,
                SLOW_DOWN => sweep + 1,
                _ => sweep + 1 + of_state[segments[stop.segment as usize].end as usize],
            };
        }
        of_state.into_iter().max().unwrap_or(0)
    }
}
