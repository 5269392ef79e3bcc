//! Collision checks of edges: is the straight path between two states free?

use super::checker::{Checker, LIMIT_TOLERANCE};
use crate::linkage::{LIMB_JOINTS, LimbPose};
use crate::problem::{CollisionTarget, LimbState, Problem};
use crate::rotation::{angle_between, mid_rotation};

/// A piece of an edge, and the pairs that are not proved apart on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeInterval {
    from: LimbState,
    to: LimbState,
    /// Range in the list of open pairs.
    first: u32,
    end: u32,
    /// Number of halvings of the edge that lead to this piece.
    level: u32,
    /// Joints whose limits are not proved.
    joints: [bool; LIMB_JOINTS],
}

/// Travel below which a piece that is not proved free counts as blocked (m).
const FINEST_M: f64 = 2e-4;
/// Turn below which a piece whose limits are not proved counts as blocked (rad).
const FINEST_RAD: f64 = 2e-4;
/// Number of halvings up to which whole meshes are searched for collisions.
const SEARCHED_LEVELS: u32 = 3;
/// Most halvings of an edge.
const MAX_LEVEL: u32 = 40;

impl Checker {
    /// True where the edge is free: time grows, no joint is faster than its limit, limits hold and nothing is too near.
    ///
    /// Only the inside of the edge is checked: both ends have to be free. Joints turn evenly, along shortest arcs.
    ///
    /// # Source
    /// Schwarzer, Saha and Latombe 2002, *Exact Collision Checking of Robot Paths*: bounds on all speeds say for how long
    /// nothing can collide; here everything else moves, too. Shapiro, Kallmann and Faloutsos 2007, section 4.1, bisect
    /// down to a resolution instead, which misses thinner obstacles.
    pub fn is_edge_free(&mut self, problem: &Problem, from: &LimbState, to: &LimbState) -> bool {
        self.prepare_if_other(problem);
        let seconds = to.time_s - from.time_s;
        if seconds.is_nan() || seconds < 0.0 {
            return false;
        }
        let mut turns = [0.0; LIMB_JOINTS];
        for i in 0..LIMB_JOINTS {
            turns[i] = angle_between(from.pose.0[i], to.pose.0[i]);
            if turns[i] > problem.limits[i].speed * seconds + 1e-9 {
                return false;
            }
        }
        self.prove_edge(problem, from, to, &turns)
    }

    fn prove_edge(&mut self, problem: &Problem, from: &LimbState, to: &LimbState, turns: &[f64; LIMB_JOINTS]) -> bool {
        self.open.clear();
        self.open.extend(0..problem.pairs.len() as u16);
        let end = self.open.len() as u32;
        self.intervals.clear();
        let joints = [true; LIMB_JOINTS];
        self.intervals.push(EdgeInterval { from: *from, to: *to, first: 0, end, level: 0, joints });
        let mut next = 0;
        while let Some(&piece) = self.intervals.get(next) {
            next += 1;
            let half_turns = turns.map(|t| t / f64::from(2u32 << piece.level.min(30)));
            let half_s = 0.5 * (piece.to.time_s - piece.from.time_s);
            let at = edge_midpoint(&piece.from, &piece.to);
            let Some(joints) = prove_limits(problem, &at.pose, &half_turns, piece.joints) else { return false };
            let first = self.open.len() as u32;
            if !self.prove_pairs(problem, &piece, &at, &half_turns, half_s) {
                return false;
            }
            let end = self.open.len() as u32;
            if end == first && joints == [false; LIMB_JOINTS] {
                continue;
            }
            if piece.level >= MAX_LEVEL {
                return false;
            }
            let half = |(from, to)| EdgeInterval { from, to, first, end, level: piece.level + 1, joints };
            self.intervals.extend([(piece.from, at), (at, piece.to)].map(half));
        }
        true
    }

    /// Checks the pairs of a piece: false where one is too near in its middle, or cannot be proved to stay away; pairs that are
    /// neither proved nor refuted are appended to the open ones.
    fn prove_pairs(
        &mut self,
        problem: &Problem,
        piece: &EdgeInterval,
        at: &LimbState,
        half_turns: &[f64; LIMB_JOINTS],
        half_s: f64,
    ) -> bool {
        let (from_s, to_s) = (piece.from.time_s, piece.to.time_s);
        self.place_parts(problem, &at.pose, at.time_s);
        // Bound on the travel of each part until the ends of the piece.
        self.travels.clear();
        self.travels.extend(problem.parts.iter().map(|part| {
            let turned: f64 = (0..=part.link).map(|j| half_turns[j] * part.reach[j]).sum();
            turned + problem.base.speed(from_s, to_s, part.base_reach) * half_s
        }));
        // Pairs with the same target are adjacent.
        let mut last = (None, 0.0);
        for k in piece.first..piece.end {
            let index = self.open[k as usize];
            let pair = &problem.pairs[usize::from(index)];
            if pair.allowed.is_some_and(|[from, to]| from <= from_s && to >= to_s) {
                continue;
            }
            if last.0 != Some(pair.target) {
                let speed = match pair.target {
                    CollisionTarget::Body(b) => problem.bodies[b].track.speed(from_s, to_s),
                    CollisionTarget::Tether => problem.tether.as_ref().map_or(0.0, |t| t.from.speed(from_s, to_s, 0.0)),
                    CollisionTarget::Upright => 0.0,
                    CollisionTarget::Solid(s) => {
                        let solid = &problem.solids[s];
                        solid.solid.path.speed(from_s, to_s, solid.reach)
                    }
                };
                last = (Some(pair.target), speed * half_s);
            }
            let distance = self.travels[pair.part] + last.1;
            if !self.is_nearer(problem, pair, at.time_s, pair.gap + distance, true) {
                continue;
            }
            // A collision ends the proof early. On short pieces a search for one costs more than it saves.
            let whole = piece.level < SEARCHED_LEVELS;
            let touches = !pair.may_touch_at(at.time_s) && self.is_nearer(problem, pair, at.time_s, pair.gap, whole);
            if touches || distance < FINEST_M {
                return false;
            }
            self.open.push(index);
        }
        true
    }
}

/// Joints whose limits are still to be proved; `None` where one is outside its limits.
fn prove_limits(
    problem: &Problem,
    pose: &LimbPose,
    half_turns: &[f64; LIMB_JOINTS],
    mut open: [bool; LIMB_JOINTS],
) -> Option<[bool; LIMB_JOINTS]> {
    for i in 0..LIMB_JOINTS {
        if !open[i] {
            continue;
        }
        let excess = problem.limits[i].excess(pose.0[i]);
        if excess > LIMIT_TOLERANCE {
            return None;
        }
        let distance = problem.limits[i].stiffness() * half_turns[i];
        open[i] = excess + distance > LIMIT_TOLERANCE && distance > FINEST_RAD;
    }
    Some(open)
}

/// Midpoint of an edge: the mean of both times and of every joint angle.
fn edge_midpoint(a: &LimbState, b: &LimbState) -> LimbState {
    let pose = LimbPose(std::array::from_fn(|i| mid_rotation(a.pose.0[i], b.pose.0[i])));
    LimbState { pose, time_s: 0.5 * (a.time_s + b.time_s) }
}
