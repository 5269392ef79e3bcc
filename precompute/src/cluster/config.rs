//! How alike the frames of a pose group are.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How frames are grouped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ClusterConfig {
    /// Any two frames of a group are nearer to each other than this. [Unit: rad, as `features` explains]
    /// [Limit: > 0]
    pub threshold: f64,
}

impl Default for ClusterConfig {
    fn default() -> Self {
        Self { threshold: 0.3 }
    }
}
