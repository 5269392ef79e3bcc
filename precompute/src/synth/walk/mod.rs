//! A walker that wanders.
//!
//! From intention to pose, in this order: `wander` deals the steps, `footsteps` lays them on the ground and in time,
//! `foot` rolls and swings the feet, `balance` moves the centre of mass over them, `pelvis`, `trunk` and `arms` carry
//! the body along.

mod arms;
mod assemble;
mod balance;
mod foot;
mod footsteps;
mod gait;
mod pelvis;
mod trunk;
mod wander;

use super::SynthConfig;
use super::foot::FootShape;
use crate::clip::ClipSet;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use throng_runtime::Skeleton;

/// Makes the `walk` set: wandering with straights, turns from gentle to on the spot, stops and starts, from slow to
/// brisk, on the default skeleton, with the true foot contacts.
///
/// - returns clips `walk_00`, `walk_01`, ... that begin and end standing.
pub fn walk(cfg: &SynthConfig) -> ClipSet {
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
    ClipSet { skeleton, clips }
}

#[cfg(test)]
mod tests;
