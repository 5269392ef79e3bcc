//! The planar transform: position on the ground and heading, the part of a root that can be placed anywhere.

use glam::{Quat, Vec2, Vec3};
use throng_base::maths;

/// A rigid transform of the ground plane: (x, z, heading).
///
/// Maps a local point `p` to `rotate_y(heading) * p + (x, 0, z)`. A character faces +Z at heading 0;
/// heading is the angle about +Y, so heading +90 degrees faces +X.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Planar {
    /// Position along X (m).
    pub x: f32,
    /// Position along Z (m).
    pub z: f32,
    /// Angle about +Y (rad).
    pub heading: f32,
}

impl Planar {
    /// The transform that changes nothing.
    pub const IDENTITY: Self = Self { x: 0.0, z: 0.0, heading: 0.0 };

    /// A transform from its three numbers.
    pub fn new(x: f32, z: f32, heading: f32) -> Self {
        Self { x, z, heading }
    }

    /// A transform from its three numbers in an array: x, z, heading.
    pub fn from_array([x, z, heading]: [f32; 3]) -> Self {
        Self { x, z, heading }
    }

    /// `self` after `inner`: first `inner`, then `self`. Headings add and are not wrapped.
    pub fn compose(self, inner: Self) -> Self {
        let p = self.transform_point(Vec2::new(inner.x, inner.z));
        Self { x: p.x, z: p.y, heading: self.heading + inner.heading }
    }

    /// The transform that undoes this one.
    pub fn inverse(self) -> Self {
        let p = rotate(Vec2::new(-self.x, -self.z), -self.heading);
        Self { x: p.x, z: p.y, heading: -self.heading }
    }

    /// `other` as seen from `self`: `self.inverse().compose(other)`.
    pub fn to_local(self, other: Self) -> Self {
        self.inverse().compose(other)
    }

    /// A local ground point (x, z) in the outer frame.
    pub fn transform_point(self, p: Vec2) -> Vec2 {
        rotate(p, self.heading) + Vec2::new(self.x, self.z)
    }

    /// An outer ground point (x, z) in the local frame.
    pub fn inverse_transform_point(self, p: Vec2) -> Vec2 {
        rotate(p - Vec2::new(self.x, self.z), -self.heading)
    }

    /// The rotation about +Y.
    pub fn rotation(self) -> Quat {
        maths::rotation_y(self.heading)
    }

    /// The translation on the ground.
    pub fn translation(self) -> Vec3 {
        Vec3::new(self.x, 0.0, self.z)
    }

    /// Splits a root into the planar part and the tilt that is left: `rotation = rotate_y(heading) * tilt`.
    ///
    /// The heading is the twist of `rotation` about +Y (swing-twist), which stays defined when the body bends
    /// forward or lies down, and only fails where the body is upside down; there it is 0.
    pub fn split(position: Vec3, rotation: Quat) -> (Self, Quat) {
        let heading = twist_about_y(rotation);
        let tilt = maths::compose(maths::rotation_y(-heading), rotation);
        (Self { x: position.x, z: position.z, heading }, tilt)
    }
}

/// The angle of the twist of `q` about +Y, in (-pi, pi] (rad).
pub fn twist_about_y(q: Quat) -> f32 {
    if q.y.abs() + q.w.abs() < 1e-6 { 0.0 } else { wrap_angle(2.0 * maths::atan2(q.y, q.w)) }
}

/// Angle wrapped to (-pi, pi] (rad).
pub fn wrap_angle(a: f32) -> f32 {
    // Most are; rounding is a call on processors without an instruction for it.
    if a.abs() < std::f32::consts::PI {
        return a;
    }
    let two_pi = std::f32::consts::TAU;
    let r = a - two_pi * (a / two_pi).round();
    if r <= -std::f32::consts::PI { r + two_pi } else { r }
}

/// Rotates a ground vector (x, z) about +Y: +Z turns towards +X.
fn rotate(p: Vec2, angle: f32) -> Vec2 {
    let (s, c) = maths::sin_cos(angle);
    Vec2::new(c * p.x + s * p.y, -s * p.x + c * p.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotates_as_the_quaternion_does() {
        let t = Planar::new(1.0, 2.0, 0.7);
        let p = t.transform_point(Vec2::new(0.3, -0.4));
        let q = t.rotation() * Vec3::new(0.3, 0.0, -0.4) + t.translation();
        assert!((p - Vec2::new(q.x, q.z)).length() < 1e-6);
        assert!((Planar::new(0.0, 0.0, 1.5).transform_point(Vec2::new(0.0, 1.0)).x) > 0.99);
    }

    #[test]
    fn inverse_undoes() {
        let t = Planar::new(1.0, 2.0, 0.7);
        let i = t.compose(t.inverse());
        assert!(i.x.abs() < 1e-6 && i.z.abs() < 1e-6 && i.heading.abs() < 1e-6);
    }

    #[test]
    fn split_rebuilds_the_root() {
        let q = Quat::from_rotation_y(2.0) * Quat::from_rotation_x(0.4) * Quat::from_rotation_z(0.1);
        let (p, tilt) = Planar::split(Vec3::new(1.0, 0.9, -3.0), q);
        assert!((p.rotation() * tilt).dot(q).abs() > 1.0 - 1e-6);
        assert!(tilt.y.abs() < 1e-6);
    }
}
