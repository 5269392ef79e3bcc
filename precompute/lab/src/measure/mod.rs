//! Measures a bundle on this machine. One file answers one question.

mod characters;
mod levels;
pub mod timing;

pub use characters::{CharactersFigures, characters};
pub use levels::{LevelFigures, levels};

use serde::Serialize;
use throng_bake::policy::made_up::{self, SyntheticProblem};
use throng_core::Bundle;
use throng_core::base::limits::{CHARACTERS, MEASURING_S};
use throng_motion::error::Result;
use timing::{fail, run_in_pool};

/// Precision of the made-up problem's values.
const EPSILON: f64 = 1e-4;

/// Settings of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct BundleMeasureConfig {
    /// Numbers of characters.
    pub characters: Vec<usize>,
    /// Numbers of threads.
    pub threads: Vec<usize>,
    /// Time given to each figure (s, > 0, <= 3600).
    pub seconds: f64,
}

impl BundleMeasureConfig {
    /// Checks numbers of characters and times, and that a bundle has a behaviour.
    fn check(&self, tables: &Bundle) -> Result<()> {
        if tables.policies().is_empty() {
            return Err(fail("the bundle has no behaviour"));
        }
        let numbers = self.characters.iter().try_for_each(|&n| CHARACTERS.check_count("characters", n));
        let times = || MEASURING_S.check("seconds", None, self.seconds);
        numbers.and_then(|()| times()).map_err(|e| fail(e.to_string()))
    }
}

/// All figures.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BundleMeasureReport {
    /// One entry for each number of characters and threads.
    pub results: Vec<CharactersFigures>,
    /// The made-up problem, on one thread.
    pub value_iteration: made_up::SolveMeasurements,
}

/// Measures everything.
///
/// # Errors
/// As [`characters`].
pub fn measure(tables: &Bundle, config: &BundleMeasureConfig) -> Result<BundleMeasureReport> {
    let results = characters(tables, config)?;
    let value_iteration = run_in_pool(1, || SyntheticProblem::default().measure(EPSILON))??;
    Ok(BundleMeasureReport { results, value_iteration })
}
