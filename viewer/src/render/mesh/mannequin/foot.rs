//! A shoe: flat below, so that contact with the ground can be seen.

use super::super::loft::{Loft, Ring};
use super::super::{BodyMesh, BodySide, Influence, SurfacePart};
use super::{BodySection, MannequinPlan};
use glam::Vec3;
use throng_core::Joint;

/// Place along the foot (0 at the ankle, 1 at the ball, 2 at the tip of the toes), half width, height, and shift to the
/// outer side (m).
const SECTIONS: [BodySection; 9] = [
    (-0.44, 0.024, 0.062, 0.000, 0),
    (-0.36, 0.034, 0.086, 0.000, 2),
    (-0.15, 0.039, 0.104, 0.000, 1),
    (0.12, 0.041, 0.107, 0.001, 3),
    (0.40, 0.042, 0.088, 0.003, 1),
    (0.72, 0.046, 0.066, 0.004, 0),
    (1.05, 0.049, 0.052, 0.004, 2),
    (1.55, 0.045, 0.045, 0.001, 0),
    (1.95, 0.033, 0.036, -0.002, 1),
];
const HEEL: f32 = -0.5;
const TIP: f32 = 2.16;

pub(super) fn build(plan: &MannequinPlan, side: BodySide, mesh: &mut BodyMesh) {
    let joints = [Joint::LeftFoot, Joint::LeftToe].map(|j| side.joint_on_side(j));
    let [ankle, ball] = joints.map(|j| plan.joint_position(j));
    let tip = plan.tips[if side == BodySide::Left { 1 } else { 2 }];
    let s = plan.scale;
    // The sole is the ground in rest pose, unless the toes are not where feet have them.
    let sole = 0.0_f32.clamp(ball.y - 0.04 * s, (ball.y - 0.008 * s).max(ball.y - 0.04 * s));
    let mirror = if side == BodySide::Right { -1.0 } else { 1.0 };
    let place = |t: f32| {
        let p = if t <= 1.0 { ankle + (ball - ankle) * t } else { ball + (tip - ball) * (t - 1.0) };
        p.with_y(sole)
    };
    let rings = plan.rings(&SECTIONS, |[t, width, height, outwards]| {
        let (centre, v) = (place(t) + Vec3::X * (outwards * mirror) * s, Vec3::Y * (0.5 * height * s));
        Ring { centre: centre.with_y(sole + v.y), u: Vec3::X * (width * s * mirror), v, square: [2.3, 5.0] }
    });
    let poles = [place(HEEL) + Vec3::Y * (0.03 * s), place(TIP) + Vec3::Y * (0.018 * s)];
    let links = [(joints[0], f32::NEG_INFINITY, 0.0), (joints[1], ball.z, 0.025 * s)];
    let part = |middle: Vec3| (if middle.y < sole + 0.004 * s { SurfacePart::Sole } else { SurfacePart::Shoe }, side);
    let loft = Loft { rings: &rings, segments: plan.segments([12, 6, 4, 3]), poles };
    loft.build(mesh, |p| Influence::chain(&links, p.z), part);
}
