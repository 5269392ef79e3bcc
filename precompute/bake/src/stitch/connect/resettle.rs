//! What a change makes of the component: only what the change may have touched is searched.
//!
//! All that stays as it was and belonged to the component still does where what led through the changed instances has
//! a way around them. That is looked for near by; then what the changed instances now are follows from what they lead
//! to, and where they are led to from.

use super::joined::Joined;
use super::reach::{Direction, Reached, Search};
use super::settled::Settled;
use crate::stitch::sets::rows::ones;
use throng_core::patch::NONE;

/// How many instances around the changed ones are settled anew, and how many more around those ways may lead; one after
/// the other, until one does.
const RINGS: [[usize; 2]; 3] = [[1, 2], [2, 4], [4, 8]];
/// Of worlds in which ways would lead through more of all instances than one in this many, all is searched.
const SHARE: usize = 2;

/// A world before it was changed.
pub(in crate::stitch) struct Before<'b> {
    /// Its graph.
    pub joined: &'b Joined,
    /// What its cells were to the component.
    pub settled: &'b Settled,
    /// The number that each instance of the changed world had before; [`NONE`] for those that are new or have
    /// something else around them.
    pub same: Vec<u32>,
}

impl Before<'_> {
    /// Moves what belongs to instances that are left to their new numbers.
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

/// What every cell of a changed world is; none where everything has to be searched to tell.
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

/// Instances by their numbers before and after the change: those that are in it and not new are in both.
#[derive(Clone)]
struct Region {
    before: Vec<bool>,
    after: Vec<bool>,
}

impl Region {
    /// What is not the same any more.
    fn changed(before: &Before<'_>) -> Self {
        let mut out = Self {
            before: vec![true; before.joined.parts.len()],
            after: before.same.iter().map(|&same| same == NONE).collect(),
        };
        let left = before.same.iter().filter(|same| **same != NONE);
        left.for_each(|&same| out.before[same as usize] = false);
        out
    }

    /// Adds the instances around it.
    fn grow(&mut self, before: &Before<'_>, graph: &Joined) {
        add_adjacent(before.joined, &mut self.before);
        add_adjacent(graph, &mut self.after);
        for (after, &same) in self.after.iter_mut().zip(&before.same).filter(|(_, same)| **same != NONE) {
            let either = *after || self.before[same as usize];
            (*after, self.before[same as usize]) = (either, either);
        }
    }

    /// Parts of it that have nothing to do with each other: each holds all that is next to what it holds.
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

    /// What of it is in another.
    fn within(&self, other: &Self) -> Self {
        let both = |a: &[bool], b: &[bool]| a.iter().zip(b).map(|(a, b)| *a && *b).collect();
        Self { before: both(&self.before, &other.before), after: both(&self.after, &other.after) }
    }

    fn num_after(&self) -> usize {
        self.after.iter().filter(|is_in| **is_in).count()
    }
}

/// An instance by its number before the change, or by that after it.
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

/// True where what belonged to the component outside of a region is still connected.
///
/// From all nodes that led into the region to all that it led to there is a way by one of them.
/// - `around`: where ways are looked for; all that is next to the region is in it.
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
    /// Instances by their number after the change, with the words of their cells come to by motion, and by joints.
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
        // What is not the same any more is in the region.
        let outside = marked(&around.after).filter(|&part| !region.after[part as usize]);
        let parts = outside.map(|part| (part, nodes(part)));
        Self { parts: parts.filter(|(_, nodes)| nodes.iter().flatten().any(|word| *word != 0)).collect() }
    }

    /// The first instance and cell come to by motion.
    fn first(&self) -> Option<(u32, u32)> {
        self.parts.iter().find_map(|(part, [moved, _])| {
            let mut words = (0u32..).zip(moved);
            words.find_map(|(k, &word)| ones(word).next().map(|bit| (*part, 64 * k + bit)))
        })
    }

    /// True where a search finds all of it; it ends as soon as it has.
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

/// All that is reached from the component, or leads to it.
///
/// - `inside`: nodes that belonged to it; those outside of the region still do.
fn derive(before: &Before<'_>, graph: &Joined, inside: &Reached, region: &Region, direction: Direction) -> Reached {
    let reached = match direction {
        Direction::Forth => &before.settled.from,
        Direction::Back => &before.settled.to,
    };
    // What does not belong to the component may have been reached by way of the region alone.
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
    // What is kept and leads to what is not has to be followed again.
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
