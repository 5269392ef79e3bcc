//! Alignment of sources whose rest pose is not a body: from the directions of their segments and the hinges that
//! the motion shows.
//!
//! Such rigs (Bandai-Namco's, LAFAN1) lay every segment along one axis and keep the axes square to the body, so a
//! frame found by geometry is snapped to the nearest square one. The result then does not depend on what the
//! clips happen to show.

use super::align::{Alignment, MIN_SAMPLES, limb_direction, main_child, mean_rotation};
use super::body::{PoseSample, SourceBody, anchor};
use crate::import::nearest_axis;
use glam::{Mat3, Quat, Vec3};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS};

/// Angle below which a frame counts as the one square to the joint's axes (rad).
const SNAP_ANGLE: f32 = 0.6;

/// Distance of joints below which they have no direction between them (m).
const MIN_SEGMENT: f32 = 0.01;

/// Bend of a limb below which it shows no hinge (sine of the angle).
const MIN_BEND: f32 = 0.25;

/// Aligns all roles but feet and toes.
pub fn from_geometry(body: &SourceBody) -> Alignment {
    use Joint::*;
    let mut out = [Quat::IDENTITY; NUM_JOINTS];
    for j in Joint::ALL {
        if !body.has(j) {
            out[j.index()] = out[anchor(&body.roles, j).index()];
            continue;
        }
        let found = match j {
            Hips | Spine | Chest | UpperChest | Neck => trunk(body, j),
            Head => mean_relative(body, j, &out),
            LeftClavicle | RightClavicle => clavicle(body, j, &out),
            LeftFoot | RightFoot | LeftToe | RightToe => continue,
            _ => limb(body, j, &out),
        };
        let snapped = snap(found);
        out[j.index()] = match j {
            Hips => level_hips(body, snapped),
            _ if limb_direction(j).is_some() => aim(body, j, snapped),
            _ => snapped,
        };
    }
    out
}

/// The trunk's frame: up leads to its next joint, left follows hips or shoulders.
fn trunk(body: &SourceBody, j: Joint) -> Quat {
    use Joint::*;
    let is_next = |n: &&Joint| **n > j && body.has(**n) && distance(body, j, **n) > MIN_SEGMENT;
    let next = Joint::ALL[..=Head.index()].iter().find(is_next);
    let up = next.and_then(|n| body.mean_local(j, |s| Some(s.pose[n.index()].0 - s.pose[j.index()].0)));
    let up = up.unwrap_or(Vec3::Y);
    let side = |s: &PoseSample, l: Joint, r: Joint| s.pose[l.index()].0 - s.pose[r.index()].0;
    let left = match j {
        Hips => body.mean_local(j, |s| Some(side(s, LeftThigh, RightThigh))),
        UpperChest | Neck => body.mean_local(j, |s| Some(side(s, LeftUpperArm, RightUpperArm))),
        _ => body.mean_local(j, |s| {
            let hips = side(s, LeftThigh, RightThigh).normalize_or_zero();
            Some(hips + side(s, LeftUpperArm, RightUpperArm).normalize_or_zero())
        }),
    };
    frame_xy(left.unwrap_or(Vec3::X), up).unwrap_or(Quat::IDENTITY)
}

/// Mean distance between two roles (m).
fn distance(body: &SourceBody, a: Joint, b: Joint) -> f32 {
    let sum: f32 = body.samples.iter().map(|s| (s.pose[a.index()].0 - s.pose[b.index()].0).length()).sum();
    sum / body.samples.len().max(1) as f32
}

/// The alignment that keeps the joint's mean rotation relative to its anchor at the identity.
fn mean_relative(body: &SourceBody, j: Joint, out: &Alignment) -> Quat {
    let p = anchor(&body.roles, j).index();
    mean_rotation(
        body.samples.iter().map(|s| maths::compose(maths::compose(s.pose[j.index()].1.inverse(), s.pose[p].1), out[p])),
    )
}

/// The clavicle's frame: outwards leads to the upper arm, up is the trunk's on average.
fn clavicle(body: &SourceBody, j: Joint, out: &Alignment) -> Quat {
    let p = anchor(&body.roles, j).index();
    let (child, sign) =
        if j == Joint::LeftClavicle { (Joint::LeftUpperArm, 1.0) } else { (Joint::RightUpperArm, -1.0) };
    let up = body.mean_local(j, |s| Some(maths::compose(s.pose[p].1, out[p]) * Vec3::Y));
    frame_xy(body.offsets[child.index()] * sign, up.unwrap_or(Vec3::Y)).unwrap_or(Quat::IDENTITY)
}

/// The limb's frame: along the segment, and about it by the hinge at its far (thigh, upper arm) or near end (shin, forearm).
fn limb(body: &SourceBody, j: Joint, out: &Alignment) -> Quat {
    let Some(t_pose) = limb_direction(j) else { return Quat::IDENTITY };
    let near = mean_relative(body, j, out);
    let along = segment(body, j).unwrap_or(near * t_pose);
    let t_hinge = t_pose_hinge(t_pose);
    let shown = hinge_owner(j).and_then(|upper| hinge(body, j, upper));
    let hinge = shown.unwrap_or(near * t_hinge);
    match (frame_xy(t_pose, t_hinge), frame_xy(along, hinge)) {
        (Some(f), Some(t)) => maths::compose(t, f.inverse()).normalize(),
        _ => near,
    }
}

/// The axis about which a limb of that T-pose direction bends: +X for knees; elbows, which bend forwards, turn about -Y on the
/// left and +Y on the right.
pub fn t_pose_hinge(direction: Vec3) -> Vec3 {
    if direction.y == 0.0 { direction.cross(Vec3::Z) } else { Vec3::X }
}

/// The upper segment of the hinge a limb's segment belongs to.
pub fn hinge_owner(j: Joint) -> Option<Joint> {
    use Joint::*;
    match j {
        LeftThigh | RightThigh | LeftUpperArm | RightUpperArm => Some(j),
        LeftShin | RightShin | LeftForearm | RightForearm => j.parent(),
        _ => None,
    }
}

/// Mean hinge axis in `j`'s axes, where the motion bends the limb often enough.
pub fn hinge(body: &SourceBody, j: Joint, upper: Joint) -> Option<Vec3> {
    let lower = main_child(upper)?;
    let end = main_child(lower).filter(|e| body.has(*e))?;
    let at = |s: &PoseSample, j: Joint| s.pose[j.index()].0;
    let axis = |s: &PoseSample| {
        let a = (at(s, lower) - at(s, upper)).try_normalize()?;
        let b = (at(s, end) - at(s, lower)).try_normalize()?;
        let n = a.cross(b);
        (n.length() > MIN_BEND).then_some(n)
    };
    let shown = body.samples.iter().filter(|s| axis(s).is_some()).count();
    if shown < MIN_SAMPLES { None } else { body.mean_local(j, axis) }
}

/// Local direction of the joint's segment.
fn segment(body: &SourceBody, j: Joint) -> Option<Vec3> {
    let offset = match (j, main_child(j)) {
        (Joint::LeftHand, _) => body.hand_tips[0]?,
        (Joint::RightHand, _) => body.hand_tips[1]?,
        (_, Some(c)) if body.has(c) => body.offsets[c.index()],
        _ => return None,
    };
    (offset.length() > MIN_SEGMENT).then(|| offset.normalize())
}

/// Turns a snapped limb back onto its segment by the shortest arc.
fn aim(body: &SourceBody, j: Joint, a: Quat) -> Quat {
    match (segment(body, j), limb_direction(j)) {
        (Some(to), Some(from)) => maths::compose(Quat::from_rotation_arc((a * from).normalize(), to), a).normalize(),
        _ => a,
    }
}

/// Turns snapped hips by the shortest arc so that the thighs keep their places: a tilt would lift one foot.
fn level_hips(body: &SourceBody, a: Quat) -> Quat {
    let across = body.offsets[Joint::LeftThigh.index()] - body.offsets[Joint::RightThigh.index()];
    match across.try_normalize() {
        Some(across) => maths::compose(Quat::from_rotation_arc((a * Vec3::X).normalize(), across), a).normalize(),
        None => a,
    }
}

/// The nearest rotation that maps axes to axes, where it is near enough.
fn snap(q: Quat) -> Quat {
    let m = Mat3::from_quat(q);
    let (x, y) = (nearest_axis(m.x_axis), nearest_axis(m.y_axis));
    if x.dot(y) != 0.0 {
        return q;
    }
    let square = Quat::from_mat3(&Mat3::from_cols(x, y, x.cross(y)));
    if square.angle_between(q) < SNAP_ANGLE { square } else { q }
}

/// Rotation whose X axis is `x` and whose Y axis is as near to `y` as that allows.
fn frame_xy(x: Vec3, y: Vec3) -> Option<Quat> {
    let x = x.try_normalize()?;
    let y = y.reject_from_normalized(x).try_normalize()?;
    Some(Quat::from_mat3(&Mat3::from_cols(x, y, x.cross(y))).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snaps_only_what_is_near_a_square_frame() {
        let square = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2) * Quat::from_rotation_x(std::f32::consts::PI);
        let near = square * Quat::from_rotation_y(0.3);
        assert!(snap(near).angle_between(square) < 1e-3);
        let far = square * Quat::from_rotation_y(0.7);
        assert_eq!(snap(far), far);
    }

    #[test]
    fn frames_are_right_handed_and_keep_the_first_axis() {
        let x = Vec3::new(1.0, 2.0, 3.0);
        let q = frame_xy(x, Vec3::Y).unwrap();
        assert!((q * Vec3::X).dot(x.normalize()) > 1.0 - 1e-5);
        assert!((q * Vec3::Y).dot(Vec3::Y) > 0.5);
        assert!((q * Vec3::X).cross(q * Vec3::Y).dot(q * Vec3::Z) > 0.999);
        assert!(frame_xy(Vec3::Y, Vec3::Y).is_none());
    }
}
