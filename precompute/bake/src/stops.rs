//! Stop tables: the area that each segment sweeps, the cheapest path to a stand from every state, and the segments in
//! which a body idles.

mod idle;

pub(crate) use idle::frames_left as idle_frames_left;

use crate::graph::{RawMotionGraph, SegmentId, StateId};
use crate::share::{clip_owners, sort_by_owner};
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use std::{cmp::Reverse, collections::BinaryHeap};
use throng_base::thresholds::{HEAD_ROOM_M, TRUNK_ROOM_M};
use throng_base::{Comm, maths::quantile};
use throng_core::stops::{
    BODY_RADIUS_M, REST, SLOW_DOWN, SWEEP_TOLERANCE_M, StopRecord, SweepNode, SweepRecord, WALK_ON,
};
use throng_core::{Contacts, Joint};
use throng_motion::{Clip, ClipSet, FrameId, Result};

/// Largest motion of a resting character from its place and back (m).
const REST_PATH_M: f32 = 0.1;
/// Cost of a metre on the way to a stand (s).
const METRE_S: f64 = 0.5;
/// Cost of a metre by which the body extends beyond the disc of an upright one, as in a bow (s).
const LEAN_S: f64 = 4.0;
/// Largest radius of a resting body, unless all are larger (m).
const REST_RADIUS_M: f32 = 0.4;
/// Cost of slowing down in the middle of a motion, without standing (s).
const SLOWING_S: f64 = 2.0;
/// Cost of slowing down without both feet on the ground (s).
const LIFTED_S: f64 = 10.0;

/// The rows of the stop tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StopRows {
    /// Sweep of each segment.
    pub sweeps: Vec<SweepRecord>,
    /// Nodes of all sweeps.
    pub nodes: Vec<SweepNode>,
    /// Stop of each state.
    pub stops: Vec<StopRecord>,
    /// Frames for which the body idles from each segment's first one on; 0 where it does not until the segment's end.
    pub idle: Vec<u32>,
}

/// Times in which characters can stop.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct StopsReport {
    /// Number of states in which a character can stand for any time.
    pub resting_states: usize,
    /// Number of states from which a character slows down in the middle of a motion, as no stand is near.
    pub slowing_states: usize,
    /// Time to come to a stand, 95th percentile of the other states (s).
    pub stop_p95_s: f64,
    /// Longest time to come to a stand (s).
    pub stop_worst_s: f64,
    /// Distance to a stand, 95th percentile (m).
    pub stop_path_p95_m: f64,
}

/// Computes the stop tables of a graph.
///
/// - `comm`: processes that hold the other poses.
///
/// # Errors
/// [`throng_motion::error::BuildError::File`] if another process has ended.
pub fn find_stops(clips: &ClipSet, graph: &RawMotionGraph, comm: &dyn Comm) -> Result<(StopRows, StopsReport)> {
    let starts = clips.frame_starts();
    let clip_of = |frame: FrameId| starts.partition_point(|&f| f <= frame.0) - 1;
    // Segments first, then states.
    let places = graph.segments.iter().map(|s| (s.start, s.num_frames as usize));
    let places: Vec<(FrameId, usize)> = places.chain(graph.states.iter().map(|&frame| (frame, 0))).collect();
    let of_clips = clip_owners(clips, comm.num_ranks());
    let of_places: Vec<usize> = places.iter().map(|&(frame, _)| of_clips[clip_of(frame)]).collect();
    let radii = sort_by_owner(comm, &of_places, |n| {
        let (frame, num_frames) = places[n];
        let clip = clip_of(frame);
        radius(clips, clip, (frame.0 - starts[clip]) as usize, num_frames) + SWEEP_TOLERANCE_M
    })?;
    let (of_segments, of_states) = radii.split_at(graph.segments.len());
    let left = sort_by_owner(comm, &clip_owners(clips, comm.num_ranks()), |c| {
        idle::frames_left(&clips.clips[c], &clips.skeleton)
    })?;
    let left = left.concat();
    let idles =
        |s: &crate::graph::GraphSegment| left.get(s.start.0 as usize).copied().filter(|left| *left >= s.num_frames);
    let idle = graph.segments.iter().map(|s| idles(s).unwrap_or(0)).collect();
    let mut out = StopRows { idle, ..StopRows::default() };
    let mut paths = Vec::with_capacity(graph.segments.len());
    for (s, &radius) in graph.segments.iter().zip(of_segments) {
        let c = clip_of(s.start);
        let first = (s.start.0 - starts[c]) as usize;
        let path = root_path(&clips.clips[c], first, s.num_frames as usize);
        let first_node = out.nodes.len() as u32;
        simplify(&path, &mut out.nodes);
        out.sweeps.push(SweepRecord { first_node, num_nodes: out.nodes.len() as u32 - first_node, radius });
        paths.push(path);
    }
    let rate = clips.clips.first().map_or(30.0, |c| c.rate_hz);
    let rests = [REST_RADIUS_M, f32::INFINITY]
        .map(|most| rest_segments(graph, &paths, |s| out.sweeps[s.0 as usize].radius <= most));
    let rests = rests.into_iter().find(|r| r.iter().any(Option::is_some)).unwrap_or(vec![None; graph.states.len()]);
    // A resting character is moved back to its place evenly: the disc includes that distance.
    for &segment in rests.iter().flatten() {
        let (path, sweep) = (&paths[segment.0 as usize], &mut out.sweeps[segment.0 as usize]);
        sweep.radius = sweep.radius.max(BODY_RADIUS_M + SWEEP_TOLERANCE_M + straightness_error(path));
    }
    let found =
        CheapestPaths { graph, rate, rests, sweeps: out.sweeps.clone(), on_both: on_both(clips, &starts, graph) };
    out.stops = found.cheapest();
    out.stops.iter_mut().zip(of_states).for_each(|(stop, &radius)| stop.pose_radius = radius);
    spread_radii(graph, &out.sweeps, &mut out.stops);
    let report = report(&out.stops, &found, &paths);
    Ok((out, report))
}

/// Path of the root over a segment, relative to its first frame (num_frames + 1).
fn root_path(clip: &Clip, first: usize, num_frames: usize) -> Vec<Vec2> {
    let origin = clip.planar(first);
    let places = (first..=first + num_frames).map(|f| clip.planar(f));
    places.map(|p| origin.inverse_transform_point(Vec2::new(p.x, p.z))).collect()
}

/// Simplifies a path to nodes, each as far from the previous one as [`SWEEP_TOLERANCE_M`] allows.
fn simplify(path: &[Vec2], out: &mut Vec<SweepNode>) {
    let node = |f: usize| SweepNode { frame: f as u32, x: path[f].x, z: path[f].y };
    let is_near = |from: usize, to: usize| {
        (from + 1..to).all(|f| {
            let share = (f - from) as f32 / (to - from) as f32;
            path[from].lerp(path[to], share).distance(path[f]) <= SWEEP_TOLERANCE_M
        })
    };
    let mut at = 0;
    out.push(node(0));
    while at + 1 < path.len() {
        let mut next = at + 1;
        while next + 1 < path.len() && is_near(at, next + 1) {
            next += 1;
        }
        out.push(node(next));
        at = next;
    }
}

/// Radius of the disc about the root that holds trunk and head in all frames of a segment (m).
fn radius(clips: &ClipSet, clip: usize, first: usize, num_frames: usize) -> f32 {
    let head_centre = clips.skeleton.tips[0] * 0.5;
    let of_frame = |f: usize| {
        let joints = clips.clips[clip].joint_transforms(&clips.skeleton, f);
        let root = joints[0].0;
        let beside = |p: Vec3| Vec2::new(p.x - root.x, p.z - root.z).length();
        let head = joints[Joint::Head.index()];
        let trunk = [Joint::Chest, Joint::UpperChest, Joint::Neck].map(|j| beside(joints[j.index()].0));
        let trunk = trunk.into_iter().fold(0.0, f32::max) + TRUNK_ROOM_M;
        trunk.max(beside(head.0 + head.1 * head_centre) + HEAD_ROOM_M)
    };
    (first..=first + num_frames).map(of_frame).fold(BODY_RADIUS_M, f32::max)
}

/// Largest distance of a path from the straight line between its ends (m).
fn straightness_error(path: &[Vec2]) -> f32 {
    let (last, end) = (path.len() - 1, path[path.len() - 1]);
    path.iter().enumerate().map(|(f, p)| p.distance(end * (f as f32 / last as f32))).fold(0.0, f32::max)
}

/// For each state in which a character may stand for long, the segment to play: it ends in such a state again, and
/// hardly moves.
///
/// The result is the greatest set of standing states each of which has an action into the set.
fn rest_segments(
    graph: &RawMotionGraph,
    paths: &[Vec<Vec2>],
    is_slim: impl Fn(SegmentId) -> bool,
) -> Vec<Option<SegmentId>> {
    let stays = |s: SegmentId| {
        let path = &paths[s.0 as usize];
        is_slim(s) && path[path.len() - 1].length() <= REST_PATH_M && straightness_error(path) <= REST_PATH_M
    };
    let mut is_rest = graph.standing.clone();
    let leads = |state: usize, is_rest: &[bool]| {
        // The clip's own continuation if possible; else the nearest pose.
        let fits = |a: &&crate::graph::GraphAction| {
            is_rest[graph.segments[a.segment.0 as usize].end.0 as usize] && stays(a.segment)
        };
        let possible = graph.actions_of(StateId(state as u32)).iter().filter(fits);
        possible.min_by(|a, b| a.error.total_cmp(&b.error)).map(|a| a.segment)
    };
    loop {
        let gone: Vec<usize> = (0..is_rest.len()).filter(|&s| is_rest[s] && leads(s, &is_rest).is_none()).collect();
        if gone.is_empty() {
            return (0..is_rest.len()).map(|s| if is_rest[s] { leads(s, &is_rest) } else { None }).collect();
        }
        gone.into_iter().for_each(|s| is_rest[s] = false);
    }
}

/// True for states with both feet on the ground.
fn on_both(clips: &ClipSet, starts: &[u32], graph: &RawMotionGraph) -> Vec<bool> {
    let contacts = |f: &FrameId| {
        let c = starts.partition_point(|&s| s <= f.0) - 1;
        clips.clips[c].contacts.get((f.0 - starts[c]) as usize).copied().unwrap_or(Contacts::NONE)
    };
    graph.states.iter().map(contacts).map(|c| c.any(Contacts::LEFT) && c.any(Contacts::RIGHT)).collect()
}

/// Inputs of the search for the cheapest path.
struct CheapestPaths<'a> {
    graph: &'a RawMotionGraph,
    rate: f64,
    rests: Vec<Option<SegmentId>>,
    sweeps: Vec<SweepRecord>,
    on_both: Vec<bool>,
}

impl CheapestPaths<'_> {
    /// Cost of a segment on the way to a stand (s).
    fn cost(&self, segment: SegmentId) -> f64 {
        let s = &self.graph.segments[segment.0 as usize];
        let lean = f64::from(self.sweeps[segment.0 as usize].radius - BODY_RADIUS_M);
        let distance = f64::from(s.displacement.x.hypot(s.displacement.z));
        f64::from(s.num_frames) / self.rate + METRE_S * distance + LEAN_S * lean
    }

    /// Cheapest action of each state on the way to a stand (Dijkstra 1959, from all resting places at once).
    fn cheapest(&self) -> Vec<StopRecord> {
        let graph = self.graph;
        let n = graph.states.len();
        let mut into: Vec<Vec<(u32, SegmentId)>> = vec![Vec::new(); n];
        let mut best: Vec<(f64, StopRecord)> = Vec::with_capacity(n);
        for state in 0..n {
            let mut slow = (f64::INFINITY, StopRecord { kind: SLOW_DOWN, ..StopRecord::zeroed() });
            for a in graph.actions_of(StateId(state as u32)) {
                let s = &graph.segments[a.segment.0 as usize];
                let end = s.end.0 as usize;
                into[end].push((state as u32, a.segment));
                let penalty = if self.on_both[end] { SLOWING_S } else { LIFTED_S };
                let cost = f64::from(s.num_frames) / self.rate + self.cost(a.segment) + penalty;
                if cost < slow.0 {
                    slow = (cost, StopRecord { segment: a.segment.0, frames: 2 * s.num_frames, ..slow.1 });
                }
            }
            let rest = |segment: SegmentId| StopRecord { segment: segment.0, kind: REST, ..StopRecord::zeroed() };
            best.push(self.rests[state].map_or(slow, |segment| (0.0, rest(segment))));
        }
        // Costs are not negative, so that their bits have their order.
        let mut open: BinaryHeap<Reverse<(u64, u32)>> =
            best.iter().enumerate().map(|(s, b)| Reverse((b.0.to_bits(), s as u32))).collect();
        while let Some(Reverse((bits, state))) = open.pop() {
            let (cost, stop) = best[state as usize];
            if cost.to_bits() != bits {
                continue;
            }
            for &(from, segment) in &into[state as usize] {
                let total = cost + self.cost(segment);
                if total < best[from as usize].0 {
                    let frames = stop.frames + graph.segments[segment.0 as usize].num_frames;
                    best[from as usize] =
                        (total, StopRecord { segment: segment.0, kind: WALK_ON, frames, ..StopRecord::zeroed() });
                    open.push(Reverse((total.to_bits(), from)));
                }
            }
        }
        best.into_iter().map(|b| b.1).collect()
    }
}

/// Largest radius from each state on: that of its pose, its segment and all that follow.
fn spread_radii(graph: &RawMotionGraph, sweeps: &[SweepRecord], stops: &mut [StopRecord]) {
    let mut changed = true;
    while changed {
        changed = false;
        for s in 0..stops.len() {
            let stop = stops[s];
            let after = match stop.kind {
                SLOW_DOWN => 0.0,
                _ => stops[graph.segments[stop.segment as usize].end.0 as usize].radius,
            };
            let radius = sweeps[stop.segment as usize].radius.max(after).max(stop.pose_radius);
            changed |= radius != stop.radius;
            stops[s].radius = radius;
        }
    }
}

fn report(stops: &[StopRecord], found: &CheapestPaths<'_>, paths: &[Vec<Vec2>]) -> StopsReport {
    let graph = found.graph;
    let slows = |mut s: usize| loop {
        match stops[s].kind {
            REST => return false,
            SLOW_DOWN => return true,
            _ => s = graph.segments[stops[s].segment as usize].end.0 as usize,
        }
    };
    let stop_path = |mut s: usize| {
        let mut sum = 0.0;
        while stops[s].kind != REST {
            let segment = stops[s].segment as usize;
            sum += f64::from(paths[segment].windows(2).map(|w| w[0].distance(w[1])).sum::<f32>());
            if stops[s].kind == SLOW_DOWN {
                break;
            }
            s = graph.segments[segment].end.0 as usize;
        }
        sum
    };
    let moving: Vec<usize> = (0..stops.len()).filter(|&s| stops[s].kind != REST).collect();
    let at = |of: &dyn Fn(usize) -> f64, share| quantile(moving.iter().map(|&s| of(s)), share).unwrap_or(0.0);
    let stop_s = |s: usize| f64::from(stops[s].frames) / found.rate;
    StopsReport {
        resting_states: stops.len() - moving.len(),
        slowing_states: moving.iter().filter(|&&s| slows(s)).count(),
        stop_p95_s: at(&stop_s, [95, 100]),
        stop_worst_s: at(&stop_s, [1, 1]),
        stop_path_p95_m: at(&stop_path, [95, 100]),
    }
}

#[cfg(test)]
mod tests;
