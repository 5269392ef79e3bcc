//! Finds the role of each joint from the shape of a skeleton.
//!
//! Legs and arms are pairs of chains of equal lengths. Legs are the longer ones, nearer to the root, and point away
//! from the arms; the spine lies between where the two pairs meet; neck and head go on from where the arms meet.
//! Toes and knees say which way the body looks, and so which side is left. Lengths and places are those of the
//! motion: rest poses follow many rules. Names confirm, and decide between what the shape leaves open.

mod limbs;
mod names;
mod no_person;
mod sides;
mod tree;
mod trunk;

use super::roles::RoleMap;
use crate::error::ensure;
use glam::Vec3;
use limbs::{LimbPair, MirroredChains};
use names::NamedPart;
pub(crate) use names::split_words;
pub(super) use no_person::check_stance;
pub(super) use sides::check_role_sides;
use std::collections::HashMap;
use throng_core::{Joint, NUM_JOINTS};
pub(super) use tree::SkeletonTree;

/// Most pairs that are tried as legs, and as arms; people have a few dozen of them.
const MAX_PAIRS: usize = 256;

/// Reason why a skeleton is no person, and the way out.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NoPerson {
    pub message: String,
    pub help: String,
}

/// Parts of a body as found.
struct RecognisedBody {
    legs: LimbPair,
    arms: LimbPair,
    /// Joint at which the legs meet.
    hips: usize,
    /// Joint at which the arms meet.
    chest: usize,
}

/// Maps the joints of a skeleton to roles by its shape.
///
/// # Errors
/// [`NoPerson`] where there is no body with two arms, two legs and a head, or left cannot be told from right.
pub(super) fn recognise(tree: &SkeletonTree) -> Result<RoleMap, NoPerson> {
    let pairs = limbs::pairs(tree);
    let Some(body) = best_body(tree, &pairs) else { return Err(no_person::explain(tree, &pairs)) };
    let mut map = RoleMap { joints: [None; NUM_JOINTS], profile: RoleMap::BY_SHAPE.into(), warnings: Vec::new() };
    let sides = sides::decide_sides(tree, &body)?;
    map.warnings.extend(sides.warnings);
    set_limbs(tree, &body, [sides.left_leg, sides.left_arm], &mut map);
    trunk::set_trunk_roles(tree, &body, &mut map);
    ensure(map.get(Joint::Neck).or(map.get(Joint::Head)).is_some(), || no_person::no_head(tree, &body))?;
    map.warnings.extend(find_other_names(tree, &map));
    let named = map.joints.iter().flatten().filter(|&&j| tree.labels[j].names_a_part()).count();
    if named * 2 < map.joints.iter().flatten().count() {
        let pairs: Vec<_> =
            map.pairs(&tree.clip.joints).map(|(role, joint)| format!("{}={joint}", role.name())).collect();
        map.warnings.push(format!(
            "the names of the joints say little, so roles were found by the shape of the skeleton alone: {}. Check them; \
             a profile decides where they are wrong (data/skeletons/README.md).",
            pairs.join(" ")
        ));
    }
    Ok(map)
}

/// Joints of limbs, from the trunk on, and the parts by which they are named.
const LIMBS: [[(Joint, NamedPart); 3]; 4] = {
    use Joint::*;
    [
        [(LeftThigh, NamedPart::Thigh), (LeftShin, NamedPart::Shin), (LeftFoot, NamedPart::Foot)],
        [(RightThigh, NamedPart::Thigh), (RightShin, NamedPart::Shin), (RightFoot, NamedPart::Foot)],
        [(LeftUpperArm, NamedPart::UpperArm), (LeftForearm, NamedPart::Forearm), (LeftHand, NamedPart::Hand)],
        [(RightUpperArm, NamedPart::UpperArm), (RightForearm, NamedPart::Forearm), (RightHand, NamedPart::Hand)],
    ]
};

/// A limb that comes apart when it bends: its foot or hand does not hang on the joint above it.
pub(super) fn find_parted_limb(tree: &SkeletonTree, map: &RoleMap) -> Option<String> {
    let part = |[above, below]: [usize; 2]| {
        let (above, below) = (tree.name(above), tree.name(below));
        format!("`{below}` does not follow when `{above}` turns: it hangs on another joint.")
    };
    let found = LIMBS.iter().flat_map(|limb| limb.windows(2)).find_map(|pair| {
        let both = [map.get(pair[0].0)?, map.get(pair[1].0)?];
        (!tree.is_above(both[0], both[1])).then_some(both)
    });
    found.map(part)
}

/// Warnings of joints of limbs that are named as another part of a limb than the one that the shape makes them.
fn find_other_names(tree: &SkeletonTree, map: &RoleMap) -> Vec<String> {
    let parts = LIMBS[1..3].as_flattened();
    let of = |&(role, part): &(Joint, NamedPart)| {
        let joint = map.get(role)?;
        let label = tree.labels[joint];
        let other = parts.iter().find(|(_, p)| *p != part && label.is_exactly(*p))?;
        let (name, found) = (tree.name(joint), role.name());
        let named = other.0.name().trim_start_matches("left_").trim_start_matches("right_");
        Some(format!("`{name}` is named as a {named}, but by the shape of the body it is the {found}: check it."))
    };
    LIMBS.as_flattened().iter().filter_map(of).collect()
}

/// The two pairs that make the best body.
fn best_body(tree: &SkeletonTree, pairs: &[MirroredChains]) -> Option<RecognisedBody> {
    let longest = pairs.iter().map(|p| p.leg.length).fold(0.0, f32::max);
    let mut best: Option<(f32, RecognisedBody)> = None;
    let mut necks = HashMap::new();
    let arms = likeliest(pairs, |p| &p.arm, longest);
    for legs in likeliest(pairs, |p| &p.leg, longest) {
        for &arms in &arms {
            let mut has_head = || {
                let (chest, hips) = (arms.parent, legs.parent);
                let necks = necks.entry((chest, hips)).or_insert_with(|| trunk::necks(tree, chest, hips));
                trunk::has_head(tree, arms, necks)
            };
            let Some(score) = score(tree, legs, arms, longest, &mut has_head) else { continue };
            if best.as_ref().is_none_or(|(s, _)| score > *s) {
                let (hips, chest) = (legs.parent, arms.parent);
                best = Some((score, RecognisedBody { legs: legs.leg.clone(), arms: arms.arm.clone(), hips, chest }));
            }
        }
    }
    best.map(|(_, body)| body)
}

/// The pairs that are the most like legs or arms, in their order.
fn likeliest(pairs: &[MirroredChains], limb: impl Fn(&MirroredChains) -> &LimbPair, most: f32) -> Vec<&MirroredChains> {
    let value = |i: &usize| 2.0 * limb(&pairs[*i]).names + limb(&pairs[*i]).score / most;
    let mut all: Vec<usize> = (0..pairs.len()).collect();
    all.sort_by(|a, b| value(b).total_cmp(&value(a)));
    all.truncate(MAX_PAIRS);
    all.sort_unstable();
    all.into_iter().map(|i| &pairs[i]).collect()
}

/// Score of two pairs as the legs and the arms of one body; `None` where they cannot be.
///
/// - `has_head`: called to find whether a head goes on from where the arms meet.
fn score(
    tree: &SkeletonTree,
    legs: &MirroredChains,
    arms: &MirroredChains,
    longest: f32,
    has_head: &mut dyn FnMut() -> bool,
) -> Option<f32> {
    let inside = |a: &MirroredChains, b: &MirroredChains| a.first.iter().any(|&f| tree.is_above(f, b.parent));
    let apart = legs.first.iter().all(|f| !arms.first.contains(f)) && !inside(legs, arms) && !inside(arms, legs);
    let is_hand = legs.parent == arms.parent && no_person::is_hand(tree, legs.parent);
    if !apart || is_hand || tree.common_ancestor(legs.parent, arms.parent).is_none() {
        return None;
    }
    let ratio = legs.leg.length / arms.arm.length;
    if !(0.5..=4.0).contains(&ratio) {
        return None;
    }
    let nearer_root = match (tree.is_above(legs.parent, arms.parent), tree.is_above(arms.parent, legs.parent)) {
        (true, true) => 0.0,
        (true, false) => 1.0,
        (false, true) => -1.0,
        (false, false) => 0.5,
    };
    // The ratio of a person is 1.5.
    let proportion = 1.0 - (ratio / 1.5).ln().abs();
    let away = pointing_away(tree, legs, arms) - pointing_away(tree, arms, legs);
    let names = legs.leg.names + arms.arm.names;
    let size = (legs.leg.score + arms.arm.score) / longest;
    let head = if has_head() { 1.0 } else { 0.0 };
    Some(2.0 * names + nearer_root + proportion + 0.5 * away + size + head)
}

/// Degree to which the limbs of one pair point away from where the other one meets: -1 to 1, the mean over the frames.
fn pointing_away(tree: &SkeletonTree, pair: &MirroredChains, other: &MirroredChains) -> f32 {
    let of = |frame: &[Vec3]| {
        let ends = (frame[pair.leg.joint(2, 0)] + frame[pair.leg.joint(2, 1)]) * 0.5;
        let limb = (ends - frame[pair.parent]).try_normalize()?;
        Some(-limb.dot((frame[other.parent] - frame[pair.parent]).try_normalize()?))
    };
    tree.mean(of).unwrap_or(0.0)
}

/// Sets the roles of the limbs; `left` has the index of the left one of the two legs and of the two arms.
fn set_limbs(tree: &SkeletonTree, body: &RecognisedBody, left: [usize; 2], map: &mut RoleMap) {
    use Joint::*;
    for right in [false, true] {
        let role = |j: Joint| if right { j.mirrored().index() } else { j.index() };
        let (leg, arm) = (left[0] ^ usize::from(right), left[1] ^ usize::from(right));
        for (part, j) in [LeftThigh, LeftShin, LeftFoot].into_iter().enumerate() {
            map.joints[role(j)] = Some(body.legs.joint(part, leg));
        }
        map.joints[role(LeftToe)] = toe(tree, body.legs.joint(2, leg));
        for (part, j) in [LeftUpperArm, LeftForearm].into_iter().enumerate() {
            map.joints[role(j)] = Some(body.arms.joint(part, arm));
        }
        // The end of a chain does not turn: the hand is one with the forearm.
        map.joints[role(LeftHand)] = Some(body.arms.joint(2, arm)).filter(|&h| tree.is_candidate(h));
        let before = &body.arms.paths[arm][..body.arms.joint_places[0]];
        map.joints[role(LeftClavicle)] = clavicle(tree, before);
    }
    for (l, r) in [(LeftToe, RightToe), (LeftHand, RightHand), (LeftClavicle, RightClavicle)] {
        if map.get(l).is_none() || map.get(r).is_none() {
            (map.joints[l.index()], map.joints[r.index()]) = (None, None);
        }
    }
}

/// The joint below a foot that is named a toe, or else starts the longest chain.
fn toe(tree: &SkeletonTree, foot: usize) -> Option<usize> {
    let below = std::iter::successors(longest_below(tree, foot), |&at| longest_below(tree, at));
    let chain: Vec<usize> = below.filter(|&j| tree.is_candidate(j)).collect();
    let named = chain.iter().copied().find(|&j| tree.labels[j].may_be(NamedPart::Toe));
    named.or(chain.first().copied())
}

/// The joint below one that turns and starts the longest chain.
fn longest_below(tree: &SkeletonTree, joint: usize) -> Option<usize> {
    let reach = |j: usize| tree.lengths[j] + tree.heights[j];
    tree.role_children(joint).filter(|&j| tree.turns(j)).max_by(|&a, &b| reach(a).total_cmp(&reach(b)).then(b.cmp(&a)))
}

/// The joint before an upper arm that carries the shoulder: by name, or else the one farthest from the arm.
fn clavicle(tree: &SkeletonTree, before: &[usize]) -> Option<usize> {
    let candidates = || before.iter().copied().filter(|&j| tree.is_candidate(j));
    candidates().find(|&j| tree.labels[j].may_be(NamedPart::Clavicle)).or(candidates().next())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::bvh;
    use std::path::Path;

    #[test]
    fn skeletons_of_many_alike_limbs_are_looked_at_in_part() {
        let limb = "JOINT a { OFFSET 0 1 0 CHANNELS 0 JOINT b { OFFSET 0 1 0 CHANNELS 0 End Site { OFFSET 0 1 0 } } }";
        let text = format!(
            "HIERARCHY ROOT r {{ OFFSET 0 0 0 CHANNELS 1 Xposition {0} JOINT s {{ OFFSET 0 1 0 CHANNELS 0 {0} }} }} MOTION \
             Frames: 1\nFrame Time: 0.1\n0\n",
            limb.repeat(30)
        );
        let clip = bvh::parse(text.as_bytes(), Path::new("a.bvh")).unwrap().clip;
        let tree = SkeletonTree::new(&clip);
        for (a, b) in (0..clip.joints.len()).flat_map(|a| [(a, 0), (0, a), (a, a / 2), (a / 2, a), (a, a)]) {
            assert_eq!(tree.is_above(a, b), tree.path_up(b).any(|j| j == a), "{a} {b}");
        }
        let pairs = limbs::pairs(&tree);
        assert!(pairs.len() > 2 * MAX_PAIRS, "{}", pairs.len());
        let longest = pairs.iter().map(|p| p.leg.length).fold(0.0, f32::max);
        let likeliest = likeliest(&pairs, |p| &p.leg, longest);
        assert_eq!(likeliest.len(), MAX_PAIRS);
        assert!(likeliest.is_sorted_by_key(|p| (p.parent, p.first)));
        assert!(recognise(&tree).is_err());
    }
}
