//! Loss of the single-load answer against the look-ahead.

use glam::Vec3;
use rand::RngExt;
use rand_pcg::Pcg64;
use throng_core::policy::{MAX_ACTIONS, PolicyTable};

/// Single-load choices against look-ahead choices, for random states and targets over the whole grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Comparison {
    /// Number of (state, target) queries.
    pub samples: u32,
    /// Share of queries with different actions.
    pub different_share: f64,
    /// Mean loss of the single-load action, by the look-ahead's score, relative to the best score.
    pub mean_loss: f64,
    /// Largest such loss.
    pub worst_loss: f64,
}

/// Compares both answers for random states and targets: angles and distances uniform, and heights if there are several.
pub fn compare(table: &PolicyTable, samples: u32, rng: &mut Pcg64) -> Comparison {
    let mut scores = [0.0; MAX_ACTIONS];
    let num_states = table.actions().num_states() as u32;
    let mut out = Comparison { samples, ..Comparison::default() };
    for _ in 0..samples {
        let state = rng.random_range(0..num_states);
        let target = random_target(table, rng);
        let n = table.action_scores(state, target, &mut scores).expect("the state exists and the target is finite");
        let best = scores[..n].iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let stored = table.best_of(state, table.nearest_cell(state, target))[0];
        let loss = f64::from(best - scores[usize::from(stored)]) / f64::from(best.abs()).max(1e-12);
        out.different_share += f64::from(u8::from(loss > 0.0)) / f64::from(samples);
        out.mean_loss += loss / f64::from(samples);
        out.worst_loss = out.worst_loss.max(loss);
    }
    out
}

/// A random target within the grid, in the character's frame: angle and distance uniform, and the height if there are
/// several.
pub fn random_target(table: &PolicyTable, rng: &mut Pcg64) -> Vec3 {
    let r = table.grid().record();
    // Periodic angles: the last cell extends to the first.
    let sectors = if table.grid().is_polar() { r.num_angles } else { r.num_angles - 1 };
    let angle = r.angle_start + r.angle_spacing * sectors as f32 * rng.random::<f32>();
    let distance = r.ring_start + (table.grid().radius() - r.ring_start) * rng.random::<f32>();
    let height = r.height_start + r.height_spacing * (r.num_heights - 1) as f32 * rng.random::<f32>();
    Vec3::new(distance * angle.sin(), height, distance * angle.cos()) + table.centre()
}
