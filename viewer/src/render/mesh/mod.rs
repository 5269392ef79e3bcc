//! Bodies as triangle meshes, generated around the joints of a skeleton.
//!
//! Two bodies: capsules, one for each limb and rigid on one joint, and a mannequin whose surface bends. Each comes in
//! [`LEVELS`] levels of detail; the coarsest, for bodies a few pixels wide, is the same for both.

mod capsules;
mod loft;
mod mannequin;
mod weights;

pub use weights::Influence;

use throng_core::{Joint, Skeleton};

/// Levels of detail of a body, finest first.
pub const LEVELS: usize = 4;

/// Appearance of a character.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub enum BodyStyle {
    /// A capsule around every limb.
    #[default]
    Capsules,
    /// A smooth figure, skinned.
    Mannequin,
    /// A mesh of the user's own; characters that cannot wear it look like [`BodyStyle::Mannequin`].
    Own,
}

/// Part of the surface; colours depend on it. Numbers match `shaders/body.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u32)]
pub enum SurfacePart {
    /// Head, neck, hands.
    Skin = 0,
    /// Trunk and arms.
    Shirt,
    /// Pelvis and legs.
    Trousers,
    /// Feet.
    Shoe,
    /// The underside of the feet.
    Sole,
    /// Eyes.
    Visor,
}

/// Which side of the body a part is on: left and right are tinted apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u32)]
pub enum BodySide {
    /// Trunk and head.
    Middle = 0,
    /// +X.
    Left = 8,
    /// -X.
    Right = 16,
}

impl BodySide {
    /// Both sides.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// A joint of the left side, on this side.
    pub fn joint_on_side(self, left: Joint) -> Joint {
        if self == Self::Right { left.mirrored() } else { left }
    }

    /// The side a joint is on.
    pub fn of_joint(joint: Joint) -> Self {
        match joint.index() {
            6..=9 | 14..=17 => Self::Left,
            10..=13 | 18..=21 => Self::Right,
            _ => Self::Middle,
        }
    }
}

/// One vertex, as the GPU reads it.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Vertex {
    /// Place in rest pose, model space (m).
    pub position: [f32; 3],
    /// [`SurfacePart`] plus [`BodySide`].
    pub part: u32,
    /// Outward in rest pose. Unit.
    pub normal: [f32; 3],
    /// Joints that move it.
    pub joints: [u8; 4],
    /// Weight of each joint (sum 255).
    pub weights: [u8; 4],
}

/// A body at one level of detail.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyMesh {
    /// Corners.
    pub vertices: Vec<Vertex>,
    /// Three for each triangle, anticlockwise from outside.
    pub indices: Vec<u32>,
}

/// The body of a skeleton at every level of detail, finest first.
pub fn build(body: BodyStyle, skeleton: &Skeleton) -> [BodyMesh; LEVELS] {
    std::array::from_fn(|level| match body {
        BodyStyle::Capsules if level < capsules::LEVELS => capsules::build(skeleton, level),
        _ => mannequin::build(skeleton, level),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use std::collections::HashMap;
    use throng_core::NUM_JOINTS;

    fn skeletons() -> [Skeleton; 2] {
        let mut small = Skeleton::default();
        for joint in Joint::ALL {
            let kind = joint.index().min(joint.mirrored().index()) % 3;
            small.offsets[joint.index()] *= 0.7 + 0.02 * kind as f32;
        }
        [Skeleton::default(), small]
    }

    fn every_mesh(mut check: impl FnMut(BodyStyle, usize, &BodyMesh)) {
        for skeleton in skeletons() {
            for body in [BodyStyle::Capsules, BodyStyle::Mannequin] {
                for (level, mesh) in build(body, &skeleton).iter().enumerate() {
                    check(body, level, mesh);
                }
            }
        }
    }

    #[test]
    fn vertices_are_sound() {
        every_mesh(|body, level, mesh| {
            for v in &mesh.vertices {
                assert!(Vec3::from(v.position).is_finite());
                assert!((Vec3::from(v.normal).length() - 1.0).abs() < 1e-4, "{body:?} {level} {v:?}");
                assert_eq!(v.weights.iter().map(|&w| u32::from(w)).sum::<u32>(), 255);
                assert!(v.joints.iter().all(|&j| usize::from(j) < NUM_JOINTS));
            }
            assert!(mesh.indices.iter().all(|&i| (i as usize) < mesh.vertices.len()));
        });
    }

    #[test]
    fn surfaces_are_closed_and_face_outwards() {
        every_mesh(|body, level, mesh| {
            let key = |i: u32| mesh.vertices[i as usize].position.map(f32::to_bits);
            let mut edges: HashMap<_, i32> = HashMap::new();
            let mut volume = 0.0;
            for t in mesh.indices.chunks_exact(3) {
                let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(mesh.vertices[t[i] as usize].position));
                volume += a.dot(b.cross(c)) / 6.0;
                for (p, q) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                    *edges.entry((key(p), key(q))).or_default() += 1;
                    *edges.entry((key(q), key(p))).or_default() -= 1;
                }
            }
            assert!(edges.values().all(|&n| n == 0), "{body:?} {level} has a hole");
            assert!((0.01..0.2).contains(&volume), "{body:?} {level}: {volume} cubic metres");
        });
    }

    #[test]
    fn coarser_levels_are_much_lighter() {
        let limits = [1500..4000, 350..1100, 150..320, 50..110];
        every_mesh(|body, level, mesh| {
            let triangles = mesh.indices.len() / 3;
            assert!(limits[level].contains(&triangles), "{body:?} {level}: {triangles}");
        });
    }

    #[test]
    fn soles_rest_on_the_ground() {
        let lowest = |m: &BodyMesh| m.vertices.iter().map(|v| v.position[1]).fold(f32::INFINITY, f32::min);
        for body in [BodyStyle::Capsules, BodyStyle::Mannequin] {
            for mesh in build(body, &Skeleton::default()) {
                assert!(lowest(&mesh).abs() < 0.02, "{body:?}: {}", lowest(&mesh));
            }
        }
    }

    #[test]
    fn both_sides_are_mirror_images() {
        every_mesh(|body, level, mesh| {
            let has = |p: Vec3| mesh.vertices.iter().any(|v| Vec3::from(v.position).abs_diff_eq(p, 2e-3));
            let limbs = mesh.vertices.iter().filter(|v| v.part & 24 == BodySide::Left as u32);
            let missing = limbs.filter(|v| !has(Vec3::from(v.position) * Vec3::new(-1.0, 1.0, 1.0))).count();
            assert_eq!(missing, 0, "{body:?} {level}");
        });
    }
}
