//! Finds which side is left: toes point and knees bend ahead; the arms lie as the legs do. Names are compared with it.

use super::{NoPerson, RecognisedBody, tree::SkeletonTree};
use crate::{import::roles::RoleMap, side::LateralSide};
use glam::Vec3;
use throng_core::Joint;

/// Distance of toes ahead of the ankles, as a share of the way, from which they show which way the body faces.
const CLEAR_TOES: f32 = 0.35;
/// Distance of knees before the line from hip to ankle, as a share of its length, from which they show it.
const CLEAR_KNEES: f32 = 0.015;
/// Part of the shoulders along the line of the hips from which they show on which side an arm is (cosine).
const CLEAR_ARMS: f32 = 0.3;

/// Least width of shoulders, as a share of the hips'.
const MIN_SHOULDERS: f32 = 0.5;

/// Which of the two legs and arms, in the order of the file, are the left ones.
pub struct Sides {
    pub left_leg: usize,
    pub left_arm: usize,
    pub warnings: Vec<String>,
}

/// Evidence of the shape about a body's sides.
struct SideEvidence {
    /// Positive where the first leg is the left one; 0 where nothing tells.
    legs: f32,
    /// True where toes and knees agree and are clear.
    is_certain: bool,
    /// Positive where the first arm is on the first leg's side; 0 where that is not clear.
    arms: f32,
}

/// The joints that tell the sides: `[part][side]`.
#[derive(Clone, Copy)]
struct SideJoints {
    thighs: [usize; 2],
    shins: [usize; 2],
    feet: [usize; 2],
    arms: [usize; 2],
    top: usize,
}

/// Finds the sides of a body.
pub(super) fn decide_sides(tree: &SkeletonTree, body: &RecognisedBody) -> Result<Sides, NoPerson> {
    let two = |limb: &super::LimbPair, part: usize| [limb.joint(part, 0), limb.joint(part, 1)];
    let [thighs, shins, feet] = [0, 1, 2].map(|part| two(&body.legs, part));
    let joints = SideJoints { thighs, shins, feet, arms: two(&body.arms, 0), top: body.chest };
    let shown = side_evidence(tree, joints);
    let named = [body.legs.named_side(tree), body.arms.named_side(tree)];
    let first_leg = match (side_of_sign(shown.legs), named[0]) {
        (Some(shape), Some(name)) if shape != name && !shown.is_certain => name,
        (Some(shape), _) => shape,
        (None, Some(name)) => name,
        (None, None) => match (named[1], side_of_sign(shown.arms)) {
            (Some(arm), Some(LateralSide::Left)) => arm,
            (Some(arm), Some(LateralSide::Right)) => arm.other(),
            _ => return Err(unknown(tree, &joints)),
        },
    };
    let first_arm = match (side_of_sign(shown.arms), named[1]) {
        (Some(LateralSide::Left), _) => first_leg,
        (Some(LateralSide::Right), _) => first_leg.other(),
        (None, Some(name)) => name,
        (None, None) => return Err(unknown(tree, &joints)),
    };
    let wrong = [named[0].filter(|&n| n != first_leg), named[1].filter(|&n| n != first_arm)];
    if let [Some(leg), Some(arm)] = wrong {
        return Err(swapped(tree, joints, leg, arm));
    }
    let pairs = [joints.thighs, joints.arms].into_iter().zip(wrong);
    let warnings = pairs.filter_map(|(joints, side)| Some(conflicts(tree, joints, side?))).flatten().collect();
    let index = |first: LateralSide| usize::from(first == LateralSide::Right);
    Ok(Sides { left_leg: index(first_leg), left_arm: index(first_arm), warnings })
}

/// Roles that names have put on the wrong side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SwappedSides {
    legs: bool,
    arms: bool,
    warnings: Vec<String>,
}

impl SwappedSides {
    /// Exchanges the sides of legs or arms that are on the wrong one, and adds warnings.
    pub fn correct(self, map: &mut RoleMap) {
        let all = Joint::ALL;
        let (arms, legs) = (Joint::LeftClavicle.index(), Joint::LeftThigh.index());
        for (first, wrong) in [(arms, self.arms), (legs, self.legs)] {
            for j in all[first..first + 4].iter().filter(|_| wrong) {
                map.joints.swap(j.index(), j.mirrored().index());
            }
        }
        map.warnings.extend(self.warnings);
    }
}

/// Compares the sides of roles that names have given with the shape.
pub fn check_role_sides(tree: &SkeletonTree, map: &RoleMap) -> Result<SwappedSides, NoPerson> {
    use Joint::*;
    let both = |j: Joint| Some([map.get(j)?, map.get(j.mirrored())?]);
    let (Some(thighs), Some(shins), Some(feet), Some(arms), Some(top)) = (
        both(LeftThigh),
        both(LeftShin),
        both(LeftFoot),
        both(LeftUpperArm),
        map.get(UpperChest).or(map.get(Neck)).or(map.get(Head)),
    ) else {
        return Ok(SwappedSides::default());
    };
    let joints = SideJoints { thighs, shins, feet, arms, top };
    let shown = side_evidence(tree, joints);
    let legs_wrong = shown.is_certain && shown.legs < 0.0;
    match (legs_wrong, shown.arms < 0.0) {
        (true, false) => Err(swapped(tree, joints, LateralSide::Left, LateralSide::Left)),
        (true, true) => {
            Ok(SwappedSides { legs: true, arms: false, warnings: conflicts(tree, thighs, LateralSide::Left) })
        }
        (false, true) => {
            Ok(SwappedSides { legs: false, arms: true, warnings: conflicts(tree, arms, LateralSide::Left) })
        }
        (false, false) => Ok(SwappedSides::default()),
    }
}

fn side_of_sign(value: f32) -> Option<LateralSide> {
    match value {
        v if v > 0.0 => Some(LateralSide::Left),
        v if v < 0.0 => Some(LateralSide::Right),
        _ => None,
    }
}

/// Examines toes, knees and shoulders in all frames.
fn side_evidence(tree: &SkeletonTree, joints: SideJoints) -> SideEvidence {
    // For a body whose first leg is the left one, this is ahead.
    let ahead = |frame: &[Vec3]| {
        let middle = (frame[joints.thighs[0]] + frame[joints.thighs[1]]) * 0.5;
        let across = (frame[joints.thighs[0]] - frame[joints.thighs[1]]).try_normalize()?;
        across.cross((frame[joints.top] - middle).try_normalize()?).try_normalize()
    };
    let tips = joints.feet.map(|foot| toe_tip(tree, foot));
    let toes = tree.mean(|frame| {
        let ahead = ahead(frame)?;
        let part = |side: usize| {
            let to = frame[tips[side]?] - frame[joints.feet[side]];
            Some(to.try_normalize()?.dot(ahead))
        };
        Some(0.5 * (part(0)? + part(1)?))
    });
    let knees = tree.mean(|frame| {
        let ahead = ahead(frame)?;
        let part = |side: usize| {
            let [hip, knee, ankle] = [joints.thighs, joints.shins, joints.feet].map(|j| frame[j[side]]);
            let leg = hip.distance(knee) + knee.distance(ankle);
            let along = (ankle - hip).try_normalize()?;
            let bend = (knee - hip).reject_from_normalized(along);
            // Measured from the side: legs that are spread do not count.
            (leg > 0.0).then(|| bend.dot(ahead) / leg)
        };
        Some(0.5 * (part(0)? + part(1)?))
    });
    let (toes, knees) = (toes.unwrap_or(0.0), knees.unwrap_or(0.0));
    let clear = (toes.abs() > CLEAR_TOES, knees.abs() > CLEAR_KNEES);
    let legs = match clear {
        (true, _) => toes,
        (false, true) => knees,
        _ => 0.0,
    };
    let arms = tree.mean(|frame| {
        let across = |pair: [usize; 2]| frame[pair[0]] - frame[pair[1]];
        let (arms, thighs) = (across(joints.arms), across(joints.thighs));
        // Shoulders in one place, as in broken frames, are no evidence.
        let apart = arms.length() > MIN_SHOULDERS * thighs.length();
        Some(arms).filter(|_| apart)?.try_normalize().map(|a| a.dot(thighs.normalize_or_zero()))
    });
    let is_certain = clear.0 && (knees * toes > 0.0 || knees.abs() <= CLEAR_KNEES);
    SideEvidence { legs, is_certain, arms: arms.filter(|a| a.abs() > CLEAR_ARMS).unwrap_or(0.0) }
}

/// The joint or end below a foot that is farthest from it.
fn toe_tip(tree: &SkeletonTree, foot: usize) -> Option<usize> {
    let reach = |j: usize| tree.lengths[j] + tree.heights[j];
    let next = |j: &usize| tree.role_children(*j).max_by(|&a, &b| reach(a).total_cmp(&reach(b)));
    std::iter::successors(Some(foot), next).last().filter(|&tip| tip != foot && tree.heights[foot] > 0.0)
}

/// Warnings about joints such as one named left that is to the right of the spine.
fn conflicts(tree: &SkeletonTree, joints: [usize; 2], first: LateralSide) -> Vec<String> {
    let conflict = |(joint, side): (usize, LateralSide)| {
        let (name, named, is) = (tree.name(joint), side.name(), side.other().name());
        format!("`{name}` is named {named}, but is to the {is} of the spine; its place decides.")
    };
    [(joints[0], first), (joints[1], first.other())].map(conflict).to_vec()
}

fn swapped(tree: &SkeletonTree, joints: SideJoints, leg: LateralSide, arm: LateralSide) -> NoPerson {
    let of =
        |pair: [usize; 2], first: LateralSide| tree.name(pair[usize::from(first == LateralSide::Right)]).to_owned();
    let message = format!(
        "left and right are swapped: by toes, knees and shoulders, `{}` and `{}` are on the right of the body",
        of(joints.thighs, leg),
        of(joints.arms, arm)
    );
    let help = "The file was mirrored, or written with a left-handed coordinate system: export it right-handed, or name \
                the sides as they are in a profile";
    NoPerson { message, help: help.into() }
}

fn unknown(tree: &SkeletonTree, joints: &SideJoints) -> NoPerson {
    let message = format!(
        "left cannot be told from right: neither the names of the joints (`{}`, `{}`) nor toes or bent knees tell",
        tree.name(joints.thighs[0]),
        tree.name(joints.thighs[1])
    );
    NoPerson { message, help: "Write a profile for the skeleton (data/skeletons/README.md says how)".into() }
}
