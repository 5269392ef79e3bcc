//! A flat hand with a thumb.

use super::super::loft::{Loft, Ring};
use super::super::{BodyMesh, BodySide, Influence, SurfacePart};
use super::{BodySection, MannequinPlan};
use glam::Vec3;
use throng_core::Joint;

/// Distance from the wrist, half thickness, half width, and how far forward (m).
const PALM: [BodySection; 7] = [
    (-0.025, 0.019, 0.023, 0.000, 1),
    (0.020, 0.018, 0.030, 0.002, 2),
    (0.055, 0.017, 0.040, 0.003, 0),
    (0.090, 0.015, 0.042, 0.001, 1),
    (0.125, 0.012, 0.038, 0.000, 0),
    (0.155, 0.010, 0.032, -0.002, 2),
    (0.172, 0.007, 0.022, -0.003, 0),
];
const PALM_ENDS: [f32; 2] = [-0.035, 0.181];
/// Centres and radii along the thumb: distance from the wrist, height, how far forward (m).
const THUMB: [([f32; 3], f32); 4] = [
    ([0.022, -0.004, 0.022], 0.0125),
    ([0.050, -0.010, 0.046], 0.0130),
    ([0.078, -0.016, 0.060], 0.0110),
    ([0.100, -0.020, 0.066], 0.0080),
];
const THUMB_ENDS: [[f32; 3]; 2] = [[0.008, 0.0, 0.012], [0.109, -0.022, 0.068]];

pub(super) fn build(plan: &MannequinPlan, side: BodySide, mesh: &mut BodyMesh) {
    let (fore, hand) = (side.joint_on_side(Joint::LeftForearm), side.joint_on_side(Joint::LeftHand));
    let wrist = plan.joint_position(hand);
    let s = plan.scale;
    let out = (wrist - plan.joint_position(fore)).normalize_or(Vec3::X);
    let mirror = if side == BodySide::Right { -1.0 } else { 1.0 };
    let place = |[along, up, forward]: [f32; 3]| wrist + (out * along + Vec3::Y * up + Vec3::Z * forward) * s;
    let weigh = |p: Vec3| Influence::chain(&[(fore, 0.0, 0.0), (hand, 0.0, 0.03 * s)], (p - wrist).dot(out));
    let rings = plan.rings(&PALM, |[along, thick, wide, forward]| {
        Ring::ellipse(place([along, 0.0, forward]), Vec3::Y * (thick * s), Vec3::Z * (wide * s))
    });
    let poles = PALM_ENDS.map(|along| place([along, 0.0, 0.0]));
    let loft = Loft { rings: &rings, segments: plan.segments([10, 5, 3, 3]), poles };
    loft.build(mesh, weigh, |_| (SurfacePart::Skin, side));
    if plan.level == 0 {
        let across = Vec3::new(mirror, 0.0, -1.0).normalize();
        let ring =
            |&(at, radius): &([f32; 3], f32)| Ring::ellipse(place(at), across * (radius * s), Vec3::Y * (radius * s));
        let rings: Vec<Ring> = THUMB.iter().map(ring).collect();
        let loft = Loft { rings: &rings, segments: 7, poles: THUMB_ENDS.map(place) };
        loft.build(mesh, weigh, |_| (SurfacePart::Skin, side));
    }
}
