//! Keeps the component connected when only good links are chosen.

use super::choose;
use super::component::{EventGraph, NO_PART, component_of_events, components, join_components, sort_edges};
use super::matches::{AT_ONCE, EventEdge, TransitionLink};
use crate::share::{exchange_values, gather_all, is_own, own_numbers};
use bytemuck::{Pod, Zeroable};
use throng_base::Comm;
use throng_motion::error::Result;

/// Adds links until all live events reach each other again and ends of clips have two outgoing links.
///
/// As in Borůvka's algorithm, every part without an outgoing link gets its best one, and every part without an incoming
/// link its best one, repeatedly: then every part has both, so some of them lie on a common cycle and merge.
///
/// - `graph`: with all chosen links, in every rank.
/// - `most`: links a single event may have.
/// - `comm`: processes that hold the other links.
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(super) fn bridge(graph: &mut EventGraph, known: KnownLinks<'_>, most: usize, comm: &dyn Comm) -> Result<()> {
    let alive = known.alive;
    GraphComponents::new(graph, known, most).join_all(comm)?;
    let ends = own_numbers(comm, alive.len()).into_iter().filter(|&i| alive[i] && !graph.has_live_successor(i, alive));
    let second = |i: usize| {
        let missing = 2usize.saturating_sub(graph.live_links(i, alive).count());
        known.candidates(graph, i).take(missing).map(move |link| EventEdge { from: i as u32, link: *link })
    };
    for EventEdge { from, link } in gather_all(comm, ends.flat_map(second).collect())? {
        graph.links[from as usize].push(link);
    }
    (0..alive.len()).filter(|&i| alive[i]).for_each(|i| choose::sort(&mut graph.links[i]));
    Ok(())
}

/// Links that may bridge parts of a graph.
#[derive(Clone, Copy)]
pub(super) struct KnownLinks<'a> {
    /// Links of this rank's events.
    pub matches: &'a [Vec<TransitionLink>],
    /// The same links by their targets.
    pub arrivals: &'a IncomingLinks,
    /// A component of the graph with all of these links.
    pub alive: &'a [bool],
}

impl<'a> KnownLinks<'a> {
    /// Links of `i` that are not chosen and lead to live events, best first.
    fn candidates(self, graph: &'a EventGraph, i: usize) -> impl Iterator<Item = &'a TransitionLink> {
        self.matches[i].iter().filter(move |l| {
            graph.has_live_successor(l.event(), self.alive) && graph.links[i].iter().all(|k| k.event() != l.event())
        })
    }
}

/// Links that lead to this rank's events.
pub(super) struct IncomingLinks {
    /// Offsets: the links to event e are `ways[starts[e]..starts[e + 1]]` (events + 1).
    starts: Vec<u32>,
    /// Links by the event that they lead to, best first for each.
    edges: Vec<EventEdge>,
}

impl IncomingLinks {
    /// - `matches`: links of this rank's events (fewer than 2^32 lead to those of any rank).
    /// - `comm`: processes that hold the other links.
    ///
    /// # Errors
    /// [`throng_base::Error::Rank`].
    pub fn new(matches: &[Vec<TransitionLink>], comm: &dyn Comm) -> Result<Self> {
        let mut paths = Vec::new();
        for first in (0..matches.len()).step_by(AT_ONCE * comm.num_ranks()) {
            let mut to = vec![Vec::new(); comm.num_ranks()];
            for (from, links) in matches.iter().enumerate().skip(first).take(AT_ONCE * comm.num_ranks()) {
                let from = from as u32;
                links.iter().for_each(|&link| to[link.event() % comm.num_ranks()].push(EventEdge { from, link }));
            }
            paths.append(&mut exchange_values(comm, to)?);
        }
        paths.sort_unstable_by_key(|way| (way.link.event(), way.rank()));
        let mut starts = vec![0u32; matches.len() + 1];
        paths.iter().for_each(|way| starts[way.link.event() + 1] += 1);
        (0..matches.len()).for_each(|e| starts[e + 1] += starts[e]);
        Ok(Self { starts, edges: paths })
    }
}

/// Strongly connected parts of the live events, as they merge. Parts never split again, so links within one are not
/// examined any more.
struct GraphComponents<'a> {
    graph: &'a mut EventGraph,
    known: KnownLinks<'a>,
    most: usize,
    /// Preceding event in the clip of each event.
    before: Vec<Option<u32>>,
    /// Part of each event; [`NO_PART`] for events that are not alive.
    part_of: Vec<u32>,
    /// Events of each part.
    events: Vec<Vec<u32>>,
    /// Edges between parts, each once, ascending.
    paths: Vec<[u32; 2]>,
    /// For each event, number of its best links that are useless: they lead into its own part, or to none.
    passed_out: Vec<u32>,
    /// For each event, number of its best incoming links that are useless: they come from its own part, from none, or
    /// from an event without room for more links.
    passed_in: Vec<u32>,
}

impl<'a> GraphComponents<'a> {
    fn new(graph: &'a mut EventGraph, known: KnownLinks<'a>, most: usize) -> Self {
        let alive = known.alive;
        let events = components(&graph.next, &graph.links, alive);
        let num_events = alive.len();
        let mut before = vec![None; num_events];
        (0..num_events).for_each(|i| graph.next[i].into_iter().for_each(|n| before[n] = Some(i as u32)));
        let part_of = component_of_events(&events, num_events);
        let paths = (0..num_events).filter(|&i| alive[i]).flat_map(|i| graph.component_edges(i, &part_of));
        let paths = sort_edges(paths.collect());
        let (passed_out, passed_in) = (vec![0; num_events], vec![0; num_events]);
        Self { graph, known, most, before, part_of, events, paths, passed_out, passed_in }
    }

    /// Adds the best missing links, until there is one part or no further link.
    fn join_all(mut self, comm: &dyn Comm) -> Result<()> {
        while self.events.len() > 1 {
            let more = self.missing_links(comm)?;
            if more.is_empty() {
                break;
            }
            for EventEdge { from, link } in more {
                self.graph.links[from as usize].push(link);
                let to = self.graph.next[link.event()].map_or(NO_PART, |n| self.part_of[n]);
                self.paths.push([self.part_of[from as usize], to]);
            }
            self.merge();
        }
        Ok(())
    }

    /// Merges parts that now reach each other.
    fn merge(&mut self) {
        self.paths.sort_unstable();
        let joined = join_components(self.events.len(), &self.paths);
        let mut new = vec![0; self.events.len()];
        for (number, parts) in (0..).zip(&joined) {
            parts.iter().for_each(|&part| new[part as usize] = number);
        }
        let events = &mut self.events;
        let together = |parts: Vec<u32>| {
            // The largest part absorbs the others.
            let largest = parts.iter().copied().max_by_key(|&p| events[p as usize].len()).unwrap_or(0);
            let mut all = std::mem::take(&mut events[largest as usize]);
            parts.iter().filter(|&&p| p != largest).for_each(|&p| all.append(&mut events[p as usize]));
            all
        };
        self.events = joined.into_iter().map(together).collect();
        self.paths.iter_mut().for_each(|path| *path = path.map(|part| new[part as usize]));
        self.paths = sort_edges(std::mem::take(&mut self.paths));
        self.part_of = component_of_events(&self.events, self.known.alive.len());
    }

    /// Best outgoing link of every part without one, and best incoming link of every part without one; ascending, each
    /// once.
    fn missing_links(&mut self, comm: &dyn Comm) -> Result<Vec<EventEdge>> {
        let (mut has_out, mut has_in) = (vec![false; self.events.len()], vec![false; self.events.len()]);
        for [from, to] in &self.paths {
            (has_out[*from as usize], has_in[*to as usize]) = (true, true);
        }
        let mut found = Vec::new();
        for part in 0..self.events.len() {
            let events = std::mem::take(&mut self.events[part]);
            let mut find = |direction: u32, best: Option<EventEdge>| {
                found.extend(best.map(|best| BestBridge { part: part as u32, direction, best }))
            };
            if !has_out[part] {
                let own = events.iter().filter(|&&i| is_own(comm, i as usize));
                find(0, own.filter_map(|&i| self.find_link_out(i as usize)).min_by_key(EventEdge::rank));
            }
            if !has_in[part] {
                let links = events.iter().filter_map(|&i| self.find_link_in(i as usize, comm));
                find(1, links.min_by_key(EventEdge::rank));
            }
            self.events[part] = events;
        }
        let mut found = gather_all(comm, found)?;
        found.sort_unstable_by_key(|f| (f.part, f.direction, f.best.rank()));
        found.dedup_by_key(|f| (f.part, f.direction));
        // A chosen link is both outgoing and incoming, so none is considered twice.
        let mut more: Vec<EventEdge> = found.into_iter().map(|f| f.best).collect();
        more.sort_unstable_by_key(|f| (f.from, f.link.event()));
        more.dedup_by_key(|f| (f.from, f.link.event()));
        Ok(more)
    }

    /// Best link of an event to another part.
    fn find_link_out(&mut self, i: usize) -> Option<EventEdge> {
        if self.graph.links[i].len() >= self.most {
            return None;
        }
        let passed = &mut self.passed_out[i];
        for link in &self.known.matches[i][*passed as usize..] {
            if self.graph.next[link.event()].is_some_and(|n| self.known.alive[n] && self.part_of[n] != self.part_of[i])
            {
                return Some(EventEdge { from: i as u32, link: *link });
            }
            *passed += 1;
        }
        None
    }

    /// Best link from another part to an event, if this rank holds it.
    fn find_link_in(&mut self, i: usize, comm: &dyn Comm) -> Option<EventEdge> {
        let to = self.before[i].filter(|&to| is_own(comm, to as usize))? as usize;
        let passed = &mut self.passed_in[i];
        let arrivals = &self.known.arrivals;
        for link in &arrivals.edges[arrivals.starts[to] as usize..arrivals.starts[to + 1] as usize][*passed as usize..]
        {
            let from = link.from as usize;
            if self.known.alive[from]
                && self.part_of[from] != self.part_of[i]
                && self.graph.links[from].len() < self.most
            {
                return Some(*link);
            }
            *passed += 1;
        }
        None
    }
}

/// Best link out of a part, or into it, that a rank has found.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct BestBridge {
    part: u32,
    /// Direction: 0 out of the part, 1 into it.
    direction: u32,
    best: EventEdge,
}
