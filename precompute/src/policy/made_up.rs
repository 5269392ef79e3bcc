//! A made-up problem of fixed size to measure value iteration on: every action has a segment of its own.

use super::behaviour::Approach;
use super::config::{BehaviourConfig, GridConfig, PolicyConfig};
use super::model::{ActionModel, SegmentMotion};
use super::solve::{Solution, value_iteration};
use crate::error::BuildError;
use crate::progress::Silent;
use glam::Vec2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use throng_runtime::Planar;

/// Size of the problem of [`MadeUp::default`]: that of 003's boxer with a finer grid, 10.8 million pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MadeUp {
    /// States.
    pub states: u32,
    /// Actions of every state. [Limit: 1 to 255]
    pub actions: u32,
    /// Rings of the grid.
    pub rings: u32,
    /// Angles of the grid.
    pub angles: u32,
    /// Seed of the generator.
    pub seed: u64,
}

impl Default for MadeUp {
    fn default() -> Self {
        Self { states: 437, actions: 62, rings: 16, angles: 25, seed: 1 }
    }
}

impl MadeUp {
    /// The states and actions: random ends, 4 to 30 frames, 0.2 to 1.2 m along an arc of up to one radian.
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
                path: (0..=num_frames).map(|f| end * (f as f32 / num_frames as f32)).collect(),
            }
        });
        ActionModel {
            rate_hz: 30.0,
            segments: segments.collect(),
            action_offsets: (0..=self.states).map(|s| s * self.actions).collect(),
            action_segments: (0..num_segments).collect(),
        }
    }

    /// The behaviour: `approach` as by default, on a grid of this size.
    ///
    /// # Errors
    /// [`BuildError::Config`] where the grid's size is out of its range.
    pub fn behaviour(&self) -> Result<Approach, BuildError> {
        let grid = GridConfig { rings: self.rings, angles: self.angles, ..GridConfig::default() };
        Approach::new(&BehaviourConfig { grid, ..BehaviourConfig::default() }, 30.0)
    }

    /// Solves it on the current rayon pool.
    ///
    /// # Errors
    /// As [`value_iteration`].
    pub fn solve(&self, model: &ActionModel, epsilon: f64) -> Result<Solution, BuildError> {
        let cfg = PolicyConfig { epsilon, ..PolicyConfig::default() };
        value_iteration(model, &self.behaviour()?, &cfg, &Silent)
    }
}
