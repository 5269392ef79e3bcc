//! Smoothing of landmarks into natural motion: straightened, rounded, and blended into the motion before and after it.

mod ends;
mod jerk;
mod round;
mod straighten;
#[cfg(test)]
mod tests;

pub(crate) use ends::smoothstep;
pub use jerk::{Roughness, roughness};
pub(crate) use round::RoundingWindow;

use crate::collide::Checker;
use crate::linkage::LimbPose;
use crate::problem::{LimbState, Problem};
use crate::search::TimeGrid;

/// Settings of smoothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothConfig {
    /// Number of times that two points of the path are drawn to straighten the part between them.
    pub straighten: u32,
    /// Half width of the windows over which corners are rounded, at most (s, >= 0).
    pub round_s: f64,
    /// Time over which both ends blend into the motion before and after, at most (s, >= 0).
    pub blend_s: f64,
}

impl Default for SmoothConfig {
    fn default() -> Self {
        Self { straighten: 60, round_s: 0.25, blend_s: 0.3 }
    }
}

/// Inputs of smoothing: each of its steps keeps a free path free.
pub(crate) struct Smoother<'a> {
    pub problem: &'a Problem,
    pub grid: TimeGrid,
    pub checker: &'a mut Checker,
}

impl Smoother<'_> {
    /// State of the path at a time.
    fn state_at(&self, path: &[LimbState], time_s: f64) -> LimbState {
        let next = path.partition_point(|s| s.time_s <= time_s);
        let (Some(to), Some(from)) = (path.get(next), next.checked_sub(1).map(|i| &path[i])) else {
            return LimbState { pose: path[next.saturating_sub(1)].pose, time_s };
        };
        let share = (time_s - from.time_s) / (to.time_s - from.time_s);
        LimbState { pose: from.pose.slerp(&to.pose, share), time_s }
    }

    /// Poses of all frames of a path.
    pub fn fill_frames(&self, path: &[LimbState], out: &mut Vec<LimbPose>) {
        out.clear();
        out.extend((0..=self.grid.steps).map(|f| self.state_at(path, self.grid.time_at(f)).pose));
    }

    /// True where the edge from one frame to the next is free; the proof covers its ends.
    fn is_edge_free(&mut self, frames: &[LimbPose], f: usize) -> bool {
        let [from, to] = [f, f + 1].map(|k| LimbState { pose: frames[k], time_s: self.grid.time_at(k) });
        self.checker.is_edge_free(self.problem, &from, &to)
    }
}
