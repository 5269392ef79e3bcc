//! Manners: changes of posture and movement by mood, for any gait.

use crate::frame::{ArmPose, BodyPose};
use crate::side::{LateralSide, forward};
use glam::{DQuat, DVec3};
use throng_core::Planar;

/// A manner of moving, as changes to the neutral one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manner {
    /// Name in names and tags of clips.
    pub name: &'static str,
    /// Ratio of the cadence to that of a neutral walker of the same speed.
    pub cadence: f64,
    /// Ratio of the stance time to a neutral one.
    pub stance: f64,
    /// Lowering of the hips (m).
    pub crouch: f64,
    /// Forward bend of the upper back (rad).
    pub slouch: f64,
    /// Forward tilt of the head (rad).
    pub nod: f64,
    /// Forward turn of the shoulders (rad).
    pub protraction: f64,
    /// Upward turn of the shoulders (rad).
    pub shrug: f64,
    /// Ratio of the arm swing to neutral.
    pub arm_swing: f64,
    /// Additional flexion of the elbows (rad).
    pub arm_bend: f64,
    /// Abduction of the arms (rad).
    pub abduction: f64,
    /// Ratio of the foot roll at heel strike and toe-off to neutral.
    pub roll: f64,
    /// Ratio of the lift of a runner's knees and heels to neutral.
    pub knee_lift: f64,
    /// Ratio of the distance between the feet across the path to neutral.
    pub width: f64,
    /// Additional outward turn of the feet (rad).
    pub toe_out: f64,
    /// Ratio of the list and turn of the pelvis to neutral.
    pub sway: f64,
}

/// The neutral manner.
pub const NEUTRAL: Manner = Manner {
    name: "neutral",
    cadence: 1.0,
    stance: 1.0,
    crouch: 0.0,
    slouch: 0.0,
    nod: 0.0,
    protraction: 0.0,
    shrug: 0.0,
    arm_swing: 1.0,
    arm_bend: 0.0,
    abduction: 0.0,
    roll: 1.0,
    knee_lift: 1.0,
    width: 1.0,
    toe_out: 0.0,
    sway: 1.0,
};

/// All manners.
pub const MANNERS: [Manner; 3] = [
    NEUTRAL,
    Manner {
        name: "proud",
        cadence: 1.05,
        stance: 0.97,
        slouch: -0.13,
        nod: -0.09,
        protraction: -0.16,
        shrug: 0.05,
        arm_swing: 1.3,
        arm_bend: 0.1,
        abduction: 0.09,
        roll: 1.08,
        knee_lift: 1.1,
        width: 0.85,
        toe_out: 0.05,
        sway: 1.2,
        ..NEUTRAL
    },
    Manner {
        name: "tired",
        cadence: 0.94,
        stance: 1.05,
        crouch: 0.038,
        slouch: 0.34,
        nod: 0.3,
        protraction: 0.2,
        shrug: -0.07,
        arm_swing: 0.5,
        arm_bend: -0.08,
        roll: 0.75,
        knee_lift: 0.82,
        width: 1.25,
        toe_out: 0.04,
        sway: 0.85,
        ..NEUTRAL
    },
];

/// Shares of the slouch in spine, chest, upper chest and neck.
const CURVE: [f64; 4] = [0.15, 0.55, 1.0, 1.0];
/// Backward shift of the hips as the back bends, which keeps the body over its feet (m/rad).
const BALANCE: f64 = 0.09;
/// Share of the slouch that is undone in the arms, which hang.
const HANG: f64 = 0.85;

/// Applies a manner to the pose of a neutral body. The feet are unchanged.
pub fn apply_manner(pose: &mut BodyPose, manner: &Manner) {
    let heading = f64::from(Planar::split(pose.root.as_vec3(), pose.hips.as_quat()).0.heading);
    let back = forward(heading) * (BALANCE * manner.slouch);
    pose.root -= DVec3::new(back.x, manner.crouch, back.y);
    for (segment, share) in pose.trunk.iter_mut().zip(CURVE) {
        *segment *= DQuat::from_rotation_x(share * manner.slouch);
    }
    pose.trunk[4] *= DQuat::from_rotation_x(manner.nod);
    LateralSide::BOTH.into_iter().for_each(|side| apply_manner_to_arm(&mut pose.arms[side.index()], side, manner));
}

fn apply_manner_to_arm(arm: &mut ArmPose, side: LateralSide, manner: &Manner) {
    let s = side.sign();
    arm.clavicle =
        DQuat::from_rotation_y(-s * manner.protraction) * DQuat::from_rotation_z(s * manner.shrug) * arm.clavicle;
    let hang = DQuat::from_rotation_x(-HANG * manner.slouch);
    // The forward turn of the shoulder must not turn the hanging arm inward.
    let outward =
        DQuat::from_rotation_z(s * (manner.abduction - manner.shrug)) * DQuat::from_rotation_y(s * manner.protraction);
    arm.upper_arm = hang * outward * arm.upper_arm;
    arm.forearm = DQuat::from_rotation_y(-s * manner.arm_bend) * arm.forearm;
}

#[cfg(test)]
mod tests {
    use super::super::super::foot::FootShape;
    use super::super::super::walk::arms::ArmAngles;
    use super::super::manner::{MANNERS, NEUTRAL};
    use super::*;
    use glam::DVec3;
    use throng_core::Skeleton;

    fn upright() -> BodyPose {
        let shape = FootShape::from_skeleton(&Skeleton::default());
        let arms = LateralSide::BOTH.map(|s| ArmAngles { flexion: 0.3, ..ArmAngles::default() }.pose(s));
        let feet =
            LateralSide::BOTH.map(|s| shape.contact_pose(DVec3::new(0.1 * s.sign(), 0.03, 0.13), 0.0, 0.0, 0.0, 0.0));
        let trunk = [DQuat::IDENTITY; 5];
        BodyPose { root: DVec3::Y, hips: DQuat::IDENTITY, trunk, arms, feet, knees: [DVec3::Z; 2] }
    }

    #[test]
    fn the_neutral_manner_changes_nothing() {
        let mut pose = upright();
        apply_manner(&mut pose, &NEUTRAL);
        assert_eq!(pose.root, upright().root);
        assert!(pose.trunk.iter().all(|q| q.angle_between(DQuat::IDENTITY) < 1e-12));
    }

    #[test]
    fn the_tired_hang_and_the_proud_hold_themselves_up() {
        let of = |name: &str| {
            let mut pose = upright();
            apply_manner(&mut pose, MANNERS.iter().find(|m| m.name == name).unwrap());
            pose
        };
        let face = |pose: &BodyPose| (pose.trunk[4] * DVec3::Z).y;
        let top = |pose: &BodyPose| (pose.trunk[2] * DVec3::Y).z;
        let (tired, proud) = (of("tired"), of("proud"));
        assert!(face(&tired) < -0.2 && face(&proud) > 0.05);
        assert!(top(&tired) > 0.2 && top(&proud) < -0.05 && tired.root.y < 0.98);
        for side in LateralSide::BOTH {
            let arm = &tired.arms[side.index()];
            let hanging = tired.trunk[2] * arm.clavicle * arm.upper_arm * DVec3::X * side.sign();
            assert!(hanging.y < -0.97, "{hanging}");
        }
    }
}
