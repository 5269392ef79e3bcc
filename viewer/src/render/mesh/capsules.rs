//! A body of capsules: those of its [`BodyVolume`], each rigid on its joint, and a visor.

use super::loft::{Loft, Ring, equal_area};
use super::{BodyMesh, BodySide, Influence, SurfacePart};
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;
use throng_core::{BodyVolume, Joint, JointCapsule, Skeleton};
use throng_geometry::Capsule;

/// Levels of detail that are made of capsules.
pub(super) const LEVELS: usize = 3;
/// Number of points of a ring, and of rings of each end, by level of detail.
const DETAIL: [[usize; 2]; LEVELS] = [[12, 3], [7, 1], [3, 1]];

/// The body at one level of detail.
pub(super) fn build(skeleton: &Skeleton, level: usize) -> BodyMesh {
    let mut mesh = BodyMesh::default();
    for limb in limbs(skeleton).into_iter().filter(|l| level < 2 || l.radius > 0.028 * BodyVolume::scale(skeleton)) {
        add_capsule(&limb, DETAIL[level], &mut mesh);
    }
    mesh
}

/// A capsule and the joint that carries it.
struct LimbCapsule {
    joint: Joint,
    from: Vec3,
    to: Vec3,
    radius: f32,
    part: SurfacePart,
}

fn limbs(skeleton: &Skeleton) -> Vec<LimbCapsule> {
    let rest = skeleton.rest_positions();
    let one = |c: JointCapsule| {
        let Capsule { ends: [from, to], radius } = c.placed(|joint, p| rest[joint.index()] + p);
        LimbCapsule { joint: c.joint, from, to, radius, part: surface_part(c.joint) }
    };
    let mut limbs: Vec<LimbCapsule> = BodyVolume::new(skeleton).capsules.map(one).into();
    // The face.
    let top = skeleton.tips[0].length().clamp(0.05, 0.6);
    let eye = |x: f32| rest[Joint::Head.index()] + Vec3::new(x * top, 0.42 * top, 0.42 * top);
    let (radius, part) = (0.029 * BodyVolume::scale(skeleton), SurfacePart::Visor);
    limbs.push(LimbCapsule { joint: Joint::Head, from: eye(0.18), to: eye(-0.18), radius, part });
    limbs
}

/// Part of the surface that a joint's capsule is.
fn surface_part(joint: Joint) -> SurfacePart {
    use Joint::*;
    match joint {
        Neck | Head | LeftHand | RightHand => SurfacePart::Skin,
        Hips | LeftThigh | RightThigh | LeftShin | RightShin => SurfacePart::Trousers,
        LeftFoot | RightFoot | LeftToe | RightToe => SurfacePart::Shoe,
        _ => SurfacePart::Shirt,
    }
}

fn add_capsule(limb: &LimbCapsule, [segments, end_rings]: [usize; 2], mesh: &mut BodyMesh) {
    let radius = limb.radius;
    let side = BodySide::of_joint(limb.joint);
    // What is nearly a ball would be two cones with a single ring: a head with a hat.
    let is_ball = limb.from.distance(limb.to) < radius && end_rings < 2 && segments > 3;
    let end_rings = if is_ball { 2 } else { end_rings };
    // Feet do not sink into the ground.
    let lift = |p: Vec3| if limb.part == SurfacePart::Shoe { p.with_y(p.y.max(radius)) } else { p };
    let (from, to) = (lift(limb.from), lift(limb.to));
    let along = (to - from).normalize_or(Vec3::Y);
    let mirrored = if side == BodySide::Right { -1.0 } else { 1.0 };
    let guide = if along.z.abs() < 0.7 { Vec3::Z } else { Vec3::Y };
    let v = (guide - along * guide.dot(along)).normalize_or(Vec3::Y);
    let u = (v.cross(along) * mirrored).normalize_or(Vec3::X);
    let ring = |centre: Vec3, angle: f32| {
        let (s, c) = angle.sin_cos();
        let across = c * radius * equal_area(segments);
        Ring::ellipse(centre + along * (s * radius), u * across, v * across)
    };
    let step = |i: usize| FRAC_PI_2 * i as f32 / end_rings as f32;
    let lower = (0..end_rings).rev().map(|i| ring(from, -step(i)));
    let upper = (0..end_rings).map(|i| ring(to, step(i)));
    let rings: Vec<Ring> = lower.chain(upper).collect();
    let poles = [from - along * radius, to + along * radius];
    Loft { rings: &rings, segments, poles }.build(mesh, |_| Influence::rigid(limb.joint), |_| (limb.part, side));
}
