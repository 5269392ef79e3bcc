//! Target that gives way when it is struck and comes back, such as a ball on a string (Lee and Lee 2004, section 6).

use super::config::check_within;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::{Result, maths};

/// Settings of a struck target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetConfig {
    /// Radius (m, 0.001 to 1).
    pub radius_m: f32,
    /// Largest deflection for each metre per second of the blow (s, 0 to 1).
    pub deflection_m_per_mps: f32,
    /// Largest deflection (m, 0 to 10).
    pub max_deflection_m: f32,
    /// Approximate half-life of a deflection (s, 0.001 to 10).
    pub half_life_s: f32,
}

impl Default for TargetConfig {
    fn default() -> Self {
        Self { radius_m: 0.12, deflection_m_per_mps: 0.06, max_deflection_m: 0.5, half_life_s: 0.4 }
    }
}

impl TargetConfig {
    pub(super) fn check(&self) -> Result<()> {
        check_within("target.radius_m", self.radius_m, 1e-3, 1.0, "between 0.001 and 1")?;
        check_within("target.deflection_m_per_mps", self.deflection_m_per_mps, 0.0, 1.0, "between 0 and 1")?;
        check_within("target.max_deflection_m", self.max_deflection_m, 0.0, 10.0, "between 0 and 10")?;
        check_within("target.half_life_s", self.half_life_s, 1e-3, 10.0, "between 0.001 and 10")
    }

    /// Rate of the critically damped spring (1/s).
    fn rate(&self) -> f32 {
        2.0 * std::f32::consts::LN_2 / self.half_life_s
    }
}

/// Target that hangs at a home, which may be moved at any time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StruckTarget {
    /// Position of rest (m).
    pub home: Vec3,
    /// Displacement from the position of rest (m).
    pub offset: Vec3,
    /// Velocity of the displacement (m/s).
    pub velocity: Vec3,
}

impl StruckTarget {
    /// Target at rest.
    pub fn new(home: Vec3) -> Self {
        Self { home, ..Self::default() }
    }

    /// False for a state that no target can have.
    pub(super) fn is_valid(&self) -> bool {
        let near = |v: Vec3, most: f32| v.abs().max_element() <= most && !v.is_nan();
        near(self.home, 1e5) && near(self.offset, 100.0) && near(self.velocity, 1e6)
    }

    /// Current position (m).
    pub fn position(&self) -> Vec3 {
        self.home + self.offset
    }

    /// Strikes the target: it swings out in the direction of the blow, in proportion to its speed.
    ///
    /// - `direction`: direction of the blow, of unit length.
    pub fn strike(&mut self, config: &TargetConfig, direction: Vec3, speed_mps: f32) {
        // From rest, a critically damped spring of rate y swings out to v / (e y).
        let furthest = (speed_mps * config.deflection_m_per_mps).min(config.max_deflection_m);
        self.velocity = direction * (furthest * std::f32::consts::E * config.rate());
    }

    /// Advances the target by the exact solution.
    pub fn step(&mut self, config: &TargetConfig, dt_s: f32) {
        let rate = config.rate();
        let slope = self.velocity + self.offset * rate;
        let line = self.offset + slope * dt_s;
        let keep = maths::exp(-rate * dt_s);
        self.velocity = (slope - line * rate) * keep;
        self.offset = line * keep;
        // Struck again on its way out, it stops at the limit.
        let distance = self.offset.length();
        if distance > config.max_deflection_m {
            let out = self.offset / distance;
            self.offset = out * config.max_deflection_m;
            self.velocity -= out * self.velocity.dot(out).max(0.0);
        }
    }
}
