//! Oddities of a person's motion as a whole, which deserve a warning before anything is built of it.

mod cadence;
mod in_place;
mod noise;

use super::roles::RoleMap;
use crate::error::Warnings;
use crate::raw::RawClip;

/// Warns of walks on the spot, of steps that are too fast, and of noise.
///
/// - `clip`: in metres, Y up, its glitches mended; a walk on the spot gets root motion.
/// - `root_motion`: false leaves it on the spot.
pub(super) fn treat_oddities(clip: &mut RawClip, roles: &RoleMap, root_motion: bool, warnings: &mut Warnings) {
    let found = [
        in_place::give_root_motion(clip, roles, root_motion),
        cadence::find_fast_steps(clip, roles),
        noise::find_noise(clip, roles),
    ];
    found.into_iter().flatten().for_each(|what| warnings.push(format!("{}: {what}", clip.path.display())));
}
