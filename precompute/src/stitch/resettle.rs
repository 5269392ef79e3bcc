//! What a change makes of the component: only what the change may have touched is searched.
//!
//! All that stays as it was and belonged to the component still does where what led through the changed instances has
//! a way around them. That is looked for near by; then what the changed instances now are follows from what they lead
//! to, and where they are led to from.

use super::joined::Joined;
use super::reach::{Direction, Reached, Search};
use super::rows::ones;
use super::settled::Settled;
use throng_runtime::patch::NONE;

/// How many instances around the changed ones are settled anew, and how many more around those ways may lead; one after
/// the other, until one does.
const RINGS: [[usize; 2]; 3] = [[1, 2], [2, 4], [4, 8]];
/// Of worlds in which ways would lead through more of all instances than one in this many, all is searched.
const SHARE: usize = 2;

/// A world before it was changed.
pub(super) struct Before<'b, 'a> {
    /// Its graph.
    pub joined: &'b Joined<'a>,
    /// What its cells were to the component.
    pub settled: &'b Settled,
    /// The number that each instance of the changed world had before; [`NONE`] for those that are new or have
    /// something else around them.
    pub same: Vec<u32>,
}

impl Before<'_, '_> {
    /// Moves what belongs to instances that are left to their new numbers.
    fn renumbered(&self, graph: &Joined<'_>, nodes: &Reached) -> Reached {
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
pub(super) fn resettle(before: &Before<'_, '_>, graph: &Joined<'_>) -> Option<Settled> {
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
        if is_bypassed(before, graph, &inside, &region, &around) {
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
    fn changed(before: &Before<'_, '_>) -> Self {
        let mut out = Self {
            before: vec![true; before.joined.parts.len()],
            after: before.same.iter().map(|&same| same == NONE).collect(),
        };
        let left = before.same.iter().filter(|same| **same != NONE);
        left.for_each(|&same| out.before[same as usize] = false);
        out
    }

    /// Adds the instances around it.
    fn grow(&mut self, before: &Before<'_, '_>, graph: &Joined<'_>) {
        add_adjacent(before.joined, &mut self.before);
        add_adjacent(graph, &mut self.after);
        for (after, &same) in self.after.iter_mut().zip(&before.same).filter(|(_, same)| **same != NONE) {
            let either = *after || self.before[same as usize];
            (*after, self.before[same as usize]) = (either, either);
        }
    }

    fn num_after(&self) -> usize {
        self.after.iter().filter(|is_in| **is_in).count()
    }
}

fn add_adjacent(graph: &Joined<'_>, parts: &mut [bool]) {
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
/// - `inside`: nodes that belonged to the component.
/// - `around`: where ways are looked for.
fn is_bypassed(
    before: &Before<'_, '_>,
    graph: &Joined<'_>,
    inside: &Reached,
    region: &Region,
    around: &Region,
) -> bool {
    let border = |direction| {
        let mut search = Search::new(before.joined, direction);
        search.within = Some(&region.before);
        for part in marked(&region.before) {
            seed(&mut search, before.joined, part, inside);
        }
        let mut found = search.run().and(inside);
        for part in marked(&region.before) {
            clear(&mut found, before.joined.words(part));
        }
        before.renumbered(graph, &found)
    };
    let (into, out_of) = rayon::join(|| border(Direction::Back), || border(Direction::Forth));
    if into.is_empty() || out_of.is_empty() {
        return true;
    }
    let Some((part, cell)) = first(graph, around, &out_of).or_else(|| first(graph, around, &into)) else {
        return false;
    };
    let leads = |direction, to: &Reached| {
        let mut search = Search::new(graph, direction);
        search.within = Some(&around.after);
        search.start(part, cell);
        search.run().holds(to)
    };
    let (forth, back) = rayon::join(|| leads(Direction::Forth, &out_of), || leads(Direction::Back, &into));
    forth && back
}

/// The first instance and cell come to by motion.
fn first(graph: &Joined<'_>, around: &Region, nodes: &Reached) -> Option<(u32, u32)> {
    marked(&around.after).find_map(|part| {
        let mut words = (0u32..).zip(&nodes.moved[graph.words(part)]);
        words.find_map(|(k, &word)| ones(word).next().map(|bit| (part, 64 * k + bit)))
    })
}

/// All that is reached from the component, or leads to it.
///
/// - `inside`: nodes that belonged to it; those outside of the region still do.
fn derive(
    before: &Before<'_, '_>,
    graph: &Joined<'_>,
    inside: &Reached,
    region: &Region,
    direction: Direction,
) -> Reached {
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

fn seed(search: &mut Search<'_, '_>, graph: &Joined<'_>, part: u32, nodes: &Reached) {
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
