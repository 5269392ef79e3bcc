//! Axes of each body part in its source joint: one constant rotation per role.
//!
//! With it the database joint's model-space rotation is the source's times the constant, and is the identity when
//! the body stands in a T-pose. Where the source's rest pose is a standing body it says how trunk and limbs are
//! turned; the rest of the sources (whose rest pose only lists segment lengths) are aligned by their geometry.

use super::body::{PoseSample, RolePose, SourceBody};
use super::geometry;
use glam::{Mat3, Quat, Vec3};
use throng_base::{maths, maths::quantile};
use throng_core::{Joint, NUM_JOINTS, skeleton::LEGS};

/// Rotation from the database joint's axes to the source joint's, per role.
pub type Alignment = [Quat; NUM_JOINTS];

/// Largest angle between the hinges of a rest pose's limbs and those that the motion shows, for the rest pose to be trusted
/// (rad).
const MAX_HINGE_ERROR: f32 = 0.26;

/// Lean of a rest pose's trunk above which it still stands upright in a T-pose (rad).
const LEANING: f32 = 0.17;

/// Bend of a rest pose's knees above which they still stand on flat feet (rad).
const BENT_KNEE: f32 = 0.2;

/// Number of frames below which nothing is shown.
pub const MIN_SAMPLES: usize = 5;

/// Lean of the shin sideways below which a foot is level sideways (sine of the angle).
const UPRIGHT_SHIN: f32 = 0.1;

/// Finds the constant rotation of every role.
pub fn align(body: &SourceBody) -> Alignment {
    let mut a = if body.rest.is_some() { from_rest(body) } else { geometry::from_geometry(body) };
    for (side, [_, shin, foot, toe]) in LEGS.into_iter().enumerate() {
        a[foot.index()] = foot_alignment(body, side, shin, foot, toe, &a);
        a[toe.index()] = toe_alignment(body, side, foot, toe, &a);
    }
    for j in Joint::ALL.into_iter().filter(|&j| !body.has(j)) {
        a[j.index()] = a[super::body::anchor(&body.roles, j).index()];
    }
    a
}

/// The direction in which the segment from `j` to its main child points in a T-pose, for the limbs.
pub fn limb_direction(j: Joint) -> Option<Vec3> {
    use Joint::*;
    match j {
        LeftThigh | LeftShin | RightThigh | RightShin => Some(Vec3::NEG_Y),
        LeftUpperArm | LeftForearm | LeftHand => Some(Vec3::X),
        RightUpperArm | RightForearm | RightHand => Some(Vec3::NEG_X),
        _ => None,
    }
}

/// The child that the direction of a joint is taken from.
pub fn main_child(j: Joint) -> Option<Joint> {
    let mut children = Joint::ALL.into_iter().filter(|c| c.parent() == Some(j));
    children.next().filter(|_| children.next().is_none())
}

/// Trunk joints stand as in the rest pose; a limb's rest direction is the T-pose's, reached by the shortest arc.
fn from_rest(body: &SourceBody) -> Alignment {
    let mut out = [Quat::IDENTITY; NUM_JOINTS];
    let Some(rest) = &body.rest else { return out };
    let lean = trunk_lean(rest);
    let mut arc = [Quat::IDENTITY; NUM_JOINTS];
    for j in Joint::ALL {
        let child = main_child(j).filter(|c| body.has(*c));
        arc[j.index()] = match (limb_direction(j), child) {
            (Some(from), Some(c)) => {
                let to = rest[c.index()].0 - rest[j.index()].0;
                // Arms hang on the trunk.
                let hung = lean.filter(|_| from.y == 0.0).unwrap_or(Quat::IDENTITY);
                let turn = |to| maths::compose(Quat::from_rotation_arc(hung * from, to), hung);
                to.try_normalize().map_or(hung, turn)
            }
            (Some(_), None) => j.parent().map_or(Quat::IDENTITY, |p| arc[p.index()]),
            (None, _) => lean.unwrap_or(Quat::IDENTITY),
        };
        let a = maths::compose(rest[j.index()].1.inverse(), arc[j.index()]).normalize();
        out[j.index()] = onto_hinge(body, j, a);
    }
    out
}

/// The rotation from upright to the lean of a rest pose's trunk, where that is more than that of a standing body.
fn trunk_lean(rest: &RolePose) -> Option<Quat> {
    use Joint::*;
    let at = |j: Joint| rest[j.index()].0;
    let up = ((at(LeftUpperArm) + at(RightUpperArm)) * 0.5 - at(Hips)).try_normalize()?;
    (up.y < LEANING.cos()).then(|| Quat::from_rotation_arc(Vec3::Y, up))
}

/// Turns a limb about its segment so that its hinge lies as in a T-pose, where the motion shows it far from there.
///
/// Rest poses agree on the directions of arms but not on which way the elbows point: CMU's are 30 degrees off.
fn onto_hinge(body: &SourceBody, j: Joint, a: Quat) -> Quat {
    let Some((expected, shown)) = limb_direction(j).and_then(|d| {
        let shown = geometry::hinge_owner(j).and_then(|upper| geometry::hinge(body, j, upper))?;
        Some((geometry::t_pose_hinge(d), (a.inverse() * shown).reject_from_normalized(d).try_normalize()?))
    }) else {
        return a;
    };
    if expected.angle_between(shown) < MAX_HINGE_ERROR {
        return a;
    }
    maths::compose(a, Quat::from_rotation_arc(expected, shown)).normalize()
}

/// The foot's frame: up is the vertical while the foot stands, forward leads to the toe.
fn foot_alignment(body: &SourceBody, side: usize, shin: Joint, foot: Joint, toe: Joint, a: &Alignment) -> Quat {
    let carried = carried(body, shin, foot, a);
    let ahead = if body.has(toe) { body.offsets[toe.index()] } else { carried * Vec3::Z };
    let fallback = match &body.rest {
        None if body.has(toe) => {
            // The T-pose foot of the default skeleton: the toe lies 24 degrees below the ankle.
            let left = carried * Vec3::X;
            Quat::from_axis_angle(left, -0.42) * ahead.cross(left).normalize_or(Vec3::Y)
        }
        // Where the rest pose bends the knee, the foot is flat rather than square to the shin.
        Some(rest) if knee_bend(rest, shin, foot) > BENT_KNEE => rest[foot.index()].1.inverse() * Vec3::Y,
        _ => carried * Vec3::Y,
    };
    let up = sole_normal(body, side, foot).filter(|u| u.dot(fallback) > 0.85).unwrap_or(fallback);
    frame_from_up(up, ahead).unwrap_or(carried)
}

/// Bend of a knee in a rest pose (rad).
fn knee_bend(rest: &RolePose, shin: Joint, foot: Joint) -> f32 {
    let at = |j: Joint| rest[j.index()].0;
    let thigh = shin.parent().map_or(Vec3::NEG_Y, |thigh| at(shin) - at(thigh));
    thigh.angle_between(at(foot) - at(shin))
}

/// The toe's frame: up is the vertical while the foot stands, forward that of the foot.
fn toe_alignment(body: &SourceBody, side: usize, foot: Joint, toe: Joint, a: &Alignment) -> Quat {
    let carried = carried(body, foot, toe, a);
    let up = sole_normal(body, side, toe).filter(|u| u.dot(carried * Vec3::Y) > 0.8);
    frame_from_up(up.unwrap_or(carried * Vec3::Y), carried * Vec3::Z).unwrap_or(carried)
}

/// The alignment `child` would have if it kept its mean rotation relative to `parent` (its rest one where known).
fn carried(body: &SourceBody, parent: Joint, child: Joint, a: &Alignment) -> Quat {
    let (p, c) = (parent.index(), child.index());
    match &body.rest {
        Some(rest) => maths::compose(maths::compose(rest[c].1.inverse(), rest[p].1), a[p]).normalize(),
        None => mean_rotation(
            body.samples.iter().map(|s| maths::compose(maths::compose(s.pose[c].1.inverse(), s.pose[p].1), a[p])),
        ),
    }
}

/// Mean of the world's vertical in the axes of `joint` over the frames in which the foot stands.
fn sole_normal(body: &SourceBody, side: usize, joint: Joint) -> Option<Vec3> {
    let standing = standing_samples(body, side);
    let sum: Vec3 = standing.iter().map(|s| s.pose[joint.index()].1.inverse() * Vec3::Y).sum();
    if standing.len() < MIN_SAMPLES { None } else { sum.try_normalize() }
}

/// The frames in which a foot stands flat: hardly moving, the toe about as low as in the lowest quarter of those,
/// and the shin not leaning sideways, because feet that are tracked by few markers lean with the leg.
fn standing_samples(body: &SourceBody, side: usize) -> Vec<&PoseSample> {
    let [_, shin, foot, toe] = LEGS[side].map(Joint::index);
    let lowest = quantile(still_samples(body, side).map(|s| s.pose[toe].0.y), [1, 4]);
    let Some(limit) = lowest.map(|h| h + 0.03) else { return Vec::new() };
    let low: Vec<&PoseSample> = still_samples(body, side).filter(|s| s.pose[toe].0.y < limit).collect();
    let leans = |s: &PoseSample| {
        let left = (s.pose[Joint::LeftThigh.index()].0 - s.pose[Joint::RightThigh.index()].0).with_y(0.0);
        let shin = (s.pose[foot].0 - s.pose[shin].0).normalize_or_zero();
        shin.dot(left.normalize_or_zero()).abs() > UPRIGHT_SHIN
    };
    let upright: Vec<&PoseSample> = low.iter().copied().filter(|s| !leans(s)).collect();
    if upright.len() < MIN_SAMPLES { low } else { upright }
}

fn still_samples(body: &SourceBody, side: usize) -> impl Iterator<Item = &PoseSample> {
    body.samples.iter().filter(move |s| s.still_feet[side])
}

/// Rotation whose Y axis is `up` and whose Z axis is as near to `forward` as that allows.
pub fn frame_from_up(up: Vec3, forward: Vec3) -> Option<Quat> {
    let y = up.try_normalize()?;
    let z = forward.reject_from_normalized(y).try_normalize()?;
    Some(Quat::from_mat3(&Mat3::from_cols(y.cross(z), y, z)).normalize())
}

/// Normalised sum of rotations, each taken on the first one's side.
pub fn mean_rotation(rotations: impl Iterator<Item = Quat>) -> Quat {
    let mut sum = glam::Vec4::ZERO;
    for q in rotations {
        let v = glam::Vec4::from(q);
        sum += if sum.dot(v) < 0.0 { -v } else { v };
    }
    sum.try_normalize().map_or(Quat::IDENTITY, Quat::from_vec4)
}
