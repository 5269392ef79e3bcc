//! From landmarks to a motion that looks like one: straightened, rounded, and blended into what is before and after it.

mod ease;
mod ends;
mod jerk;
mod round;
mod straighten;
#[cfg(test)]
mod tests;

pub(crate) use ease::smoothstep;
pub use jerk::{Roughness, roughness};
pub(crate) use round::Window;

use crate::collide::{Checker, EdgeCheck};
use crate::linkage::LimbPose;
use crate::problem::{Problem, State};
use crate::search::TimeGrid;
use throng_base::maths::slerp;

/// How the way is smoothed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothConfig {
    /// How often two points of the way are drawn to straighten what is between them.
    pub straighten: u32,
    /// Corners are rounded over at most that long to either side (s, >= 0).
    pub round_s: f64,
    /// Both ends blend over at most that long into what is before and after (s, >= 0).
    pub blend_s: f64,
}

impl Default for SmoothConfig {
    fn default() -> Self {
        Self { straighten: 60, round_s: 0.25, blend_s: 0.3 }
    }
}

/// What smoothing needs: each step keeps free what is.
pub(crate) struct Smoother<'a> {
    pub problem: &'a Problem,
    pub grid: TimeGrid,
    pub check: EdgeCheck,
    pub checker: &'a mut Checker,
}

impl Smoother<'_> {
    /// The way at a time.
    fn way_at(&self, way: &[State], time_s: f64) -> State {
        let next = way.partition_point(|s| s.time_s <= time_s);
        let (Some(to), Some(from)) = (way.get(next), next.checked_sub(1).map(|i| &way[i])) else {
            return State { pose: way[next.saturating_sub(1)].pose, time_s };
        };
        let share = (time_s - from.time_s) / (to.time_s - from.time_s);
        let mut pose = from.pose;
        for i in 0..self.problem.chain.len() {
            pose.0[i] = slerp(from.pose.0[i], to.pose.0[i], share);
        }
        State { pose, time_s }
    }

    /// Poses of all frames of a way.
    pub fn frames(&self, way: &[State], out: &mut Vec<LimbPose>) {
        out.clear();
        out.extend((0..=self.grid.steps).map(|f| self.way_at(way, self.grid.at(f)).pose));
    }

    /// True where the way from one frame to the next is free, and the next one, too.
    fn is_edge_free(&mut self, frames: &[LimbPose], f: usize) -> bool {
        let [from, to] = [f, f + 1].map(|k| State { pose: frames[k], time_s: self.grid.at(k) });
        // What proves a way proves its ends.
        let end_is_free = self.check == EdgeCheck::Conservative || self.checker.is_free(self.problem, &to);
        end_is_free && self.checker.is_way_free(self.problem, &from, &to, self.check)
    }
}
