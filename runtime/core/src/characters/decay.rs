//! The offsets of the last transition, which decay as critically damped springs do.

use super::block::{BodyBlock, MotionBlock, ROTATION_CODES, VELOCITY_CODES, load_codes};
use crate::body::{Decay, HALF_LIVES_KEPT, LanePose, load};
use throng_base::simd::{Lanes, Q};

/// Adds the decaying offsets of the last transition.
#[inline(always)]
pub(crate) fn add_offsets<F: Lanes>(pose: &mut LanePose<F>, block: &MotionBlock, body: &BodyBlock, half_life_s: f32) {
    let (age, kept, zero) = (F::load(&block.age_s), F::splat(HALF_LIVES_KEPT * half_life_s), F::splat(0.0));
    // No lane's offsets matter any more.
    if !kept.any_gt(age) {
        return;
    }
    let mut decay = Decay::new(age, half_life_s);
    // A lane whose offsets have decayed has none, whatever its neighbours hold.
    decay.position = F::select_lt(kept, age, zero, decay.position);
    decay.velocity = F::select_lt(kept, age, zero, decay.velocity);
    let o = &body.offsets;
    pose.root = pose.root + decay.apply(load(&o.root), load(&o.root_velocity));
    let decay = Decay {
        position: decay.position * F::splat(1.0 / ROTATION_CODES),
        velocity: decay.velocity * F::splat(1.0 / VELOCITY_CODES),
    };
    for (q, (x, v)) in pose.rotations.iter_mut().zip(o.rotation.iter().zip(&o.rotation_velocity)) {
        *q = Q::from_mrp(decay.apply(load_codes(x), load_codes(v))) * *q;
    }
}
