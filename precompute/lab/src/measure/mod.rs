//! Measures a bundle on this machine. One file answers one question.

mod blend;
mod characters;
mod levels;
mod matching;
mod timing;
mod world;

pub use blend::{BlendFigures, blend};
pub use characters::{CharactersFigures, characters};
pub use levels::{LevelFigures, levels};
pub use matching::{MatchingConfig, MatchingFigures, matching};
pub use world::{EditFigures, PathFigures, WorldFigures, world};

use serde::Serialize;
use throng_bake::policy::made_up::{self, MadeUp};
use throng_bake::policy::{self, Quality, QualityConfig};
use throng_motion::error::BuildError;
use throng_runtime::Bundle;
use throng_runtime::base::limits::PAIRS;
use timing::{fail, in_pool};

/// Precision of the made-up problem's values.
const EPSILON: f64 = 1e-4;

/// Settings of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasureConfig {
    /// Numbers of characters.
    pub characters: Vec<usize>,
    /// Numbers of threads.
    pub threads: Vec<usize>,
    /// Time given to each figure (s, > 0, <= 3600).
    pub seconds: f64,
}

/// All figures.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Measured {
    /// One entry for each number of characters and threads.
    pub results: Vec<CharactersFigures>,
    /// The made-up problem, on one thread.
    pub value_iteration: made_up::Measured,
}

/// Measures everything.
///
/// # Errors
/// As [`characters`].
pub fn measure(tables: &Bundle, config: &MeasureConfig) -> Result<Measured, BuildError> {
    let results = characters(tables, config)?;
    let value_iteration = in_pool(1, || MadeUp::default().measure(EPSILON))??;
    Ok(Measured { results, value_iteration })
}

/// Compares the reward that the policies of a bundle collect with that of a search, on the current rayon pool.
///
/// # Errors
/// [`BuildError::Stage`] where the bundle has no behaviour or a number is out of range.
pub fn quality(tables: &Bundle, config: &QualityConfig) -> Result<Vec<Quality>, BuildError> {
    if tables.policies().is_empty() {
        return Err(fail("the bundle has no behaviour"));
    }
    PAIRS.check_count("pairs", config.pairs).map_err(|e| fail(e.to_string()))?;
    let names = &tables.meta().behaviours;
    Ok(names.iter().enumerate().map(|(i, name)| policy::quality(&tables.policies()[i], name, config)).collect())
}
