//! A body of capsules: one around every limb, rigid on the joint at its start.

use super::loft::{Loft, Ring, equal_area};
use super::{BodyMesh, BodySide, Influence, SurfacePart};
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;
use throng_core::{Joint, Skeleton};

/// Levels of detail that are made of capsules.
pub(super) const LEVELS: usize = 3;
/// Fineness of a capsule's mesh.
#[derive(Clone, Copy)]
struct CapsuleDetail {
    /// Number of points of a ring.
    segments: usize,
    /// Number of rings of each end.
    end_rings: usize,
}

/// Fineness by level of detail.
const DETAIL: [CapsuleDetail; LEVELS] = [
    CapsuleDetail { segments: 12, end_rings: 3 },
    CapsuleDetail { segments: 7, end_rings: 1 },
    CapsuleDetail { segments: 3, end_rings: 1 },
];

/// The body at one level of detail.
pub(super) fn build(skeleton: &Skeleton, level: usize) -> BodyMesh {
    let mut mesh = BodyMesh::default();
    let scale = skeleton.leg_length() / Skeleton::default().leg_length();
    for limb in limbs(skeleton).into_iter().filter(|l| level < 2 || l.radius > 0.028) {
        let side = BodySide::of_joint(limb.joint);
        capsule(&limb, limb.radius * scale, side, DETAIL[level], &mut mesh);
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
    let mut limbs: Vec<LimbCapsule> = Vec::with_capacity(26);
    for joint in Joint::ALL {
        if let Some(parent) = joint.parent() {
            let (radius, part) = limb_style(joint);
            limbs.push(LimbCapsule {
                joint: parent,
                from: rest[parent.index()],
                to: rest[joint.index()],
                radius,
                part,
            });
        }
    }
    for (i, joint) in [Joint::Head, Joint::LeftToe, Joint::RightToe].into_iter().enumerate() {
        let from = rest[joint.index()];
        let (radius, part) = if i == 0 { (0.085, SurfacePart::Skin) } else { (0.02, SurfacePart::Shoe) };
        let to = from + skeleton.tips[i] * if i == 0 { 0.58 } else { 1.0 };
        limbs.push(LimbCapsule { joint, from, to, radius, part });
    }
    // The face.
    let top = skeleton.tips[0].length().clamp(0.05, 0.6);
    let eye = |x: f32| rest[Joint::Head.index()] + Vec3::new(x * top, 0.42 * top, 0.36 * top);
    limbs.push(LimbCapsule {
        joint: Joint::Head,
        from: eye(0.18),
        to: eye(-0.18),
        radius: 0.029,
        part: SurfacePart::Visor,
    });
    for side in BodySide::BOTH {
        let joint = side.joint_on_side(Joint::LeftHand);
        let fore = skeleton.offsets[joint.index()];
        let from = rest[joint.index()];
        limbs.push(LimbCapsule { joint, from, to: from + fore * 0.45, radius: 0.028, part: SurfacePart::Skin });
    }
    limbs
}

/// Radius and part of the limb that ends in a joint (m).
fn limb_style(joint: Joint) -> (f32, SurfacePart) {
    use Joint::*;
    match joint {
        Hips | Spine => (0.1, SurfacePart::Trousers),
        Chest => (0.1, SurfacePart::Shirt),
        UpperChest => (0.105, SurfacePart::Shirt),
        Neck => (0.07, SurfacePart::Shirt),
        Head => (0.045, SurfacePart::Skin),
        LeftClavicle | RightClavicle => (0.05, SurfacePart::Shirt),
        LeftUpperArm | RightUpperArm => (0.05, SurfacePart::Shirt),
        LeftForearm | RightForearm => (0.045, SurfacePart::Shirt),
        LeftHand | RightHand => (0.034, SurfacePart::Shirt),
        LeftThigh | RightThigh => (0.074, SurfacePart::Trousers),
        LeftShin | RightShin => (0.068, SurfacePart::Trousers),
        LeftFoot | RightFoot => (0.05, SurfacePart::Trousers),
        LeftToe | RightToe => (0.03, SurfacePart::Shoe),
    }
}

fn capsule(limb: &LimbCapsule, radius: f32, side: BodySide, detail: CapsuleDetail, mesh: &mut BodyMesh) {
    let CapsuleDetail { segments, end_rings } = detail;
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
