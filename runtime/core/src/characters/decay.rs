//! The offsets of the last transition, which decay as critically damped springs do.

use super::block::{BodyBlock, MotionBlock, ROTATION_CODES, VELOCITY_CODES, load_codes};
use crate::pose::{LanePose, load};
use throng_base::simd::{Functions, Lanes, Q, V};

/// Past this many half-lives an offset is below a four-hundredth of what it was and is no longer applied.
pub(super) const HALF_LIVES_KEPT: f32 = 6.0;

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
        let age = clamp_age(age_s, half_life_s);
        let e = (-(y * age)).exp8();
        Self { position: e * (F::splat(1.0) + y * age), velocity: e * age }
    }

    /// The rate of change of the offset at that age: `position' * x + velocity' * v`.
    #[inline(always)]
    pub fn rate(age_s: F, half_life_s: f32) -> Self {
        let y = F::splat(2.0 * std::f32::consts::LN_2 / half_life_s);
        let age = clamp_age(age_s, half_life_s);
        let e = (-(y * age)).exp8();
        Self { position: -(y * y * age * e), velocity: e * (F::splat(1.0) - y * age) }
    }

    #[inline(always)]
    pub fn apply(&self, x: V<F>, v: V<F>) -> V<F> {
        x * self.position + v * self.velocity
    }
}

/// Ages at which the offsets are those of the start, of the end or of between. A clip that begins within a step has offsets
/// a little before its begin; long before it they would be without bounds.
#[inline(always)]
fn clamp_age<F: Lanes>(age_s: F, half_life_s: f32) -> F {
    age_s.max(F::splat(-half_life_s)).min(F::splat(8.0 * HALF_LIVES_KEPT * half_life_s))
}

/// True where no lane's offsets matter any more.
#[inline(always)]
fn offsets_have_decayed<F: Lanes>(block: &MotionBlock, half_life_s: f32) -> bool {
    !F::splat(HALF_LIVES_KEPT * half_life_s).any_gt(F::load(&block.age_s))
}

/// Adds the decaying offsets of the last transition.
#[inline(always)]
pub(crate) fn add_offsets<F: Lanes>(pose: &mut LanePose<F>, block: &MotionBlock, body: &BodyBlock, half_life_s: f32) {
    if offsets_have_decayed::<F>(block, half_life_s) {
        return;
    }
    let age = F::load(&block.age_s);
    let mut decay = Decay::new(age, half_life_s);
    // A lane whose offsets have decayed has none, whatever its neighbours hold.
    let (kept, zero) = (F::splat(HALF_LIVES_KEPT * half_life_s), F::splat(0.0));
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

#[cfg(test)]
mod tests {
    use super::*;
    use throng_base::simd::ArrayLanes;

    #[test]
    fn offsets_are_bounded_however_long_before_their_clip_begins() {
        let at = |age: f32| {
            let (value, rate) = (Decay::new(ArrayLanes::splat(age), 0.1), Decay::rate(ArrayLanes::splat(age), 0.1));
            [value.position, value.velocity, rate.position, rate.velocity].map(|v| v.to_array()[0])
        };
        assert_eq!(at(-900.0), at(-0.1));
        assert!(at(-0.1).iter().all(|v| v.abs() < 100.0), "{:?}", at(-0.1));
        assert_eq!(at(0.0)[..2], [1.0, 0.0]);
        // Half is left after the half-life of a spring that starts at rest: (1 + y t) exp(-y t) with y t = 2 ln 2.
        let left = (1.0 + 2.0 * std::f32::consts::LN_2) / 4.0;
        assert!((at(0.1)[0] - left).abs() < 1e-5);
    }
}
