//! Elementary functions on [`Lanes`].

use super::Lanes;

/// Coefficients of a polynomial of degree 4 for 2^f in [-0.5, 0.5] that is exact at 0: relative error below 3e-6.
pub const EXP2: [f32; 4] = [0.693_124_2, 0.240_241, 0.055_906_37, 0.009_582_818];

/// Functions made of the operations of [`Lanes`].
pub trait Functions: Lanes {
    /// Sine and cosine. Error below 2e-6 for |self| <= 8192 (rad).
    #[inline(always)]
    fn sin_cos8(self) -> (Self, Self) {
        // Reduced by quarter turns to [-pi/4, pi/4] in two steps, then minimax polynomials (Cephes sinf, cosf).
        let q = (self * Self::splat(std::f32::consts::FRAC_2_PI)).round();
        let r = self - q * Self::splat(1.570_312_5) - q * Self::splat(4.838_268e-4);
        let r2 = r * r;
        let s = r + r
            * r2
            * (Self::splat(-1.666_665_5e-1) + r2 * (Self::splat(8.332_161e-3) + r2 * Self::splat(-1.951_529_6e-4)));
        let c = Self::splat(1.0) - Self::splat(0.5) * r2
            + r2 * r2
                * (Self::splat(4.166_664_6e-2)
                    + r2 * (Self::splat(-1.388_731_6e-3) + r2 * Self::splat(2.443_315_7e-5)));
        // Quarter turns modulo 4 as 0, 1, 2 or 3.
        let m = q - (q * Self::splat(0.25) - Self::splat(0.374)).round() * Self::splat(4.0);
        let odd = (m - Self::splat(2.0)).abs(); // 2, 1, 0, 1
        let swap = (odd - Self::splat(1.0)).abs(); // 1 where even, 0 where odd
        let (half, zero) = (Self::splat(0.5), Self::splat(0.0));
        let sin = Self::select_lt(swap, half, c, s);
        let cos = Self::select_lt(swap, half, s, c);
        let sin = Self::select_lt(m, Self::splat(1.5), sin, zero - sin);
        let cos = Self::select_lt((m - Self::splat(1.5)).abs(), Self::splat(1.0), zero - cos, cos);
        (sin, cos)
    }

    /// Exponential. Relative error below 1e-6 for -80 <= self <= 80, clamped outside.
    #[inline(always)]
    fn exp8(self) -> Self {
        let x = self.max(Self::splat(-80.0)).min(Self::splat(80.0)) * Self::splat(std::f32::consts::LOG2_E);
        let n = x.round();
        let f = (x - n) * Self::splat(std::f32::consts::LN_2);
        let mut p = Self::splat(1.0 / 720.0);
        for coefficient in [1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
            p = Self::splat(coefficient) + f * p;
        }
        p.times_exp2(n)
    }

    /// 2 to the power of a number that is not positive. Relative error below 3e-6 down to -125, about 1e-38 below.
    #[inline(always)]
    fn exp2_neg(self) -> Self {
        let y = self.max(Self::splat(-126.0));
        let n = y.round();
        let f = y - n;
        let p = Self::splat(EXP2[1]) + f * (Self::splat(EXP2[2]) + f * Self::splat(EXP2[3]));
        (Self::splat(1.0) + f * (Self::splat(EXP2[0]) + f * p)).times_exp2(n)
    }

    /// Angle of (x, z) from +Z without its sign: in [0, pi], 0 at the origin. Within 4e-6 rad (rad).
    #[inline(always)]
    fn angle_from_ahead(x: Self, z: Self) -> Self {
        let (ax, az, zero) = (x.abs(), z.abs(), Self::splat(0.0));
        let q = ax.min(az) / ax.max(az).max(Self::splat(f32::MIN_POSITIVE));
        let s = q * q;
        let p = Self::splat(0.052_653_32) + s * Self::splat(-0.011_721_2);
        let p = Self::splat(0.193_543_46) + s * (Self::splat(-0.116_432_87) + s * p);
        let p = Self::splat(0.999_977_26) + s * (Self::splat(-0.332_623_47) + s * p);
        let a = p * q;
        let a = Self::select_lt(az, ax, Self::splat(std::f32::consts::FRAC_PI_2) - a, a);
        Self::select_lt(z, zero, Self::splat(std::f32::consts::PI) - a, a)
    }
}

impl<F: Lanes> Functions for F {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::ArrayLanes;

    /// Miri is slow: it looks at one number in so many.
    const STEP: usize = if cfg!(miri) { 997 } else { 1 };

    #[test]
    fn sine_and_cosine_match_the_library() {
        for i in (-40_000..40_000).step_by(STEP) {
            let x = i as f32 * 0.001_37;
            let (s, c) = ArrayLanes::splat(x).sin_cos8();
            let (s, c) = (s.to_array()[0], c.to_array()[0]);
            let (es, ec) = (f64::from(x).sin() as f32, f64::from(x).cos() as f32);
            assert!((s - es).abs() < 2e-6 && (c - ec).abs() < 2e-6, "{x}: {s} {es}, {c} {ec}");
        }
    }

    #[test]
    fn exponential_matches_the_library() {
        for i in (-7900..7900).step_by(STEP) {
            let x = i as f32 * 0.01;
            let e = ArrayLanes::splat(x).exp8().to_array()[0];
            let want = f64::from(x).exp();
            assert!(((f64::from(e) - want) / want).abs() < 1e-5, "{x}: {e} {want}");
        }
    }
}
