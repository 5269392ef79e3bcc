//! Legs and arms: a tube along two joints, and the balls within.

use super::super::loft::{Loft, Ring, equal_area};
use super::super::{BodyMesh, BodySide, Influence, SurfacePart};
use super::{BodySection, MannequinPlan};
use glam::Vec3;
use throng_core::Joint;

/// Along the limb (0 to 1 from the first to the second joint, 1 to 2 from there to the third), semi-axes sideways (arms:
/// up and down) and front to back, and how far forward, in a body of the default size (m).
const LEG: [BodySection; 14] = [
    (-0.11, 0.036, 0.050, -0.008, 1),
    (-0.02, 0.064, 0.090, -0.006, 3),
    (0.12, 0.079, 0.098, -0.004, 0),
    (0.30, 0.081, 0.091, 0.001, 1),
    (0.55, 0.071, 0.079, 0.007, 0),
    (0.80, 0.058, 0.065, 0.006, 1),
    (0.94, 0.053, 0.061, 0.005, 0),
    (1.04, 0.051, 0.059, 0.003, 3),
    (1.13, 0.050, 0.057, -0.004, 0),
    (1.25, 0.052, 0.060, -0.012, 1),
    (1.42, 0.048, 0.054, -0.013, 0),
    (1.64, 0.039, 0.044, -0.008, 1),
    (1.86, 0.035, 0.041, -0.003, 2),
    (1.94, 0.037, 0.045, -0.002, 1),
];

const ARM: [BodySection; 13] = [
    (-0.26, 0.040, 0.052, 0.0, 1),
    (-0.06, 0.055, 0.060, 0.0, 3),
    (0.08, 0.056, 0.059, 0.0, 0),
    (0.24, 0.052, 0.055, 0.0, 1),
    (0.48, 0.045, 0.050, 0.001, 0),
    (0.74, 0.041, 0.044, 0.0, 1),
    (0.94, 0.039, 0.041, 0.0, 0),
    (1.04, 0.039, 0.041, 0.0, 3),
    (1.17, 0.041, 0.043, 0.001, 1),
    (1.40, 0.038, 0.039, 0.001, 0),
    (1.68, 0.031, 0.031, 0.0, 0),
    (1.92, 0.028, 0.028, 0.0, 2),
    (1.99, 0.027, 0.027, 0.0, 0),
];

/// A leg from the hip to the ankle, in trousers.
pub(super) fn leg(plan: &MannequinPlan, side: BodySide, mesh: &mut BodyMesh) {
    let joints = [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot].map(|j| side.joint_on_side(j));
    let (part, coarse_end) = (SurfacePart::Trousers, 2.0);
    let tube = LimbTube { joints, before: Joint::Hips, across: Vec3::X, blends: [0.075, 0.07], part, coarse_end };
    tube.build(plan, &LEG, plan.segments([14, 6, 4, 3]), mesh);
    plan.ball(joints[0], 0.062, SurfacePart::Trousers, mesh);
    plan.ball(joints[1], 0.052, SurfacePart::Trousers, mesh);
}

/// An arm from the shoulder to the wrist, in a sleeve.
pub(super) fn arm(plan: &MannequinPlan, side: BodySide, mesh: &mut BodyMesh) {
    let joints = [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand].map(|j| side.joint_on_side(j));
    let before = side.joint_on_side(Joint::LeftClavicle);
    let (part, coarse_end) = (SurfacePart::Shirt, 2.4);
    let tube = LimbTube { joints, before, across: Vec3::Y, blends: [0.075, 0.05], part, coarse_end };
    tube.build(plan, &ARM, plan.segments([12, 5, 3, 3]), mesh);
    plan.ball(joints[0], 0.047, SurfacePart::Shirt, mesh);
    plan.ball(joints[1], 0.036, SurfacePart::Shirt, mesh);
}

/// A limb's joints and how its surface bends.
struct LimbTube {
    /// Start, middle and end of the limb.
    joints: [Joint; 3],
    /// Joint that carries the part before the first joint.
    before: Joint,
    /// Direction of the first half axis.
    across: Vec3,
    /// Widths to each side of the soft stretches around the first and the second joint (m).
    blends: [f32; 2],
    part: SurfacePart,
    /// End along the limb at the coarsest level of detail.
    coarse_end: f32,
}

impl LimbTube {
    fn build(&self, plan: &MannequinPlan, sections: &[BodySection], segments: usize, mesh: &mut BodyMesh) {
        let [a, b, c] = self.joints.map(|j| plan.joint_position(j));
        let (s, side) = (plan.scale, BodySide::of_joint(self.joints[0]));
        let place = |t: f32| if t <= 1.0 { a + (b - a) * t } else { b + (c - b) * (t - 1.0) };
        let is_mirrored = side == BodySide::Right && self.across == Vec3::X;
        let direction = if is_mirrored { -self.across } else { self.across };
        let rings = plan.rings(sections, |[along, across, depth, forward]| {
            let [u, v] = [across, depth].map(|half| half * s * equal_area(segments));
            Ring::ellipse(place(along) + Vec3::Z * (forward * s), direction * u, Vec3::Z * v)
        });
        let ends = sections.first().zip(sections.last()).map_or([0.0, 2.0], |(f, l)| [f.0 - 0.04, l.0 + 0.02]);
        let ends = if plan.is_coarsest() { [ends[0], self.coarse_end] } else { ends };
        let loft = Loft { rings: &rings, segments, poles: ends.map(place) };
        loft.build(mesh, |p| self.weigh(plan, p), |_| (self.part, side));
    }

    /// By the distance from the first joint along the limb.
    fn weigh(&self, plan: &MannequinPlan, p: Vec3) -> Influence {
        let [a, b, c] = self.joints.map(|j| plan.joint_position(j));
        let along = (c - a).normalize_or(Vec3::NEG_Y);
        let s = plan.scale;
        let links = [
            (self.before, f32::NEG_INFINITY, 0.0),
            (self.joints[0], 0.0, self.blends[0] * s),
            (self.joints[1], (b - a).dot(along), self.blends[1] * s),
        ];
        Influence::chain(&links, (p - a).dot(along))
    }
}

/// Place along the foot (0 at the ankle, 1 at the ball, 2 at the tip of the toes), half width, height, and shift to the
/// outer side (m).
const FOOT: [BodySection; 9] = [
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

pub(super) fn foot(plan: &MannequinPlan, side: BodySide, mesh: &mut BodyMesh) {
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
    let rings = plan.rings(&FOOT, |[t, width, height, outwards]| {
        let (centre, v) = (place(t) + Vec3::X * (outwards * mirror) * s, Vec3::Y * (0.5 * height * s));
        Ring { centre: centre.with_y(sole + v.y), u: Vec3::X * (width * s * mirror), v, square: [2.3, 5.0] }
    });
    let poles = [place(HEEL) + Vec3::Y * (0.03 * s), place(TIP) + Vec3::Y * (0.018 * s)];
    let links = [(joints[0], f32::NEG_INFINITY, 0.0), (joints[1], ball.z, 0.025 * s)];
    let part = |middle: Vec3| (if middle.y < sole + 0.004 * s { SurfacePart::Sole } else { SurfacePart::Shoe }, side);
    let loft = Loft { rings: &rings, segments: plan.segments([12, 6, 4, 3]), poles };
    loft.build(mesh, |p| Influence::chain(&links, p.z), part);
}

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

pub(super) fn hand(plan: &MannequinPlan, side: BodySide, mesh: &mut BodyMesh) {
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
