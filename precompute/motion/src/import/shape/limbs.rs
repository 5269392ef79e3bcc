//! Pairs of limbs: chains of equal lengths that hang on one joint, and the places of the limb's three joints on them.

use super::names::NamedPart::{self, Foot, Forearm, Hand, Shin, Thigh, UpperArm};
use super::{names::Label, tree::SkeletonTree};
use crate::side::LateralSide;
use std::collections::HashSet;

/// Largest difference of segments of a left and a right limb (share).
const MAX_ASYMMETRY: f32 = 0.22;
/// Depth of the deepest chain that is searched.
const MAX_DEPTH: usize = 14;
/// Most branches of a joint that are compared, the longest first.
const MAX_BRANCHES: usize = 48;
/// Length of a pair, as a share of the longest pair's, below which it is no arms or legs.
const MIN_SHARE: f32 = 0.3;
/// Factor on the score of a segment for a joint in its middle.
const BETWEEN: f32 = 0.65;
/// Factor on the score of a hand or foot that is the end of a chain, not a joint.
const END: f32 = 0.8;
/// Least ratio of the upper and lower segment of a limb, and of one whose joints are all named as its parts.
const MIN_RATIO: f32 = 0.4;
const MIN_NAMED_RATIO: f32 = 0.15;
/// Factor on the score of a limb whose joints are all named as its parts: drawn figures have forearms of any length.
const NAMED: f32 = 3.0;

/// The three joints of a limb on both sides: `[upper, middle, end][side]`, sides in the order of the file.
#[derive(Clone, Debug)]
pub struct LimbPair {
    /// Joints from the first one below the meeting to the limb's end.
    pub paths: [Vec<usize>; 2],
    /// Places on the path at which the upper segment starts, the limb bends, and the lower segment ends.
    pub joint_places: [usize; 3],
    /// Length of upper and lower segment.
    pub length: f32,
    /// Score as a limb: length, weighted by the equality of its segments and by names.
    pub score: f32,
    /// Agreement of the names: 1 for all, negative where they contradict.
    pub names: f32,
}

impl LimbPair {
    /// The joint of a part (0 upper, 1 middle, 2 end) on a side of the file.
    pub fn joint(&self, part: usize, side: usize) -> usize {
        self.paths[side][self.joint_places[part]]
    }

    /// The side that the names give to the first of the two, where they agree.
    pub fn named_side(&self, tree: &SkeletonTree) -> Option<LateralSide> {
        let vote = |joint: usize| tree.labels[joint].side.map_or(0.0, LateralSide::sign);
        let votes = |side: usize| -> f64 { (0..3).map(|part| vote(self.joint(part, side))).sum() };
        let more = votes(0) - votes(1);
        (more.abs() >= 2.0).then(|| LateralSide::inside(more))
    }
}

/// Two chains that mirror each other: candidates for a pair of legs, and for a pair of arms.
#[derive(Clone, Debug)]
pub struct MirroredChains {
    /// The joint that both hang on.
    pub parent: usize,
    /// The first joints of the two.
    pub first: [usize; 2],
    pub leg: LimbPair,
    pub arm: LimbPair,
}

/// All pairs of limbs of a skeleton, none much shorter than the longest.
pub fn pairs(tree: &SkeletonTree) -> Vec<MirroredChains> {
    let mut all = Vec::new();
    for parent in 0..tree.children.len() {
        let mut below: Vec<usize> = tree.role_children(parent).filter(|&c| tree.heights[c] > 0.0).collect();
        below.sort_by(|&a, &b| tree.heights[b].total_cmp(&tree.heights[a]));
        below.truncate(MAX_BRANCHES);
        below.sort_unstable();
        for (i, &a) in below.iter().enumerate() {
            for &b in &below[i + 1..] {
                all.extend(pair(tree, parent, a, b));
            }
        }
    }
    let longest = all.iter().map(|p| p.leg.length).fold(0.0, f32::max);
    all.retain(|p| p.leg.length.max(p.arm.length) >= MIN_SHARE * longest);
    all
}

fn pair(tree: &SkeletonTree, parent: usize, a: usize, b: usize) -> Option<MirroredChains> {
    if !are_alike(tree, a, b) {
        return None;
    }
    let mut paths = Vec::new();
    walk_chains(tree, &mut vec![[a, b]], &mut paths);
    let best = |parts: [NamedPart; 3]| {
        let limbs = paths.iter().filter_map(|path| limb(tree, path, parts));
        limbs.max_by(|x, y| x.score.total_cmp(&y.score))
    };
    // Limbs that only their names make legs are no arms, and the other way round.
    let weaker = |limb: &LimbPair| LimbPair { score: 0.1 * limb.score, names: -0.5, ..limb.clone() };
    let (leg, arm) = match (best([Thigh, Shin, Foot]), best([UpperArm, Forearm, Hand])) {
        (Some(leg), Some(arm)) => (leg, arm),
        (Some(leg), None) => (leg.clone(), weaker(&leg)),
        (None, arm) => (weaker(arm.as_ref()?), arm?),
    };
    Some(MirroredChains { parent, first: [a, b], leg, arm })
}

/// True where two joints are equally far from their parents; those that are named left and right may differ by more.
fn are_alike(tree: &SkeletonTree, a: usize, b: usize) -> bool {
    let (x, y) = (tree.lengths[a], tree.lengths[b]);
    let size = tree.heights[a].max(tree.heights[b]) + x.max(y);
    let named = tree.labels[a].side.is_some_and(|s| tree.labels[b].side == Some(s.other()));
    let slack = if named { 2.0 } else { 1.0 };
    (x - y).abs() <= slack * (MAX_ASYMMETRY * x.max(y) + 0.02 * size)
}

/// Collects all paths down two chains at once, as far as they are alike.
fn walk_chains(tree: &SkeletonTree, path: &mut Vec<[usize; 2]>, out: &mut Vec<Vec<[usize; 2]>>) {
    let [a, b] = path[path.len() - 1];
    let matched = if path.len() < MAX_DEPTH { match_children(tree, a, b) } else { Vec::new() };
    if matched.is_empty() {
        out.push(path.clone());
    }
    for next in matched {
        path.push(next);
        walk_chains(tree, path, out);
        path.pop();
    }
}

/// Children of two joints that mirror each other, each once, the most alike first.
fn match_children(tree: &SkeletonTree, a: usize, b: usize) -> Vec<[usize; 2]> {
    let mut all = Vec::new();
    for x in tree.role_children(a) {
        for y in tree.role_children(b).filter(|&y| are_alike(tree, x, y)) {
            let difference = (tree.lengths[x] - tree.lengths[y]).abs() + (tree.heights[x] - tree.heights[y]).abs();
            all.push((difference, [x, y]));
        }
    }
    all.sort_by(|x, y| x.0.total_cmp(&y.0));
    let mut taken = HashSet::<usize>::new();
    all.retain(|(_, both)| {
        let free = both.iter().all(|j| !taken.contains(j));
        taken.extend(both.iter().filter(|_| free));
        free
    });
    all.into_iter().map(|(_, both)| both).collect()
}

/// True where both joints of each part are named as it; the first two, with words that mean nothing else. Another joint that may
/// start the limb by its name does not hang on the first one: `Arm` above `Shoulder` is a collarbone.
fn is_named(tree: &SkeletonTree, path: &[[usize; 2]], at: [usize; 3], [upper, middle, end]: [NamedPart; 3]) -> bool {
    let all = |k: usize, is: &dyn Fn(Label) -> bool| path[k].iter().all(|&j| is(tree.labels[j]));
    let turns = path[at[2]].iter().all(|&j| tree.turns(j));
    let may_start = |l: Label| l.may_be(upper) && !l.is_exactly(upper) && !l.left_out;
    turns
        && !(at[0] + 1..at[1]).any(|k| all(k, &may_start))
        && all(at[0], &|l| l.is_exactly(upper))
        && all(at[1], &|l| l.is_exactly(middle))
        && all(at[2], &|l| l.may_be(end))
}

/// The three joints of a limb on one path down.
fn limb(tree: &SkeletonTree, path: &[[usize; 2]], parts: [NamedPart; 3]) -> Option<LimbPair> {
    let mut along = vec![0f32; path.len()];
    for k in 1..path.len() {
        along[k] = along[k - 1] + 0.5 * (tree.lengths[path[k][0]] + tree.lengths[path[k][1]]);
    }
    let turns = |k: usize| path[k].iter().all(|&j| tree.is_candidate(j));
    let ends = |k: usize| path[k].iter().all(|&j| tree.clip.joints[j].is_end || tree.is_candidate(j));
    let agreement =
        |k: usize, part: NamedPart| 0.5 * path[k].iter().map(|&j| tree.labels[j].agreement(part)).sum::<f32>();
    let mut best: Option<([usize; 3], f32, f32)> = None;
    for upper in (0..path.len()).rev().filter(|&k| turns(k)) {
        for middle in (upper + 1..path.len()).filter(|&k| turns(k)) {
            for end in (middle + 1..path.len()).filter(|&k| ends(k)) {
                let (first, second) = (along[middle] - along[upper], along[end] - along[middle]);
                let at = [upper, middle, end];
                let named = is_named(tree, path, at, parts);
                let ratio = first.min(second) / first.max(second);
                let (least, counted) = if named { (MIN_NAMED_RATIO, ratio.max(0.6)) } else { (MIN_RATIO, ratio) };
                if ratio.is_nan() || ratio < least {
                    continue;
                }
                let names = at.iter().zip(parts).map(|(&k, part)| agreement(k, part)).sum::<f32>() / 3.0;
                let between = (upper + 1..end).filter(|&k| k != middle && turns(k)).count() as i32;
                let whole = BETWEEN.powi(between) * if turns(end) { 1.0 } else { END };
                let whole = whole * if named { NAMED } else { 1.0 };
                let score = whole * counted * counted * (first + second) * (1.0 + 0.9 * names);
                if best.is_none_or(|(_, s, _)| score > s * 1.0001) {
                    best = Some((at, score, names));
                }
            }
        }
    }
    let (at, score, names) = best?;
    let paths = [0, 1].map(|side| path.iter().map(|p| p[side]).collect());
    Some(LimbPair { paths, joint_places: at, length: along[at[2]] - along[at[0]], score, names })
}
