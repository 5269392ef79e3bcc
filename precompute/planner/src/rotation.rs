//! Rotations in doubles, with the same bits on every machine: axis and angle, logarithm, slerp, swing and twist.

use glam::{DQuat, DVec3, Quat, Vec3};
use std::f64::consts::{PI, TAU};
use throng_base::maths;

/// The rotation about a unit axis (rad).
pub fn rotation_about(axis: DVec3, angle: f64) -> DQuat {
    let (sin, cos) = maths::sin_cos(0.5 * angle);
    let v = axis * sin;
    DQuat::from_xyzw(v.x, v.y, v.z, cos)
}

/// Angle wrapped to [-pi, pi) (rad).
pub fn wrap_angle(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

/// The rotation of a rotation vector: its direction is the axis, its length the angle (rad).
pub fn exp(vector: DVec3) -> DQuat {
    let angle = vector.length();
    if angle < 1e-12 {
        let v = 0.5 * vector;
        return DQuat::from_xyzw(v.x, v.y, v.z, 1.0);
    }
    rotation_about(vector / angle, angle)
}

/// The rotation vector of a unit quaternion, at most half a turn long (rad).
pub fn log(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let v = q.xyz();
    let sin = v.length();
    if sin < 1e-12 { 2.0 * v } else { v * (2.0 * maths::atan2(sin, q.w) / sin) }
}

/// Angle between two rotations, in [0, pi] (rad).
pub fn angle_between(a: DQuat, b: DQuat) -> f64 {
    let b = nearest_sign(a, b);
    // Arctangent of half the difference and half the sum: as exact for small angles as for large ones.
    4.0 * maths::atan2((a - b).length(), (a + b).length())
}

/// The middle of the shortest path from `a` to `b`: [`maths::slerp`] at one half, without trigonometry.
pub fn mid_rotation(a: DQuat, b: DQuat) -> DQuat {
    (a + nearest_sign(a, b)).normalize()
}

/// `b` or its negative, whichever is nearer to `a`.
fn nearest_sign(a: DQuat, b: DQuat) -> DQuat {
    if a.dot(b) < 0.0 { -b } else { b }
}

/// The smallest rotation that takes one unit vector to another.
pub fn rotation_between(from: DVec3, to: DVec3) -> DQuat {
    let w = 1.0 + from.dot(to);
    if w < 1e-9 {
        let axis = from.any_orthonormal_vector();
        return DQuat::from_xyzw(axis.x, axis.y, axis.z, 0.0);
    }
    let v = from.cross(to);
    DQuat::from_xyzw(v.x, v.y, v.z, w).normalize()
}

/// Splits `q = swing * twist`: the twist about a unit axis comes first.
///
/// - returns the swing, whose axis is at right angles to `axis`, and the twist in (-pi, pi] (rad).
///
/// # Source
/// Grassia 1998, *Practical Parameterization of Rotations Using the Exponential Map*, section 5.
pub fn swing_twist(q: DQuat, axis: DVec3) -> (DQuat, f64) {
    let q = if q.w < 0.0 { -q } else { q };
    let twist = twist_about(q, axis);
    (q * twist.inverse(), 2.0 * maths::atan2(twist.xyz().dot(axis), twist.w))
}

/// The twist of a rotation about a unit axis: the same whether it comes before or after the swing.
pub fn twist_about(q: DQuat, axis: DVec3) -> DQuat {
    let along = q.xyz().dot(axis);
    let length = (along * along + q.w * q.w).sqrt();
    if length < 1e-12 {
        return DQuat::IDENTITY;
    }
    let v = axis * (along / length);
    DQuat::from_xyzw(v.x, v.y, v.z, q.w / length)
}

/// The rotation as seen in a mirror at x = 0.
pub fn mirror_rotation_x(q: DQuat) -> DQuat {
    DQuat::from_xyzw(q.x, -q.y, -q.z, q.w)
}

/// Position and rotation of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid {
    /// Position (m).
    pub position: DVec3,
    /// Rotation (unit).
    pub rotation: DQuat,
}

impl Rigid {
    /// The origin, without rotation.
    pub const IDENTITY: Self = Self { position: DVec3::ZERO, rotation: DQuat::IDENTITY };

    /// A position without rotation.
    pub const fn from_position(position: DVec3) -> Self {
        Self { position, rotation: DQuat::IDENTITY }
    }

    /// The position (m) and rotation of a joint, with a rotation of unit length.
    pub fn from_joint(position: Vec3, rotation: Quat) -> Self {
        Self { position: position.as_dvec3(), rotation: rotation.as_dquat().normalize() }
    }

    /// A point of its frame, in the outer frame (m).
    pub fn transform_point(&self, p: DVec3) -> DVec3 {
        self.position + self.rotation * p
    }

    /// A point of the outer frame, in its frame (m).
    pub fn local_point(&self, p: DVec3) -> DVec3 {
        self.rotation.inverse() * (p - self.position)
    }

    /// A transform in its frame, expressed in the outer frame.
    pub fn compose(&self, inner: Self) -> Self {
        Self { position: self.transform_point(inner.position), rotation: self.rotation * inner.rotation }
    }

    /// A transform in the outer frame, expressed in its frame.
    pub fn to_local(&self, outer: Self) -> Self {
        Self { position: self.local_point(outer.position), rotation: self.rotation.inverse() * outer.rotation }
    }

    /// True where all numbers are finite and the rotation is unit.
    pub fn is_valid(&self) -> bool {
        self.position.is_finite() && self.rotation.is_finite() && (self.rotation.length() - 1.0).abs() < 1e-3
    }

    /// Interpolates the position linearly, the rotation by the normalised sum of the quaternions.
    pub fn lerp(&self, to: &Self, share: f64) -> Self {
        let b = nearest_sign(self.rotation, to.rotation);
        Self {
            position: self.position + (to.position - self.position) * share,
            rotation: (self.rotation * (1.0 - share) + b * share).normalize(),
        }
    }

    /// Bound on the travel of a point within `reach` of the origin along [`Rigid::lerp`]: as if it always had its greatest
    /// speed (m).
    pub fn travel_bound(&self, to: &Self, reach: f64) -> f64 {
        // The normalised sum turns fastest in its middle: there by 4 tan(angle / 4) for the whole path.
        let b = nearest_sign(self.rotation, to.rotation);
        let quarter = maths::atan2((self.rotation - b).length(), (self.rotation + b).length());
        (to.position - self.position).length() + 4.0 * maths::sin(quarter) / maths::cos(quarter) * reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use throng_base::maths::slerp;

    fn rotations() -> impl Strategy<Value = DQuat> {
        prop::array::uniform3(-3.0f64..3.0).prop_map(|v| exp(DVec3::from(v)))
    }

    proptest! {
        #[test]
        fn a_rotation_is_its_swing_after_its_twist(q in rotations(), axis in prop::array::uniform3(-1.0f64..1.0)) {
            let axis = DVec3::from(axis);
            prop_assume!(axis.length() > 0.1);
            let axis = axis.normalize();
            let (swing, twist) = swing_twist(q, axis);
            prop_assert!(angle_between(swing * rotation_about(axis, twist), q) < 1e-9);
            prop_assert!(swing.xyz().dot(axis).abs() < 1e-9);
            prop_assert!(twist.abs() <= std::f64::consts::PI + 1e-12);
        }

        #[test]
        fn logarithm_and_exponential_are_inverse(q in rotations()) {
            prop_assert!(angle_between(exp(log(q)), q) < 1e-9);
            prop_assert!((log(q).length() - angle_between(q, DQuat::IDENTITY)).abs() < 1e-9);
        }

        #[test]
        fn slerp_turns_evenly_and_its_middle_is_the_middle(a in rotations(), b in rotations(), share in 0.0f64..1.0) {
            let whole = angle_between(a, b);
            prop_assert!((angle_between(a, slerp(a, b, share)) - share * whole).abs() < 1e-7);
            prop_assert!(angle_between(mid_rotation(a, b), slerp(a, b, 0.5)) < 1e-7);
        }

        #[test]
        fn the_smallest_rotation_leads_from_one_direction_to_another(
            a in prop::array::uniform3(-1.0f64..1.0), b in prop::array::uniform3(-1.0f64..1.0),
        ) {
            let (a, b) = (DVec3::from(a), DVec3::from(b));
            prop_assume!(a.length() > 0.1 && b.length() > 0.1);
            let (a, b) = (a.normalize(), b.normalize());
            let q = rotation_between(a, b);
            prop_assert!((q * a - b).length() < 1e-6);
            prop_assert!(swing_twist(q, a).1.abs() < 1e-6);
        }

        #[test]
        fn nothing_travels_farther_than_said(
            a in rotations(), b in rotations(), p in prop::array::uniform3(-1.0f64..1.0), from in 0.0f64..1.0, to in 0.0f64..1.0,
        ) {
            let a = Rigid { position: DVec3::new(0.1, 0.2, 0.3), rotation: a };
            let b = Rigid { position: DVec3::new(-0.4, 0.2, 0.5), rotation: b };
            // Half a turn has no shortest way.
            prop_assume!(angle_between(a.rotation, b.rotation) < 3.0);
            let p = DVec3::from(p);
            let moved = a.lerp(&b, to).transform_point(p) - a.lerp(&b, from).transform_point(p);
            prop_assert!(moved.length() <= a.travel_bound(&b, p.length()) * (to - from).abs() + 1e-9);
        }
    }

    #[test]
    fn half_a_turn_has_an_axis() {
        let q = rotation_between(DVec3::X, DVec3::NEG_X);
        assert!((q * DVec3::X + DVec3::X).length() < 1e-12);
        assert_eq!(swing_twist(rotation_about(DVec3::Y, std::f64::consts::PI), DVec3::X).1, 0.0);
    }
}
