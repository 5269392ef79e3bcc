//! Arms between hanging and holding a hand somewhere.

use super::super::arm::ArmShape;
use super::super::attitude::Attitude;
use super::super::frame::ArmPose;
use super::super::side::Side;
use super::posture::HandPose;
use glam::{DQuat, DVec3};
use throng_runtime::{Joint, Skeleton};

/// What hands are held against, at one sample.
pub struct Held {
    /// Upper chest joint. [Unit: m]
    chest: DVec3,
    /// World rotation of the upper chest.
    rotation: DQuat,
    /// Neck joint. [Unit: m]
    neck: DVec3,
    /// Frame that turns with the chest and bends a little less.
    frame: DQuat,
}

impl Held {
    /// The chest over the hips.
    ///
    /// - `trunk`: world rotations from the spine to the head.
    pub fn over(root: DVec3, hips: DQuat, trunk: [DQuat; 5], chest: Attitude, skeleton: &Skeleton) -> Self {
        let offset = |j: Joint| skeleton.offsets[j.index()].as_dvec3();
        let spine = root + hips * offset(Joint::Spine);
        let lower = spine + trunk[0] * offset(Joint::Chest);
        let upper = lower + trunk[1] * offset(Joint::UpperChest);
        let frame = Attitude { yaw: chest.yaw, pitch: 0.6 * chest.pitch, list: 0.6 * chest.list };
        Self { chest: upper, rotation: trunk[2], neck: upper + trunk[2] * offset(Joint::Neck), frame: frame.rotation() }
    }
}

/// An arm: hanging where the hand is not held, reaching for its wrist where it is, between them otherwise.
pub fn arm(side: Side, held: &Held, hanging: &ArmPose, hand: &HandPose, skeleton: &Skeleton) -> ArmPose {
    if hand.held <= 0.0 {
        return *hanging;
    }
    let reaching = reach(side, held, hand, skeleton);
    let mix = |a: DQuat, b: DQuat| a.slerp(b, hand.held.min(1.0));
    ArmPose {
        clavicle: mix(hanging.clavicle, reaching.clavicle),
        upper_arm: mix(hanging.upper_arm, reaching.upper_arm),
        forearm: mix(hanging.forearm, reaching.forearm),
        hand: mix(hanging.hand, reaching.hand),
    }
}

fn reach(side: Side, held: &Held, hand: &HandPose, skeleton: &Skeleton) -> ArmPose {
    let [clavicle_at, shoulder_at, fore, wrist] = side.arm().map(|j| skeleton.offsets[j.index()].as_dvec3());
    let s = side.sign();
    let clavicle = DQuat::from_rotation_y(-s * hand.reach) * DQuat::from_rotation_z(s * (hand.shrug - 0.05));
    let shoulder = held.chest + held.rotation * (clavicle_at + clavicle * shoulder_at);
    let body = held.neck + held.frame * hand.body;
    let goal = body.lerp(hand.room, hand.placed);
    let shape = ArmShape { upper_arm: fore.length(), forearm: wrist.length() };
    let bent = shape.solve(side, shoulder, goal, held.frame * hand.pole);
    ArmPose {
        clavicle,
        upper_arm: (held.rotation * clavicle).inverse() * bent.upper_arm,
        forearm: ArmShape::forearm(side, bent.elbow, hand.twist),
        hand: DQuat::from_rotation_z(-s * hand.flex),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_wrist_is_where_it_is_held_on_both_sides() {
        let skeleton = Skeleton::default();
        let upright = [DQuat::IDENTITY; 5];
        let held = Held::over(DVec3::Y, DQuat::IDENTITY, upright, Attitude::default(), &skeleton);
        let still = ArmPose {
            clavicle: DQuat::IDENTITY,
            upper_arm: DQuat::IDENTITY,
            forearm: DQuat::IDENTITY,
            hand: DQuat::IDENTITY,
        };
        for side in Side::BOTH {
            let pose = HandPose { held: 1.0, body: DVec3::new(0.1, -0.3, 0.3), ..HandPose::HANGING };
            let pose = if side == Side::Left { pose } else { pose.mirrored() };
            let arm = arm(side, &held, &still, &pose, &skeleton);
            let [c, u, f, h] = side.arm().map(|j| skeleton.offsets[j.index()].as_dvec3());
            let upper = arm.clavicle * arm.upper_arm;
            let wrist = held.chest + c + arm.clavicle * u + upper * (f + arm.forearm * h);
            assert!(wrist.distance(held.neck + pose.body) < 1e-9, "{wrist}");
        }
    }
}
