//! Keeps the component whole when only good links are chosen.

use super::choose;
use super::component::{EventGraph, components, strongly_connected};
use super::matches::Link;

/// Adds links until all events alive reach each other again and ends of clips have two ways out.
///
/// As in Borůvka's algorithm, every part that nothing leads out of gets its best link out, every part that nothing
/// leads into its best link in, and that is repeated: then every part has a way in and a way out, so some of them
/// lie on a common cycle and grow together.
///
/// - `arrivals`: of `matches`.
/// - `alive`: a component of the graph with all of `matches`.
/// - `most`: links a single event may have; where it has as many, no more are added.
pub(super) fn bridge(graph: &mut EventGraph, matches: &[Vec<Link>], arrivals: &Arrivals, alive: &[bool], most: usize) {
    Parts::new(graph, matches, arrivals, alive, most).join();
    for i in (0..alive.len()).filter(|&i| alive[i]) {
        if !graph.goes_on(i, alive) {
            let missing = 2usize.saturating_sub(graph.jumps(i, alive).count());
            let more: Vec<Link> = candidates(graph, matches, alive, i).take(missing).copied().collect();
            graph.links[i].extend(more);
        }
        choose::sort(&mut graph.links[i]);
    }
}

/// Links of `i` that are not chosen and stay among the events alive, best first.
fn candidates<'a>(
    graph: &'a EventGraph,
    matches: &'a [Vec<Link>],
    alive: &'a [bool],
    i: usize,
) -> impl Iterator<Item = &'a Link> {
    matches[i]
        .iter()
        .filter(move |l| graph.goes_on(l.event(), alive) && graph.links[i].iter().all(|k| k.event() != l.event()))
}

/// The events that links lead from, by where they lead.
pub(super) struct Arrivals {
    /// Those of links to event e are `from[starts[e]..starts[e + 1]]` (events + 1).
    starts: Vec<u32>,
    /// Of each event the best link first, of equally good ones that from the earliest event.
    from: Vec<u32>,
}

impl Arrivals {
    /// - `matches`: links of all events (fewer than 2^32).
    pub fn new(matches: &[Vec<Link>]) -> Self {
        let mut starts = vec![0u32; matches.len() + 1];
        matches.iter().flatten().for_each(|l| starts[l.event() + 1] += 1);
        (0..matches.len()).for_each(|e| starts[e + 1] += starts[e]);
        let mut all = vec![(0u32, 0u32); starts[matches.len()] as usize];
        let mut free = starts.clone();
        for (i, links) in matches.iter().enumerate() {
            for link in links {
                let at = &mut free[link.event()];
                all[*at as usize] = (link.error.to_bits(), i as u32);
                *at += 1;
            }
        }
        starts.windows(2).for_each(|w| all[w[0] as usize..w[1] as usize].sort_unstable());
        Self { from: all.into_iter().map(|(_, from)| from).collect(), starts }
    }

    /// Events with a link to `event`.
    fn to(&self, event: usize) -> &[u32] {
        &self.from[self.starts[event] as usize..self.starts[event + 1] as usize]
    }
}

/// A link and the event that it leads from.
type From = (usize, Link);

/// Strongly connected parts of the events alive, as they grow together. Parts never come apart again: what lies within one is
/// looked at no more.
struct Parts<'a> {
    graph: &'a mut EventGraph,
    matches: &'a [Vec<Link>],
    arrivals: &'a Arrivals,
    alive: &'a [bool],
    most: usize,
    /// The event before each in its clip.
    before: Vec<Option<u32>>,
    /// Part of each event, [`NO_PART`] of those that are not alive.
    part_of: Vec<u32>,
    /// Events of each part.
    events: Vec<Vec<u32>>,
    /// Ways from one part to another, each once, ascending.
    ways: Vec<[u32; 2]>,
    /// Of each event, how many of its best links are of no use: they lead into its own part, or to none.
    passed_out: Vec<u32>,
    /// Of each event, how many of the best links that arrive at it are of no use: they come from its own part, from none, or
    /// from an event that has as many links as it may have.
    passed_in: Vec<u32>,
}

/// The part of events that are in none.
const NO_PART: u32 = u32::MAX;

impl<'a> Parts<'a> {
    fn new(
        graph: &'a mut EventGraph,
        matches: &'a [Vec<Link>],
        arrivals: &'a Arrivals,
        alive: &'a [bool],
        most: usize,
    ) -> Self {
        let events = components(graph, alive);
        let num_events = alive.len();
        let mut before = vec![None; num_events];
        (0..num_events).for_each(|i| graph.next[i].into_iter().for_each(|n| before[n] = Some(i as u32)));
        let part_of = vec![NO_PART; num_events];
        let (passed_out, passed_in) = (vec![0; num_events], vec![0; num_events]);
        let mut parts = Self {
            graph,
            matches,
            arrivals,
            alive,
            most,
            before,
            part_of,
            events,
            ways: Vec::new(),
            passed_out,
            passed_in,
        };
        parts.number();
        for i in (0..num_events).filter(|&i| alive[i]) {
            let ways = parts.graph.targets(i).map(|n| [parts.part_of[i], parts.part_of[n]]);
            parts.ways.extend(ways.filter(|[from, to]| from != to && *to != NO_PART));
        }
        parts.ways.sort_unstable();
        parts.ways.dedup();
        parts
    }

    /// Adds the best links that are missing, until there is one part or nothing more leads on.
    fn join(mut self) {
        while self.events.len() > 1 {
            let more = self.missing();
            if more.is_empty() {
                break;
            }
            for (i, link) in more {
                self.graph.links[i].push(link);
                let to = self.graph.next[link.event()].map_or(NO_PART, |n| self.part_of[n]);
                self.ways.push([self.part_of[i], to]);
            }
            self.merge();
        }
    }

    /// Notes the part of each event.
    fn number(&mut self) {
        for (part, events) in (0..).zip(&self.events) {
            events.iter().for_each(|&i| self.part_of[i as usize] = part);
        }
    }

    /// Joins the parts that reach each other now.
    fn merge(&mut self) {
        self.ways.sort_unstable();
        let first = |part: usize| self.ways.partition_point(|w| (w[0] as usize) < part);
        let starts: Vec<usize> = (0..=self.events.len()).map(first).collect();
        let target = |part: usize, way: usize| Some(self.ways[starts[part] + way][1] as usize);
        let num_ways = |part: usize| starts[part + 1] - starts[part];
        let joined = strongly_connected(self.events.len(), |_| true, num_ways, target);
        let mut new = vec![0; self.events.len()];
        for (number, parts) in (0..).zip(&joined) {
            parts.iter().for_each(|&part| new[part as usize] = number);
        }
        let events = &mut self.events;
        let together = |parts: Vec<u32>| {
            // The largest takes in the others.
            let largest = parts.iter().copied().max_by_key(|&p| events[p as usize].len()).unwrap_or(0);
            let mut all = std::mem::take(&mut events[largest as usize]);
            parts.iter().filter(|&&p| p != largest).for_each(|&p| all.append(&mut events[p as usize]));
            all
        };
        self.events = joined.into_iter().map(together).collect();
        self.ways.iter_mut().for_each(|way| *way = way.map(|part| new[part as usize]));
        self.ways.retain(|[from, to]| from != to);
        self.ways.sort_unstable();
        self.ways.dedup();
        self.number();
    }

    /// The best link out of every part without a way out, and into every part without a way in; ascending, each once.
    fn missing(&mut self) -> Vec<From> {
        let (mut has_out, mut has_in) = (vec![false; self.events.len()], vec![false; self.events.len()]);
        for [from, to] in &self.ways {
            (has_out[*from as usize], has_in[*to as usize]) = (true, true);
        }
        let mut more = Vec::new();
        for part in 0..self.events.len() {
            let events = std::mem::take(&mut self.events[part]);
            // A link that is chosen already is a way out and a way in, so none is considered twice.
            if !has_out[part] {
                more.extend(best(events.iter().filter_map(|&i| self.way_out(i as usize))));
            }
            if !has_in[part] {
                more.extend(best(events.iter().filter_map(|&i| self.way_in(i as usize))));
            }
            self.events[part] = events;
        }
        more.sort_unstable_by_key(|(i, link)| (*i, link.event()));
        more.dedup_by_key(|(i, link)| (*i, link.event()));
        more
    }

    /// The best link of an event to another part.
    fn way_out(&mut self, i: usize) -> Option<From> {
        if self.graph.links[i].len() >= self.most {
            return None;
        }
        let passed = &mut self.passed_out[i];
        for link in &self.matches[i][*passed as usize..] {
            if self.graph.next[link.event()].is_some_and(|n| self.alive[n] && self.part_of[n] != self.part_of[i]) {
                return Some((i, *link));
            }
            *passed += 1;
        }
        None
    }

    /// The best link from another part to an event.
    fn way_in(&mut self, i: usize) -> Option<From> {
        let to = self.before[i]? as usize;
        let passed = &mut self.passed_in[i];
        for &from in &self.arrivals.to(to)[*passed as usize..] {
            let from = from as usize;
            if self.alive[from] && self.part_of[from] != self.part_of[i] && self.graph.links[from].len() < self.most {
                return self.matches[from].iter().find(|l| l.event() == to).map(|l| (from, *l));
            }
            *passed += 1;
        }
        None
    }
}

/// The best link, of equally good ones that from the earliest event to the earliest.
fn best(links: impl Iterator<Item = From>) -> Option<From> {
    links.min_by_key(|(i, link)| (link.error.to_bits(), *i, link.event()))
}
