//! Explains why a skeleton is no whole body.

use super::limbs::MirroredChains;
use super::tree::SkeletonTree;
use super::{NoPerson, RecognisedBody, trunk};

/// Number of chains that make a hand.
const FINGERS: usize = 4;
/// Names listed in an error.
const MAX_NAMES: usize = 40;

/// Explains why two arms, two legs and the parts that join them were not found.
pub(super) fn explain(tree: &SkeletonTree, pairs: &[MirroredChains]) -> NoPerson {
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
