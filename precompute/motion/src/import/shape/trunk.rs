//! Hips, spine, neck and head: the joints between the legs and the arms, and the chain that goes on from there.

use super::{RecognisedBody, RoleMap, limbs::MirroredChains, names::NamedPart, tree::SkeletonTree};
use glam::Vec3;
use throng_core::Joint::{Chest, Head, Hips, Neck, Spine, UpperChest};

/// Largest distance of the head joint along neck joints from where the arms meet, as a share of a leg: joints beyond are hats
/// and hair.
const MAX_NECK: f32 = 0.47;

/// Sets the roles of the trunk. The hips are the joint where the legs meet: its turns move the legs.
pub fn set_trunk_roles(tree: &SkeletonTree, body: &RecognisedBody, map: &mut RoleMap) {
    map.joints[Hips.index()] = Some(body.hips);
    let mut spine = spine(tree, body);
    let neck_carries_arms = tree.labels[body.chest].may_be(NamedPart::Neck) && spine.last() == Some(&body.chest);
    if neck_carries_arms {
        spine.pop();
    }
    match spine.as_slice() {
        [] => {}
        [only] => map.joints[UpperChest.index()] = Some(*only),
        [first, middle @ .., last] => {
            map.joints[Spine.index()] = Some(*first);
            map.joints[Chest.index()] = halfway(tree, *first, middle, *last);
            map.joints[UpperChest.index()] = Some(*last);
        }
    }
    let chain = head_chain(tree, body.chest, &body.arms.paths, body.hips);
    let head = head(tree, &chain, body.legs.length);
    let before: Vec<usize> = chain.iter().copied().take_while(|&j| Some(j) != head).collect();
    let named = before.iter().copied().find(|&j| tree.labels[j].may_be(NamedPart::Neck));
    map.joints[Head.index()] = head;
    map.joints[Neck.index()] = if neck_carries_arms { Some(body.chest) } else { named.or(before.first().copied()) };
    if head.is_some_and(|h| tree.labels[h].may_be(NamedPart::Neck)) && map.get(Neck).is_none() {
        (map.joints[Neck.index()], map.joints[Head.index()]) = (head, None);
    }
}

/// The joint nearest to halfway between the first and the last of a spine, the lower one of two as near.
fn halfway(tree: &SkeletonTree, first: usize, middle: &[usize], last: usize) -> Option<usize> {
    let along = |j: usize| tree.path_up(j).take_while(|&k| k != first).map(|k| tree.lengths[k]).sum::<f32>();
    let off = |j: usize| (along(j) - 0.49 * along(last)).abs();
    middle.iter().copied().min_by(|&a, &b| off(a).total_cmp(&off(b)))
}

/// Joints above the hips up to where the arms meet, lowest first.
fn spine(tree: &SkeletonTree, body: &RecognisedBody) -> Vec<usize> {
    let below = tree.common_ancestor(body.hips, body.chest);
    let mut spine: Vec<usize> =
        tree.path_up(body.chest).take_while(|&j| Some(j) != below).filter(|&j| tree.is_candidate(j)).collect();
    spine.reverse();
    spine
}

/// True where a chain goes on from where a pair of arms meets, away from the legs.
///
/// - `necks`: joints that may start it, from [`necks`].
pub fn has_head(tree: &SkeletonTree, arms: &MirroredChains, necks: &[usize]) -> bool {
    let start = necks.iter().copied().find(|j| !arms.first.contains(j));
    start.is_some_and(|start| neck_chain(tree, arms.parent, start).next().is_some())
}

/// The chain of joints from where the arms meet to the head, and beyond it.
fn head_chain(tree: &SkeletonTree, chest: usize, arms: &[Vec<usize>; 2], hips: usize) -> Vec<usize> {
    let start = necks(tree, chest, hips).into_iter().find(|j| !arms.iter().any(|arm| arm.contains(j)));
    start.map_or_else(Vec::new, |start| neck_chain(tree, chest, start).collect())
}

/// The joints that a neck may start with, the best first.
pub fn necks(tree: &SkeletonTree, chest: usize, hips: usize) -> Vec<usize> {
    let above = tree.role_children(chest).filter(|&j| tree.turns(j) && !tree.is_above(j, hips));
    let scored = above.map(|j| (j, head_score(tree, chest, hips, j)));
    let mut all: Vec<(usize, f32)> = scored.filter(|(_, score)| *score > 0.0).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    all.into_iter().map(|(j, _)| j).collect()
}

/// The chain of joints that a neck starts.
fn neck_chain<'a>(tree: &'a SkeletonTree, chest: usize, start: usize) -> impl Iterator<Item = usize> + 'a {
    let reach = move |j: usize| {
        let named = tree.labels[j].may_be(NamedPart::Neck) || tree.labels[j].may_be(NamedPart::Head);
        tree.lengths[j] + tree.heights[j] + if named { tree.heights[chest] } else { 0.0 }
    };
    let farther = move |a: &usize, b: &usize| reach(*a).total_cmp(&reach(*b)).then(b.cmp(a));
    let next = move |j: &usize| tree.role_children(*j).filter(|&c| tree.turns(c)).max_by(|a, b| farther(a, b));
    std::iter::successors(Some(start), next).filter(|&j| tree.is_candidate(j))
}

/// Score of a joint as the start of the neck: it goes on where the trunk points, and is named so.
fn head_score(tree: &SkeletonTree, chest: usize, hips: usize, joint: usize) -> f32 {
    let of = |frame: &[Vec3]| {
        let up = (frame[chest] - frame[hips]).try_normalize()?;
        let to = if tree.lengths[joint] > 0.0 { joint } else { *tree.children[joint].first()? };
        Some((frame[to] - frame[chest]).try_normalize()?.dot(up))
    };
    let label = tree.labels[joint];
    let named = label.may_be(NamedPart::Neck) || label.may_be(NamedPart::Head);
    let sided = label.side.is_some();
    tree.mean(of).unwrap_or(0.0).max(if named { 0.1 } else { -1.0 }) + if named { 2.0 } else { 0.0 }
        - if sided { 1.0 } else { 0.0 }
}

/// The head of the chain: by name, or else the last joint that is near enough to where the arms meet.
fn head(tree: &SkeletonTree, chain: &[usize], leg: f32) -> Option<usize> {
    let called = |exact: bool| {
        let is = |j: &usize| tree.labels[*j].may_be(NamedPart::Head) && (tree.labels[*j].exact || !exact);
        chain.iter().copied().find(is)
    };
    if let Some(named) = called(true).or_else(|| called(false)) {
        return Some(named);
    }
    let mut along = 0.0;
    let near = chain.iter().copied().take_while(|&j| {
        along += tree.lengths[j];
        along <= MAX_NECK * leg
    });
    // A joint that others hang on side by side is a head with a face.
    let near: Vec<usize> = near.collect();
    let face = near.iter().copied().find(|&j| tree.children[j].len() > 2);
    face.or(near.last().copied()).or(chain.first().copied())
}
