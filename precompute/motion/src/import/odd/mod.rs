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
pub(super) fn tell(clip: &RawClip, roles: &RoleMap, warnings: &mut Warnings) {
    let told = [
        in_place::find(clip, roles).map(|f| f.to_string()),
        cadence::find(clip, roles).map(|f| f.to_string()),
        noise::find(clip, roles).map(|f| f.to_string()),
    ];
    told.into_iter().flatten().for_each(|what| warnings.push(format!("{}: {what}", clip.path.display())));
}
