//! Synthetic motion, so that a fresh machine needs no captured motion: rigs that walk, box and play by rule and chance.
//!
//! A rig goes from intention to pose. Feet come first: a planted foot never slides, and the rest of the body follows
//! from the feet. Each rig has a folder; shared parts are here: the geometry of feet and limbs (`foot`, `leg`, `arm`),
//! balance (`pendulum`), smooth signals (`signal`), chance (`deck`), and the conversion to clips (`frame`).

mod arm;
mod attitude;
mod boxing;
#[cfg(test)]
#[path = "../tests/common/checks.rs"]
mod checks;
mod deck;
mod files;
mod foot;
mod frame;
mod input;
mod leg;
mod locomotion;
mod office;
mod pendulum;
mod people;
mod playground;
mod set;
mod side;
mod signal;
mod track;
mod walk;

pub use files::save;
pub use input::{SynthInput, input};
pub use set::{SynthSet, make_set, write_set};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_base::limits::{RATE_HZ, SYNTH_MINUTES};
use throng_motion::error::{Result, check_ranges};

/// Settings of synthetic motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SynthConfig {
    /// Seed: equal seeds give equal motion, to the bit.
    pub seed: u64,
    /// Length of the whole set; clips end standing, so the result is a little longer. The locomotion set is a list: a
    /// shorter length gives its first clips, a longer one further takes (min, 0.05 to 240).
    pub minutes: f64,
    /// Approximate length of one clip; exact for the locomotion set (s, 3 to 600).
    pub clip_seconds: f64,
    /// Frame rate (Hz, 20 to 240).
    pub rate_hz: f64,
    /// Amount of variation of steps, arms and gaze; 0 repeats every step exactly (0 to 2).
    pub variation: f64,
}

impl Default for SynthConfig {
    fn default() -> Self {
        Self { seed: 1, minutes: 6.0, clip_seconds: 40.0, rate_hz: 30.0, variation: 1.0 }
    }
}

impl SynthConfig {
    /// Default settings of a set in `throng synth`: its own length, and defaults otherwise.
    pub fn for_set(set: SynthSet) -> Self {
        match set {
            SynthSet::Walk => Self::default(),
            SynthSet::Boxing => Self { minutes: 8.0, clip_seconds: 60.0, ..Self::default() },
            SynthSet::Office => Self { minutes: 13.0, clip_seconds: 60.0, ..Self::default() },
            SynthSet::Playground => Self { minutes: 12.0, clip_seconds: 60.0, ..Self::default() },
            SynthSet::People => Self { minutes: people::MINUTES, ..Self::default() },
            SynthSet::Locomotion => {
                let clip_seconds = locomotion::CLIP_SECONDS;
                let minutes = locomotion::NUM_ACTS as f64 * clip_seconds / 60.0;
                Self { minutes, clip_seconds, ..Self::default() }
            }
        }
    }

    fn check(&self) -> Result<()> {
        let ranges = [
            ("minutes", self.minutes, SYNTH_MINUTES.least, SYNTH_MINUTES.most),
            ("clip_seconds", self.clip_seconds, 3.0, 600.0),
            ("rate_hz", self.rate_hz, RATE_HZ.least, RATE_HZ.most),
            ("variation", self.variation, 0.0, 2.0),
        ];
        check_ranges(ranges).map_err(|e| e.within_key("synth"))
    }
}
