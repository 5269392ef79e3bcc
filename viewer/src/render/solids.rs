//! Things that stand in the world: meshes of boxes, bars and triangles, each made once and drawn in many places.

use super::{Ray, Rgba, shape_draws::round_mesh};
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};
use std::sync::Arc;
use throng_core::patch::Placement;
use throng_geometry::{RayCrossing, ray_crossing};
use throng_precompute::environment::UnitSolid;

/// Corners around a bar, and rings of each of its ends.
const AROUND: usize = 10;
const END_RINGS: usize = 2;

/// Corner of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct SolidVertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
}

/// Triangles in the frame of a thing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolidMesh {
    pub(super) vertices: Vec<SolidVertex>,
    pub(super) indices: Vec<u32>,
}

/// A thing with its placement. With alpha below 1 it is transparent and drawn after all others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidInstance {
    /// Number of the mesh.
    pub mesh: u32,
    /// Position of its frame in the world (m).
    pub at: Vec3,
    /// Rotation of its frame. Unit.
    pub turn: Quat,
    /// Colour of the thing.
    pub colour: Rgba,
}

impl SolidInstance {
    /// A thing that stands upright.
    pub fn upright(mesh: u32, placement: Placement, colour: Rgba) -> Self {
        let (at, turn) = upright(placement);
        Self { mesh, at, turn, colour }
    }
}

/// Position and rotation of the frame of an upright thing.
pub fn upright(p: Placement) -> (Vec3, Quat) {
    (Vec3::new(p.x, p.y, p.z), Quat::from_rotation_y(p.heading))
}

/// All that stands in the world.
#[derive(Clone, Debug, Default)]
pub struct Solids {
    /// The meshes; the same `Arc` stands for the same meshes.
    pub meshes: Arc<[SolidMesh]>,
    /// Placed things.
    pub instances: Vec<SolidInstance>,
}

impl SolidMesh {
    /// Adds a box (m).
    ///
    /// - `half`: half of the edge lengths along the box's own axes, which `rotation` turns.
    pub fn add_box(&mut self, centre: Vec3, rotation: Quat, half: Vec3) {
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut normal = Vec3::ZERO;
                normal[axis] = side;
                let corner = |a: f32, b: f32| {
                    let mut p = normal * half;
                    (p[u], p[v]) = (a * side * half[u], b * half[v]);
                    centre + rotation * p
                };
                let face = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                self.add_face(&face, rotation * normal);
            }
        }
    }

    /// Adds a bar with round ends (m).
    pub fn add_bar(&mut self, from: Vec3, to: Vec3, radius: f32) {
        let y = (to - from).normalize_or(Vec3::Y);
        let (x, z) = y.any_orthonormal_pair();
        let first = self.vertices.len() as u32;
        let (corners, indices) = round_mesh(AROUND, END_RINGS);
        self.vertices.extend(corners.iter().map(|corner| {
            let [aside, up, ahead] = corner.direction;
            let normal = z * aside + y * up + x * ahead;
            let position = from.lerp(to, corner.end) + normal * radius;
            SolidVertex { position: position.to_array(), normal: normal.to_array() }
        }));
        self.indices.extend(indices.iter().map(|i| first + i));
    }

    /// Adds a solid of a unit.
    pub fn add_solid(&mut self, solid: &UnitSolid) {
        match solid {
            UnitSolid::Box { centre, rotation, half } => self.add_box(*centre, *rotation, *half),
            UnitSolid::Bar { from, to, radius } => self.add_bar(*from, *to, *radius),
            UnitSolid::Mesh(triangles) => triangles.corners().iter().for_each(|t| self.add_triangle(*t)),
        }
    }

    /// Adds a triangle, which is seen from both sides (m).
    pub fn add_triangle(&mut self, [a, b, c]: [Vec3; 3]) {
        let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
        self.add_face(&[a, b, c], normal);
        self.add_face(&[a, c, b], -normal);
    }

    /// A convex face, its corners counter-clockwise as seen from outside.
    fn add_face(&mut self, corners: &[Vec3], normal: Vec3) {
        let first = self.vertices.len() as u32;
        let normal = normal.to_array();
        self.vertices.extend(corners.iter().map(|c| SolidVertex { position: c.to_array(), normal }));
        for i in 2..corners.len() as u32 {
            self.indices.extend([first, first + i - 1, first + i]);
        }
    }

    /// Nearest intersection of a ray with the mesh at a position and rotation: the distance along the ray (m).
    pub fn intersect(&self, ray: &Ray, (at, turn): (Vec3, Quat)) -> Option<f32> {
        let back = turn.conjugate();
        let local = Ray { origin: back * (ray.origin - at), direction: back * ray.direction };
        let corner = |i: u32| Vec3::from(self.vertices[i as usize].position);
        let met = self.indices.chunks_exact(3).filter_map(|triangle| {
            let corners = [0, 1, 2].map(|k| corner(triangle[k]));
            let RayCrossing { det, u, v, t } = ray_crossing(local.origin, local.direction, &corners);
            // Hit from outside.
            (det > 1e-12 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
        });
        met.min_by(f32::total_cmp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    fn every_triangle_faces_away_from(mesh: &SolidMesh, middle: Vec3) {
        for t in mesh.indices.chunks_exact(3) {
            let v = [0, 1, 2].map(|k| mesh.vertices[t[k] as usize]);
            let p = v.map(|v| Vec3::from(v.position));
            let normal = (p[1] - p[0]).cross(p[2] - p[0]);
            assert!(normal.dot((p[0] + p[1] + p[2]) / 3.0 - middle) > -1e-7);
            assert!(normal.length() < 1e-7 || normal.dot(Vec3::from(v[0].normal)) > 0.0);
        }
    }

    #[test]
    fn boxes_and_bars_face_outwards() {
        let mut mesh = SolidMesh::default();
        let centre = Vec3::new(1.0, 2.0, -0.5);
        mesh.add_box(centre, Quat::from_rotation_y(0.7), Vec3::new(0.5, 0.2, 1.0));
        assert_eq!((mesh.vertices.len(), mesh.indices.len()), (24, 36));
        every_triangle_faces_away_from(&mesh, centre);
        let mut mesh = SolidMesh::default();
        let (from, to) = (Vec3::new(0.0, 0.3, 0.0), Vec3::new(0.4, 1.0, 0.2));
        mesh.add_bar(from, to, 0.05);
        every_triangle_faces_away_from(&mesh, 0.5 * (from + to));
        for v in &mesh.vertices {
            let p = Vec3::from(v.position);
            let t = ((p - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
            assert!((p.distance(from.lerp(to, t)) - 0.05).abs() < 1e-5);
        }
    }

    #[test]
    fn rays_meet_what_stands_turned_and_elsewhere() {
        let mut mesh = SolidMesh::default();
        mesh.add_box(Vec3::new(0.0, 0.5, 0.0), Quat::IDENTITY, Vec3::new(1.0, 0.5, 0.1));
        let ray = Ray { origin: Vec3::new(5.0, 0.5, -7.0), direction: Vec3::Z };
        let at = Vec3::new(5.0, 0.0, 3.0);
        let turned = Quat::from_rotation_y;
        assert!(mesh.intersect(&ray, (at, Quat::IDENTITY)).is_some_and(|d| (d - 9.9).abs() < 1e-4));
        assert!(mesh.intersect(&ray, (at, turned(0.5 * PI))).is_some_and(|d| (d - 9.0).abs() < 1e-4));
        let beside = Ray { origin: ray.origin + Vec3::X * 0.5, ..ray };
        assert!(
            mesh.intersect(&beside, (at, Quat::IDENTITY)).is_some()
                && mesh.intersect(&beside, (at, turned(0.5 * PI))).is_none()
        );
        assert!(mesh.intersect(&Ray { direction: -Vec3::Z, ..ray }, (at, Quat::IDENTITY)).is_none());
    }

    #[test]
    fn a_triangle_is_met_from_both_sides() {
        let mut mesh = SolidMesh::default();
        mesh.add_triangle([Vec3::ZERO, Vec3::X, Vec3::Y]);
        for side in [-1.0, 1.0] {
            let ray = Ray { origin: Vec3::new(0.2, 0.2, 2.0 * side), direction: Vec3::Z * -side };
            assert!(mesh.intersect(&ray, (Vec3::ZERO, Quat::IDENTITY)).is_some_and(|d| (d - 2.0).abs() < 1e-5));
        }
    }
}
