//! A walker that wanders.
//!
//! From intention to pose, in this order: `wander` deals the steps, `footsteps` places them on the ground and in time,
//! `foot` swings the feet and `roll` rolls them over the ground, `pelvis` moves the centre of mass over them and the hips
//! with it, and `trunk` and `arms` move the body along.

pub(super) mod arms;
pub(super) mod assemble;
pub(super) mod foot;
pub(super) mod footsteps;
pub(super) mod gait;
pub(super) mod pelvis;
pub(super) mod roll;
pub(super) mod trunk;
pub(super) mod wander;

use super::{SynthConfig, foot::FootShape};
use footsteps::{FeetStance, LAST_STAND};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use throng_core::Skeleton;
use throng_motion::clip::ClipSet;

/// Makes the `walk` set: wandering with straights, turns from gentle to on the spot, stops and starts, from slow to
/// brisk, on the default skeleton, with the true foot contacts.
///
/// - returns clips `walk_00`, `walk_01`, ... that begin and end standing.
pub fn walk(cfg: &SynthConfig) -> ClipSet {
    let skeleton = Skeleton::default();
    let shape = FootShape::from_skeleton(&skeleton);
    let mut rng = Pcg64Mcg::seed_from_u64(cfg.seed);
    let mut wanderer = wander::Wanderer::new(cfg.variation);
    let (mut clips, mut seconds) = (Vec::new(), 0.0);
    while seconds < cfg.minutes * 60.0 {
        let wanted = (cfg.minutes * 60.0 - seconds).min(cfg.clip_seconds * rng.random_range(0.85..1.1));
        let intents = wanderer.wander(wanted, &mut rng);
        let steps = footsteps::place_footsteps(shape, FeetStance::default(), &intents, LAST_STAND, |_| 0.0, &mut rng);
        seconds += steps.duration;
        let name = format!("walk_{:02}", clips.len());
        clips.push(assemble::clip(name, &steps, &skeleton, cfg, &mut rng));
    }
    ClipSet { skeleton, clips }
}

#[cfg(test)]
mod tests;
