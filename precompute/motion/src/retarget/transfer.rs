//! Motion of one clip on the target skeleton.

use super::align::{Alignment, main_child};
use super::body::{RetargetSource, RolePose, SourceBody, anchor, role_pose};
use super::{legs::LegTransfer, plan::SkeletonGroup};
use glam::{Quat, Vec3};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS, Skeleton};

/// Length of segments below which they have no direction (m).
const MIN_SEGMENT: f32 = 0.005;

/// Clavicles, and the joints that they carry.
const SHOULDERS: [(Joint, Joint); 2] =
    [(Joint::LeftClavicle, Joint::LeftUpperArm), (Joint::RightClavicle, Joint::RightUpperArm)];

/// Root positions and local rotations of a whole clip.
pub struct RetargetedMotion {
    /// Hips in the world (m).
    pub root_positions: Vec<Vec3>,
    /// Local rotations, row-major by frame; neighbouring frames have a positive dot product.
    pub rotations: Vec<Quat>,
}

/// Moves `source`, of a group, onto `target`.
///
/// Every joint turns as its source does, but clavicles, which move the shoulder as far as the source's do, and legs, which put
/// the feet at the places of the source's: feet that stand there stand here, whatever the proportions. Positions are multiplied
/// by the quotient of the leg lengths. The middle between the thighs is where the source has it, because skeletons disagree
/// about where the hips joint lies above it.
pub fn transfer_motion(source: RetargetSource, group: &SkeletonGroup, target: &Skeleton) -> RetargetedMotion {
    let SkeletonGroup { body, alignment, own, .. } = group;
    let scale = target.leg_length() / own.leg_length();
    let mut scratch = Vec::new();
    let mut root_positions = Vec::with_capacity(source.clip.num_frames);
    let mut rotations: Vec<Quat> = Vec::with_capacity(source.clip.num_frames * NUM_JOINTS);
    let legs = LegTransfer::new(own, target, scale, [Joint::LeftToe, Joint::RightToe].map(|j| body.has(j)));
    for frame in 0..source.clip.num_frames {
        let pose = role_pose(source, frame, &mut scratch);
        let mut model = model_rotations(&pose, body, alignment);
        move_shoulders(&mut model, own, target, scale);
        let root = legs.hips(model[0], &pose);
        root_positions.push(root);
        legs.reach_feet(&mut model, root, &pose);
        for j in Joint::ALL {
            let above = j.parent().map(|p| model[p.index()].inverse());
            let local = above.map_or(model[0], |above| maths::compose(above, model[j.index()])).normalize();
            let before = frame.checked_sub(1).map(|f| rotations[f * NUM_JOINTS + j.index()]);
            let flip = before.is_some_and(|b| b.dot(local) < 0.0);
            rotations.push(if flip { -local } else { local });
        }
    }
    RetargetedMotion { root_positions, rotations }
}

/// Turns clavicles so that the shoulders of `target` move as far as those of `own`.
pub fn move_shoulders(model: &mut [Quat; NUM_JOINTS], own: &Skeleton, target: &Skeleton, scale: f32) {
    let chest = model[Joint::UpperChest.index()];
    for (clavicle, arm) in SHOULDERS.map(|(clavicle, arm)| (clavicle.index(), arm.index())) {
        let local = maths::compose(chest.inverse(), model[clavicle]);
        let turned = clavicle_rotation(local, own.offsets[arm], target.offsets[arm], scale);
        model[clavicle] = maths::compose(chest, turned);
    }
}

/// The clavicle's rotation that moves the end of `target` as far from rest as `local` moves that of `own`.
///
/// Rigs differ in how much of the shoulder they call clavicle; copying the angle would make a long one droop.
fn clavicle_rotation(local: Quat, own: Vec3, target: Vec3, scale: f32) -> Quat {
    let moved = target + (local * own - own) * scale;
    match (moved.try_normalize(), (local * target).try_normalize()) {
        (Some(to), Some(from)) => maths::compose(Quat::from_rotation_arc(from, to), local).normalize(),
        _ => local,
    }
}

/// World rotation of every database joint at one frame.
fn model_rotations(pose: &RolePose, body: &SourceBody, a: &Alignment) -> [Quat; NUM_JOINTS] {
    let mut model = [Quat::IDENTITY; NUM_JOINTS];
    for j in Joint::ALL {
        let i = j.index();
        if !body.has(j) {
            model[i] = model[anchor(&body.roles, j).index()];
            continue;
        }
        model[i] = maths::compose(maths::compose(segment_correction(pose, body, j), pose[i].1), a[i]).normalize();
    }
    model
}

/// The rotation from the segment's direction by the joint's rotation alone to its direction in the source: the identity for a
/// rigid source, and the bend of joints without a role or with translations of their own otherwise.
fn segment_correction(pose: &RolePose, body: &SourceBody, j: Joint) -> Quat {
    let Some(child) = main_child(j).filter(|c| body.has(*c)) else { return Quat::IDENTITY };
    let predicted = pose[j.index()].1 * body.offsets[child.index()];
    let actual = pose[child.index()].0 - pose[j.index()].0;
    if predicted.length() < MIN_SEGMENT || actual.length() < MIN_SEGMENT {
        return Quat::IDENTITY;
    }
    Quat::from_rotation_arc(predicted.normalize(), actual.normalize())
}
