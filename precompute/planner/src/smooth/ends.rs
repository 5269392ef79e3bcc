//! Both ends of a motion: they start and stop gently where they are at rest, with a speed that grows and shrinks like a
//! bell, and blend into the motion before and after them, in velocity as well as in position.

use super::Smoother;
use crate::linkage::{LIMB_JOINTS, LimbPose};
use crate::{problem::LimbState, rotation::angle_between};

impl Smoother<'_> {
    /// Blends the first and the last frames with the external motion's poses, where the plan begins or ends in its pose, or
    /// with the end's own pose, where it does not: a reach comes to rest in the trunk's frame. Halves the length of a blend
    /// until it is free.
    ///
    /// - `eased`: ends that are not in the external motion come to rest already.
    /// - `spare`: scratch.
    /// - returns the number of frames over which each end was blended.
    pub fn blend_ends(
        &mut self,
        frames: &mut Vec<LimbPose>,
        spare: &mut Vec<LimbPose>,
        blend: usize,
        eased: bool,
    ) -> [usize; 2] {
        [false, true].map(|at_goal| {
            let come_to_rest = eased && !self.path_end(at_goal).follows;
            let mut length = if come_to_rest { 0 } else { blend.min((frames.len() - 1) / 2) };
            while length > 1 && !self.blend_end(frames, spare, length, at_goal) {
                length /= 2;
            }
            if length > 1 { length } else { 0 }
        })
    }

    /// Blends one end over some frames; returns false, and changes nothing, where that is not free.
    fn blend_end(&mut self, frames: &mut Vec<LimbPose>, spare: &mut Vec<LimbPose>, len: usize, at_goal: bool) -> bool {
        let problem = self.problem;
        let end = if at_goal { &problem.goal } else { &problem.init };
        let follows = self.path_end(at_goal).follows;
        let last = frames.len() - 1;
        spare.clear();
        spare.extend_from_slice(frames);
        for k in 1..len {
            let f = if at_goal { last - k } else { k };
            let there = if follows { problem.external_pose_at(self.grid.time_at(f)) } else { end.pose };
            let share = smoothstep(k as f64 / len as f64);
            spare[f] = there.slerp(&frames[f], share);
        }
        let first = if at_goal { last - len } else { 0 };
        let free = (first..first + len).all(|f| self.is_edge_free(spare, f));
        if free {
            std::mem::swap(frames, spare);
        }
        free
    }
}

/// Speed of the external motion below which it is at rest (rad/s).
const AT_REST: f64 = 0.3;
/// Time over which that speed is measured (s).
const MEASURED_S: f64 = 0.05;
/// Difference below which poses count as the same (rad).
const SAME: f64 = 1e-3;
/// Shares of the easing that are tried, most first.
const SHARES: [f64; 4] = [1.0, 0.75, 0.5, 0.25];

/// State of the motion at an end of the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PathEnd {
    /// True where the end is in the external motion's pose.
    pub follows: bool,
    /// True where nothing moves there, relative to the trunk.
    pub at_rest: bool,
}

impl Smoother<'_> {
    /// State of the motion at the start or the goal.
    pub(super) fn path_end(&self, at_goal: bool) -> PathEnd {
        let problem = self.problem;
        let end = if at_goal { &problem.goal } else { &problem.init };
        let inner_s = if at_goal { end.time_s - MEASURED_S } else { end.time_s + MEASURED_S };
        let (here, inner) = (problem.external_pose_at(end.time_s), problem.external_pose_at(inner_s));
        let mut joints = 0..LIMB_JOINTS;
        let follows = joints.clone().all(|i| angle_between(here.0[i], end.pose.0[i]) < SAME);
        let slow = joints.all(|i| angle_between(here.0[i], inner.0[i]) < AT_REST * MEASURED_S);
        PathEnd { follows, at_rest: !follows || slow }
    }

    /// Frames of the path, passed more slowly at ends that are at rest and faster in between, as far as that is free.
    ///
    /// Between two ends at rest that is the path of least jerk along a straight line.
    ///
    /// - returns the share of the easing that was possible (0 to 1).
    ///
    /// # Source
    /// Flash and Hogan 1985, *The Coordination of Arm Movements*: x^3 (10 - 15 x + 6 x^2).
    pub fn ease_ends(&mut self, path: &[LimbState], frames: &mut Vec<LimbPose>) -> f64 {
        let rest = [false, true].map(|at_goal| self.path_end(at_goal).at_rest);
        if rest != [false, false] {
            for share in SHARES {
                let last = self.grid.steps;
                frames.clear();
                frames.extend((0..=last).map(|f| {
                    let x = f as f64 / last as f64;
                    let eased = x + share * (ease_profile(x, rest) - x);
                    self.state_at(path, self.grid.start_s + eased * (self.grid.goal_s - self.grid.start_s)).pose
                }));
                if (0..last).all(|f| self.is_edge_free(frames, f)) {
                    return share;
                }
            }
        }
        self.fill_frames(path, frames);
        0.0
    }
}

/// Time profile from 0 to 1, with no speed and acceleration at ends at rest, and even speed at the others.
fn ease_profile(x: f64, [start, goal]: [bool; 2]) -> f64 {
    let from_rest = |x: f64| x * x * x * (6.0 + x * (3.0 * x - 8.0));
    match (start, goal) {
        (true, true) => smoothstep(x),
        (true, false) => from_rest(x),
        (false, true) => 1.0 - from_rest(1.0 - x),
        (false, false) => x,
    }
}

/// Time profile from 0 to 1 with velocity and acceleration 0 at both ends.
pub(crate) fn smoothstep(x: f64) -> f64 {
    x * x * x * (10.0 + x * (6.0 * x - 15.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_begin_and_end_as_they_should() {
        let slope = |rest, x: f64| (ease_profile(x + 1e-5, rest) - ease_profile(x - 1e-5, rest)) / 2e-5;
        for rest in [[true, true], [true, false], [false, true], [false, false]] {
            assert!((ease_profile(0.0, rest)).abs() < 1e-12 && (ease_profile(1.0, rest) - 1.0).abs() < 1e-12);
            for (x, at_rest) in [(1e-5, rest[0]), (1.0 - 1e-5, rest[1])] {
                assert!((slope(rest, x) - if at_rest { 0.0 } else { 1.0 }).abs() < 1e-3, "{rest:?}");
            }
            assert!(
                (0..100)
                    .all(|i| ease_profile(f64::from(i + 1) / 100.0, rest) > ease_profile(f64::from(i) / 100.0, rest))
            );
        }
        assert!((slope([true, true], 0.5) - 1.875).abs() < 1e-6);
    }
}
