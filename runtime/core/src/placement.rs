//! Placement in a world with more than one level: a planar transform and a height.

use crate::planar::{Planar, wrap_angle};
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

/// A rigid transform that keeps the vertical: (x, y, z, heading).
///
/// Maps a local point `p` to `rotate_y(heading) * p + (x, y, z)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, serde::Serialize, serde::Deserialize)]
#[repr(C)]
pub struct Placement {
    /// Position along X (m).
    pub x: f32,
    /// Height (m).
    pub y: f32,
    /// Position along Z (m).
    pub z: f32,
    /// Angle about +Y (rad).
    pub heading: f32,
}

impl Placement {
    /// The transform that changes nothing.
    pub const IDENTITY: Self = Self { x: 0.0, y: 0.0, z: 0.0, heading: 0.0 };

    /// A transform from its four numbers.
    pub fn new(x: f32, y: f32, z: f32, heading: f32) -> Self {
        Self { x, y, z, heading }
    }

    /// A planar transform at a height.
    pub fn from_planar(planar: Planar, y: f32) -> Self {
        Self { x: planar.x, y, z: planar.z, heading: planar.heading }
    }

    /// The part on the ground.
    pub fn planar(self) -> Planar {
        Planar::new(self.x, self.z, self.heading)
    }

    /// The translation.
    pub fn translation(self) -> Vec3 {
        Vec3::new(self.x, self.y, self.z)
    }

    /// `self` after `inner`: first `inner`, then `self`. Headings add and are not wrapped.
    pub fn compose(self, inner: Self) -> Self {
        Self::from_planar(self.planar().compose(inner.planar()), self.y + inner.y)
    }

    /// The transform that undoes this one.
    pub fn inverse(self) -> Self {
        Self::from_planar(self.planar().inverse(), -self.y)
    }

    /// `other` as seen from `self`: `self.inverse().compose(other)`.
    pub fn to_local(self, other: Self) -> Self {
        self.inverse().compose(other)
    }

    /// A local point in the outer frame.
    pub fn transform_point(self, p: Vec3) -> Vec3 {
        let on_ground = self.planar().transform_point(Vec2::new(p.x, p.z));
        Vec3::new(on_ground.x, self.y + p.y, on_ground.y)
    }

    /// An outer point in the local frame.
    pub fn inverse_transform_point(self, p: Vec3) -> Vec3 {
        let on_ground = self.planar().inverse_transform_point(Vec2::new(p.x, p.z));
        Vec3::new(on_ground.x, p.y - self.y, on_ground.y)
    }

    /// Placement with the heading in (-pi, pi].
    pub fn with_wrapped_heading(self) -> Self {
        Self { heading: wrap_angle(self.heading), ..self }
    }

    /// True where every number is below `limit` in size, and so none is infinite or not a number.
    pub fn is_moderate(self, limit: f32) -> bool {
        [self.x, self.y, self.z, self.heading].iter().all(|v| v.abs() < limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn placement() -> impl Strategy<Value = Placement> {
        (-9.0f32..9.0, -9.0f32..9.0, -9.0f32..9.0, -3.0f32..3.0).prop_map(|(x, y, z, h)| Placement::new(x, y, z, h))
    }

    proptest! {
        #[test]
        fn composing_is_transforming_twice_and_inverting_undoes_it(
            a in placement(), b in placement(), p in prop::array::uniform3(-9.0f32..9.0)
        ) {
            let p = Vec3::from_array(p);
            let twice = a.transform_point(b.transform_point(p));
            prop_assert!((a.compose(b).transform_point(p) - twice).length() < 1e-4);
            prop_assert!((a.inverse_transform_point(a.transform_point(p)) - p).length() < 1e-4);
            let back = a.compose(a.to_local(b));
            prop_assert!((back.translation() - b.translation()).length() < 1e-4);
        }
    }
}
