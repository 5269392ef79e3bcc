//! Sines, exponentials and their like, with the same bits on every machine.
//!
//! The functions of `std` and of glam come from the platform's library, or from the compiler, and differ in their last bits; motion
//! drifts apart from there. The runtime uses these alone; square roots and roundings are exact everywhere.

use glam::{DQuat, Quat, Vec2, Vec3};

/// Declares [`Real`] and a function for each line: its parameters, and what `libm` calls it for `f32` and for `f64`.
macro_rules! functions {
    ($($(#[$doc:meta])+ $name:ident($($x:ident),+) = $single:ident, $double:ident;)+) => {
        /// Float types with these functions.
        pub trait Real: Copy {
            /// Sine and cosine (rad).
            fn sin_cos(x: Self) -> (Self, Self);
            $($(#[$doc])+ fn $name($($x: Self),+) -> Self;)+
        }

        functions! { f32: sincosf $($name($($x),+) = $single;)+ }
        functions! { f64: sincos $($name($($x),+) = $double;)+ }

        $(
            $(#[$doc])+
            #[inline]
            pub fn $name<R: Real>($($x: R),+) -> R {
                R::$name($($x),+)
            }
        )+
    };
    ($float:ty: $sin_cos:ident $($name:ident($($x:ident),+) = $function:ident;)+) => {
        impl Real for $float {
            #[inline]
            fn sin_cos(x: Self) -> (Self, Self) {
                libm::$sin_cos(x)
            }
            $(
                #[inline]
                fn $name($($x: Self),+) -> Self {
                    libm::$function($($x),+)
                }
            )+
        }
    };
}

functions! {
    /// Sine (rad).
    sin(x) = sinf, sin;
    /// Cosine (rad).
    cos(x) = cosf, cos;
    /// The angle of (x, y) from +X, in [-pi, pi] (rad).
    atan2(y, x) = atan2f, atan2;
    /// e to the power of x.
    exp(x) = expf, exp;
    /// Natural logarithm.
    ln(x) = logf, log;
    /// 2 to the power of x.
    exp2(x) = exp2f, exp2;
    /// x to the power of y.
    pow(x, y) = powf, pow;
    /// Cube root.
    cbrt(x) = cbrtf, cbrt;
    /// Length of (x, y).
    hypot(x, y) = hypotf, hypot;
}

/// Sine and cosine (rad).
#[inline]
pub fn sin_cos<R: Real>(x: R) -> (R, R) {
    R::sin_cos(x)
}

/// The unit vector at an angle from +X (rad).
#[inline]
pub fn direction_at_angle(angle: f32) -> Vec2 {
    let (sin, cos) = sin_cos(angle);
    Vec2::new(cos, sin)
}

/// The rotation about +X (rad).
#[inline]
pub fn rotation_x(angle: f32) -> Quat {
    let (sin, cos) = sin_cos(0.5 * angle);
    Quat::from_xyzw(sin, 0.0, 0.0, cos)
}

/// The rotation about +Y (rad).
#[inline]
pub fn rotation_y(angle: f32) -> Quat {
    let (sin, cos) = sin_cos(0.5 * angle);
    Quat::from_xyzw(0.0, sin, 0.0, cos)
}

/// The rotation about +Z (rad).
#[inline]
pub fn rotation_z(angle: f32) -> Quat {
    let (sin, cos) = sin_cos(0.5 * angle);
    Quat::from_xyzw(0.0, 0.0, sin, cos)
}

/// A vector turned by a rotation: glam adds in another order on each kind of processor.
#[inline]
pub fn rotate(q: Quat, v: Vec3) -> Vec3 {
    let axis = Vec3::new(q.x, q.y, q.z);
    v * (q.w * q.w - axis.dot(axis)) + axis * (2.0 * axis.dot(v)) + axis.cross(v) * (2.0 * q.w)
}

/// Product of two rotations, `a` after `b`. The product of glam fuses multiply and add where the processor can.
///
/// Terms are added in pairs, so that the difference of equal rotations has no axis, and that of two the same but its sign,
/// whichever is taken from the other.
#[inline]
pub fn compose(a: Quat, b: Quat) -> Quat {
    Quat::from_xyzw(
        (a.w * b.x + a.x * b.w) + (a.y * b.z - a.z * b.y),
        (a.w * b.y + a.y * b.w) + (a.z * b.x - a.x * b.z),
        (a.w * b.z + a.z * b.w) + (a.x * b.y - a.y * b.x),
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
    )
}

/// Rotation scaled to unit length; the identity where all components are 0.
#[inline]
pub fn normalize_or_identity(q: Quat) -> Quat {
    let length = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
    if length > 0.0 { Quat::from_xyzw(q.x / length, q.y / length, q.z / length, q.w / length) } else { Quat::IDENTITY }
}

/// Normalized linear interpolation of two rotations along the shorter arc; unit length.
///
/// - `share`: weight of `b` (0 to 1).
#[inline]
pub fn nlerp(a: Quat, b: Quat, share: f32) -> Quat {
    let dot = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
    let (s, t) = (1.0 - share, if dot < 0.0 { -share } else { share });
    normalize_or_identity(Quat::from_xyzw(a.x * s + b.x * t, a.y * s + b.y * t, a.z * s + b.z * t, a.w * s + b.w * t))
}

/// Spherical linear interpolation of two rotations along the shorter arc; unit length.
///
/// - `share`: weight of `b` (0 to 1).
///
/// # Source
/// Shoemake 1985, *Animating Rotation with Quaternion Curves*.
pub fn slerp(a: DQuat, b: DQuat, share: f64) -> DQuat {
    let b = if a.dot(b) < 0.0 { -b } else { b };
    let half = 2.0 * atan2((a - b).length(), (a + b).length());
    if half < 1e-9 {
        return (a * (1.0 - share) + b * share).normalize();
    }
    let over = 1.0 / sin(half);
    (a * (sin((1.0 - share) * half) * over) + b * (sin(share * half) * over)).normalize()
}

/// [`slerp`] of rotations in single precision.
pub fn slerp_f32(a: Quat, b: Quat, share: f32) -> Quat {
    slerp(a.as_dquat(), b.as_dquat(), f64::from(share)).as_quat()
}

/// The value that a share of all values is below, as a fraction: `[1, 2]` for the median; the greatest for all, and `None` of none.
pub fn quantile<R: Copy + Into<f64>>(values: impl IntoIterator<Item = R>, [part, whole]: [usize; 2]) -> Option<R> {
    let mut all: Vec<R> = values.into_iter().collect();
    let at = (all.len() * part / whole).min(all.len().checked_sub(1)?);
    Some(*all.select_nth_unstable_by(at, |a, b| (*a).into().total_cmp(&(*b).into())).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Hash128;

    #[test]
    fn rotations_agree_with_the_library() {
        let [a, b] = [Quat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0), Quat::from_rotation_z(-0.7)];
        let v = Vec3::new(0.4, -2.0, 1.5);
        assert!(rotate(a, v).distance(a * v) < 1e-6 && compose(a, b).abs_diff_eq(a * b, 1e-6));
        assert_eq!(compose(a.conjugate(), a).xyz(), Vec3::ZERO);
        assert_eq!(compose(a, b.conjugate()).xyz(), -compose(b, a.conjugate()).xyz());
        assert!(nlerp(a, -b, 0.25).abs_diff_eq((a * 0.75 + b * (0.25 * a.dot(b).signum())).normalize(), 1e-6));
        assert!(slerp_f32(a, -b, 0.25).abs_diff_eq(a.slerp(-b, 0.25), 1e-6));
        assert_eq!(normalize_or_identity(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)), Quat::IDENTITY);
    }

    #[test]
    fn they_agree_with_the_library() {
        let mut worst = 0.0f64;
        for i in -20_000..20_000 {
            let x = f64::from(i) * 7.3e-4;
            let y = 0.3 - x * x;
            let pairs = [
                (sin(x as f32), f64::from(x as f32).sin()),
                (cos(x as f32), f64::from(x as f32).cos()),
                (atan2(x as f32, y as f32), f64::from(x as f32).atan2(f64::from(y as f32))),
                (exp(x as f32), f64::from(x as f32).exp()),
                (exp2(x as f32), f64::from(x as f32).exp2()),
                (pow(1.7, x as f32), f64::from(1.7f32).powf(f64::from(x as f32))),
                (cbrt(x as f32), f64::from(x as f32).cbrt()),
                (hypot(x as f32, y as f32), f64::from(x as f32).hypot(f64::from(y as f32))),
            ];
            for (found, exact) in pairs {
                worst = worst.max((f64::from(found) - exact).abs() / exact.abs().max(1e-30));
            }
            let doubles = [
                (sin(x), x.sin()),
                (sin_cos(x).1, x.cos()),
                (atan2(x, y), x.atan2(y)),
                (exp(x), x.exp()),
                (exp2(x), x.exp2()),
                (pow(1.7, x), 1.7f64.powf(x)),
                (cbrt(x), x.cbrt()),
                (hypot(x, y), x.hypot(y)),
            ];
            for (found, exact) in doubles {
                assert!((found - exact).abs() <= 1e-15 * exact.abs(), "{x}: {found} {exact}");
            }
        }
        assert!(worst < 1.2e-7, "worst relative error {worst:e}");
    }

    #[test]
    fn rotations_are_those_of_the_library() {
        for i in -50..50 {
            let a = i as f32 * 0.13;
            let all = [
                (rotation_x(a), Quat::from_rotation_x(a)),
                (rotation_y(a), Quat::from_rotation_y(a)),
                (rotation_z(a), Quat::from_rotation_z(a)),
            ];
            assert!(all.iter().all(|(found, exact)| found.abs_diff_eq(*exact, 2e-7)), "{a}: {all:?}");
            assert!(direction_at_angle(a).abs_diff_eq(Vec2::from_angle(a), 2e-7));
        }
    }

    /// On each machine that runs the tests, whatever its library.
    #[test]
    fn the_bits_are_those_of_every_machine() {
        let mut hash = Hash128::default();
        for i in -5000..5000 {
            let x = i as f32 * 3.7e-3;
            let y = 1.0 - x;
            for v in [sin(x), cos(x), atan2(x, y), exp(x), exp2(x), pow(1.7, x), cbrt(x), hypot(x, y)] {
                hash.add_word(u64::from(v.to_bits()));
            }
            let (x, y) = (f64::from(x), f64::from(y));
            for v in [sin(x), cos(x), atan2(x, y), exp(x), exp2(x), pow(1.7, x), cbrt(x), hypot(x, y)] {
                hash.add_word(v.to_bits());
            }
        }
        assert_eq!(hash.finish(), 126_578_984_256_741_891_817_928_826_187_781_028_977);
    }
}
