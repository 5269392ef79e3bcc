//! Finds out what the zero pose of a source is, and a standing pose to compare with.
//!
//! Retargeting needs to know how each joint is turned when the body stands in a known pose. Where the zero pose
//! is a body, that is simple. Where it is not (Bandai-Namco, LAFAN1: all offsets along X), the turn of each joint
//! is averaged over the motion as seen from the body, and then swung so that each segment points as in a T-pose.

use super::config::Forward;
use super::roles::RoleMap;
use super::units::{feet_to_head, rest_world, sample_frames};
use crate::raw::RawClip;
use glam::{Mat3, Quat, Vec3, Vec4};
use throng_runtime::{Joint, NUM_JOINTS};

/// Frames averaged for a reference pose.
const MAX_SAMPLES: usize = 240;

/// What the pose is that a source skeleton has when all rotations are zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RestPoseKind {
    /// A body that stands with its arms held out sideways (within 20 degrees).
    TPose,
    /// A body that stands with its arms lowered.
    APose,
    /// Not a standing body: offsets follow some other rule, such as every segment along one axis.
    Other,
}

impl RestPoseKind {
    /// As reports write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::TPose => "t_pose",
            Self::APose => "a_pose",
            Self::Other => "other",
        }
    }
}

/// The rest pose of a source and a standing pose to compare with.
#[derive(Clone, Debug, PartialEq)]
pub struct RestPose {
    /// What the zero pose is.
    pub kind: RestPoseKind,
    /// World rotation of every source joint when the body stands upright, legs straight down, facing +Z, and is
    /// as near to a T-pose as is known. Where the zero pose is a body, all entries are the one rotation that
    /// turns it upright and towards +Z (the identity for most files), and limbs point wherever the offsets take
    /// them (an A-pose stays one). Where the zero pose is not a body, rotations of role joints are estimated from
    /// the motion, so that each segment points as it does in a T-pose. Positions follow from the offsets.
    /// [Size: joints.len()]
    pub reference: Vec<Quat>,
    /// What was found and why.
    pub sentence: String,
}

/// Looks at the zero pose of a clip in metres, Y up; also returns the heading it faces, 0 where it is not a body
/// and none is given. [Unit: rad]
pub(super) fn find_rest_pose(clip: &RawClip, roles: &RoleMap, forward: Option<Forward>) -> (RestPose, f32) {
    let world = rest_world(clip);
    match stance(&world, roles) {
        Ok(stance) => {
            let heading = forward.map_or(stance.heading, Forward::heading);
            let upright = Quat::from_rotation_y(-heading) * stance.upright;
            let given = if forward.is_some() { " (given in the config)" } else { "" };
            let sentence = format!(
                "{}; it faces a heading of {:.0} degrees{given}.",
                stance.sentence,
                heading.to_degrees().round() + 0.0
            );
            (RestPose { kind: stance.kind, reference: vec![upright; clip.joints.len()], sentence }, heading)
        }
        Err(why) => {
            let sentence =
                format!("The rest pose is not a standing body: {why}. A standing pose was estimated from the motion.");
            let reference = reference_from_motion(clip, roles);
            let heading = forward.map_or(0.0, Forward::heading);
            (RestPose { kind: RestPoseKind::Other, reference, sentence }, heading)
        }
    }
}

/// A zero pose that is a standing body.
struct Stance {
    kind: RestPoseKind,
    /// Turns the body's up axis to +Y.
    upright: Quat,
    /// Heading once upright.
    heading: f32,
    sentence: String,
}

/// The body's own up and left axes in a pose.
fn body_axes(world: &[(Vec3, Quat)], roles: &RoleMap) -> Option<(Vec3, Vec3)> {
    use Joint::*;
    let at = |role: Joint| roles.get(role).map(|j| world[j].0);
    let (left, right) = (at(LeftThigh)?, at(RightThigh)?);
    let up = (at(Head).or(at(Neck))? - (left + right) * 0.5).try_normalize()?;
    let across = (left - right).try_normalize()?;
    Some((up, (across - up * across.dot(up)).try_normalize()?))
}

/// The stance of the zero pose, or why it is none.
fn stance(world: &[(Vec3, Quat)], roles: &RoleMap) -> Result<Stance, String> {
    use Joint::*;
    let (up, left) = body_axes(world, roles).ok_or("its hips, thighs and head are in one line")?;
    let segment = |a: Joint, b: Joint| {
        let (a, b) = (roles.get(a)?, roles.get(b)?);
        (world[b].0 - world[a].0).try_normalize()
    };
    for (thigh, shin, foot, side) in
        [(LeftThigh, LeftShin, LeftFoot, "left"), (RightThigh, RightShin, RightFoot, "right")]
    {
        for (from, to) in [(thigh, shin), (shin, foot)] {
            let down = segment(from, to).map_or(0.0, |d| -d.dot(up));
            if down < 35f32.to_radians().cos() {
                return Err(format!("its {side} leg does not point down"));
            }
        }
    }
    let mut raised = 0f32;
    for (arm, end, side, out) in [
        (LeftUpperArm, [LeftHand, LeftForearm], "left", left),
        (RightUpperArm, [RightHand, RightForearm], "right", -left),
    ] {
        let arm = end.into_iter().find_map(|e| segment(arm, e)).ok_or(format!("its {side} arm has no length"))?;
        let (sideways, up) = (arm.dot(out), arm.dot(up));
        if sideways < -0.2 || up > 0.5 || sideways.hypot(up) < 0.8 {
            return Err(format!("its {side} arm is neither out nor down"));
        }
        raised += 0.5 * up.atan2(sideways);
    }
    let degrees = raised.to_degrees();
    let (kind, name) =
        if degrees.abs() <= 20.0 { (RestPoseKind::TPose, "a T-pose") } else { (RestPoseKind::APose, "an A-pose") };
    let upright = Quat::from_rotation_arc(nearest_axis(up), Vec3::Y);
    let ahead = (upright * left).cross(Vec3::Y);
    Ok(Stance {
        kind,
        upright,
        heading: snap_heading(ahead.x.atan2(ahead.z)),
        sentence: format!("The rest pose is {name}: legs down, arms {:.0} degrees above level", degrees.round() + 0.0),
    })
}

fn nearest_axis(v: Vec3) -> Vec3 {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    axes.into_iter().max_by(|a, b| a.dot(v).total_cmp(&b.dot(v))).unwrap_or(Vec3::Y)
}

/// A heading near a quarter turn is that quarter turn.
fn snap_heading(heading: f32) -> f32 {
    use std::f32::consts::FRAC_PI_2;
    let quarter = (heading / FRAC_PI_2).round() * FRAC_PI_2;
    if (heading - quarter).abs() < 15f32.to_radians() { quarter } else { heading }
}

/// A segment between two roles, and where it points in a T-pose.
fn t_pose_segment(role: Joint) -> Option<(Joint, Vec3)> {
    use Joint::*;
    Some(match role {
        LeftClavicle => (LeftUpperArm, Vec3::X),
        LeftUpperArm => (LeftForearm, Vec3::X),
        LeftForearm => (LeftHand, Vec3::X),
        RightClavicle => (RightUpperArm, -Vec3::X),
        RightUpperArm => (RightForearm, -Vec3::X),
        RightForearm => (RightHand, -Vec3::X),
        LeftThigh => (LeftShin, -Vec3::Y),
        LeftShin => (LeftFoot, -Vec3::Y),
        RightThigh => (RightShin, -Vec3::Y),
        RightShin => (RightFoot, -Vec3::Y),
        _ => return None,
    })
}

/// The toe of a foot.
fn toe_of(role: Joint) -> Option<Joint> {
    match role {
        Joint::LeftFoot => Some(Joint::LeftToe),
        Joint::RightFoot => Some(Joint::RightToe),
        _ => None,
    }
}

/// Mean of rotations and positions as seen from the body, over upright frames; feet and toes only over the frames
/// in which that foot is low, because there it stands flat.
struct MeanPose {
    rotations: Vec<Quat>,
    /// Sum of the positions of each role's joint in each joint's own axes. [Size: joints.len()]
    locals: Vec<[Vec3; NUM_JOINTS]>,
}

/// Estimates how every joint is turned in a T-pose.
fn reference_from_motion(clip: &RawClip, roles: &RoleMap) -> Vec<Quat> {
    let mean = mean_pose(clip, roles);
    let n = clip.joints.len();
    let mut role_of = vec![None; n];
    for role in Joint::ALL {
        if let Some(j) = roles.get(role) {
            role_of[j] = Some(role);
        }
    }
    // What each joint is turned by, beyond its mean; children follow their parents.
    let mut swing = vec![Quat::IDENTITY; n];
    let mut reference = Vec::with_capacity(n);
    for j in 0..n {
        swing[j] = clip.joints[j].parent.map_or(Quat::IDENTITY, |p| swing[p]);
        if let Some((child, target)) = role_of[j].and_then(t_pose_segment).filter(|(c, _)| roles.get(*c).is_some()) {
            let now = swing[j] * mean.rotations[j] * mean.locals[j][child.index()];
            if let Some(now) = now.try_normalize() {
                swing[j] = Quat::from_rotation_arc(now, target) * swing[j];
            }
        } else if let Some(toe) = role_of[j].and_then(toe_of) {
            // Feet keep the tilt they have while they stand, and point ahead.
            let ahead = roles.get(toe).map_or(Vec3::Z, |_| mean.rotations[j] * mean.locals[j][toe.index()]);
            swing[j] = Quat::from_rotation_y(-ahead.x.atan2(ahead.z));
        }
        reference.push((swing[j] * mean.rotations[j]).normalize());
    }
    snap_to_rig_axes(&mut reference, clip, roles);
    reference
}

/// Where limb segments lie along the joints' own axes, the rig was built with those axes along the world's in a
/// T-pose: role joints that are near such a pose are put into it. Feet are left, as theirs slope to the toes.
fn snap_to_rig_axes(reference: &mut [Quat], clip: &RawClip, roles: &RoleMap) {
    let rest = rest_world(clip);
    if !Joint::ALL.into_iter().all(|role| along_an_axis(&rest, roles, role)) {
        return;
    }
    for j in Joint::ALL.into_iter().filter(|r| toe_of(*r).is_none()).filter_map(|r| roles.get(r)) {
        reference[j] = nearest_quarter_turn(reference[j]).unwrap_or(reference[j]);
    }
}

/// True unless the role starts a limb segment that lies askew of the joint's own axes.
fn along_an_axis(rest: &[(Vec3, Quat)], roles: &RoleMap, role: Joint) -> bool {
    let Some((child, _)) = t_pose_segment(role) else { return true };
    let (Some(j), Some(k)) = (roles.get(role), roles.get(child)) else { return true };
    let segment = rest[k].0 - rest[j].0;
    segment.abs().max_element() > 2f32.to_radians().cos() * segment.length()
}

/// The rotation that takes axes to axes nearest to `r`, if it is within 35 degrees.
fn nearest_quarter_turn(r: Quat) -> Option<Quat> {
    let x = nearest_axis(r * Vec3::X);
    let y = nearest_axis((r * Vec3::Y).reject_from_normalized(x));
    let turn = Quat::from_mat3(&Mat3::from_cols(x, y, x.cross(y))).normalize();
    (turn.angle_between(r) < 35f32.to_radians()).then_some(turn)
}

fn mean_pose(clip: &RawClip, roles: &RoleMap) -> MeanPose {
    let n = clip.joints.len();
    let frames: Vec<_> = sample_frames(clip.num_frames, MAX_SAMPLES).map(|f| clip.world(f)).collect();
    let is_upright = |w: &&Vec<(Vec3, Quat)>| feet_to_head(w, roles).y > 0.85;
    let mut upright: Vec<_> = frames.iter().filter(is_upright).collect();
    if upright.is_empty() {
        upright = frames.iter().collect();
    }
    let feet = stance_limits(&upright, clip, roles);
    let mut sums = vec![Vec4::ZERO; n];
    let mut locals = vec![[Vec3::ZERO; NUM_JOINTS]; n];
    for world in &upright {
        let Some(turn) = to_facing_z(world, roles) else { continue };
        for j in 0..n {
            if feet[j].is_some_and(|(foot, limit)| world[foot].0.y > limit) {
                continue;
            }
            let r = Vec4::from(turn * world[j].1);
            let sign = if sums[j].dot(r) < 0.0 { -1.0 } else { 1.0 };
            sums[j] += r * sign;
            for role in Joint::ALL {
                if let Some(k) = roles.get(role) {
                    locals[j][role.index()] += world[j].1.inverse() * (world[k].0 - world[j].0);
                }
            }
        }
    }
    let rotations = sums.into_iter().map(|s| s.try_normalize().map_or(Quat::IDENTITY, Quat::from_vec4)).collect();
    MeanPose { rotations, locals }
}

/// For each joint from an ankle down: the ankle, and the height below which it is in a quarter of the frames.
/// [Size: joints.len()]
fn stance_limits(frames: &[&Vec<(Vec3, Quat)>], clip: &RawClip, roles: &RoleMap) -> Vec<Option<(usize, f32)>> {
    let mut limits: Vec<Option<(usize, f32)>> = vec![None; clip.joints.len()];
    for foot in [Joint::LeftFoot, Joint::RightFoot].into_iter().filter_map(|r| roles.get(r)) {
        let mut heights: Vec<f32> = frames.iter().map(|w| w[foot].0.y).collect();
        heights.sort_by(f32::total_cmp);
        limits[foot] = heights.get(heights.len() / 4).map(|&limit| (foot, limit));
    }
    for j in 0..limits.len() {
        if let (None, Some(p)) = (limits[j], clip.joints[j].parent) {
            limits[j] = limits[p];
        }
    }
    limits
}

/// The turn about +Y after which the body of a pose faces +Z.
fn to_facing_z(world: &[(Vec3, Quat)], roles: &RoleMap) -> Option<Quat> {
    use Joint::*;
    let at = |role: Joint| roles.get(role).map(|j| world[j].0);
    let across = at(LeftThigh)? - at(RightThigh)? + at(LeftUpperArm)? - at(RightUpperArm)?;
    let left = Vec3::new(across.x, 0.0, across.z).try_normalize()?;
    let ahead = left.cross(Vec3::Y);
    Some(Quat::from_rotation_y(-ahead.x.atan2(ahead.z)))
}

/// Gives clips of one skeleton one reference pose: the mean of what their motions gave, weighted by frames.
///
/// Only poses estimated from motion differ between clips; without this, the same source pose would retarget to
/// different poses in different clips.
pub(super) fn share_references(clips: &mut [super::Imported]) {
    let mut done = vec![false; clips.len()];
    for first in 0..clips.len() {
        if done[first] || clips[first].rest_pose.kind != RestPoseKind::Other {
            continue;
        }
        let same: Vec<usize> = (first..clips.len()).filter(|&i| same_skeleton(&clips[first], &clips[i])).collect();
        let mut sums = vec![Vec4::ZERO; clips[first].clip.joints.len()];
        for &i in &same {
            done[i] = true;
            let weight = clips[i].clip.num_frames as f32;
            for (sum, r) in sums.iter_mut().zip(&clips[i].rest_pose.reference) {
                let r = Vec4::from(*r) * weight;
                let sign = if sum.dot(r) < 0.0 { -1.0 } else { 1.0 };
                *sum += r * sign;
            }
        }
        let mut shared: Vec<_> = sums.iter().map(|s| Quat::from_vec4(s.normalize_or(Vec4::W))).collect();
        snap_to_rig_axes(&mut shared, &clips[first].clip, &clips[first].roles);
        for &i in &same {
            clips[i].rest_pose.reference.clone_from(&shared);
        }
    }
}

/// True where joints and roles agree, offsets below the hips do so within a centimetre, and neither zero pose is a
/// body. Some files put the body's place in the world into the offsets of the hips and above, and
/// files of one rig differ in their ends of chains.
fn same_skeleton(a: &super::Imported, b: &super::Imported) -> bool {
    let (p, q) = (&a.clip.joints, &b.clip.joints);
    let hips = a.roles.get(Joint::Hips).unwrap_or(0);
    let close = |j: usize| {
        let same_place = j <= hips || p[j].is_end || p[j].offset.distance(q[j].offset) < 0.01;
        same_place && p[j].name == q[j].name && p[j].parent == q[j].parent
    };
    b.rest_pose.kind == RestPoseKind::Other
        && a.roles.joints == b.roles.joints
        && p.len() == q.len()
        && (0..p.len()).all(close)
}
