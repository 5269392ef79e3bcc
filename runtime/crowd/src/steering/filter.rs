//! A Kalman filter on velocity, against abrupt changes that would show in a motion (Kim, Kim and Shin 2003b, section 2.1).

use crate::{Space, steering::config::SteeringConfig};
use serde::{Deserialize, Serialize};

/// Estimate of a velocity that wanders, from observations at any times; the same for each axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct VelocityFilter<V> {
    /// (m/s)
    pub velocity: V,
    /// Variance of the estimate (m2/s2).
    pub variance: f32,
}

impl<V: Space> VelocityFilter<V> {
    /// Adds an observation, `dt` after the one before.
    #[inline]
    pub fn observe(&mut self, velocity: V, dt: f32, steering: &SteeringConfig) {
        let predicted = self.variance + steering.filter_wander * dt;
        let gain = predicted / (predicted + steering.filter_sway);
        self.velocity += (velocity - self.velocity) * gain;
        self.variance = (1.0 - gain) * predicted;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn settles_on_constant_velocity_and_smooths_sway() {
        let steering = SteeringConfig::default();
        let mut filter = VelocityFilter { velocity: Vec2::ZERO, variance: 1.0 };
        let mut sways = 0.0f32;
        for i in 0..200 {
            let sway = if i % 2 == 0 { 0.2 } else { -0.2 };
            filter.observe(Vec2::new(1.3, sway), 0.1, &steering);
            if i > 100 {
                sways = sways.max(filter.velocity.y.abs());
            }
        }
        assert!((filter.velocity.x - 1.3).abs() < 1e-3);
        assert!(sways > 0.0 && sways < 0.15, "{sways}");
        // The variance is that of the equation p = (p + q)(1 - gain).
        let (q, s) = (steering.filter_wander * 0.1, steering.filter_sway);
        let p = filter.variance;
        assert!((p - (p + q) * s / (p + q + s)).abs() < 1e-5);
    }
}
