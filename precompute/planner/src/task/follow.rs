//! Motion of the second hand at a thing: the first hand fixes its place, and the swivel of its arm over time is searched.

use crate::ik::{LimbIk, Swivel};
use crate::problem::{LimbState, Problem};
use crate::rotation::{Rigid, mid_rotation, wrap_angle};
use crate::{collide::Checker, linkage::LimbPose};
use std::f64::consts::TAU;

/// Number of swivels that are tried on each frame.
const SWIVELS: usize = 72;
/// Largest change of the swivel from frame to frame, in steps between these.
const MOST_STEPS: usize = 2;
/// Change of the elbow from frame to frame above which swivels are searched (rad).
const LEAP_RAD: f64 = 0.1;
/// Frames to either side over which the swivel is made smooth.
const SMOOTH: usize = 6;

/// Frames of a hand's path, and targets of the second hand where it follows the first one.
pub(super) struct HandPath<'a> {
    pub problem: &'a Problem,
    /// One for each frame, the first one included.
    pub targets: &'a [Rigid],
    pub start_s: f64,
    pub rate_hz: f64,
}

/// Time at which the hand cannot follow (s), and the reason.
pub(super) type FollowError = (f64, String);

impl HandPath<'_> {
    fn state(&self, k: usize, pose: LimbPose) -> LimbState {
        LimbState { pose, time_s: self.start_s + k as f64 / self.rate_hz }
    }

    /// Poses of all frames: with the elbow as near as possible to the frame before, or, where it would leap or that fails,
    /// along the swivels over time that turn it the least.
    ///
    /// - `first`: the pose of the first frame.
    ///
    /// # Errors
    /// Time at which the elbow as near as possible to the frame before cannot go on, and the reason.
    pub fn poses(&self, first: &LimbPose) -> Result<Vec<LimbPose>, FollowError> {
        let (mut checker, limits) = (Checker::default(), &self.problem.limits);
        let ik = LimbIk::new(&self.problem.chain, limits);
        let near = self.nearest_swivel_poses(first, &mut checker);
        let swivel = |k: usize, pose: &LimbPose| ik.swivel_of(&self.base(k), &self.targets[k], pose);
        let leaps = |poses: &[LimbPose]| {
            let all: Vec<f64> = poses.iter().enumerate().filter_map(|(k, p)| swivel(k, p)).collect();
            all.windows(2).any(|w| wrap_angle(w[1] - w[0]).abs() > LEAP_RAD)
        };
        match near {
            Ok(poses) if !leaps(&poses) => Ok(poses),
            near => self.searched_swivel_poses(first, &ik, &mut checker).map_or(near, Ok),
        }
    }

    /// Largest offset of the hand halfway between two frames (m), and its time (s).
    ///
    /// - `target`: transform that the hand should have.
    pub fn largest_offset(&self, poses: &[LimbPose], target: impl Fn(f64) -> Rigid) -> (f64, f64) {
        let off = |k: usize| {
            let time_s = self.start_s + (k as f64 + 0.5) / self.rate_hz;
            let pose = LimbPose(std::array::from_fn(|i| mid_rotation(poses[k].0[i], poses[k + 1].0[i])));
            let hand = self.problem.place_chain(&LimbState { pose, time_s })[2];
            (hand.position.distance(target(time_s).position), time_s)
        };
        (1..poses.len()).map(|k| off(k - 1)).fold((0.0, self.start_s), |a, b| if b.0 > a.0 { b } else { a })
    }

    fn base(&self, k: usize) -> Rigid {
        self.problem.base_at(self.start_s + k as f64 / self.rate_hz)
    }

    fn nearest_swivel_poses(&self, first: &LimbPose, checker: &mut Checker) -> Result<Vec<LimbPose>, FollowError> {
        let mut poses = vec![*first];
        for (k, target) in self.targets.iter().enumerate().skip(1) {
            let time_s = self.state(k, *first).time_s;
            let pose = self.problem.solve_reach_from(checker, target, time_s, &poses[k - 1], Swivel::Present);
            poses.push(pose.map_err(|why| (time_s, why.to_string()))?);
        }
        self.keep_if_free(poses, checker)
    }

    /// Poses along the swivels over time that turn the elbow the least, by dynamic programming, and smoothed.
    fn searched_swivel_poses(&self, first: &LimbPose, ik: &LimbIk, checker: &mut Checker) -> Option<Vec<LimbPose>> {
        let step = TAU / SWIVELS as f64;
        let mut at = |k: usize, swivel: f64| {
            let pose = ik.solve_at_swivel(&self.base(k), &self.targets[k], swivel)?;
            checker.deepest_hit(self.problem, &self.state(k, pose)).is_none().then_some(pose)
        };
        let start = ik.swivel_of(&self.base(0), &self.targets[0], first)?;
        let mut costs = [f64::INFINITY; SWIVELS];
        costs[0] = 0.0;
        // For each frame and swivel, the swivel of the frame before.
        let mut before: Vec<[usize; SWIVELS]> = Vec::new();
        for k in 1..self.targets.len() {
            let (mut next, mut from) = ([f64::INFINITY; SWIVELS], [0; SWIVELS]);
            for s in 0..SWIVELS {
                let reachable = (0..=2 * MOST_STEPS).map(|d| {
                    let by = d as f64 - MOST_STEPS as f64;
                    let source = (s + SWIVELS + MOST_STEPS - d) % SWIVELS;
                    (costs[source] + by * by, source)
                });
                let (cost, source) = reachable.fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a });
                if cost.is_finite() && at(k, start + s as f64 * step).is_some() {
                    (next[s], from[s]) = (cost, source);
                }
            }
            costs = next;
            before.push(from);
        }
        let mut s = (0..SWIVELS).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
        if costs[s].is_infinite() {
            return None;
        }
        let mut turns = vec![s as f64 * step];
        for from in before.iter().rev() {
            s = from[s];
            turns.push(turns[turns.len() - 1] + wrap_angle(s as f64 * step - turns[turns.len() - 1]));
        }
        turns.reverse();
        let last = turns.len() - 1;
        let smooth = |k: usize| {
            let reach = SMOOTH.min(k).min(last - k);
            turns[k - reach..=k + reach].iter().sum::<f64>() / (2 * reach + 1) as f64
        };
        let mut poses = vec![*first];
        for k in 1..=last {
            poses.push(at(k, start + smooth(k)).or_else(|| at(k, start + turns[k]))?);
        }
        self.keep_if_free(poses, checker).ok()
    }

    /// Passes on poses whose motion is free in between, too.
    fn keep_if_free(&self, poses: Vec<LimbPose>, checker: &mut Checker) -> Result<Vec<LimbPose>, FollowError> {
        let way = self.check_free_all_along(checker, &poses);
        way.map(|()| poses).map_err(|(t, with)| (t, format!("{with} is in the way")))
    }

    /// Checks that a motion is free; else returns when it collides, or a joint is too fast, and the obstacle or joint.
    pub fn check_free_all_along(&self, checker: &mut Checker, poses: &[LimbPose]) -> Result<(), FollowError> {
        let (problem, state) = (self.problem, |k: usize| self.state(k, poses[k]));
        for k in 0..poses.len() {
            if let Some(hit) = checker.deepest_hit(problem, &state(k)) {
                return Err((state(k).time_s, problem.hit_names(&hit)[1].clone()));
            }
            if k > 0 && !checker.is_edge_free(problem, &state(k - 1), &state(k)) {
                let (least_s, joint) = problem.least_time(&poses[k - 1], &poses[k]);
                let is_fast = least_s > 1.0 / self.rate_hz + 1e-9;
                let what = if is_fast { format!("the speed of {}", joint.name()) } else { "something thin".into() };
                return Err((state(k).time_s, what));
            }
        }
        Ok(())
    }
}
