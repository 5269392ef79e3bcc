//! How worlds are stitched.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_motion::error::BuildError;

/// How patches are fitted into an environment and joined where they overlap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct StitchConfig {
    /// Motion goes on in another patch no farther away than this on the ground (m, > 0, <= 0.5).
    pub position_m: f32,
    /// And no higher or lower than this (m, > 0, <= 0.5).
    pub height_m: f32,
    /// And turned by no more than this (deg, > 0, <= 45).
    pub heading_deg: f32,
    /// Motion of a tile is left and entered no nearer to its ends than this, or than a quarter of it where it is short.
    /// (frames, >= 1)
    pub min_frames: u32,
    /// Most joints that a block's cell may have with one other patch: the nearest ones are kept (>= 1).
    pub joints_per_cell: usize,
    /// A body that is deeper than this in a unit collides with it (m, >= 0).
    pub penetration_m: f32,
    /// Two units stand in each other where their solids are deeper in each other than this (m, > 0).
    pub overlap_m: f32,
    /// Names of units that are only in the way, such as walls: no patch need fit them.
    pub obstacles: Vec<String>,
    /// True where units may be left over that no character can get to, or away from again.
    pub allow_unreachable: bool,
}

impl Default for StitchConfig {
    fn default() -> Self {
        Self {
            position_m: 0.1,
            height_m: 0.1,
            heading_deg: 10.0,
            min_frames: 10,
            joints_per_cell: 16,
            penetration_m: 0.05,
            overlap_m: 0.15,
            obstacles: Vec::new(),
            allow_unreachable: false,
        }
    }
}

impl StitchConfig {
    /// Checks the limits of its numbers.
    ///
    /// # Errors
    /// [`BuildError::Config`] names the key, what was expected and what was found.
    pub fn check(&self) -> Result<(), BuildError> {
        let numbers = [
            ("position_m", self.position_m, self.position_m > 0.0 && self.position_m <= 0.5, "above 0, up to 0.5"),
            ("height_m", self.height_m, self.height_m > 0.0 && self.height_m <= 0.5, "above 0, up to 0.5"),
            ("heading_deg", self.heading_deg, self.heading_deg > 0.0 && self.heading_deg <= 45.0, "above 0, up to 45"),
            ("penetration_m", self.penetration_m, self.penetration_m >= 0.0, "0 or more"),
            ("overlap_m", self.overlap_m, self.overlap_m > 0.0, "above 0"),
        ];
        let counts = [("min_frames", self.min_frames as usize), ("joints_per_cell", self.joints_per_cell)];
        let bad_number = numbers.iter().find(|n| !n.2).map(|n| (n.0, n.3, n.1.to_string()));
        let bad_count = counts.iter().find(|c| c.1 == 0).map(|c| (c.0, "1 or more", c.1.to_string()));
        match bad_number.or(bad_count) {
            None => Ok(()),
            Some((key, expected, found)) => Err(BuildError::Config {
                message: format!("[stitch] {key}: expected {expected}, found {found}. Correct it or leave it out."),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_limits_are_refused_by_name() {
        assert!(StitchConfig::default().check().is_ok());
        let bad = StitchConfig { heading_deg: f32::NAN, ..StitchConfig::default() };
        assert!(bad.check().unwrap_err().to_string().contains("heading_deg: expected above 0, up to 45, found NaN"));
        let bad = StitchConfig { min_frames: 0, ..StitchConfig::default() };
        assert!(bad.check().unwrap_err().to_string().contains("min_frames"));
    }
}
