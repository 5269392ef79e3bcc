//! Straightens a path between any two points of it.

use super::Smoother;
use crate::{linkage::LIMB_JOINTS, problem::LimbState, rotation::angle_between};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Gain below which a shortcut is not tried: sum of all turns (rad).
const LEAST_GAIN: f64 = 0.05;

impl Smoother<'_> {
    /// Draws two frames of the path, not necessarily landmarks, and replaces the part between them by even motion where that is
    /// free; time becomes even, too.
    ///
    /// - `spare`: scratch.
    ///
    /// # Source
    /// Shapiro, Kallmann and Faloutsos 2007, section 4.1, path smoothing.
    pub fn straighten_path(
        &mut self,
        path: &mut Vec<LimbState>,
        spare: &mut Vec<LimbState>,
        times: u32,
        rng: &mut Pcg64Mcg,
        keep_on: impl Fn() -> bool,
    ) {
        for _ in 0..times {
            let frames: [usize; 2] = std::array::from_fn(|_| rng.random_range(0..=self.grid.steps));
            if path.len() <= 2 || !keep_on() {
                return;
            }
            let [from, to] =
                [frames[0].min(frames[1]), frames[0].max(frames[1])].map(|f| self.state_at(path, self.grid.time_at(f)));
            let inner = |s: &&LimbState| s.time_s > from.time_s && s.time_s < to.time_s;
            let mut turned = 0.0;
            let mut last = &from;
            for next in path.iter().filter(inner).chain([&to]) {
                turned += self.total_turn(last, next);
                last = next;
            }
            if turned - self.total_turn(&from, &to) < LEAST_GAIN || !self.checker.is_edge_free(self.problem, &from, &to)
            {
                continue;
            }
            spare.clear();
            spare.extend(path.iter().filter(|s| s.time_s < from.time_s));
            spare.extend([from, to]);
            spare.extend(path.iter().filter(|s| s.time_s > to.time_s));
            std::mem::swap(path, spare);
        }
    }

    /// Sum of the turns of all joints (rad).
    fn total_turn(&self, from: &LimbState, to: &LimbState) -> f64 {
        (0..LIMB_JOINTS).map(|i| angle_between(from.pose.0[i], to.pose.0[i])).sum()
    }
}
