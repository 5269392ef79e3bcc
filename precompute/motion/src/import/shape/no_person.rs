//! Explains why a skeleton is no whole body.

use super::limbs::{self, MirroredChains};
use super::{NoPerson, RecognisedBody, names::NamedPart, tree::SkeletonTree, trunk};
use crate::{import::roles::RoleMap, import::units::rest_world};
use glam::Vec3;
use throng_core::Joint;

/// Number of chains that make a hand.
const FINGERS: usize = 4;
/// Names listed in an error.
const MAX_NAMES: usize = 40;

/// Share of the frames above which limbs that reach the ground carry a body.
const MOST_FRAMES: f32 = 0.8;
/// Length of the limbs before the hind legs, as a share of these, above which they may be forelegs.
const SHORTEST_FORELEGS: f32 = 0.8;

/// Refuses a body that stands on more than its legs: other limbs reach the ground before or behind the feet, its knees are
/// up, and it does so in nearly all frames and at rest. People at rest stand on their legs, whatever they do then.
pub fn check_stance(tree: &SkeletonTree, map: &RoleMap) -> Result<(), NoPerson> {
    use Joint::*;
    let both = |j: Joint| Some([map.get(j)?, map.get(j.mirrored())?]);
    let (Some(thighs), Some(shins), Some(feet)) = (both(LeftThigh), both(LeftShin), both(LeftFoot)) else {
        return Ok(());
    };
    let middle = |frame: &[Vec3], [a, b]: [usize; 2]| (frame[a] + frame[b]) * 0.5;
    // Hind legs of animals have more joints than legs of people.
    let hips = map.get(Hips);
    let tops = thighs.map(|t| tree.path_up(t).take_while(|&j| Some(j) != hips).last().unwrap_or(t));
    let down = |frame: &[Vec3]| middle(frame, feet) - middle(frame, tops);
    let stands_on = |frame: &[Vec3], pair: &MirroredChains| {
        let (down, leg) = (down(frame).normalize_or_zero(), down(frame).length());
        let foot = middle(frame, feet);
        let height = |at: Vec3| (foot - at).dot(down);
        let place = |k: usize| middle(frame, [pair.leg.paths[0][k], pair.leg.paths[1][k]]);
        let lowest = (0..pair.leg.paths[0].len()).map(place).min_by(|a, b| height(*a).total_cmp(&height(*b)));
        let end = lowest.unwrap_or(foot);
        let apart = (end - foot + down * height(end)).length();
        let knees = height(middle(frame, shins)) > 0.25 * leg;
        knees && height(end) < 0.25 * leg && height(place(0)) > 0.5 * leg && apart > 0.35 * leg
    };
    let rest: Vec<Vec3> = rest_world(tree.clip).into_iter().map(|(at, _)| at).collect();
    let top = map.get(Head).or(map.get(Neck));
    let is_upright = |top: usize| {
        let trunk = (rest[top] - middle(&rest, tops)).normalize_or_zero();
        trunk.dot(down(&rest).normalize_or_zero()) < -0.7
    };
    let is_leg = |pair: &MirroredChains| {
        let along = |f: usize, t: usize| tree.is_above(f, t) || tree.is_above(t, f);
        pair.first.iter().any(|&f| tops.iter().any(|&t| along(f, t)))
    };
    let reach = |path: &Vec<usize>| path.iter().skip(1).map(|&j| tree.lengths[j]).sum::<f32>();
    let leg = tree.lengths[shins[0]] + tree.lengths[feet[0]];
    for pair in limbs::pairs(tree).iter().filter(|p| !is_leg(p)) {
        let seen = tree.frames.iter().filter(|f| stands_on(f, pair)).count();
        let at_rest = stands_on(&rest, pair)
            || (!top.is_some_and(is_upright) && reach(&pair.leg.paths[0]) > SHORTEST_FORELEGS * leg);
        if seen as f32 > MOST_FRAMES * tree.frames.len() as f32 && at_rest {
            let [a, b, c, d] = [thighs[0], thighs[1], pair.first[0], pair.first[1]].map(|j| tree.name(j));
            let message = format!(
                "no person was found: it goes on four legs (`{a}`, `{b}`, `{c}`, `{d}`), which all reach the ground"
            );
            return Err(NoPerson { message, help: "Only people are read: leave the file out".into() });
        }
    }
    Ok(())
}

/// Limbs that end too early: the parts of one, the part that is not below it, and both in words.
const SHORT_LIMBS: [([NamedPart; 3], &str, &str); 2] = [
    ([NamedPart::Thigh, NamedPart::Shin, NamedPart::Foot], "legs", "feet"),
    ([NamedPart::UpperArm, NamedPart::Forearm, NamedPart::Hand], "arms", "hands"),
];

/// Explains limbs whose feet or hands hang elsewhere, or are not there.
fn explain_short_limb(tree: &SkeletonTree) -> Option<NoPerson> {
    SHORT_LIMBS.iter().find_map(|&([upper, middle, end], limbs, ends)| {
        let is_upper = |j: usize| tree.labels[j].is_exactly(upper);
        let hangs = |j: usize| tree.labels[j].may_be(middle) && tree.path_up(j).skip(1).any(is_upper);
        let all = || 0..tree.labels.len();
        let is_last = |&j: &usize| tree.is_candidate(j) && tree.heights[j] <= f32::EPSILON && (hangs(j) || is_upper(j));
        let last = all().find(is_last)?;
        let is_end = |j: &usize| tree.labels[*j].may_be(end) && tree.labels[*j].side == tree.labels[last].side;
        let parent = |j: usize| tree.clip.joints[j].parent.map_or("nothing", |p| tree.name(p));
        let other = |j: usize| format!("; `{}` hangs on `{}`", tree.name(j), parent(j));
        let other = all().find(is_end).map_or_else(String::new, other);
        let message = format!("its {limbs} have no {ends}: nothing hangs on `{}`{other}", tree.name(last));
        let help = "Hang each one there in the program that made the rig, bake the motion, and export it again";
        Some(NoPerson { message, help: help.into() })
    })
}

/// Explains why two arms, two legs and the parts that join them were not found.
pub(super) fn explain(tree: &SkeletonTree, pairs: &[MirroredChains]) -> NoPerson {
    if let Some(reason) = explain_short_limb(tree) {
        return reason;
    }
    let longest = pairs.iter().max_by(|a, b| a.leg.length.total_cmp(&b.leg.length));
    let Some(pair) = longest else {
        let what = "no two limbs of equal length hang on one joint, so it is no body; it may be a prop or a camera";
        return no_person(tree, what);
    };
    if pairs.iter().filter(|p| p.parent == pair.parent).count() > 3 || is_hand(tree, pair.parent) {
        return no_person(tree, &format!("it is a hand alone: fingers hang on `{}`", tree.name(pair.parent)));
    }
    let [a, b] = pair.first.map(|j| tree.name(j));
    let arms = pair.arm.names > pair.leg.names;
    let legs = pair.leg.names > pair.arm.names;
    let above = tree.path_up(pair.parent).last().unwrap_or(pair.parent);
    let upper = arms || (!legs && trunk::has_head(tree, pair, &trunk::necks(tree, pair.parent, above)));
    let (has, lacks) = if upper { ("an upper body", "legs") } else { ("a lower body", "arms") };
    no_person(tree, &format!("it is {has} alone: `{a}` and `{b}` are a pair of limbs, and no pair of {lacks} is there"))
}

/// A body without a head.
pub(super) fn no_head(tree: &SkeletonTree, body: &RecognisedBody) -> NoPerson {
    let chest = tree.name(body.chest);
    no_person(tree, &format!("no joint for a neck or head goes on from `{chest}`, where the arms meet"))
}

/// True for a joint on which fingers hang.
pub(super) fn is_hand(tree: &SkeletonTree, joint: usize) -> bool {
    let long = |j: &usize| tree.heights[*j] > 0.0 && tree.role_children(*j).count() > 0;
    let all = tree.children[joint].iter().filter(|&&j| !tree.clip.joints[j].is_end);
    all.filter(|j| long(j)).count() >= FINGERS
}

fn no_person(tree: &SkeletonTree, what: &str) -> NoPerson {
    let joints: Vec<&str> =
        tree.clip.joints.iter().filter(|j| !j.is_end).take(MAX_NAMES).map(|j| j.name.as_str()).collect();
    let message = format!("no person was found: {what}. Joints: {}", joints.join(", "));
    let help = "Whole bodies are needed: two legs, two arms and a head. Where they are there, write a skeleton profile that \
                names them (data/skeletons/README.md says how) and add it to `profiles` in the config";
    NoPerson { message, help: help.into() }
}
