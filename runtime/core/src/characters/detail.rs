//! Bodies that sleep while nobody is near, and the records of characters.

use super::block::{BodyBlock, MotionBlock};
use super::{motion_set::MotionSet, transition};
use crate::body::{Decay, DetailLevel, FramePosition, HALF_LIVES_KEPT, PlacementLanes, PoseInstance, unorm};
use throng_base::simd::{LANES, Lanes};

/// Wakes a body or lets it sleep, as its block's level requires.
pub fn set_awake(to: DetailLevel, block: &MotionBlock, body: &mut BodyBlock, motion_set: &MotionSet, half_life_s: f32) {
    match (to, body.awake) {
        (DetailLevel::Record, 1) => *body = BodyBlock::ZERO,
        (DetailLevel::Full | DetailLevel::FreeFeet, 0) => transition::wake_block(block, body, motion_set, half_life_s),
        _ => {}
    }
}

/// Writes the records of a block (out.len() <= 8).
#[inline(always)]
pub(super) fn write_instances<F: Lanes>(
    out: &mut [PoseInstance],
    block: &MotionBlock,
    spots: &[FramePosition; LANES],
    place: &PlacementLanes<F>,
    motion_set: &MotionSet,
    half_life_s: f32,
) {
    let kept = F::splat(HALF_LIVES_KEPT * half_life_s);
    let age = F::load(&block.age_s);
    let fading = F::select_lt(kept, age, F::splat(0.0), Decay::new(age, half_life_s).position);
    let (fading, y) = (fading.to_array(), place.y.to_array());
    for (l, out) in out.iter_mut().enumerate() {
        let (spot, [from, to]) = (&spots[l], [block.change[0][l], block.change[1][l]]);
        let (row, blend) = (spot.frame as u32, unorm(fading[l]));
        // What was left goes on beside what is played, as far as its clip goes.
        let since = row.wrapping_sub(to).min(motion_set.frames_after(from).saturating_sub(1));
        *out = PoseInstance {
            row_a: row,
            row_b: if blend > 0 { from + since } else { row },
            frac_blend: [unorm(spot.ratio), blend],
            variant: block.name[l] as u32,
            x: block.root[0][l],
            y: y[l],
            z: block.root[1][l],
            heading: block.root[2][l],
        };
    }
}

#[cfg(test)]
mod tests;
