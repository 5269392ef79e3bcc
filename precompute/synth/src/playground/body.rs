//! Body parts for slides and ladders: hips, trunk and arms as keyed channels, and hands that hold on.

use super::moment::{ease_in_out, mix_arms};
use crate::attitude::{Attitude, trunk_between};
use crate::frame::{ArmPose, BodyPose, upper_chest};
use crate::{arm::ArmShape, side::LateralSide, signal::bump};
use bytemuck::{Pod, Zeroable};
use glam::{DQuat, DVec3};
use throng_core::{Contacts, Skeleton};

/// Distance of the palm from the wrist (m).
const PALM: f64 = 0.065;
/// Distance of a palm from its hold below which it holds on (m).
const HOLDS: f64 = 0.008;

/// Posture of hips and trunk, relative to a path: a ladder, or the bed of a slide.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Carriage {
    /// Hips along the path, off it and to its left (m).
    pub place: DVec3,
    /// Forward tilt and list of the hips (rad).
    pub hips: [f64; 2],
    /// Yaw, forward tilt and list of the chest (rad).
    pub chest: [f64; 3],
    /// Yaw, forward tilt and list of the head (rad).
    pub head: [f64; 3],
}

impl Carriage {
    /// Posture of standing at ease.
    pub fn standing(place: DVec3) -> Self {
        Self { place, hips: [0.04, 0.0], chest: [0.0, 0.02, 0.0], head: [0.0, 0.06, 0.0] }
    }

    /// World rotations of the hips, and of spine, chest, upper chest, neck and head.
    pub fn rotations(&self, heading: f64) -> (DQuat, [DQuat; 5]) {
        let [pitch, list] = self.hips;
        let hips = Attitude { yaw: heading + 0.25 * self.chest[0], pitch, list };
        let turned = |[yaw, pitch, list]: [f64; 3]| Attitude { yaw: heading + yaw, pitch, list };
        let trunk = trunk_between(hips, turned(self.chest), turned(self.head));
        (hips.rotation(), trunk.map(Attitude::rotation))
    }
}

/// A hand's contact with a hold.
#[derive(Clone, Debug)]
pub struct SynthHandGrip {
    /// Time of arrival (s).
    pub land: f64,
    /// Time of release (s).
    pub lift: f64,
    /// Position of the palm.
    pub hold: HoldPoint,
    /// Direction of the elbow.
    pub pole: DVec3,
    /// Twist of the forearm, palm down positive (rad).
    pub twist: f64,
}

/// Position that a hand holds on to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HoldPoint {
    /// Fixed in the world (m).
    Still(DVec3),
    /// Moving with the body: along the path from the hips, off it and to its left (m).
    Along(DVec3),
}

/// Motion of one hand: hanging, holding on here and there, hanging.
pub struct HandTrack {
    /// Side of the hand.
    pub side: LateralSide,
    /// Contacts, in order.
    pub grips: Vec<SynthHandGrip>,
    /// Time to reach the first contact, and to return from the last one (s).
    pub reach: f64,
    /// Detour of the hand between contacts (m).
    pub detour: DVec3,
}

/// Goal of a hand at an instant.
struct SynthHandGoal {
    palm: DVec3,
    pole: DVec3,
    twist: f64,
    /// Share of holding on, as opposed to hanging.
    share: f64,
    /// True if the hold is fixed.
    still: bool,
}

/// Brings the arms of a body from hanging to their holds at `t` seconds.
///
/// - `along`: maps a position that moves with the body to the world.
/// - returns the contacts of the hands that hold on.
pub fn hold_on(
    hands: &[HandTrack; 2],
    t: f64,
    body: &mut BodyPose,
    along: impl Fn(DVec3) -> DVec3,
    skeleton: &Skeleton,
) -> Contacts {
    let mut held = Contacts::NONE;
    let chest = upper_chest(body.root, body.hips, &body.trunk, skeleton);
    for ((hand, arm), bit) in hands.iter().zip(&mut body.arms).zip([Contacts::LEFT_HAND, Contacts::RIGHT_HAND]) {
        let Some(goal) = hand.goal(t, &along) else { continue };
        let (holding, miss) = hand.reach_hold(&goal, chest, body.trunk[2], skeleton);
        *arm = mix_arms(arm, &holding, goal.share);
        if goal.still && miss < HOLDS {
            held.insert(bit);
        }
    }
    held
}

impl HandTrack {
    fn goal(&self, t: f64, along: impl Fn(DVec3) -> DVec3) -> Option<SynthHandGoal> {
        let (first, last) = (self.grips.first()?, self.grips.last()?);
        let share =
            ease_in_out((t - first.land) / self.reach + 1.0) * (1.0 - ease_in_out((t - last.lift) / self.reach));
        let place = |hold: HoldPoint| match hold {
            HoldPoint::Still(p) => p,
            HoldPoint::Along(p) => along(p),
        };
        let i = self.grips.partition_point(|g| g.land <= t).saturating_sub(1);
        let grip = &self.grips[i];
        let stays = (grip.land..=grip.lift).contains(&t);
        let still = stays && matches!(grip.hold, HoldPoint::Still(_));
        let at = SynthHandGoal { palm: place(grip.hold), pole: grip.pole, twist: grip.twist, share, still };
        let Some(next) = self.grips.get(i + 1).filter(|_| t > grip.lift) else { return Some(at) };
        let u = (t - grip.lift) / (next.land - grip.lift);
        let w = ease_in_out(u);
        Some(SynthHandGoal {
            palm: at.palm.lerp(place(next.hold), w) + self.detour * bump(u),
            pole: grip.pole.lerp(next.pole, w),
            twist: grip.twist + (next.twist - grip.twist) * w,
            ..at
        })
    }

    /// Pose of the arm that brings the palm to its hold, and the remaining distance (m).
    ///
    /// - `chest`, `turned`: position and rotation of the upper chest.
    fn reach_hold(&self, goal: &SynthHandGoal, chest: DVec3, turned: DQuat, skeleton: &Skeleton) -> (ArmPose, f64) {
        let [shoulder, upper, fore, hand] = self.side.arm().map(|j| skeleton.offsets[j.index()].as_dvec3());
        let shape = ArmShape { upper_arm: fore.length(), forearm: hand.length() };
        let (s, base) = (self.side.sign(), chest + turned * shoulder);
        let towards = turned.inverse() * (goal.palm - base);
        // The shoulder follows: up with a raised hand, forward with one in front.
        let (raise, forward) = (0.35 * (towards.y / 0.6).clamp(-0.15, 1.0), 0.3 * (towards.z / 0.6).clamp(-0.5, 1.0));
        let clavicle = DQuat::from_rotation_y(-s * forward) * DQuat::from_rotation_z(s * raise);
        let shoulder = base + turned * clavicle * upper;
        let along = DVec3::X * s;
        let mut wrist = goal.palm - (goal.palm - shoulder).normalize_or(DVec3::Z) * PALM;
        let mut out =
            (ArmPose { clavicle, upper_arm: DQuat::IDENTITY, forearm: DQuat::IDENTITY, hand: DQuat::IDENTITY }, 0.0);
        for _ in 0..4 {
            let reach = shape.solve(self.side, shoulder, wrist, goal.pole);
            let forearm = ArmShape::forearm(self.side, reach.elbow, goal.twist);
            let elbow = shoulder + reach.upper_arm * along * shape.upper_arm;
            let direction = reach.upper_arm * forearm * along;
            let palm = elbow + direction * (shape.forearm + PALM);
            out.0.upper_arm = (turned * clavicle).inverse() * reach.upper_arm;
            out.0.forearm = forearm;
            out.1 = palm.distance(goal.palm);
            wrist = goal.palm - direction * PALM;
        }
        out
    }
}
