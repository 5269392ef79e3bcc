//! The largest strongly connected component, without dead ends.

use super::connect::GraphInputs;
use super::matches::{TransitionLink, displacement, successors};
use crate::components::SuccessorGraph;
use crate::share::{gather_all, gather_each, gather_rows, own_numbers};
use std::borrow::Cow;
use throng_base::Comm;
use throng_motion::error::Result;

/// Event frames and edges between them: event i is followed by `next[i]`, as the clip continues, or by
/// `next[l.event()]` for a link l.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EventGraph {
    /// Next event in the clip of each event.
    pub next: Vec<Option<usize>>,
    /// Frames between the previous event, exclusive, and this one, which an arrival plays.
    pub frames: Vec<u32>,
    /// Weight in the comparison of components: a metre travelled counts as much as a second (frames).
    pub worth: Vec<u32>,
    /// True for events in a stand at ease, by which a component is preferred that walks and stands.
    pub rests: Vec<bool>,
    /// Transitions of every event; if ranks share them, only those of this rank's events.
    pub links: Vec<Vec<TransitionLink>>,
}

impl EventGraph {
    /// The events, as their clips go on, without links.
    pub fn of_events(given: &GraphInputs<'_>) -> Self {
        let GraphInputs { clips, events, rate_hz, .. } = *given;
        let next = successors(events);
        let (mut frames, mut worth) = (vec![0; events.len()], vec![0; events.len()]);
        let starts = clips.frame_starts();
        for (i, n) in next.iter().enumerate() {
            let Some(n) = *n else { continue };
            let (from, to) = (events[i].frame, events[n].frame);
            frames[n] = to.0 - from.0;
            let offset = displacement(clips, &starts, events[i].clip, from, to);
            worth[n] = frames[n] + (f64::from(offset.x.hypot(offset.z)) * rate_hz).round() as u32;
        }
        let rests = events.iter().map(|e| e.is_rest).collect();
        Self { next, frames, worth, rests, links: vec![Vec::new(); events.len()] }
    }

    /// True if people can go and stand within some events.
    pub fn serves(&self, events: impl Iterator<Item = usize> + Clone) -> bool {
        let rests = events.clone().filter(|&n| self.rests[n]).count();
        let travelled: u64 = events.map(|n| u64::from(self.worth[n].saturating_sub(self.frames[n]))).sum();
        rests >= LEAST_RESTS && travelled >= LEAST_TRAVEL
    }

    /// The same events with other links.
    pub fn with_links(&self, links: Vec<Vec<TransitionLink>>) -> Self {
        let (next, frames) = (self.next.clone(), self.frames.clone());
        Self { next, frames, worth: self.worth.clone(), rests: self.rests.clone(), links }
    }

    /// True if the clip continues from `i` to an event of the component.
    pub fn has_live_successor(&self, i: usize, alive: &[bool]) -> bool {
        self.next[i].is_some_and(|n| alive[n])
    }

    /// Events that may follow `i`.
    pub fn targets(&self, i: usize) -> impl Iterator<Item = usize> {
        (0..=self.links[i].len()).filter_map(move |way| successor_event(&self.next, &self.links, i, way))
    }

    /// Edges from the part of event `i` to other parts.
    pub fn component_edges<'a>(&'a self, i: usize, part_of: &'a [u32]) -> impl Iterator<Item = [u32; 2]> + 'a {
        let paths = self.targets(i).map(move |n| [part_of[i], part_of[n]]);
        paths.filter(|[from, to]| from != to && *to != NO_PART)
    }

    /// Removes every edge from or to events outside the component.
    pub fn restrict(&mut self, alive: &[bool]) {
        for i in 0..self.next.len() {
            let next = &self.next;
            self.links[i].retain(|l| alive[i] && next[l.event()].is_some_and(|n| alive[n]));
        }
    }

    /// Links of `i` that arrive in the component.
    pub fn live_links<'a>(&'a self, i: usize, alive: &'a [bool]) -> impl Iterator<Item = &'a TransitionLink> {
        self.links[i].iter().filter(|l| self.has_live_successor(l.event(), alive))
    }
}

/// Reduces the graph to its largest strongly connected component in which people walk and stand, or else to the largest of all,
/// measured in seconds and metres, so that much motion in place does not win over a little less that travels.
///
/// - `comm`: processes that hold the other links.
///
/// An event without continuation in its clip must have two links into the component; one with fewer is removed, and so
/// is an event after which the next choice is more than `most_frames` away. This is repeated until nothing changes:
/// every event of the result reaches every other.
///
/// - returns whether each event is in the component, which may be empty.
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(super) fn largest_component(graph: &EventGraph, most_frames: u32, comm: &dyn Comm) -> Result<Vec<bool>> {
    let num_events = graph.next.len();
    let own = own_numbers(comm, num_events);
    let of_all = |of_one: &dyn Fn(usize) -> u8| gather_each(comm, num_events, own.iter().map(|&i| of_one(i)).collect());
    let leads_to_itself = of_all(&|i| u8::from(graph.targets(i).any(|n| n == i)))?;
    let is_alone = comm.num_ranks() == 1;
    let few = |&i: &usize| graph.links[i].iter().take(KNOWN).copied().collect();
    let best = || gather_rows(comm, num_events, own.iter().map(few).collect());
    let best = if is_alone { Cow::Borrowed(&graph.links) } else { Cow::Owned(best()?) };
    let mut alive = vec![true; num_events];
    loop {
        let parts = components(&graph.next, &best, &alive);
        let parts = if is_alone { parts } else { merge_components(graph, parts, &alive, comm)? };
        alive = strongest(graph, parts, &leads_to_itself);
        // Two links are as good as many.
        let jumps = of_all(&|i| graph.live_links(i, &alive).take(2).count() as u8)?;
        let is_end = |i: usize| alive[i] && !graph.has_live_successor(i, &alive) && jumps[i] < 2;
        let ends = (0..num_events).filter(|&i| is_end(i));
        let out: Vec<usize> = ends.chain(too_far_ahead(graph, &alive, &jumps, most_frames)).collect();
        if out.is_empty() {
            return Ok(alive);
        }
        out.into_iter().for_each(|i| alive[i] = false);
    }
}

/// Events from whose predecessor the next choice is more than so many frames away.
///
/// - `jumps`: number of links of each event, up to two.
fn too_far_ahead(graph: &EventGraph, alive: &[bool], jumps: &[u8], most_frames: u32) -> Vec<usize> {
    let paths = |i: usize| u8::from(graph.has_live_successor(i, alive)) + jumps[i];
    // Clips go forward: the successor of an event has a greater number.
    let mut frames_left = vec![0u32; alive.len()];
    let mut out = Vec::new();
    for i in (0..alive.len()).rev() {
        let Some(n) = graph.next[i].filter(|&n| alive[n]) else { continue };
        let rest = if paths(n) > 1 { 0 } else { frames_left[n] };
        frames_left[i] = graph.frames[n].saturating_add(rest);
        if frames_left[i] > most_frames {
            out.push(n);
        }
    }
    out
}

/// Strongly connected components of the live events, each ascending.
///
/// - `next`, `links`: as of an [`EventGraph`], links of all events.
pub(super) fn components(next: &[Option<usize>], links: &[Vec<TransitionLink>], alive: &[bool]) -> Vec<Vec<u32>> {
    let target = |i: usize, way: usize| successor_event(next, links, i, way).filter(|&n| alive[n]);
    strongly_connected(alive.len(), |i| alive[i], |i| links[i].len() + 1, target)
}

/// Target of an outgoing edge of event `i`: the clip's for 0, or that of a link (way <= links[i].len()).
fn successor_event(next: &[Option<usize>], links: &[Vec<TransitionLink>], i: usize, way: usize) -> Option<usize> {
    next[if way == 0 { i } else { links[i][way - 1].event() }]
}

/// Fewest events of stands at ease, and least travel, of a component that serves behaviours (metres times frames a second).
const LEAST_RESTS: usize = 4;
const LEAST_TRAVEL: u64 = 90;

/// Number of best links of each event known to all ranks: they connect nearly everything.
const KNOWN: usize = 8;

/// Components by all links, from those by the few links known to all ranks: ranks exchange the edges between
/// components.
fn merge_components(graph: &EventGraph, parts: Vec<Vec<u32>>, live: &[bool], comm: &dyn Comm) -> Result<Vec<Vec<u32>>> {
    let part_of = component_of_events(&parts, live.len());
    let own = own_numbers(comm, live.len()).into_iter().filter(|&i| live[i]);
    let paths = own.flat_map(|i| graph.component_edges(i, &part_of));
    let paths = gather_all(comm, sort_edges(paths.collect()))?;
    let joined = join_components(parts.len(), &sort_edges(paths));
    let together = |of: Vec<u32>| {
        let mut all: Vec<u32> = of.iter().flat_map(|&part| parts[part as usize].iter().copied()).collect();
        all.sort_unstable();
        all
    };
    Ok(joined.into_iter().map(together).collect())
}

/// Part number of events without a part.
pub(super) const NO_PART: u32 = u32::MAX;

/// The part of each event.
pub(super) fn component_of_events(parts: &[Vec<u32>], num_events: usize) -> Vec<u32> {
    let mut out = vec![NO_PART; num_events];
    for (part, events) in (0..).zip(parts) {
        events.iter().for_each(|&i| out[i as usize] = part);
    }
    out
}

/// Edges between parts, each once, ascending.
pub(super) fn sort_edges(mut paths: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    paths.retain(|[from, to]| from != to);
    paths.sort_unstable();
    paths.dedup();
    paths
}

/// Groups of parts that reach each other.
///
/// - `paths`: edges between parts, ascending.
pub(super) fn join_components(num_parts: usize, paths: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let first = |part: usize| paths.partition_point(|w| (w[0] as usize) < part);
    let starts: Vec<usize> = (0..=num_parts).map(first).collect();
    let target = |part: usize, edge: usize| Some(paths[starts[part] + edge][1] as usize);
    strongly_connected(num_parts, |_| true, |part| starts[part + 1] - starts[part], target)
}

/// Strongly connected components of a graph, each ascending.
///
/// - `is_in`: for each node, whether the graph contains it.
/// - `num_edges`: number of outgoing edges of a node.
/// - `target`: target of an outgoing edge of a node (edge < num_edges); `None` outside of the graph.
fn strongly_connected(
    num_nodes: usize,
    is_in: impl Fn(usize) -> bool,
    num_edges: impl Fn(usize) -> usize,
    target: impl Fn(usize, usize) -> Option<usize>,
) -> Vec<Vec<u32>> {
    let number = crate::components::components(&NumberedGraph { num_nodes, num_edges, target });
    let mut nodes: Vec<u32> = (0..num_nodes as u32).filter(|&n| is_in(n as usize)).collect();
    nodes.sort_by_key(|&n| number[n as usize]);
    nodes.chunk_by(|a, b| number[*a as usize] == number[*b as usize]).map(<[u32]>::to_vec).collect()
}

/// A graph whose nodes have numbered outgoing edges.
struct NumberedGraph<N, T> {
    num_nodes: usize,
    num_edges: N,
    target: T,
}

impl<N: Fn(usize) -> usize, T: Fn(usize, usize) -> Option<usize>> SuccessorGraph for NumberedGraph<N, T> {
    type Cursor = usize;

    fn num_nodes(&self) -> usize {
        self.num_nodes
    }

    fn next(&self, node: u32, edge: &mut usize) -> Option<u32> {
        let node = node as usize;
        let ahead = (*edge..(self.num_edges)(node)).find_map(|k| Some((k, (self.target)(node, k)?)));
        ahead.map(|(k, n)| {
            *edge = k + 1;
            n as u32
        })
    }
}

/// Component of the largest weight, with the first event on a tie: of those in which people both walk and stand, if there is
/// one, as behaviours go to places and stay there. A single event counts only if it leads to itself.
fn strongest(graph: &EventGraph, parts: Vec<Vec<u32>>, leads_to_itself: &[u8]) -> Vec<bool> {
    let worth = |c: &[u32]| c.iter().map(|&n| u64::from(graph.worth[n as usize])).sum::<u64>();
    let cycles = parts.into_iter().filter(|c| c.len() > 1 || leads_to_itself[c[0] as usize] > 0);
    let serves = |c: &[u32]| graph.serves(c.iter().map(|&n| n as usize));
    let best = cycles.max_by_key(|c| (serves(c), worth(c), std::cmp::Reverse(c[0])));
    let mut out = vec![false; graph.next.len()];
    best.into_iter().flatten().for_each(|n| out[n as usize] = true);
    out
}
