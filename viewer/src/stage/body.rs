//! Bodies of other sizes and proportions, drawn with the triangles of the database skeleton's.

use glam::Vec3;
use throng_core::{Joint, Mat3x4, NUM_JOINTS, Skeleton};

/// Ratio of length and thickness of each limb to those of the database skeleton, along its joint's axes.
pub(super) type Stretch = [Vec3; NUM_JOINTS];

/// Stretch that fits the triangles around one skeleton to another: limbs get their lengths there, and the thickness of
/// the larger or smaller trunk.
pub(super) fn stretch(database: &Skeleton, body: &Skeleton) -> Stretch {
    let ratio = |j: Joint| body.offsets[j.index()].length() / database.offsets[j.index()].length().max(1e-6);
    let trunk = [Joint::Spine, Joint::Chest, Joint::UpperChest, Joint::Neck];
    let thickness = trunk.iter().map(|&j| ratio(j)).sum::<f32>() / trunk.len() as f32;
    let mut out = [Vec3::splat(thickness); NUM_JOINTS];
    for (joint, end) in LIMBS {
        // Limbs lie along one axis of their joint in the rest pose.
        let axis = database.offsets[end.index()].abs().max_position();
        out[joint.index()][axis] = ratio(end);
    }
    out
}

/// The skeleton of a pose: distances between joints are the same in every pose.
pub(super) fn body_of_pose(database: &Skeleton, pose: &[Mat3x4]) -> Skeleton {
    let mut body = database.clone();
    for joint in Joint::ALL {
        let Some(parent) = joint.parent() else { continue };
        let length = pose[joint.index()].translation().distance(pose[parent.index()].translation());
        let offset = &mut body.offsets[joint.index()];
        *offset = offset.normalize_or_zero() * length;
    }
    body
}

/// Joints from which a limb leads to another joint.
const LIMBS: [(Joint, Joint); 8] = [
    (Joint::LeftUpperArm, Joint::LeftForearm),
    (Joint::LeftForearm, Joint::LeftHand),
    (Joint::RightUpperArm, Joint::RightForearm),
    (Joint::RightForearm, Joint::RightHand),
    (Joint::LeftThigh, Joint::LeftShin),
    (Joint::LeftShin, Joint::LeftFoot),
    (Joint::RightThigh, Joint::RightShin),
    (Joint::RightShin, Joint::RightFoot),
];

/// The axis that a joint's limb lies along in the rest pose, where it has one.
pub(super) fn axis_of_limb(database: &Skeleton, joint: usize) -> Option<usize> {
    let (_, end) = LIMBS.iter().find(|l| l.0.index() == joint)?;
    Some(database.offsets[end.index()].abs().max_position())
}

/// Adds the poses of a body, so that they skin the database skeleton's triangles to it.
pub(super) fn push_stretched(poses: &mut Vec<Mat3x4>, pose: &[Mat3x4], stretch: &Stretch) {
    let stretched = |(m, s): (&Mat3x4, &Vec3)| m.rows.map(|[x, y, z, at]| [x * s.x, y * s.y, z * s.z, at]);
    poses.extend(pose.iter().zip(stretch).map(|joint| Mat3x4 { rows: stretched(joint) }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use throng_simulation::wander::scaled_skeleton;

    #[test]
    fn the_ends_of_limbs_come_to_lie_on_the_next_joints() {
        let database = Skeleton::default();
        let body = scaled_skeleton(&database, 0.8, 1.1);
        let stretch = stretch(&database, &body);
        let (from, to) = (database.rest_positions(), body.rest_positions());
        let rest: Vec<Mat3x4> = to.map(|p| Mat3x4::from_rotation_translation(Quat::IDENTITY, p)).to_vec();
        let mut poses = Vec::new();
        push_stretched(&mut poses, &rest, &stretch);
        for joint in Joint::ALL {
            let Some(parent) = joint.parent() else { continue };
            let skinned = poses[parent.index()].to_mat4().transform_point3(from[joint.index()] - from[parent.index()]);
            assert!(skinned.distance(to[joint.index()]) < 1e-4, "{joint:?}: {skinned}");
        }
    }

    #[test]
    fn the_database_skeleton_is_left_as_it_is() {
        let skeleton = Skeleton::default();
        assert!(stretch(&skeleton, &skeleton).iter().all(|s| s.distance(Vec3::ONE) < 1e-5));
    }
}
