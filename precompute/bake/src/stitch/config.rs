//! Settings of stitching.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_base::thresholds::BODY_IN_WORLD_M;
use throng_motion::error::{BuildError, Result, check_ranges};

/// Settings for fitting patches into an environment and joining them where they overlap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct StitchConfig {
    /// Largest distance on the ground over which motion continues in another patch (m, > 0, <= 0.5).
    pub position_m: f32,
    /// Largest height difference of such a continuation (m, > 0, <= 0.5).
    pub height_m: f32,
    /// Largest heading difference of such a continuation (deg, > 0, <= 45).
    pub heading_deg: f32,
    /// Least distance from the ends of a tile's motion at which it is left and entered; for short motion a quarter of
    /// it suffices (frames, 1 to 10000).
    pub min_frames: u32,
    /// Most joints that a block's cell may have with one other patch: the nearest ones are kept (1 to 1000).
    pub joints_per_cell: usize,
    /// Depth of a body in a unit above which it collides (m, 0 to 100).
    pub penetration_m: f32,
    /// Depth of the solids of two units in each other above which the units overlap (m, > 0, <= 100).
    pub overlap_m: f32,
    /// Names of units that are obstacles only, such as walls: no patch need fit them.
    pub obstacles: Vec<String>,
    /// True to allow units that no character can reach, or leave again.
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
            penetration_m: BODY_IN_WORLD_M,
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
    pub fn check(&self) -> Result<()> {
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
            .map_err(|e| e.within_key("stitch"))
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
