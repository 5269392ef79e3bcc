//! A plain body, so that motion can be seen: the capsules of a [`BodyVolume`], each rigid on its joint.

use crate::body::BodyVolume;
use crate::skeleton::{Joint, Skeleton};
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, TAU};
use throng_base::maths::sin_cos;
use throng_geometry::Capsule;

/// Triangles that joints carry, in the rest pose on the ground.
///
/// ```
/// use throng_core::{PlainBody, Skeleton};
///
/// let body = PlainBody::coarse(&Skeleton::default());
/// assert_eq!(body.positions.len(), body.joints.len());
/// ```
#[derive(Clone, Debug, Default)]
pub struct PlainBody {
    /// (m)
    pub positions: Vec<Vec3>,
    /// Unit (positions.len()).
    pub normals: Vec<Vec3>,
    /// Joint that carries each point (positions.len()).
    pub joints: Vec<u8>,
    /// Corners of triangles, counter-clockwise as seen from outside.
    pub triangles: Vec<[u16; 3]>,
}

impl PlainBody {
    /// Body of a skeleton in its rest pose: 1408 triangles.
    pub fn fine(skeleton: &Skeleton) -> Self {
        Self::with_rings(skeleton, 8, 2)
    }

    /// Coarse body for distant characters: 352 triangles.
    pub fn coarse(skeleton: &Skeleton) -> Self {
        Self::with_rings(skeleton, 4, 1)
    }

    /// Body whose capsules have some rings of so many sides at each end.
    fn with_rings(skeleton: &Skeleton, sides: usize, rings: usize) -> Self {
        let rest = skeleton.rest_positions();
        let mut body = Self::default();
        for limb in BodyVolume::new(skeleton).capsules {
            body.add_capsule(limb.joint, &limb.placed(|joint, p| rest[joint.index()] + p), sides, rings);
        }
        body
    }

    fn add_capsule(&mut self, joint: Joint, capsule: &Capsule, sides: usize, rings: usize) {
        let Capsule { ends: [from, to], radius } = *capsule;
        let along = (to - from).normalize_or(Vec3::Y);
        let u = along.any_orthonormal_vector();
        let v = along.cross(u);
        let first = self.positions.len() as u16;
        let mut point = |centre: Vec3, normal: Vec3| {
            self.positions.push(centre + normal * radius);
            self.normals.push(normal.normalize());
            self.joints.push(joint.index() as u8);
        };
        point(from, -along);
        for (centre, low, high) in [(from, -FRAC_PI_2, 0.0), (to, 0.0, FRAC_PI_2)] {
            for ring in 0..rings {
                let part = if low < 0.0 { ring + 1 } else { ring } as f32 / rings as f32;
                let turn = low + (high - low) * part;
                let (s, c) = sin_cos(turn);
                for side in 0..sides {
                    let (y, x) = sin_cos(TAU * side as f32 / sides as f32);
                    point(centre, along * s + (u * x + v * y) * c);
                }
            }
        }
        point(to, along);
        let ring = |r: usize, side: usize| first + 1 + (r * sides + side % sides) as u16;
        let last = first + 1 + (2 * rings * sides) as u16;
        for side in 0..sides {
            self.triangles.push([first, ring(0, side + 1), ring(0, side)]);
            self.triangles.push([last, ring(2 * rings - 1, side), ring(2 * rings - 1, side + 1)]);
            for r in 0..2 * rings - 1 {
                let [a, b, c, d] = [ring(r, side), ring(r, side + 1), ring(r + 1, side), ring(r + 1, side + 1)];
                self.triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_closed_and_face_outwards() {
        for (body, triangles) in
            [(PlainBody::fine(&Skeleton::default()), 1408), (PlainBody::coarse(&Skeleton::default()), 352)]
        {
            assert_eq!(body.triangles.len(), triangles);
            check(&body);
        }
    }

    fn check(body: &PlainBody) {
        let at = |i: u16| body.positions[usize::from(i)];
        let mut edges = std::collections::HashMap::<(u16, u16), i32>::new();
        for [a, b, c] in &body.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((*from.min(to), *from.max(to))).or_default() += if from < to { 1 } else { -1 };
            }
            let outwards = body.normals[usize::from(*a)] + body.normals[usize::from(*b)];
            assert!((at(*b) - at(*a)).cross(at(*c) - at(*a)).dot(outwards) > 0.0);
        }
        assert!(edges.values().all(|n| *n == 0), "every edge is gone along once each way");
        assert!(body.positions.iter().all(|p| (-0.1..1.9).contains(&p.y) && p.x.abs() < 1.0));
    }
}
