//! Update of the component after a change, which searches only the affected part.
//!
//! Unchanged cells of the component still belong to it if each path through the changed instances has a bypass, which
//! is searched nearby. Then the membership of the changed instances follows from their edges to and from the component.

use super::component_cells::ComponentCells;
use super::joined::JoinedGraph;
use super::reach::{ReachSearch, ReachedNodes, SearchDirection};
use crate::stitch::sets::rows::set_bits;
use throng_core::patch::NONE;

/// Numbers of rings of instances around the changed ones that are updated, and of further rings in which bypasses are
/// searched; tried in turn until one succeeds.
const RINGS: [[usize; 2]; 3] = [[1, 2], [2, 4], [4, 8]];
/// Reciprocal of the share of all instances above which the bypass search is given up for a full search.
const SHARE: usize = 2;

/// The world before a change.
pub(in crate::stitch) struct PriorGraph<'b> {
    /// Its graph.
    pub joined: &'b JoinedGraph,
    /// Membership of its cells in the component.
    pub component: &'b ComponentCells,
    /// Previous number of each instance of the changed world; [`NONE`] for new ones and those with changed
    /// surroundings.
    pub previous_of: Vec<u32>,
}

impl PriorGraph<'_> {
    /// Moves the nodes of unchanged instances to their new numbers.
    fn renumbered(&self, graph: &JoinedGraph, nodes: &ReachedNodes) -> ReachedNodes {
        let mut out = ReachedNodes::empty(graph.num_words);
        for (part, same) in (0u32..).zip(&self.previous_of).filter(|(_, same)| **same != NONE) {
            let (from, to) = (self.joined.words(*same), graph.words(part));
            out.moved[to.clone()].copy_from_slice(&nodes.moved[from.clone()]);
            out.joined[to].copy_from_slice(&nodes.joined[from]);
        }
        out
    }
}

/// Membership of the cells of a changed world; `None` if a full search is needed.
pub(in crate::stitch) fn update_component(before: &PriorGraph<'_>, graph: &JoinedGraph) -> Option<ComponentCells> {
    let mut region = ChangedRegion::of_changed(before);
    let inside = &before.component.from.intersection(&before.component.to);
    let mut rings = 0;
    for [near, beyond] in RINGS {
        (rings..near).for_each(|_| region.grow_ring(before, graph));
        rings = near;
        let mut around = region.clone();
        (0..beyond).for_each(|_| around.grow_ring(before, graph));
        if around.after.iter().filter(|is_in| **is_in).count() * SHARE > graph.parts.len() {
            return None;
        }
        let apart = around.independent_parts(before, graph);
        if apart.iter().all(|around| is_bypassed(before, graph, inside, &region.intersection(around), around)) {
            let search = |direction| derive_reached(before, graph, inside, &region, direction);
            let (from, to) = rayon::join(|| search(SearchDirection::Forth), || search(SearchDirection::Back));
            let component = ComponentCells::new(from, to);
            return component.is_largest(graph).then_some(component);
        }
    }
    None
}

/// A set of instances by their numbers before and after the change: unchanged ones are in both.
#[derive(Clone)]
struct ChangedRegion {
    before: Vec<bool>,
    after: Vec<bool>,
}

impl ChangedRegion {
    /// The set of changed instances.
    fn of_changed(before: &PriorGraph<'_>) -> Self {
        let mut out = Self {
            before: vec![true; before.joined.parts.len()],
            after: before.previous_of.iter().map(|&same| same == NONE).collect(),
        };
        let left = before.previous_of.iter().filter(|same| **same != NONE);
        left.for_each(|&same| out.before[same as usize] = false);
        out
    }

    /// Adds the adjacent instances.
    fn grow_ring(&mut self, before: &PriorGraph<'_>, graph: &JoinedGraph) {
        add_adjacent(before.joined, &mut self.before);
        add_adjacent(graph, &mut self.after);
        for (after, &same) in self.after.iter_mut().zip(&before.previous_of).filter(|(_, same)| **same != NONE) {
            let either = *after || self.before[same as usize];
            (*after, self.before[same as usize]) = (either, either);
        }
    }

    /// Splits the set into independent parts: each contains all neighbours of its instances.
    fn independent_parts(&self, before: &PriorGraph<'_>, graph: &JoinedGraph) -> Vec<Self> {
        let mut now = vec![NONE; self.before.len()];
        (0u32..).zip(&before.previous_of).filter(|(_, s)| **s != NONE).for_each(|(i, &s)| now[s as usize] = i);
        let mut left = self.clone();
        let mut out = Vec::new();
        while let Some(first) = left.any_instance() {
            let mut part = Self { before: vec![false; left.before.len()], after: vec![false; left.after.len()] };
            let mut open = vec![first];
            while let Some(instance) = open.pop() {
                let (mine, all) = match instance {
                    NumberedInstance::Before(i) => (&mut part.before[i as usize], &mut left.before[i as usize]),
                    NumberedInstance::After(i) => (&mut part.after[i as usize], &mut left.after[i as usize]),
                };
                if !std::mem::take(all) {
                    continue;
                }
                *mine = true;
                match instance {
                    NumberedInstance::Before(i) => {
                        open.extend(before.joined.adjacent(i).map(NumberedInstance::Before));
                        open.extend((now[i as usize] != NONE).then_some(NumberedInstance::After(now[i as usize])));
                    }
                    NumberedInstance::After(i) => {
                        open.extend(graph.adjacent(i).map(NumberedInstance::After));
                        let same = before.previous_of[i as usize];
                        open.extend((same != NONE).then_some(NumberedInstance::Before(same)));
                    }
                }
            }
            out.push(part);
        }
        out
    }

    /// Any instance of it.
    fn any_instance(&self) -> Option<NumberedInstance> {
        let before = marked_numbers(&self.before).next().map(NumberedInstance::Before);
        before.or_else(|| marked_numbers(&self.after).next().map(NumberedInstance::After))
    }

    /// Intersection with another set.
    fn intersection(&self, other: &Self) -> Self {
        let both = |a: &[bool], b: &[bool]| a.iter().zip(b).map(|(a, b)| *a && *b).collect();
        Self { before: both(&self.before, &other.before), after: both(&self.after, &other.after) }
    }
}

/// An instance by its number before or after the change.
#[derive(Clone, Copy, Debug)]
enum NumberedInstance {
    Before(u32),
    After(u32),
}

fn add_adjacent(graph: &JoinedGraph, parts: &mut [bool]) {
    for part in marked_numbers(parts).collect::<Vec<_>>() {
        graph.adjacent(part).for_each(|other| parts[other as usize] = true);
    }
}

fn marked_numbers(parts: &[bool]) -> impl Iterator<Item = u32> {
    (0u32..).zip(parts).filter(|(_, is_in)| **is_in).map(|(part, _)| part)
}

/// True if the component outside of a region is still connected.
///
/// Each node that led into the region must have a path to all nodes that the region led to; one search from one of them
/// shows it.
///
/// - `inside`: nodes of the component.
/// - `around`: region in which paths are searched; contains all neighbours of `region`.
fn is_bypassed(
    before: &PriorGraph<'_>,
    graph: &JoinedGraph,
    inside: &ReachedNodes,
    region: &ChangedRegion,
    around: &ChangedRegion,
) -> bool {
    // Nodes outside of the region that lead into it, or that it leads to. Changed instances are in the region.
    let border = |direction| {
        let mut search = ReachSearch::new(before.joined, direction);
        search.within = Some(&region.before);
        marked_numbers(&region.before).for_each(|part| seed(&mut search, part, inside));
        let found = search.run().intersection(inside);
        let outside = marked_numbers(&around.after).filter(|&part| !region.after[part as usize]);
        let nodes = |part: u32| {
            let words = before.joined.words(before.previous_of[part as usize]);
            (part, [found.moved[words.clone()].to_vec(), found.joined[words].to_vec()])
        };
        let parts = outside.map(nodes).filter(|(_, nodes)| nodes.iter().flatten().any(|word| *word != 0));
        RegionBorder { parts: parts.collect() }
    };
    let (into, out_of) = rayon::join(|| border(SearchDirection::Back), || border(SearchDirection::Forth));
    if into.parts.is_empty() || out_of.parts.is_empty() {
        return true;
    }
    let Some((part, cell)) = out_of.first_node().or_else(|| into.first_node()) else { return false };
    let leads = |direction, to: &RegionBorder| {
        let mut search = ReachSearch::new(graph, direction);
        search.within = Some(&around.after);
        search.start(part, cell);
        to.is_found(search)
    };
    let (forth, back) = rayon::join(|| leads(SearchDirection::Forth, &out_of), || leads(SearchDirection::Back, &into));
    forth && back
}

/// Nodes of the component outside of a region that lead into it, or that it leads to.
struct RegionBorder {
    /// Instances by their number after the change, with the words of their cells reached by motion, and by joints.
    parts: Vec<(u32, [Vec<u64>; 2])>,
}

impl RegionBorder {
    /// First instance and cell reached by motion.
    fn first_node(&self) -> Option<(u32, u32)> {
        self.parts.iter().find_map(|(part, [moved, _])| {
            let mut words = (0u32..).zip(moved);
            words.find_map(|(k, &word)| set_bits(word).next().map(|bit| (*part, 64 * k + bit)))
        })
    }

    /// True if a search finds the whole border; it stops as soon as that is the case.
    fn is_found(&self, mut search: ReachSearch<'_>) -> bool {
        let holds = |a: &[u64], b: &[u64]| a.iter().zip(b).all(|(a, b)| b & !a == 0);
        self.parts.iter().all(|(part, [moved, joined])| {
            let words = search.graph.words(*part);
            let is_there = |found: &ReachedNodes| {
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
fn derive_reached(
    before: &PriorGraph<'_>,
    graph: &JoinedGraph,
    inside: &ReachedNodes,
    region: &ChangedRegion,
    direction: SearchDirection,
) -> ReachedNodes {
    let reached = match direction {
        SearchDirection::Forth => &before.component.from,
        SearchDirection::Back => &before.component.to,
    };
    // Nodes outside of the component may have been reached through the region only.
    let mut search = ReachSearch::new(before.joined, direction);
    search.done = inside.clone();
    for part in marked_numbers(&region.before) {
        clear(&mut search.done, before.joined.words(part));
        seed(&mut search, part, reached);
    }
    let doubtful = search.run();
    let left = |reached: &[u64], doubtful: &[u64], inside: &[u64]| {
        let words = reached.iter().zip(doubtful).zip(inside);
        words.map(|((reached, doubtful), inside)| reached & (inside | !doubtful)).collect()
    };
    let mut kept = ReachedNodes {
        moved: left(&reached.moved, &doubtful.moved, &inside.moved),
        joined: left(&reached.joined, &doubtful.joined, &inside.joined),
    };
    let mut again = region.after.clone();
    for (part, &same) in (0u32..).zip(&before.previous_of).filter(|(_, same)| **same != NONE) {
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
    let mut search = ReachSearch::new(graph, direction);
    search.found = before.renumbered(graph, &kept);
    search.done = search.found.clone();
    add_adjacent(graph, &mut again);
    for part in marked_numbers(&again) {
        clear(&mut search.done, graph.words(part));
        search.queue_instance(part);
    }
    search.run()
}

fn seed(search: &mut ReachSearch<'_>, part: u32, nodes: &ReachedNodes) {
    let words = search.graph.words(part);
    search.found.moved[words.clone()].copy_from_slice(&nodes.moved[words.clone()]);
    search.found.joined[words.clone()].copy_from_slice(&nodes.joined[words]);
    search.queue_instance(part);
}

fn clear(nodes: &mut ReachedNodes, words: std::ops::Range<usize>) {
    nodes.moved[words.clone()].fill(0);
    nodes.joined[words].fill(0);
}

#[cfg(test)]
mod tests;
