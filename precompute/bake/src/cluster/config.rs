//! Settings of pose groups.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_motion::error::{Result, check_ranges};

/// Settings of the grouping of frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ClusterConfig {
    /// Upper bound of the distance between any two frames of a group (rad, as `features` explains; > 0).
    pub threshold: f64,
}

impl Default for ClusterConfig {
    fn default() -> Self {
        Self { threshold: 0.3 }
    }
}

impl ClusterConfig {
    /// Threshold as single precision: any distance below it is below the one of the config.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Key`] for a threshold outside its limits.
    pub(crate) fn check(&self) -> Result<f32> {
        check_ranges([("threshold", self.threshold, 1e-6, 1e3)]).map_err(|e| e.within_key("cluster"))?;
        Ok(self.threshold as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_thresholds_that_are_not_above_zero() {
        for threshold in [0.0, -0.3, f64::NAN, f64::INFINITY, 1e30, 1e-30] {
            let error = ClusterConfig { threshold }.check().unwrap_err().to_string();
            assert!(error.starts_with("cluster.threshold: expected 0.000001 to 1000, found"), "{error}");
        }
        assert_eq!(ClusterConfig::default().check().unwrap(), 0.3);
    }
}
