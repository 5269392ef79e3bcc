//! Paths of segments and of the stops after them, in the world.

use super::super::block::{MotionBlock, NO_STATE, SCHEDULED};
use super::{super::bent, super::motion_set::MotionSet, super::pace};
use crate::planar::Planar;
use crate::reserve::{PathNode, ReservedPath};
use crate::stops::{BODY_RADIUS_M, REST, SLOW_DOWN, SweepNode};
use glam::Vec2;

/// Nodes that are added to a segment which is not played at its own rate, evenly in time.
const PACE_NODES: usize = 16;
/// Furthest that the root is beside the path, for rounding and for what nodes leave out of slowing (m).
const MARGIN_M: f32 = 0.005;

/// Time in which the pose that one comes from has nearly gone over into an action's (s).
const CHANGE_S: f32 = 0.3;

/// Most nodes of the path of an action and the stop after it.
pub fn most_nodes(motion_set: &MotionSet) -> usize {
    let (graph, stops) = (&motion_set.graph, &motion_set.stops);
    let bent = |s: &crate::graph::MotionSegment| (s.num_frames / crate::stops::PIECE_FRAMES) as usize;
    let longest = stops.sweeps.iter().map(|s| s.num_nodes as usize).max().unwrap_or(0);
    let longest = longest + graph.segments.iter().map(bent).max().unwrap_or(0);
    longest + stops.most_nodes(&graph.segments) + 2 * (PACE_NODES + 2) + 1
}

/// Segment to play, with pace and bending.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentPlan {
    /// Number of the segment.
    pub segment: u32,
    /// See [`pace`].
    pub pace: u32,
    /// Rate of bending (rad/frame).
    pub bend: f32,
}

impl SegmentPlan {
    /// Lays the path of the segment from a place on, and of the stop after it.
    ///
    /// - `from`: state that one comes from, if it is known.
    /// - `root`: at its first frame.
    pub fn lay_path(self, from: Option<u32>, root: Planar, motion_set: &MotionSet, out: &mut ReservedPath) {
        let end = motion_set.graph.segments[self.segment as usize].end;
        let mut laying = ReservedPathBuilder::begin(motion_set, root, out);
        match self.pace {
            pace::HELD_STILL => laying.add_stand(motion_set.stops.stops[end as usize].radius),
            pace::IN_PLACE => {
                let sweep = motion_set.stops.sweeps[self.segment as usize].radius;
                let pose = from.map_or(0.0, |s| motion_set.stops.stops[s as usize].pose_radius);
                laying.add_stand(sweep.max(motion_set.stops.stops[end as usize].radius).max(pose));
            }
            _ => {
                laying.add_segment(self, from);
                let offset = Vec2::new(laying.root.x - root.x, laying.root.z - root.z);
                laying.out.velocity = offset / laying.time_s;
                match self.pace {
                    pace::SLOWING => laying.add_stand(motion_set.stops.stops[end as usize].radius),
                    _ => laying.add_stop(end),
                }
            }
        }
    }
}

/// The path that a character has, which is that of its last choice.
pub fn path_of_state(b: &MotionBlock, lane: usize, motion_set: &MotionSet, out: &mut ReservedPath) {
    if b.segment[lane] == SCHEDULED {
        // A scheduled clip is set by the caller, who knows where it leads.
        let root = Planar::new(b.root[0][lane], b.root[1][lane], 0.0);
        return ReservedPathBuilder::begin(motion_set, root, out).add_stand(BODY_RADIUS_M);
    }
    let plan = SegmentPlan { segment: b.segment[lane], pace: b.pace[lane], bend: b.bend[lane] };
    match plan.pace {
        pace::HELD_STILL => plan.lay_path(None, b.root_at_end(lane, motion_set), motion_set, out),
        // A character that has not begun is at the end of its segment, and stops from then on, however long ago that
        // is.
        pace::NORMAL if b.choice_state[lane] == NO_STATE && b.time[lane] >= b.length[lane] as f32 => {
            let mut laying = ReservedPathBuilder::begin(motion_set, b.root_at_end(lane, motion_set), out);
            laying.time_s = b.length[lane] as f32 / motion_set.rate_hz;
            laying.add_stop(motion_set.graph.segments[plan.segment as usize].end);
        }
        _ => {
            let from = Some(b.choice_state[lane]).filter(|&s| s != NO_STATE);
            plan.lay_path(from, b.choice_root(lane), motion_set, out);
        }
    }
}

/// A path that grows.
struct ReservedPathBuilder<'a> {
    motion_set: &'a MotionSet,
    out: &'a mut ReservedPath,
    /// Time since the path began (s).
    time_s: f32,
    /// Root at the end of the path so far.
    root: Planar,
    /// Radius of the disc from here on (m).
    radius_m: f32,
    /// Radius of the disc about the previous pose, and the time until which it counts (m, s).
    pose: (f32, f32),
}

impl<'a> ReservedPathBuilder<'a> {
    fn begin(motion_set: &'a MotionSet, root: Planar, out: &'a mut ReservedPath) -> Self {
        out.nodes.clear();
        out.velocity = Vec2::ZERO;
        Self { motion_set, out, time_s: 0.0, root, radius_m: 0.0, pose: (0.0, 0.0) }
    }

    /// Adds a stand at the end of the path.
    fn add_stand(&mut self, radius_m: f32) {
        self.pose = (0.0, 0.0);
        self.radius_m = radius_m + MARGIN_M;
        self.add_node(0.0, Vec2::ZERO);
    }

    /// Adds a node at a time after `time_s`, where a point as seen from the root is.
    fn add_node(&mut self, after_frames: f32, local: Vec2) {
        let time_s = self.time_s + after_frames / self.motion_set.rate_hz;
        let (pose_m, until_s) = self.pose;
        let place = self.root.transform_point(local);
        let is_changing = pose_m > self.radius_m && time_s < until_s;
        let node = PathNode::new(time_s, place, if is_changing { pose_m } else { self.radius_m });
        if pose_m > self.radius_m
            && let Some(last) = self.out.nodes.last().filter(|n| n.time_s < until_s && until_s < time_s)
        {
            let share = (until_s - last.time_s) / (time_s - last.time_s);
            let place = last.place.lerp(place, share);
            self.out.nodes.push(PathNode::new(until_s, place, self.radius_m));
        }
        match self.out.nodes.last_mut() {
            // The end of one segment is the beginning of the next.
            Some(last) if time_s <= last.time_s => *last = node,
            _ => self.out.nodes.push(node),
        }
    }

    /// Adds a segment to its end, entered from a state.
    fn add_segment(&mut self, plan: SegmentPlan, from: Option<u32>) {
        let motion_set = self.motion_set;
        let pose = from.map_or(0.0, |s| motion_set.stops.stops[s as usize].pose_radius + MARGIN_M);
        self.pose = (pose, self.time_s + CHANGE_S);
        let segment = &motion_set.graph.segments[plan.segment as usize];
        let (nodes, length) = (motion_set.stops.nodes_of(plan.segment), segment.num_frames as f32);
        let place = |n: &SweepNode| Vec2::new(n.x, n.z);
        let mut end = segment.displacement();
        let mut frames = length;
        self.radius_m = motion_set.stops.sweeps[plan.segment as usize].radius + MARGIN_M;
        match plan.pace {
            pace::SLOWING | pace::STARTING => {
                frames = 2.0 * length;
                // Evenly in time, and at the nodes of the sweep.
                let time = |f: u32| pace::time_at_frame(plan.pace, length, f as f32);
                let every = frames / PACE_NODES as f32;
                let mut even = 0.0;
                for w in nodes.windows(2) {
                    let (from, to) = (w[0].frame as f32, w[1].frame as f32);
                    while even + 1e-3 < time(w[1].frame) {
                        let share = (pace::frame_at_time(plan.pace, length, even) - from) / (to - from);
                        self.add_node(even, place(&w[0]).lerp(place(&w[1]), share.clamp(0.0, 1.0)));
                        even += every;
                    }
                    self.add_node(time(w[1].frame), place(&w[1]));
                }
            }
            _ if plan.bend != 0.0 => {
                self.add_node(0.0, Vec2::ZERO);
                let mut at = Vec2::ZERO;
                for (frame, place) in bent::nodes(motion_set, plan.segment, plan.bend) {
                    at = place;
                    self.add_node(frame, at);
                }
                end = Planar::new(at.x, at.y, end.heading + plan.bend * length);
            }
            _ => nodes.iter().for_each(|n| self.add_node(n.frame as f32, place(n))),
        }
        self.time_s += frames / motion_set.rate_hz;
        self.root = self.root.compose(end);
    }

    /// Adds the stop from a state to a stand.
    fn add_stop(&mut self, mut state: u32) {
        let (graph, stops) = (&self.motion_set.graph, &self.motion_set.stops.stops);
        loop {
            let (stop, plan) = (&stops[state as usize], stop_of(state, self.motion_set));
            let from = std::mem::replace(&mut state, graph.segments[stop.segment as usize].end);
            if stop.kind != REST {
                self.add_segment(plan, Some(from));
            }
            match stop.kind {
                REST => return self.add_stand(stop.radius),
                SLOW_DOWN => return self.add_stand(stops[state as usize].radius),
                _ => {}
            }
        }
    }
}

/// The stop of a state, as it is played.
pub fn stop_of(state: u32, motion_set: &MotionSet) -> SegmentPlan {
    let stop = &motion_set.stops.stops[state as usize];
    let pace = match stop.kind {
        REST => pace::IN_PLACE,
        SLOW_DOWN => pace::SLOWING,
        _ => pace::NORMAL,
    };
    SegmentPlan { segment: stop.segment, pace, bend: 0.0 }
}
