//! Update of the component after a change, which searches only the affected part.
//!
//! Unchanged cells of the component still belong to it if each path through the changed instances has a bypass, which
//! is searched nearby. Then the membership of the changed instances follows from their edges to and from the component.

use super::joined::Joined;
use super::reach::{Direction, Reached, Search};
use super::settled::Settled;
use crate::stitch::sets::rows::ones;
use throng_core::patch::NONE;

/// Numbers of rings of instances around the changed ones that are updated, and of further rings in which bypasses are
/// searched; tried in turn until one succeeds.
const RINGS: [[usize; 2]; 3] = [[1, 2], [2, 4], [4, 8]];
/// Reciprocal of the share of all instances above which the bypass search is given up for a full search.
const SHARE: usize = 2;

/// The world before a change.
pub(in crate::stitch) struct Before<'b> {
    /// Its graph.
    pub joined: &'b Joined,
    /// Membership of its cells in the component.
    pub settled: &'b Settled,
    /// Previous number of each instance of the changed world; [`NONE`] for new ones and those with changed
    /// surroundings.
    pub same: Vec<u32>,
}

impl Before<'_> {
    /// Moves the nodes of unchanged instances to their new numbers.
    fn renumbered(&self, graph: &Joined, nodes: &Reached) -> Reached {
        let mut out = Reached::none(graph.num_words);
        for (part, same) in (0u32..).zip(&self.same).filter(|(_, same)| **same != NONE) {
            let (from, to) = (self.joined.words(*same), graph.words(part));
            out.moved[to.clone()].copy_from_slice(&nodes.moved[from.clone()]);
            out.joined[to].copy_from_slice(&nodes.joined[from]);
        }
        out
    }
}

/// Membership of the cells of a changed world; `None` if a full search is needed.
pub(in crate::stitch) fn resettle(before: &Before<'_>, graph: &Joined) -> Option<Settled> {
    let mut region = Region::changed(before);
    let inside = before.settled.from.and(&before.settled.to);
    let mut rings = 0;
    for [near, beyond] in RINGS {
        (rings..near).for_each(|_| region.grow(before, graph));
        rings = near;
        let mut around = region.clone();
        (0..beyond).for_each(|_| around.grow(before, graph));
        if around.num_after() * SHARE > graph.parts.len() {
            return None;
        }
        let apart = around.apart(before, graph);
        if apart.iter().all(|around| is_bypassed(before, graph, &region.within(around), around)) {
            let search = |direction| derive(before, graph, &inside, &region, direction);
            let (from, to) = rayon::join(|| search(Direction::Forth), || search(Direction::Back));
            let settled = Settled::new(from, to);
            return settled.is_largest(graph).then_some(settled);
        }
    }
    None
}

/// A set of instances by their numbers before and after the change: unchanged ones are in both.
#[derive(Clone)]
struct Region {
    before: Vec<bool>,
    after: Vec<bool>,
}

impl Region {
    /// The set of changed instances.
    fn changed(before: &Before<'_>) -> Self {
        let mut out = Self {
            before: vec![true; before.joined.parts.len()],
            after: before.same.iter().map(|&same| same == NONE).collect(),
        };
        let left = before.same.iter().filter(|same| **same != NONE);
        left.for_each(|&same| out.before[same as usize] = false);
        out
    }

    /// Adds the adjacent instances.
    fn grow(&mut self, before: &Before<'_>, graph: &Joined) {
        add_adjacent(before.joined, &mut self.before);
        add_adjacent(graph, &mut self.after);
        for (after, &same) in self.after.iter_mut().zip(&before.same).filter(|(_, same)| **same != NONE) {
            let either = *after || self.before[same as usize];
            (*after, self.before[same as usize]) = (either, either);
        }
    }

    /// Splits the set into independent parts: each contains all neighbours of its instances.
    fn apart(&self, before: &Before<'_>, graph: &Joined) -> Vec<Self> {
        let mut now = vec![NONE; self.before.len()];
        (0u32..).zip(&before.same).filter(|(_, s)| **s != NONE).for_each(|(i, &s)| now[s as usize] = i);
        let mut left = self.clone();
        let mut out = Vec::new();
        while let Some(first) = left.first() {
            let mut part = Self { before: vec![false; left.before.len()], after: vec![false; left.after.len()] };
            let mut open = vec![first];
            while let Some(instance) = open.pop() {
                let (mine, all) = match instance {
                    Instance::Before(i) => (&mut part.before[i as usize], &mut left.before[i as usize]),
                    Instance::After(i) => (&mut part.after[i as usize], &mut left.after[i as usize]),
                };
                if !std::mem::take(all) {
                    continue;
                }
                *mine = true;
                match instance {
                    Instance::Before(i) => {
                        open.extend(before.joined.adjacent(i).map(Instance::Before));
                        open.extend((now[i as usize] != NONE).then_some(Instance::After(now[i as usize])));
                    }
                    Instance::After(i) => {
                        open.extend(graph.adjacent(i).map(Instance::After));
                        let same = before.same[i as usize];
                        open.extend((same != NONE).then_some(Instance::Before(same)));
                    }
                }
            }
            out.push(part);
        }
        out
    }

    /// Any instance of it.
    fn first(&self) -> Option<Instance> {
        let before = marked(&self.before).next().map(Instance::Before);
        before.or_else(|| marked(&self.after).next().map(Instance::After))
    }

    /// Intersection with another set.
    fn within(&self, other: &Self) -> Self {
        let both = |a: &[bool], b: &[bool]| a.iter().zip(b).map(|(a, b)| *a && *b).collect();
        Self { before: both(&self.before, &other.before), after: both(&self.after, &other.after) }
    }

    fn num_after(&self) -> usize {
        self.after.iter().filter(|is_in| **is_in).count()
    }
}

/// An instance by its number before or after the change.
#[derive(Clone, Copy, Debug)]
enum Instance {
    Before(u32),
    After(u32),
}

fn add_adjacent(graph: &Joined, parts: &mut [bool]) {
    for part in marked(parts).collect::<Vec<_>>() {
        graph.adjacent(part).for_each(|other| parts[other as usize] = true);
    }
}

fn marked(parts: &[bool]) -> impl Iterator<Item = u32> {
    (0u32..).zip(parts).filter(|(_, is_in)| **is_in).map(|(part, _)| part)
}

/// True if the component outside of a region is still connected.
///
/// Each node that led into the region must have a path to all nodes that the region led to; one search from one of them
/// shows it.
///
/// - `around`: region in which paths are searched; contains all neighbours of `region`.
fn is_bypassed(before: &Before<'_>, graph: &Joined, region: &Region, around: &Region) -> bool {
    let search = |direction| Border::new(before, region, around, direction);
    let (into, out_of) = rayon::join(|| search(Direction::Back), || search(Direction::Forth));
    if into.parts.is_empty() || out_of.parts.is_empty() {
        return true;
    }
    let Some((part, cell)) = out_of.first().or_else(|| into.first()) else { return false };
    let leads = |direction, to: &Border| {
        let mut search = Search::new(graph, direction);
        search.within = Some(&around.after);
        search.start(part, cell);
        to.is_found(search)
    };
    let (forth, back) = rayon::join(|| leads(Direction::Forth, &out_of), || leads(Direction::Back, &into));
    forth && back
}

/// Nodes of the component outside of a region that lead into it, or that it leads to.
struct Border {
    /// Instances by their number after the change, with the words of their cells reached by motion, and by joints.
    parts: Vec<(u32, [Vec<u64>; 2])>,
}

impl Border {
    fn new(before: &Before<'_>, region: &Region, around: &Region, direction: Direction) -> Self {
        let Settled { from, to, .. } = before.settled;
        let both = |a: &[u64], b: &[u64]| a.iter().zip(b).map(|(a, b)| a & b).collect::<Vec<_>>();
        let mut search = Search::new(before.joined, direction);
        search.within = Some(&region.before);
        for part in marked(&region.before) {
            let words = before.joined.words(part);
            search.found.moved[words.clone()]
                .copy_from_slice(&both(&from.moved[words.clone()], &to.moved[words.clone()]));
            search.found.joined[words.clone()].copy_from_slice(&both(&from.joined[words.clone()], &to.joined[words]));
            search.open(part);
        }
        let found = search.run();
        let nodes = |part: u32| {
            let was = before.same[part as usize];
            let words = before.joined.words(was);
            let inside = |found: &[u64], from: &[u64], to: &[u64]| {
                both(&both(&found[words.clone()], &from[words.clone()]), &to[words.clone()])
            };
            [inside(&found.moved, &from.moved, &to.moved), inside(&found.joined, &from.joined, &to.joined)]
        };
        // Changed instances are in the region.
        let outside = marked(&around.after).filter(|&part| !region.after[part as usize]);
        let parts = outside.map(|part| (part, nodes(part)));
        Self { parts: parts.filter(|(_, nodes)| nodes.iter().flatten().any(|word| *word != 0)).collect() }
    }

    /// First instance and cell reached by motion.
    fn first(&self) -> Option<(u32, u32)> {
        self.parts.iter().find_map(|(part, [moved, _])| {
            let mut words = (0u32..).zip(moved);
            words.find_map(|(k, &word)| ones(word).next().map(|bit| (*part, 64 * k + bit)))
        })
    }

    /// True if a search finds the whole border; it stops as soon as that is the case.
    fn is_found(&self, mut search: Search<'_>) -> bool {
        let holds = |a: &[u64], b: &[u64]| a.iter().zip(b).all(|(a, b)| b & !a == 0);
        self.parts.iter().all(|(part, [moved, joined])| {
            let words = search.graph().words(*part);
            let is_there = |found: &Reached| {
                holds(&found.moved[words.clone()], moved) && holds(&found.joined[words.clone()], joined)
            };
            while !is_there(&search.found) {
                if !search.follow_next() {
                    return false;
                }
            }
            true
        })
    }
}

/// All nodes reachable from the component, or from which it is reachable.
///
/// - `inside`: nodes that belonged to it; those outside of the region still do.
fn derive(before: &Before<'_>, graph: &Joined, inside: &Reached, region: &Region, direction: Direction) -> Reached {
    let reached = match direction {
        Direction::Forth => &before.settled.from,
        Direction::Back => &before.settled.to,
    };
    // Nodes outside of the component may have been reached through the region only.
    let mut search = Search::new(before.joined, direction);
    search.done = inside.clone();
    for part in marked(&region.before) {
        clear(&mut search.done, before.joined.words(part));
        seed(&mut search, before.joined, part, reached);
    }
    let doubtful = search.run();
    let left = |reached: &[u64], doubtful: &[u64], inside: &[u64]| {
        let words = reached.iter().zip(doubtful).zip(inside);
        words.map(|((reached, doubtful), inside)| reached & (inside | !doubtful)).collect()
    };
    let mut kept = Reached {
        moved: left(&reached.moved, &doubtful.moved, &inside.moved),
        joined: left(&reached.joined, &doubtful.joined, &inside.joined),
    };
    let mut again = region.after.clone();
    for (part, &same) in (0u32..).zip(&before.same).filter(|(_, same)| **same != NONE) {
        let words = before.joined.words(same);
        if again[part as usize] {
            clear(&mut kept, words);
        } else {
            let is_less = kept.moved[words.clone()] != reached.moved[words.clone()]
                || kept.joined[words.clone()] != reached.joined[words];
            again[part as usize] = is_less;
        }
    }
    // Kept nodes that lead to others have to be followed again.
    let mut search = Search::new(graph, direction);
    search.found = before.renumbered(graph, &kept);
    search.done = search.found.clone();
    add_adjacent(graph, &mut again);
    for part in marked(&again) {
        clear(&mut search.done, graph.words(part));
        search.open(part);
    }
    search.run()
}

fn seed(search: &mut Search<'_>, graph: &Joined, part: u32, nodes: &Reached) {
    let words = graph.words(part);
    search.found.moved[words.clone()].copy_from_slice(&nodes.moved[words.clone()]);
    search.found.joined[words.clone()].copy_from_slice(&nodes.joined[words]);
    search.open(part);
}

fn clear(nodes: &mut Reached, words: std::ops::Range<usize>) {
    nodes.moved[words.clone()].fill(0);
    nodes.joined[words].fill(0);
}

#[cfg(test)]
mod tests;
