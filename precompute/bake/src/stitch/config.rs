//! How worlds are stitched.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_motion::error::{BuildError, check_ranges};

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
    /// (frames, 1 to 10000)
    pub min_frames: u32,
    /// Most joints that a block's cell may have with one other patch: the nearest ones are kept (1 to 1000).
    pub joints_per_cell: usize,
    /// A body that is deeper than this in a unit collides with it (m, 0 to 100).
    pub penetration_m: f32,
    /// Two units stand in each other where their solids are deeper in each other than this (m, > 0, <= 100).
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
    /// [`BuildError::Key`] names the key, what was expected and what was found.
    pub fn check(&self) -> Result<(), BuildError> {
        let above = |key, v: f32, high| {
            let fine = v > 0.0 && v <= high;
            let why = || format!("expected above 0, up to {high}, found {v}. Correct it or leave it out.");
            if fine { Ok(()) } else { Err(BuildError::key(key, why())) }
        };
        above("position_m", self.position_m, 0.5)
            .and_then(|()| above("height_m", self.height_m, 0.5))
            .and_then(|()| above("heading_deg", self.heading_deg, 45.0))
            .and_then(|()| above("overlap_m", self.overlap_m, 100.0))
            .and_then(|()| {
                check_ranges([
                    ("penetration_m", f64::from(self.penetration_m), 0.0, 100.0),
                    ("min_frames", f64::from(self.min_frames), 1.0, 1e4),
                    ("joints_per_cell", self.joints_per_cell as f64, 1.0, 1e3),
                ])
            })
            .map_err(|e| e.within("stitch"))
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
