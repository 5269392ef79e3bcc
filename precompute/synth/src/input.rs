//! Synthetic clips as the input of a build.

use super::{SynthConfig, SynthSet, files, make_set};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, path::Path};
use throng_motion::annotate::Sidecar;
use throng_motion::error::{BuildError, Result, check_ranges};
use throng_motion::import::{self, ImportConfig, ImportedSet};

/// Synthetic motion as input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SynthInput {
    /// Set of motion.
    pub set: SynthSet,
    /// Length; the default of `throng synth` if absent (min, 0.05 to 240).
    pub minutes: Option<f64>,
    /// Seed, which determines the motion; the default of `throng synth` if absent.
    pub seed: Option<u64>,
    /// Further sets.
    #[serde(default)]
    pub also: Vec<SynthInput>,
}

impl SynthInput {
    /// Settings at a rate (Hz).
    pub fn config(&self, rate_hz: f64) -> SynthConfig {
        let usual = SynthConfig::for_set(self.set);
        let (minutes, seed) = (self.minutes.unwrap_or(usual.minutes), self.seed.unwrap_or(usual.seed));
        SynthConfig { minutes, seed, rate_hz, ..usual }
    }

    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`BuildError::Key`] names the first one out of its range.
    pub fn check(&self) -> Result<()> {
        check_ranges([("minutes", self.minutes.unwrap_or(1.0), 0.05, 240.0)])?;
        self.also.iter().enumerate().try_for_each(|(i, s)| s.check().map_err(|e| e.within_key(&format!("also[{i}]"))))
    }

    /// This set and the further ones.
    pub fn with_others(&self) -> Vec<&SynthInput> {
        std::iter::once(self).chain(self.also.iter().flat_map(SynthInput::with_others)).collect()
    }
}

/// Makes the clips, as if they had been written as files and read again, and the contents of their sidecars.
///
/// - `rate_hz`: of the clips (Hz).
///
/// # Errors
/// As [`make_set`].
pub fn input(
    cfg: &SynthInput,
    rate_hz: f64,
    import: &ImportConfig,
) -> Result<(ImportedSet, BTreeMap<String, Sidecar>)> {
    let (mut all, mut sidecars) = (ImportedSet { clips: Vec::new(), skipped: Vec::new() }, BTreeMap::new());
    let inputs = cfg.with_others();
    for (i, one) in inputs.iter().enumerate() {
        if inputs[..i].iter().any(|o| o.set == one.set) {
            let name = one.set.name();
            let why = format!("expected every set once, found `{name}` again. Raise its minutes instead");
            return Err(BuildError::key("synth.also", why));
        }
        let set = make_set(one.set, &one.config(rate_hz))?;
        sidecars.extend(set.clips.iter().filter_map(|c| Some((c.name.clone(), files::sidecar(c)?))));
        all.clips.extend(import::import_made(&set, Path::new(one.set.name()), import)?.clips);
    }
    Ok((all, sidecars))
}
