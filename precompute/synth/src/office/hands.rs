//! Arms between hanging and holding a hand at a position.

use super::posture::KeyedHandPose;
use crate::frame::{ArmPose, upper_chest};
use crate::{arm::ArmShape, attitude::Attitude, side::LateralSide};
use glam::{DQuat, DVec3};
use throng_core::{Joint, Skeleton};

/// Reference frames of held hands, at one sample.
pub struct HandFrame {
    /// Upper chest joint (m).
    chest: DVec3,
    /// World rotation of the upper chest.
    rotation: DQuat,
    /// Neck joint (m).
    neck: DVec3,
    /// Frame that turns with the chest and bends a little less.
    frame: DQuat,
}

impl HandFrame {
    /// Frames of the chest over the hips.
    ///
    /// - `trunk`: world rotations from the spine to the head.
    pub fn chest_over_hips(root: DVec3, hips: DQuat, trunk: [DQuat; 5], chest: Attitude, skeleton: &Skeleton) -> Self {
        let (upper, rotation) = (upper_chest(root, hips, &trunk, skeleton), trunk[2]);
        let neck = upper + rotation * skeleton.offsets[Joint::Neck.index()].as_dvec3();
        let frame = Attitude { yaw: chest.yaw, pitch: 0.6 * chest.pitch, list: 0.6 * chest.list };
        Self { chest: upper, rotation, neck, frame: frame.rotation() }
    }
}

/// Twist of a hanging forearm, and the direction of its elbow in the upper arm's frame.
const HANGING: (f64, DVec3) = (0.15, DVec3::NEG_Z);
/// Share of holding from which the arm fully reaches. The wrist moves from hanging to its target from the beginning, so
/// that only the difference in stretch of a hanging and a reaching arm is blended.
const TAKEN: f64 = 0.25;

/// Pose of an arm: hanging if the hand is not held, reaching for its wrist if it is, blended in between.
pub fn arm(side: LateralSide, held: &HandFrame, hung: &ArmPose, hand: &KeyedHandPose, skeleton: &Skeleton) -> ArmPose {
    if hand.held <= 0.0 {
        return *hung;
    }
    let reaching = reach(side, held, hung, hand, skeleton);
    let u = (hand.held / TAKEN).min(1.0);
    let taken = u * u * (3.0 - 2.0 * u);
    ArmPose {
        clavicle: reaching.clavicle,
        upper_arm: hung.upper_arm.slerp(reaching.upper_arm, taken),
        forearm: hung.forearm.slerp(reaching.forearm, taken),
        hand: hung.hand.slerp(reaching.hand, hand.held.min(1.0)),
    }
}

fn reach(side: LateralSide, held: &HandFrame, hanging: &ArmPose, hand: &KeyedHandPose, skeleton: &Skeleton) -> ArmPose {
    let [clavicle_at, shoulder_at, fore, wrist] = side.arm().map(|j| skeleton.offsets[j.index()].as_dvec3());
    let (s, share) = (side.sign(), hand.held.min(1.0));
    let clavicle = DQuat::from_rotation_y(-s * hand.reach) * DQuat::from_rotation_z(s * (hand.shrug - 0.05));
    let clavicle = hanging.clavicle.slerp(clavicle, share);
    let shoulder = held.chest + held.rotation * (clavicle_at + clavicle * shoulder_at);
    let hung = held.rotation * clavicle * hanging.upper_arm;
    let hung_wrist = shoulder + hung * (fore + hanging.forearm * wrist);
    let body = held.neck + held.frame * hand.body;
    let goal = hung_wrist.lerp(body.lerp(hand.room, hand.placed), share);
    let pole = (hung * HANGING.1).lerp((held.frame * hand.pole).normalize_or(DVec3::NEG_Y), share);
    let shape = ArmShape { upper_arm: fore.length(), forearm: wrist.length() };
    let bent = shape.solve(side, shoulder, goal, pole);
    let forearm = ArmShape::forearm(side, bent.elbow, HANGING.0 + share * (hand.twist - HANGING.0));
    let along = bent.upper_arm * forearm * (DVec3::X * s);
    // A hand that is put down lies level, however steep the forearm is.
    let level = hand.placed * hand.twist.sin().max(0.0) * along.y.clamp(-0.9, 0.9).asin();
    ArmPose {
        clavicle,
        upper_arm: (held.rotation * clavicle).inverse() * bent.upper_arm,
        forearm,
        hand: DQuat::from_rotation_z(-s * (hand.flex + level)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_wrist_is_where_it_is_held_on_both_sides() {
        let skeleton = Skeleton::default();
        let upright = [DQuat::IDENTITY; 5];
        let held = HandFrame::chest_over_hips(DVec3::Y, DQuat::IDENTITY, upright, Attitude::default(), &skeleton);
        let still = ArmPose {
            clavicle: DQuat::IDENTITY,
            upper_arm: DQuat::IDENTITY,
            forearm: DQuat::IDENTITY,
            hand: DQuat::IDENTITY,
        };
        for side in LateralSide::BOTH {
            let pose = KeyedHandPose { held: 1.0, body: DVec3::new(0.1, -0.3, 0.3), ..KeyedHandPose::HANGING };
            let pose = if side == LateralSide::Left { pose } else { pose.mirrored() };
            let arm = arm(side, &held, &still, &pose, &skeleton);
            let [c, u, f, h] = side.arm().map(|j| skeleton.offsets[j.index()].as_dvec3());
            let upper = arm.clavicle * arm.upper_arm;
            let wrist = held.chest + c + arm.clavicle * u + upper * (f + arm.forearm * h);
            assert!(wrist.distance(held.neck + pose.body) < 1e-9, "{wrist}");
        }
    }
}
