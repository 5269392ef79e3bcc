//! Classifies the zero pose of a source: a standing body with its heading, or not a body at all.

use super::{Forward, RoleMap, rest_world};
use crate::{error::ensure, raw::RawClip};
use glam::{Quat, Vec3};
use throng_core::Joint;

/// Least downward part of thighs and shins of a body that stands: knees may bend by 45 degrees.
pub(crate) const LEG_DOWN: f32 = 0.7;
pub(crate) const LEG_SEGMENTS: [(Joint, Joint); 4] = {
    use Joint::*;
    [(LeftThigh, LeftShin), (LeftShin, LeftFoot), (RightThigh, RightShin), (RightShin, RightFoot)]
};

/// Kind of the pose of a source skeleton when all rotations are zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum RestPoseKind {
    /// A body that stands with its arms held out sideways (within 20 degrees).
    TPose,
    /// A body that stands with its arms lowered.
    APose,
    /// Not a standing body: offsets follow some other rule, such as every segment along one axis.
    Other,
}

impl RestPoseKind {
    /// Name in reports.
    pub fn name(self) -> &'static str {
        ["t_pose", "a_pose", "other"][self as usize]
    }
}

/// The rest pose of a source.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RestPose {
    /// Kind of the zero pose.
    pub kind: RestPoseKind,
    /// Finding, and its reason.
    pub sentence: String,
}

/// Examines the zero pose of a clip in metres, Y up; also returns the heading it faces, 0 where it is not a body.
/// (rad)
pub(super) fn find_rest_pose(clip: &RawClip, roles: &RoleMap, forward: Option<Forward>) -> (RestPose, f32) {
    let world = rest_world(clip);
    match stance(&world, roles) {
        Ok((stance, heading)) => {
            let heading = forward.map_or(heading, Forward::heading);
            let given = if forward.is_some() { " (as given)" } else { "" };
            let degrees = heading.to_degrees().round() + 0.0;
            let sentence = format!("{}; it faces a heading of {degrees:.0} degrees{given}.", stance.sentence);
            (RestPose { sentence, ..stance }, heading)
        }
        Err(why) => {
            let sentence =
                format!("The rest pose is not a standing body: {why}. Segments and motion tell how joints are turned.");
            (RestPose { kind: RestPoseKind::Other, sentence }, 0.0)
        }
    }
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

/// The stance of the zero pose and its heading once upright (rad), or the reason why it is none.
fn stance(world: &[(Vec3, Quat)], roles: &RoleMap) -> Result<(RestPose, f32), String> {
    use Joint::*;
    let (up, left) = body_axes(world, roles).ok_or("its hips, thighs and head are in one line")?;
    let vertical = nearest_axis(up);
    let segment = |a: Joint, b: Joint| {
        let (a, b) = (roles.get(a)?, roles.get(b)?);
        (world[b].0 - world[a].0).try_normalize()
    };
    for (from, to) in LEG_SEGMENTS {
        let down = segment(from, to).map_or(0.0, |d| -d.dot(vertical));
        let side = if from < from.mirrored() { "left" } else { "right" };
        ensure(down >= LEG_DOWN, || format!("its {side} leg does not point down"))?;
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
    let sentence = format!("The rest pose is {name}: legs down, arms {:.0} degrees above level", degrees.round() + 0.0);
    Ok((RestPose { kind, sentence }, snap_heading(ahead.x.atan2(ahead.z))))
}

/// The axis, or its opposite, that points most along a vector.
pub(crate) fn nearest_axis(v: Vec3) -> Vec3 {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    axes.into_iter().max_by(|a, b| a.dot(v).total_cmp(&b.dot(v))).unwrap_or(Vec3::Y)
}

/// Snaps a heading near a quarter turn to it.
fn snap_heading(heading: f32) -> f32 {
    use std::f32::consts::FRAC_PI_2;
    let quarter = (heading / FRAC_PI_2).round() * FRAC_PI_2;
    if (heading - quarter).abs() < 15f32.to_radians() { quarter } else { heading }
}
