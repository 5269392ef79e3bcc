//! Manners that people keep: each has a graph of its own, in which they go and stand, and transitions to the others.

use super::choose::{self, MotionOutcome};
use super::component::{EventGraph, largest_component};
use super::connect::{GraphInputs, GraphSearch};
use super::events::EventFrame;
use super::matches::{EventEdge, LinkFinder, LinkLimits, TransitionLink};
use crate::features::Features;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use throng_base::{Comm, SingleRank};
use throng_motion::{annotate::classes::named_manner, error::Result, progress::Progress};

/// Most transitions of an event to other manners, each to another one: few, as every look ahead pays for them.
const TO_OTHERS: usize = 2;
/// Most transitions of each direction that join a part which would be lost.
const JOINING: usize = 8;

/// Manners of a graph, with those that cannot be kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KeptManners {
    /// Manner of most motion, whose graph has the motion of the thin ones.
    usual: String,
    /// Manners with too little motion to go and stand in them alone, ascending.
    pub thin: Vec<String>,
}

impl KeptManners {
    /// True for the manner of most motion.
    pub(super) fn is_usual(&self, manner: &str) -> bool {
        self.usual == manner
    }

    /// Manner that people keep while they move in one.
    pub fn kept_in<'a>(&'a self, manner: &'a str) -> &'a str {
        let named = named_manner(manner);
        if self.thin.iter().any(|thin| thin == named) { &self.usual } else { named }
    }
}

/// Search for the graph of each manner and for transitions between them.
pub(super) struct MannersSearch<'a> {
    pub given: GraphInputs<'a>,
    pub limits: LinkLimits,
    pub progress: &'a dyn Progress,
    /// Processes that search together.
    pub comm: &'a dyn Comm,
}

/// Graph of the events of all manners.
pub(super) struct ConnectedEvents {
    pub graph: EventGraph,
    /// True for events in its component.
    pub alive: Vec<bool>,
    /// Largest threshold of a manner (rad).
    pub threshold: f32,
    pub manners: KeptManners,
}

impl MannersSearch<'_> {
    /// Finds the links that the motion of each manner has alone, and then the nearest ones between manners.
    ///
    /// # Errors
    /// As [`super::connect`].
    pub fn run(&self) -> Result<ConnectedEvents> {
        let mut of_manners = self.events_of_manners();
        of_manners.sort_by_key(|(_, own)| own.len());
        let mut manner_of = vec![0; self.given.events.len()];
        of_manners.iter().enumerate().for_each(|(n, (_, own))| own.iter().for_each(|&i| manner_of[i] = n));
        let (usual, mut rest) = of_manners.pop().unwrap_or_default();
        let mut manners = KeptManners { usual, thin: Vec::new() };
        let mut parts = Vec::new();
        for (manner, own) in of_manners {
            let part = self.search_within(own, self.limits)?;
            if part.graph.serves((0..part.own.len()).filter(|&k| part.alive[k])) {
                parts.push(part);
            } else {
                manners.thin.push(manner);
                rest.extend(part.own);
            }
        }
        rest.sort_unstable();
        manners.thin.sort_unstable();
        parts.push(self.search_rest(rest, &manner_of)?);
        let (mut graph, mut part_of) = (EventGraph::of_events(&self.given), vec![None; self.given.events.len()]);
        for (number, part) in (0..).zip(&parts) {
            for ((&i, links), &is_alive) in part.own.iter().zip(&part.graph.links).zip(&part.alive) {
                let of_all = |l: &TransitionLink| TransitionLink::new(part.own[l.event()], l.error);
                graph.links[i] = links.iter().map(of_all).collect();
                part_of[i] = is_alive.then_some(number);
            }
        }
        if parts.len() > 1 {
            self.link_parts(&mut graph, &part_of)?;
        }
        let mut alive = largest_component(&graph, self.given.most_frames(), &SingleRank)?;
        let kept: BTreeSet<_> = (0..alive.len()).filter(|&i| alive[i]).map(|i| part_of[i]).collect();
        if kept.len() < parts.len() && self.farther().error > self.limits.error {
            self.join_parts(&mut graph, &part_of, &kept)?;
            alive = largest_component(&graph, self.given.most_frames(), &SingleRank)?;
        }
        let threshold = parts.iter().map(|part| part.threshold).fold(0.0, f32::max);
        Ok(ConnectedEvents { graph, alive, threshold, manners })
    }

    /// The named manners, ascending, with their events.
    fn events_of_manners(&self) -> Vec<(String, Vec<usize>)> {
        let GraphInputs { events, clips, .. } = self.given;
        let starts = clips.frame_starts();
        let mut out = BTreeMap::<&str, Vec<usize>>::new();
        for (i, e) in events.iter().enumerate() {
            let class = clips.clips[e.clip].class_at((e.frame.0 - starts[e.clip]) as usize);
            out.entry(class.map_or("", |c| named_manner(&c.manner))).or_default().push(i);
        }
        out.into_iter().map(|(manner, own)| (manner.to_owned(), own)).collect()
    }

    /// Limits of the transitions without which a manner would be lost.
    fn farther(&self) -> LinkLimits {
        LinkLimits { error: self.limits.error.max(self.given.config.join_error as f32), ..self.limits }
    }

    /// The graph of the most usual manner with the thin ones, which farther transitions keep whole where one would be lost.
    ///
    /// - `manner_of`: number of the manner of each event.
    fn search_rest(&self, own: Vec<usize>, manner_of: &[usize]) -> Result<MannerPart> {
        let all: BTreeSet<usize> = own.iter().map(|&i| manner_of[i]).collect();
        let kept = |part: &MannerPart| -> BTreeSet<usize> { part.live_events().map(|i| manner_of[i]).collect() };
        let near = self.search_within(own, self.limits)?;
        if kept(&near).len() == all.len() || self.farther().error <= self.limits.error {
            return Ok(near);
        }
        let far = self.search_within(near.own.clone(), self.farther())?;
        Ok(if kept(&far).len() > kept(&near).len() { far } else { near })
    }

    /// The graph that some events have alone.
    fn search_within(&self, own: Vec<usize>, limits: LinkLimits) -> Result<MannerPart> {
        let inputs = PartInputs::new(&self.given, &own, |i| self.given.outcomes[i]);
        let given = inputs.as_graph_inputs(self.given);
        let finder = LinkFinder::new(given, limits, self.progress, self.comm)?;
        let (graph, alive, threshold) = GraphSearch::new(given, finder, self.comm)?.run()?;
        Ok(MannerPart { own, graph, alive, threshold })
    }

    /// Adds the best links of each event to other parts, where it has room.
    ///
    /// - `part_of`: number of the part in whose component each event is.
    fn link_parts(&self, graph: &mut EventGraph, part_of: &[Option<u16>]) -> Result<()> {
        for (i, links) in self.links_between(graph, part_of, self.limits)? {
            let room = (self.given.config.max_actions - 1).saturating_sub(graph.links[i].len());
            graph.links[i].extend(links.into_iter().take(TO_OTHERS.min(room)));
            choose::sort(&mut graph.links[i]);
        }
        Ok(())
    }

    /// Adds the best farther links between parts that a component holds and others.
    ///
    /// - `kept`: parts that the component holds.
    fn join_parts(&self, graph: &mut EventGraph, part_of: &[Option<u16>], kept: &BTreeSet<Option<u16>>) -> Result<()> {
        let mut between = BTreeMap::<[Option<u16>; 2], Vec<EventEdge>>::new();
        for (i, links) in self.links_between(graph, part_of, self.farther())? {
            for link in links {
                let ends = [part_of[i], part_of[link.event()]];
                if ends.iter().any(|part| !kept.contains(part)) {
                    between.entry(ends).or_default().push(EventEdge { from: i as u32, link });
                }
            }
        }
        for mut edges in between.into_values() {
            edges.sort_unstable_by_key(EventEdge::rank);
            for EventEdge { from, link } in edges.into_iter().take(JOINING) {
                let links = &mut graph.links[from as usize];
                if links.len() + 1 < self.given.config.max_actions && links.iter().all(|l| l.event() != link.event()) {
                    links.push(link);
                    choose::sort(links);
                }
            }
        }
        Ok(())
    }

    /// Best links of each event to every other part.
    fn links_between(
        &self,
        graph: &EventGraph,
        part_of: &[Option<u16>],
        limits: LinkLimits,
    ) -> Result<Vec<(usize, Vec<TransitionLink>)>> {
        let own: Vec<usize> = (0..part_of.len()).filter(|&i| part_of[i].is_some()).collect();
        // The best link to each part, in place of each kind of outcome.
        let as_outcome = |i: usize| {
            let [low, high] = part_of[i].unwrap_or(u16::MAX).to_le_bytes();
            MotionOutcome { kind: (high as i8, low), ..self.given.outcomes[i] }
        };
        let inputs = PartInputs::new(&self.given, &own, as_outcome);
        let finder = LinkFinder::new(inputs.as_graph_inputs(self.given), limits, self.progress, self.comm)?;
        let alive: Vec<bool> = part_of.iter().map(Option::is_some).collect();
        let of_event = |(&i, links): (&usize, Vec<TransitionLink>)| {
            let links = links.into_iter().map(|l| TransitionLink::new(own[l.event()], l.error));
            let leads_out =
                |l: &TransitionLink| part_of[l.event()] != part_of[i] && graph.has_live_successor(l.event(), &alive);
            (i, links.filter(leads_out).collect())
        };
        Ok(own.iter().zip(finder.best_of_kinds(self.comm)?).map(of_event).collect())
    }
}

/// The graph of one manner.
struct MannerPart {
    /// Its events, ascending.
    own: Vec<usize>,
    graph: EventGraph,
    alive: Vec<bool>,
    threshold: f32,
}

impl MannerPart {
    /// Events of its component.
    fn live_events(&self) -> impl Iterator<Item = usize> {
        self.own.iter().zip(&self.alive).filter(|(_, is_alive)| **is_alive).map(|(&i, _)| i)
    }
}

/// Some of the events, with what is known of them.
struct PartInputs {
    events: Vec<EventFrame>,
    features: Features,
    outcomes: Vec<MotionOutcome>,
}

impl PartInputs {
    fn new(given: &GraphInputs<'_>, own: &[usize], outcome: impl Fn(usize) -> MotionOutcome) -> Self {
        let events = own.iter().map(|&i| given.events[i]).collect();
        Self { events, features: given.features.select(own), outcomes: own.iter().map(|&i| outcome(i)).collect() }
    }

    fn as_graph_inputs<'a>(&'a self, all: GraphInputs<'a>) -> GraphInputs<'a> {
        let Self { events, features, outcomes } = self;
        GraphInputs { events, features, outcomes, ..all }
    }
}
