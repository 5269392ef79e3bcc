//! Pieces of geometry, with their distance from points.

use super::{UnitShape, mesh};
use glam::{Quat, Vec3};
use throng_base::maths;
use throng_geometry::{BoundingBox, SurfacePoint, TriangleMesh, nearest_on_bar, nearest_on_box, nearest_on_segment};
use throng_motion::error::{BuildError, Result};

/// A piece of geometry in its unit's frame.
#[derive(Clone, Debug, PartialEq)]
pub enum UnitSolid {
    /// A box.
    Box {
        /// Its middle (m).
        centre: Vec3,
        /// From the box's axes to the unit's.
        rotation: Quat,
        /// Extents on each side of the centre, along the box's axes (m).
        half: Vec3,
    },
    /// A bar with round ends.
    Bar {
        /// One end of its axis (m).
        from: Vec3,
        /// The other end (m).
        to: Vec3,
        /// Radius (m).
        radius: f32,
    },
    /// A surface of triangles.
    Mesh(TriangleMesh),
}

impl UnitSolid {
    /// Solid of a shape; triangles are read from their file.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError`] where a mesh cannot be read.
    pub fn from_shape(shape: &UnitShape) -> Result<Self> {
        Ok(match shape {
            UnitShape::Box { at, size, heading_deg, pitch_deg } => Self::Box {
                centre: Vec3::from(*at),
                rotation: maths::compose(
                    Quat::from_rotation_y(heading_deg.to_radians()),
                    Quat::from_rotation_x(pitch_deg.to_radians()),
                ),
                half: 0.5 * Vec3::from(*size),
            },
            UnitShape::Bar { from, to, radius } => {
                Self::Bar { from: Vec3::from(*from), to: Vec3::from(*to), radius: *radius }
            }
            UnitShape::Mesh { file } => {
                let fail = |e| BuildError::Config { message: format!("{}: {e}", file.display()) };
                Self::Mesh(TriangleMesh::new(mesh::read(file)?).map_err(fail)?)
            }
        })
    }

    /// Bounds of the solid.
    pub fn bounds(&self) -> BoundingBox {
        match self {
            Self::Box { centre, rotation, half } => {
                let corners = BoundingBox { min: -*half, max: *half }.corners();
                BoundingBox::around_points(corners.map(|c| *centre + *rotation * c))
            }
            Self::Bar { from, to, radius } => BoundingBox::around_points([*from, *to]).expanded(*radius),
            Self::Mesh(mesh) => mesh.bounds(),
        }
    }

    /// Distance of `p`, as in [`Self::nearest`]; infinite at `limit` or farther (m).
    pub fn distance(&self, p: Vec3, limit: f32) -> f32 {
        let distance = match self {
            Self::Box { centre, rotation, half } => {
                let local = rotation.conjugate() * (p - *centre);
                let over = (local.abs() - *half).max_element();
                if over > 0.0 { (local - local.clamp(-*half, *half)).length() } else { over }
            }
            Self::Bar { from, to, radius } => (p - nearest_on_segment(p, [*from, *to])).length() - radius,
            Self::Mesh(mesh) => mesh.point_distance(p, limit),
        };
        if distance < limit { distance } else { f32::INFINITY }
    }

    /// Nearest surface point to `p`; `None` at `limit` or farther. Distances are signed for boxes and bars, and never
    /// negative for triangles, which have no inside.
    pub fn nearest(&self, p: Vec3, limit: f32) -> Option<SurfacePoint> {
        let found = match self {
            Self::Box { centre, rotation, half } => {
                let local = rotation.conjugate() * (p - *centre);
                let s = nearest_on_box(local, *half);
                let (point, normal) = (*centre + *rotation * s.point, *rotation * s.normal);
                SurfacePoint { distance: s.distance, point, normal }
            }
            Self::Bar { from, to, radius } => nearest_on_bar(p, *from, *to, *radius),
            Self::Mesh(mesh) => mesh.nearest(p, limit)?,
        };
        (found.distance < limit).then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(limit: f32) -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-limit..limit).prop_map(Vec3::from)
    }

    /// Every point of a grid over the surface of a box, given by its faces.
    fn box_surface(shape: &UnitShape) -> Vec<Vec3> {
        let UnitShape::Box { at, size, heading_deg, pitch_deg } = shape else { panic!("a box") };
        let (sh, ch) = heading_deg.to_radians().sin_cos();
        let (sp, cp) = pitch_deg.to_radians().sin_cos();
        let place = |q: Vec3| {
            let tilted = Vec3::new(q.x, q.y * cp - q.z * sp, q.y * sp + q.z * cp);
            Vec3::from(*at) + Vec3::new(tilted.x * ch + tilted.z * sh, tilted.y, tilted.z * ch - tilted.x * sh)
        };
        let n = 40;
        let at = |i: i32| i as f32 / n as f32 - 0.5;
        let mut out = Vec::new();
        for i in 0..=n {
            for j in 0..=n {
                for side in [-0.5, 0.5] {
                    for face in [[side, at(i), at(j)], [at(i), side, at(j)], [at(i), at(j), side]] {
                        out.push(place(Vec3::from(face) * Vec3::from(*size)));
                    }
                }
            }
        }
        out
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn distance_to_a_box_is_that_to_its_densely_sampled_surface(
            at in vector(1.0), size in prop::array::uniform3(0.1f32..2.0), heading_deg in -180.0f32..180.0,
            pitch_deg in -80.0f32..80.0, p in vector(2.0)
        ) {
            let shape = UnitShape::Box { at: at.into(), size, heading_deg, pitch_deg };
            let solid = UnitSolid::from_shape(&shape).unwrap();
            let found = solid.nearest(p, f32::INFINITY).unwrap();
            let surface = box_surface(&shape);
            let sampled = surface.iter().map(|s| s.distance(p)).fold(f32::INFINITY, f32::min);
            // Half of the diagonal of the largest cell of the samples.
            let cell = 2.0 / 40.0 * 0.71;
            prop_assert!(found.distance.abs() <= sampled + 1e-4 && sampled <= found.distance.abs() + cell);
            prop_assert!((found.point.distance(p) - found.distance.abs()).abs() < 1e-4);
            prop_assert!(solid.nearest(found.point + found.normal * 0.01, 9.0).unwrap().distance > 0.009);
            prop_assert!(surface.iter().all(|s| solid.bounds().expanded(1e-4).contains(*s)));
            let inside = (0..3).all(|k| {
                let q = Quat::from_rotation_x(-pitch_deg.to_radians())
                    * Quat::from_rotation_y(-heading_deg.to_radians()) * (p - at);
                q[k].abs() < 0.5 * size[k]
            });
            prop_assert_eq!(found.distance < 0.0, inside);
        }

        #[test]
        fn distance_to_a_bar_is_that_to_its_densely_sampled_axis(
            from in vector(1.0), to in vector(1.0), radius in 0.01f32..0.4, p in vector(2.0)
        ) {
            let solid = UnitSolid::Bar { from, to, radius };
            let found = solid.nearest(p, f32::INFINITY).unwrap();
            let axis = (0..=4000).map(|i| from.lerp(to, i as f32 / 4000.0).distance(p)).fold(f32::INFINITY, f32::min);
            prop_assert!((found.distance - (axis - radius)).abs() < 2e-3);
            prop_assert!((found.point.distance(p) - found.distance.abs()).abs() < 1e-4);
            prop_assert!(solid.bounds().expanded(1e-4).contains(found.point));
        }
    }

    #[test]
    fn a_tilted_box_falls_towards_its_far_end() {
        let shape = UnitShape::Box { at: [0.0, 1.0, 0.0], size: [1.0, 0.2, 4.0], heading_deg: 90.0, pitch_deg: 30.0 };
        let top = |x: f32| {
            let p = Vec3::new(x, 1.8, 0.0);
            UnitSolid::from_shape(&shape).unwrap().nearest(p, 99.0).unwrap().point
        };
        assert!(top(-1.0).y > top(1.0).y, "+z of the box is +x of the unit and lies lower");
    }

    #[test]
    fn what_is_farther_than_the_limit_is_not_found() {
        let solid = UnitSolid::Bar { from: Vec3::ZERO, to: Vec3::ZERO, radius: 0.5 };
        assert_eq!(solid.nearest(Vec3::X * 2.0, 1.4), None);
        let found = solid.nearest(Vec3::X * 2.0, 1.6).unwrap();
        assert!((found.distance - 1.5).abs() < 1e-6 && (found.point - Vec3::X * 0.5).length() < 1e-6);
        assert!((solid.nearest(Vec3::ZERO, 1.0).unwrap().distance + 0.5).abs() < 1e-6);
    }
}
