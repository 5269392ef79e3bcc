//! Settings of adaptive resolution.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_motion::error::{BuildError, Result, check_ranges};

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
    pub(super) fn check(&self) -> Result<()> {
        if self.share <= 0.0 {
            return Err(BuildError::key("share", format!("expected above 0, up to 1, found {}", self.share)));
        }
        check_ranges([("share", self.share, 0.0, 1.0), ("tolerance", self.tolerance, 0.0, 1e6)])
    }
}
