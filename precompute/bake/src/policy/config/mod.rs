//! What the configuration says about behaviours and about solving them.

mod adaptive;
mod behaviour;
mod centre;
mod grid;
mod region;

pub use adaptive::AdaptiveConfig;
pub use behaviour::{BehaviourConfig, BehaviourKind, KernelConfig, RewardForm};
pub use centre::CentreConfig;
pub use grid::{BoundsConfig, GridConfig};
pub use region::RegionConfig;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How policies are solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PolicyConfig {
    /// Values are within this of the optimal ones, on a scale where standing on the target for ever is worth 1.
    /// (1e-6 to 1)
    pub epsilon: f64,
    /// Full sweeps after which solving is given up (> 0).
    pub max_sweeps: u32,
    /// Best actions stored per (state, cell) (1 to 4).
    pub choices: u32,
    /// Random (state, target) pairs on which the single-load answer is compared with the look-ahead.
    pub compare_samples: u32,
}

impl Default for PolicyConfig {
    fn default() -> Self {
        Self { epsilon: 1e-4, max_sweeps: 500, choices: 4, compare_samples: 10_000 }
    }
}
