//! Application of a manner to the body: trunk, shoulders and arms.

use super::super::frame::{ArmPose, BodyPose};
use super::super::side::{LateralSide, forward};
use super::manner::Manner;
use glam::{DQuat, DVec3};
use throng_core::Planar;

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
    for side in LateralSide::BOTH {
        apply_manner_to_arm(&mut pose.arms[side.index()], side, manner);
    }
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
