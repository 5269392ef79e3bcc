//! Measures a bundle on this machine. One file answers one question.

mod characters;
mod levels;
pub mod timing;

pub use characters::{CharactersFigures, characters};
pub use levels::{LevelFigures, levels};

use throng_core::Bundle;
use throng_core::base::limits::{CHARACTERS, MEASURING_S};
use throng_motion::error::{Result, ensure};
use timing::fail;

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
        ensure(!tables.policies().is_empty(), || fail("the bundle has no behaviour"))?;
        let numbers = self.characters.iter().try_for_each(|&n| CHARACTERS.check_count("characters", n));
        let times = || MEASURING_S.check("seconds", None, self.seconds);
        numbers.and_then(|()| times()).map_err(|e| fail(e.to_string()))
    }
}
