//! Fast elementary functions of the hot path, written so that the compiler can vectorise them; tests bound the errors.

use std::f32::consts::{FRAC_PI_2, LOG2_E, PI};
use throng_base::simd::EXP2;

/// Adding this to a small float leaves the nearest integer in the low bits: 1.5 * 2^23.
const ROUNDER: f32 = 12_582_912.0;

/// The smaller of two numbers, the second where either is NaN: one instruction, unlike [`f32::min`].
#[inline(always)]
pub(super) fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers, the second where either is NaN: one instruction, unlike [`f32::max`].
#[inline(always)]
pub(super) fn greatest(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Angle of the ground point (x, z) from +Z, positive towards +X, in [-pi, pi]; 0 at the origin (rad).
///
/// Within 4e-6 rad of `x.atan2(z)` (odd minimax polynomial of degree 11 on [0, 1]).
#[inline(always)]
pub fn angle_of(x: f32, z: f32) -> f32 {
    let (ax, az) = (x.abs(), z.abs());
    let q = least(ax, az) / greatest(greatest(ax, az), f32::MIN_POSITIVE);
    let s = q * q;
    let p = 0.052_653_32 + s * -0.011_721_2;
    let p = 0.999_977_26 + s * (-0.332_623_47 + s * (0.193_543_46 + s * (-0.116_432_87 + s * p)));
    let a = p * q;
    let a = if ax > az { FRAC_PI_2 - a } else { a };
    let a = if z < 0.0 { PI - a } else { a };
    a.copysign(x)
}

/// `exp(-x)` for `x >= 0`, within a relative error of 8e-6 up to 80; about 1e-38 where the result would be smaller.
#[inline(always)]
pub fn exp_neg(x: f32) -> f32 {
    let y = greatest(x * -LOG2_E, -126.0);
    let k = y + ROUNDER;
    let f = y - (k - ROUNDER);
    let p = 1.0 + f * (EXP2[0] + f * (EXP2[1] + f * (EXP2[2] + f * EXP2[3])));
    f32::from_bits(p.to_bits().wrapping_add(k.to_bits() << 23))
}

/// Index of the interval that contains `t`, at most `last`, and the ratio within it in [0, 1].
///
/// - `t`: (0 <= t <= last + 1, last < 2^22); anything else, NaN too, gives an index in range.
#[inline(always)]
pub fn split_interval(t: f32, last: u32) -> (u32, f32) {
    let i = nearest_index(greatest(t - 0.5, 0.0), last);
    (i, t - i as i32 as f32)
}

/// The integer nearest to `t`, at most `last`.
///
/// - `t`: (0 <= t < 2^22); anything else, NaN too, gives an index in range.
#[inline(always)]
pub fn nearest_index(t: f32, last: u32) -> u32 {
    let k = (t + ROUNDER).to_bits().wrapping_sub(ROUNDER.to_bits());
    // Signed numbers, which SSE2 compares more cheaply; negative or large ones are out of range.
    (k as i32).max(0).min(last as i32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Miri is slow: only every STEP-th number is tested.
    const STEP: usize = if cfg!(miri) { 1999 } else { 1 };

    #[test]
    fn angle_error_is_within_its_bound() {
        let mut worst = 0.0f64;
        for i in (0..200_000).step_by(STEP) {
            let a = (i as f64 / 200_000.0 - 0.5) * std::f64::consts::TAU;
            let r = 0.01 + (i % 97) as f64 * 0.1;
            let (x, z) = ((r * a.sin()) as f32, (r * a.cos()) as f32);
            worst = worst.max((f64::from(angle_of(x, z)) - f64::from(x).atan2(f64::from(z))).abs());
        }
        assert!(worst < 4e-6, "worst error {worst:e}");
        assert_eq!(angle_of(0.0, 0.0), 0.0);
        assert!((angle_of(1.0, 0.0) - FRAC_PI_2).abs() < 4e-6);
        assert!((angle_of(0.0, -1.0).abs() - PI).abs() < 4e-6);
    }

    #[test]
    fn exponential_error_is_within_its_bound() {
        let mut worst = 0.0f64;
        for i in (0..200_000).step_by(STEP) {
            let x = i as f32 * 4e-4;
            let exact = (-f64::from(x)).exp();
            worst = worst.max((f64::from(exp_neg(x)) - exact).abs() / exact);
        }
        assert!(worst < 8e-6, "worst relative error {worst:e}");
        assert_eq!(exp_neg(0.0), 1.0);
        assert!(exp_neg(1e6) < 2e-38 && exp_neg(1e6) >= 0.0);
    }

    #[test]
    fn intervals_contain_their_argument() {
        for i in 0..=400 {
            let t = i as f32 * 0.01;
            let (k, f) = split_interval(t, 3);
            assert!(k <= 3 && (0.0..=1.0).contains(&f) && (k as f32 + f - t).abs() < 1e-6, "{t} {k} {f}");
        }
        for t in [f32::NAN, -5.0, 1e30, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(split_interval(t, 3).0 <= 3 && nearest_index(t, 3) <= 3);
        }
    }
}
