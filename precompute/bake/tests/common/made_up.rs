//! A synthetic problem of any size for value iteration: every action has a segment of its own.

use super::behaviour::Approach;
use super::config::{GridConfig, PolicyBehaviourConfig, PolicyConfig};
use super::model::{ActionModel, SegmentMotion};
use super::solve::{PolicySolver, Solution};
use glam::Vec2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use throng_base::SingleRank;
use throng_core::Planar;
use throng_motion::error::Result;
use throng_motion::progress::Silent;

/// Size of a synthetic problem. [`SyntheticProblem::default`] is that of Lee and Lee's (2004) boxer with a finer grid, 10.8
/// million pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SyntheticProblem {
    /// States.
    pub states: u32,
    /// Actions of every state (1 to 255).
    pub actions: u32,
    /// Rings of the grid.
    pub rings: u32,
    /// Angles of the grid.
    pub angles: u32,
    /// Seed of the generator.
    pub seed: u64,
}

impl Default for SyntheticProblem {
    fn default() -> Self {
        Self { states: 437, actions: 62, rings: 16, angles: 25, seed: 1 }
    }
}

impl SyntheticProblem {
    /// Policy of a behaviour, solved on this problem.
    #[cfg(test)]
    pub(crate) fn solve_timed(&self, behaviour: &Approach) -> throng_core::policy::PolicyTable {
        let cfg = PolicyConfig { compare_samples: 1, ..PolicyConfig::default() };
        let mut rng = Pcg64::seed_from_u64(1);
        let solver = PolicySolver { model: &self.model(), cfg: &cfg, progress: &Silent, comm: &SingleRank };
        solver.solve_all(&[behaviour], &mut rng).expect("it converges").table(0).expect("sound tables")
    }

    /// States and actions: random ends, 4 to 30 frames, 0.2 to 1.2 m along an arc of up to one radian.
    pub fn model(&self) -> ActionModel {
        let mut rng = Pcg64::seed_from_u64(self.seed);
        let num_segments = self.states * self.actions;
        let segments = (0..num_segments).map(|_| {
            let num_frames = rng.random_range(4..=30u32);
            let (length, turn) = (rng.random_range(0.2..1.2f32), rng.random_range(-1.0..1.0f32));
            let direction = 0.5 * turn + rng.random_range(-0.3..0.3f32);
            let end = Vec2::new(length * direction.sin(), length * direction.cos());
            SegmentMotion {
                end: rng.random_range(0..self.states),
                num_frames,
                displacement: Planar::new(end.x, end.y, turn),
                path: (0..=num_frames)
                    .map(|f| f as f32 / num_frames as f32)
                    .map(|t| Planar::new(t * end.x, t * end.y, t * turn))
                    .collect(),
            }
        });
        ActionModel {
            rate_hz: 30.0,
            segments: segments.collect(),
            action_offsets: (0..=self.states).map(|s| s * self.actions).collect(),
            action_segments: (0..num_segments).collect(),
            action_errors: (0..num_segments)
                .map(|a| if a % self.actions == 0 { 0.0 } else { 0.1 * (a % 5) as f32 })
                .collect(),
            action_traits: Vec::new(),
        }
    }

    /// Default `approach` behaviour, on a grid of this size.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Config`] if the grid's size is out of its range.
    pub fn behaviour(&self) -> Result<Approach> {
        let grid = GridConfig { rings: Some(self.rings), angles: Some(self.angles), ..GridConfig::default() };
        Approach::new(&PolicyBehaviourConfig { grid, ..PolicyBehaviourConfig::default() }, 30.0, None)
    }

    /// Solves the problem on the current rayon pool.
    ///
    /// # Errors
    /// As [`PolicySolver::value_iteration`].
    pub fn solve(&self, model: &ActionModel, epsilon: f64) -> Result<Solution> {
        let cfg = PolicyConfig { epsilon, ..PolicyConfig::default() };
        PolicySolver { model, cfg: &cfg, progress: &Silent, comm: &SingleRank }.value_iteration(&self.behaviour()?)
    }
}
