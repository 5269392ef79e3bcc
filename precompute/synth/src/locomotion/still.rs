//! Standing at ease: periodic breath, weight and gaze.

use super::super::walk::trunk::Drift;
use rand::{Rng, RngExt};
use std::f64::consts::TAU;

/// Period of standing: a breath of fifteen a minute (s).
pub const PERIOD: f64 = 4.0;

/// State of standing at ease.
pub struct StandingEase {
    variation: f64,
    /// Phases of weight, gaze, nod, arms and breath (rad).
    phases: [f64; 6],
}

impl StandingEase {
    /// Begins at random phases.
    ///
    /// - `variation`: factor on the usual amount of shifting and looking.
    pub fn new(variation: f64, rng: &mut impl Rng) -> Self {
        Self { variation, phases: [(); 6].map(|()| rng.random_range(0.0..TAU)) }
    }

    /// Share of the weight on the left foot.
    pub fn left_foot_load(&self, t: f64) -> f64 {
        0.5 + 0.09 * self.variation * self.wave(0, t)
    }

    /// Gaze, arms and breath.
    pub fn drift(&self, times: &[f64]) -> Drift {
        let of = |k: usize, amount: f64| times.iter().map(|&t| amount * self.wave(k, t)).collect();
        let small = |k: usize, amount: f64| of(k, amount * self.variation);
        let arms = [3, 4].map(|k| small(k, 0.025));
        Drift { gaze: small(1, 0.07), nod: small(2, 0.02), arms, breath: of(5, 1.0) }
    }

    /// A slightly uneven wave of the period; even for the breath.
    fn wave(&self, k: usize, t: f64) -> f64 {
        let angle = TAU * t / PERIOD + self.phases[k];
        let uneven = if k == 5 { 0.0 } else { 0.35 };
        angle.sin() + uneven * (2.0 * angle + self.phases[5]).sin()
    }
}
