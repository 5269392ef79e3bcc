//! Differences that fade smoothly: neither their value nor their rate ever jumps.

use throng_base::maths;
use throng_base::simd::Lanes;

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

#[cfg(test)]
mod tests {
    use super::*;

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
}
