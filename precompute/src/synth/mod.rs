//! Synthetic motion: a procedural walker, so that a fresh machine needs no captured motion.
//!
//! From intention to pose, in this order: `wander` deals the steps, `footsteps` lays them on the ground and in time,
//! `foot` rolls and swings the feet, `balance` moves the centre of mass over them, `pelvis`, `trunk` and `arms` carry
//! the body along, and `leg` closes the legs. Feet come first: what stands on the ground never slides, and the rest of
//! the body follows from it.

mod arms;
mod assemble;
mod balance;
mod files;
mod foot;
mod footsteps;
mod gait;
mod leg;
mod pelvis;
mod side;
mod signal;
mod trunk;
mod wander;

pub use files::save;

use crate::clip::ClipSet;
use crate::error::BuildError;
use foot::FootShape;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;
use throng_runtime::Skeleton;

/// How much motion to make, and how varied.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SynthConfig {
    /// Same seed, same motion, to the bit.
    pub seed: u64,
    /// Length of the whole set; clips end standing, so it comes out a little longer. [Unit: min] [Limit: 0 to 240]
    pub minutes: f64,
    /// Length of one clip, about. [Unit: s] [Limit: 10 to 600]
    pub clip_seconds: f64,
    /// Frames a second. [Unit: Hz] [Limit: 20 to 240]
    pub rate_hz: f64,
    /// How much steps, arms and gaze vary; 0 repeats every step exactly. [Limit: 0 to 2]
    pub variation: f64,
}

impl Default for SynthConfig {
    fn default() -> Self {
        Self { seed: 1, minutes: 6.0, clip_seconds: 40.0, rate_hz: 30.0, variation: 1.0 }
    }
}

impl SynthConfig {
    fn check(&self) -> Result<(), BuildError> {
        let limits = [
            ("minutes", self.minutes, 0.05, 240.0),
            ("clip_seconds", self.clip_seconds, 10.0, 600.0),
            ("rate_hz", self.rate_hz, 20.0, 240.0),
            ("variation", self.variation, 0.0, 2.0),
        ];
        match limits.into_iter().find(|(_, v, low, high)| !(low..=high).contains(&v)) {
            None => Ok(()),
            Some((key, v, low, high)) => Err(BuildError::Config {
                message: format!("synth.{key}: expected {low} to {high}, found {v}. Change it in the config."),
            }),
        }
    }
}

/// Makes the `walk` set: wandering with straights, turns from gentle to on the spot, stops and starts, from slow to
/// brisk, on the default skeleton, with the true foot contacts.
///
/// - returns clips `walk_00`, `walk_01`, ... that begin and end standing.
///
/// # Errors
/// [`BuildError::Config`] for a value outside its limits.
pub fn walk(cfg: &SynthConfig) -> Result<ClipSet, BuildError> {
    cfg.check()?;
    let skeleton = Skeleton::default();
    let shape = FootShape::of(&skeleton);
    let mut rng = Pcg64Mcg::seed_from_u64(cfg.seed);
    let mut wanderer = wander::Wanderer::new(cfg.variation);
    let (mut clips, mut seconds) = (Vec::new(), 0.0);
    while seconds < cfg.minutes * 60.0 {
        let wanted = (cfg.minutes * 60.0 - seconds).min(cfg.clip_seconds * rng.random_range(0.85..1.1));
        let intents = wanderer.wander(wanted, &mut rng);
        let steps = footsteps::place(shape, &intents, &mut rng);
        seconds += steps.duration;
        let name = format!("walk_{:02}", clips.len());
        clips.push(assemble::clip(name, &steps, &skeleton, cfg, &mut rng));
    }
    Ok(ClipSet { skeleton, clips })
}

/// Makes the `walk` set and writes each clip as `NAME.bvh` into a folder, which is made if it is not there.
///
/// - returns what was written.
///
/// # Errors
/// As [`walk`] and [`save`].
pub fn write_walk(cfg: &SynthConfig, folder: &Path) -> Result<ClipSet, BuildError> {
    let set = walk(cfg)?;
    save(&set, folder)?;
    Ok(set)
}

#[cfg(test)]
mod tests;
