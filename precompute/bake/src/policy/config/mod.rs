//! Settings of behaviours and of solving them.

mod behaviour;
mod centre;
mod costs;
mod grid;
mod region;

pub use behaviour::{BehaviourKind, KernelConfig, PolicyBehaviourConfig, RewardForm};
pub use centre::CentreConfig;
pub use costs::CostsConfig;
pub use grid::{BoundsConfig, GridConfig};
pub use region::RegionConfig;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_core::policy::MAX_RANKED;
use throng_motion::error::{BuildError, Result, check_ranges};

/// Settings of solving policies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PolicyConfig {
    /// Largest distance of values from the optimal ones, on a scale on which standing on the target for ever is worth 1
    /// (1e-6 to 1).
    pub epsilon: f64,
    /// Most full sweeps before solving fails (1 to 1e6).
    pub max_sweeps: u32,
    /// Number of best actions stored per (state, cell) (1 to 4).
    pub choices: u32,
    /// Number of random (state, target) pairs on which the single-load answer is compared with the look-ahead (0 to
    /// 1e7).
    pub compare_samples: u32,
}

impl Default for PolicyConfig {
    fn default() -> Self {
        Self { epsilon: 1e-4, max_sweeps: 500, choices: 4, compare_samples: 10_000 }
    }
}

impl PolicyConfig {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Key`] names the first one out of its range.
    pub(crate) fn check(&self) -> Result<()> {
        let ranges = [
            ("epsilon", self.epsilon, 1e-6, 1.0),
            ("max_sweeps", f64::from(self.max_sweeps), 1.0, 1e6),
            ("choices", f64::from(self.choices), 1.0, MAX_RANKED as f64),
            ("compare_samples", f64::from(self.compare_samples), 0.0, 1e7),
        ];
        check_ranges(ranges).map_err(|e| e.within_key("policy"))
    }
}

/// Resolution per state: fine for values that change fast, coarse for others (Lee and Lee 2004, section 7).
///
/// The policy is solved with the grid's counts everywhere, which are the finest; then every state gets a smaller grid
/// over the same region, with values fitted to it. Cells are spent where they lower the error most.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AdaptiveConfig {
    /// Memory of values and best actions, as a share of that of the finest grid everywhere (> 0, <= 1).
    pub share: f64,
    /// Error of a state's values, as a root mean square over the finest cells, below which it gets no finer grid even
    /// with memory left (>= 0).
    pub tolerance: f64,
}

impl Default for AdaptiveConfig {
    fn default() -> Self {
        Self { share: 0.25, tolerance: 0.0 }
    }
}

impl AdaptiveConfig {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`BuildError::Key`] names the key out of its range.
    fn check(&self) -> Result<()> {
        if self.share <= 0.0 {
            return Err(BuildError::key("share", format!("expected above 0, up to 1, found {}", self.share)));
        }
        check_ranges([("share", self.share, 0.0, 1.0), ("tolerance", self.tolerance, 0.0, 1e6)])
    }
}
