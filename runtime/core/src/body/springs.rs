//! Differences that fade smoothly: neither their value nor their rate ever jumps.

use throng_base::maths;
use throng_base::simd::{Functions, Lanes, V};

/// A critically damped spring over one tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DampedSpring {
    /// Factors of displacement and rate in the new displacement (-, s).
    keep: [f32; 2],
    /// Factors of displacement and rate in the new rate (1/s, -).
    rate: [f32; 2],
}

impl DampedSpring {
    /// Decays as the offsets of transitions do: about half is left after the half-life; 0 decays at once.
    pub fn new(dt_s: f32, half_life_s: f32) -> Self {
        if half_life_s <= 0.0 {
            return Self { keep: [0.0; 2], rate: [0.0; 2] };
        }
        let y = 2.0 * std::f32::consts::LN_2 / half_life_s;
        let e = maths::exp(-y * dt_s);
        Self { keep: [e * (1.0 + y * dt_s), e * dt_s], rate: [-e * y * y * dt_s, e * (1.0 - y * dt_s)] }
    }

    /// Displacement and rate after the tick.
    pub fn pull_towards_zero(&self, displacement: f32, rate: f32) -> (f32, f32) {
        let ([a, b], [c, d]) = (self.keep, self.rate);
        (a * displacement + b * rate, c * displacement + d * rate)
    }

    /// [`Self::pull_towards_zero`] of eight lanes.
    #[inline(always)]
    pub fn pull_lanes<F: Lanes>(&self, displacement: F, rate: F) -> (F, F) {
        let ([a, b], [c, d]) = (self.keep.map(F::splat), self.rate.map(F::splat));
        (a * displacement + b * rate, c * displacement + d * rate)
    }
}

/// Past this many half-lives an offset is below a four-hundredth of what it was and is no longer applied.
pub(crate) const HALF_LIVES_KEPT: f32 = 6.0;

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

#[cfg(test)]
mod tests {
    use super::*;
    use throng_base::simd::ArrayLanes;

    #[test]
    fn step_length_does_not_change_the_result() {
        let (mut p, mut v) = (1.0, -3.0);
        for _ in 0..40 {
            (p, v) = DampedSpring::new(0.01, 0.2).pull_towards_zero(p, v);
        }
        let (once, rate) = DampedSpring::new(0.4, 0.2).pull_towards_zero(1.0, -3.0);
        assert!((p - once).abs() < 1e-5 && (v - rate).abs() < 1e-4, "{p} {once} {v} {rate}");
        assert!(DampedSpring::new(0.2, 0.2).pull_towards_zero(1.0, 0.0).0 < 0.6);
        assert_eq!(DampedSpring::new(0.0, 0.2).pull_towards_zero(1.0, -3.0), (1.0, -3.0));
        assert_eq!(DampedSpring::new(0.1, 0.0).pull_towards_zero(1.0, -3.0), (0.0, 0.0));
    }

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
