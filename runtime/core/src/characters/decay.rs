//! The offsets of the last transition, which decay as critically damped springs do.

use super::block::{Block, ROTATION_CODES, VELOCITY_CODES, load_codes};
use crate::pose::{LanePose, load};
use throng_base::simd::{Functions, Lanes, Q, V};

/// Past this many half-lives an offset is below a four-hundredth of what it was and is no longer applied.
const HALF_LIVES_KEPT: f32 = 6.0;

/// Coefficients of a critically damped spring that has run for `age_s`: the offset is `position * x + velocity * v`.
///
/// (s for `velocity`)
pub(crate) struct Decay<F> {
    pub position: F,
    pub velocity: F,
}

impl<F: Lanes> Decay<F> {
    /// `x(t) = exp(-y t) (x0 + (v0 + y x0) t)` with y = 2 ln 2 / half-life.
    #[inline(always)]
    pub fn new(age_s: F, half_life_s: f32) -> Self {
        let y = F::splat(2.0 * std::f32::consts::LN_2 / half_life_s);
        let age = age_s.min(F::splat(8.0 * HALF_LIVES_KEPT * half_life_s));
        let e = (-(y * age)).exp8();
        Self { position: e * (F::splat(1.0) + y * age), velocity: e * age }
    }

    /// The rate of change of the offset at that age: `position' * x + velocity' * v`.
    #[inline(always)]
    pub fn rate(age_s: F, half_life_s: f32) -> Self {
        let y = F::splat(2.0 * std::f32::consts::LN_2 / half_life_s);
        let age = age_s.min(F::splat(8.0 * HALF_LIVES_KEPT * half_life_s));
        let e = (-(y * age)).exp8();
        Self { position: -(y * y * age * e), velocity: e * (F::splat(1.0) - y * age) }
    }

    #[inline(always)]
    pub fn apply(&self, x: V<F>, v: V<F>) -> V<F> {
        x * self.position + v * self.velocity
    }
}

/// True where no lane's offsets matter any more.
#[inline(always)]
fn settled<F: Lanes>(block: &Block, half_life_s: f32) -> bool {
    !F::splat(HALF_LIVES_KEPT * half_life_s).any_gt(F::load(&block.age_s))
}

/// Adds the decaying offsets of the last transition.
#[inline(always)]
pub(crate) fn add_offsets<F: Lanes>(pose: &mut LanePose<F>, block: &Block, half_life_s: f32) {
    if settled::<F>(block, half_life_s) {
        return;
    }
    let age = F::load(&block.age_s);
    let mut decay = Decay::new(age, half_life_s);
    // A lane whose offsets are settled has none, whatever its neighbours do.
    let (kept, zero) = (F::splat(HALF_LIVES_KEPT * half_life_s), F::splat(0.0));
    decay.position = F::select_lt(kept, age, zero, decay.position);
    decay.velocity = F::select_lt(kept, age, zero, decay.velocity);
    let o = &block.offsets;
    pose.root = pose.root + decay.apply(load(&o.root), load(&o.root_velocity));
    let decay = Decay {
        position: decay.position * F::splat(1.0 / ROTATION_CODES),
        velocity: decay.velocity * F::splat(1.0 / VELOCITY_CODES),
    };
    for (q, (x, v)) in pose.rotations.iter_mut().zip(o.rotation.iter().zip(&o.rotation_velocity)) {
        *q = Q::from_mrp(decay.apply(load_codes(x), load_codes(v))) * *q;
    }
}
