//! Oddities of a person's motion as a whole, which deserve a warning before anything is built of it.

mod cadence;
mod in_place;
mod noise;

use super::roles::RoleMap;
use crate::error::Warnings;
use crate::raw::RawClip;

/// Warns of walks on the spot, of steps that are too fast, and of noise.
///
/// - `clip`: in metres, Y up, its glitches mended.
pub(super) fn warn_of_oddities(clip: &RawClip, roles: &RoleMap, warnings: &mut Warnings) {
    let found = [
        in_place::find_walk_in_place(clip, roles),
        cadence::find_fast_steps(clip, roles),
        noise::find_noise(clip, roles),
    ];
    found.into_iter().flatten().for_each(|what| warnings.push(format!("{}: {what}", clip.path.display())));
}
