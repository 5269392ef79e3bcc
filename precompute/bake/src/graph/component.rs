//! The largest strongly connected component, without dead ends.

use super::matches::Link;

/// Event frames and the ways between them: after event i comes either `next[i]`, as the clip goes on, or
/// `next[l.event()]` for a link l.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EventGraph {
    /// The event the clip goes on to.
    pub next: Vec<Option<usize>>,
    /// Frames between the event before, exclusive, and this one: what an arrival plays.
    pub frames: Vec<u32>,
    /// What they are worth when components are compared: a metre travelled counts as much as a second (frames).
    pub worth: Vec<u32>,
    /// The chosen transitions of every event.
    pub links: Vec<Vec<Link>>,
}

impl EventGraph {
    /// True where the clip goes on from `i` to an event of the component.
    pub fn goes_on(&self, i: usize, alive: &[bool]) -> bool {
        self.next[i].is_some_and(|n| alive[n])
    }

    /// Events that may come after `i`.
    pub fn targets(&self, i: usize) -> impl Iterator<Item = usize> {
        (0..=self.links[i].len()).filter_map(move |way| self.target(i, way))
    }

    /// Where a way out of `i` leads: the clip's, for 0, or that of a link (way <= links[i].len()).
    fn target(&self, i: usize, way: usize) -> Option<usize> {
        self.next[if way == 0 { i } else { self.links[i][way - 1].event() }]
    }

    /// Drops every way out of or into events that are not in the component.
    pub fn restrict(&mut self, alive: &[bool]) {
        for i in 0..self.next.len() {
            let next = &self.next;
            self.links[i].retain(|l| alive[i] && next[l.event()].is_some_and(|n| alive[n]));
        }
    }

    /// Links of `i` that arrive in the component.
    pub fn jumps<'a>(&'a self, i: usize, alive: &'a [bool]) -> impl Iterator<Item = &'a Link> {
        self.links[i].iter().filter(|l| self.goes_on(l.event(), alive))
    }
}

/// Reduces the graph to its largest strongly connected component, measured in seconds and metres: much motion on the
/// spot is not kept in place of a little less that gets somewhere.
///
/// An event where the clip does not go on must have two links into the component; one with fewer is removed, and so is
/// an event that would be passed more than `most_frames` before the next choice. That is repeated until nothing
/// changes: every event of the result leads on, and every one of them to every other.
///
/// - returns which events are in the component; none may be.
pub(super) fn largest_component(graph: &EventGraph, most_frames: u32) -> Vec<bool> {
    let mut alive = vec![true; graph.next.len()];
    loop {
        alive = strongest(graph, &alive);
        let is_end = |i: usize| alive[i] && !graph.goes_on(i, &alive) && graph.jumps(i, &alive).count() < 2;
        let ends = (0..alive.len()).filter(|&i| is_end(i));
        let out: Vec<usize> = ends.chain(too_far_ahead(graph, &alive, most_frames)).collect();
        if out.is_empty() {
            return alive;
        }
        for i in out {
            alive[i] = false;
        }
    }
}

/// Events from whose predecessor it takes more than so many frames to the next one with a choice.
fn too_far_ahead(graph: &EventGraph, alive: &[bool], most_frames: u32) -> Vec<usize> {
    let ways = |i: usize| usize::from(graph.goes_on(i, alive)) + graph.jumps(i, alive).count();
    // Clips go forward: what follows an event has a greater number.
    let mut frames_left = vec![0u32; alive.len()];
    let mut out = Vec::new();
    for i in (0..alive.len()).rev() {
        let Some(n) = graph.next[i].filter(|&n| alive[n]) else { continue };
        let rest = if ways(n) > 1 { 0 } else { frames_left[n] };
        frames_left[i] = graph.frames[n].saturating_add(rest);
        if frames_left[i] > most_frames {
            out.push(n);
        }
    }
    out
}

/// Strongly connected components of the events alive, each ascending.
pub(super) fn components(graph: &EventGraph, alive: &[bool]) -> Vec<Vec<u32>> {
    let target = |i: usize, way: usize| graph.target(i, way).filter(|&n| alive[n]);
    strongly_connected(alive.len(), |i| alive[i], |i| graph.links[i].len() + 1, target)
}

/// Strongly connected components of a graph, each ascending.
///
/// - `is_in`: of each of so many nodes, whether the graph has it.
/// - `num_ways`: out of a node of the graph.
/// - `target`: where a way out of a node leads (way < num_ways); none where it leads out of the graph.
///
/// # Source
/// Tarjan 1972, with a stack of its own: ways through a large database are longer than the stack of a thread.
pub(super) fn strongly_connected(
    num_nodes: usize,
    is_in: impl Fn(usize) -> bool,
    num_ways: impl Fn(usize) -> usize,
    target: impl Fn(usize, usize) -> Option<usize>,
) -> Vec<Vec<u32>> {
    let mut out = Vec::new();
    // Orders of arrival, 0 for nodes not seen yet; the earliest node that one leads back to.
    let (mut order, mut lowest, mut num_seen) = (vec![0u32; num_nodes], vec![0u32; num_nodes], 0);
    let (mut open, mut is_open) = (Vec::<u32>::new(), vec![false; num_nodes]);
    for root in (0..num_nodes).filter(|&i| is_in(i)) {
        // Nodes on the way from the root, and how many ways out of each were followed.
        let mut way = if order[root] == 0 { vec![(root, 0)] } else { Vec::new() };
        while let Some((i, followed)) = way.last_mut() {
            let i = *i;
            if order[i] == 0 {
                num_seen += 1;
                (order[i], lowest[i], is_open[i]) = (num_seen, num_seen, true);
                open.push(i as u32);
            }
            if *followed < num_ways(i) {
                let target = target(i, *followed);
                *followed += 1;
                match target {
                    Some(n) if order[n] == 0 => way.push((n, 0)),
                    Some(n) if is_open[n] => lowest[i] = lowest[i].min(order[n]),
                    _ => {}
                }
                continue;
            }
            way.pop();
            if let Some(&(before, _)) = way.last() {
                lowest[before] = lowest[before].min(lowest[i]);
            }
            if lowest[i] == order[i] {
                let first = open.iter().rposition(|&n| n as usize == i).unwrap_or(0);
                let mut component = open.split_off(first);
                component.iter().for_each(|&n| is_open[n as usize] = false);
                component.sort_unstable();
                out.push(component);
            }
        }
    }
    out
}

/// The component that is worth most among the events alive; the one with the first event on a tie. A single event is
/// one only if it leads to itself.
fn strongest(graph: &EventGraph, alive: &[bool]) -> Vec<bool> {
    let worth = |c: &[u32]| c.iter().map(|&n| u64::from(graph.worth[n as usize])).sum::<u64>();
    let best = components(graph, alive)
        .into_iter()
        .filter(|c| c.len() > 1 || graph.targets(c[0] as usize).any(|n| n == c[0] as usize))
        .max_by_key(|c| (worth(c), std::cmp::Reverse(c[0])));
    let mut out = vec![false; alive.len()];
    for n in best.into_iter().flatten() {
        out[n as usize] = true;
    }
    out
}
