//! A Kalman filter on velocity, against abrupt changes that would show in a motion (001 section 2.1).

use super::Space;
use serde::{Deserialize, Serialize};

/// How much a velocity wanders by itself. [Unit: m2/s3]
const WANDER: f32 = 2.0;
/// Variance of what is observed: how much of an observed velocity is sway. [Unit: m2/s2]
const SWAY: f32 = 0.1;

/// Estimate of a velocity that wanders, from observations at any times; the same for each axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Filter<V> {
    /// [Unit: m/s]
    pub velocity: V,
    /// Of the estimate. [Unit: m2/s2]
    pub variance: f32,
}

impl<V: Space> Filter<V> {
    /// Takes in what was observed, `dt` after the observation before.
    #[inline]
    pub fn observe(&mut self, velocity: V, dt: f32) {
        let predicted = self.variance + WANDER * dt;
        let gain = predicted / (predicted + SWAY);
        self.velocity += (velocity - self.velocity) * gain;
        self.variance = (1.0 - gain) * predicted;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn settles_on_what_stays_and_smooths_what_sways() {
        let mut filter = Filter { velocity: Vec2::ZERO, variance: 1.0 };
        let mut sways = 0.0f32;
        for i in 0..200 {
            let sway = if i % 2 == 0 { 0.2 } else { -0.2 };
            filter.observe(Vec2::new(1.3, sway), 0.1);
            if i > 100 {
                sways = sways.max(filter.velocity.y.abs());
            }
        }
        assert!((filter.velocity.x - 1.3).abs() < 1e-3);
        assert!(sways > 0.0 && sways < 0.15, "{sways}");
        // The variance is that of the equation p = (p + q)(1 - gain).
        let q = WANDER * 0.1;
        let p = filter.variance;
        assert!((p - (p + q) * SWAY / (p + q + SWAY)).abs() < 1e-5);
    }
}
