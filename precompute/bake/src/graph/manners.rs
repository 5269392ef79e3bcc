//! Manners that people keep: each has a graph of its own, in which they go and stand, and transitions to the others.

use super::choose::{self, MotionOutcome};
use super::component::{EventGraph, largest_component};
use super::connect::{GraphInputs, GraphSearch};
use super::events::EventFrame;
use super::matches::{LinkFinder, LinkLimits, TransitionLink};
use crate::features::Features;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_base::{Comm, SingleRank};
use throng_motion::{annotate::classes::named_manner, error::Result, progress::Progress};

/// Most transitions of an event to other manners, each to another one: few, as every look ahead pays for them.
const TO_OTHERS: usize = 2;

/// Manners of a graph, with those that cannot be kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KeptManners {
    /// Manner of most motion, whose graph has the motion of the thin ones.
    usual: String,
    /// Manners with too little motion to go and stand in them alone, ascending.
    pub thin: Vec<String>,
}

impl KeptManners {
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
        let (usual, mut rest) = of_manners.pop().unwrap_or_default();
        let mut manners = KeptManners { usual, thin: Vec::new() };
        let mut parts = Vec::new();
        for (manner, own) in of_manners {
            let part = self.search_within(own)?;
            if part.graph.serves((0..part.own.len()).filter(|&k| part.alive[k])) {
                parts.push(part);
            } else {
                manners.thin.push(manner);
                rest.extend(part.own);
            }
        }
        rest.sort_unstable();
        manners.thin.sort_unstable();
        parts.push(self.search_within(rest)?);
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
        let alive = largest_component(&graph, self.given.most_frames(), &SingleRank)?;
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

    /// The graph that some events have alone.
    fn search_within(&self, own: Vec<usize>) -> Result<MannerPart> {
        let inputs = PartInputs::new(&self.given, &own, |i| self.given.outcomes[i]);
        let given = inputs.as_graph_inputs(self.given);
        let finder = LinkFinder::new(given, self.limits, self.progress, self.comm)?;
        let (graph, alive, threshold) = GraphSearch::new(given, finder, self.comm)?.run()?;
        Ok(MannerPart { own, graph, alive, threshold })
    }

    /// Adds the best links of each event to other parts, where it has room.
    ///
    /// - `part_of`: number of the part in whose component each event is.
    fn link_parts(&self, graph: &mut EventGraph, part_of: &[Option<u16>]) -> Result<()> {
        let own: Vec<usize> = (0..part_of.len()).filter(|&i| part_of[i].is_some()).collect();
        // The best link to each part, in place of each kind of outcome.
        let as_outcome = |i: usize| {
            let [low, high] = part_of[i].unwrap_or(u16::MAX).to_le_bytes();
            MotionOutcome { kind: (high as i8, low), ..self.given.outcomes[i] }
        };
        let inputs = PartInputs::new(&self.given, &own, as_outcome);
        let finder = LinkFinder::new(inputs.as_graph_inputs(self.given), self.limits, self.progress, self.comm)?;
        let alive: Vec<bool> = part_of.iter().map(Option::is_some).collect();
        for (&i, links) in own.iter().zip(finder.best_of_kinds(self.comm)?) {
            let room = (self.given.config.max_actions - 1).saturating_sub(graph.links[i].len());
            let links = links.into_iter().map(|l| TransitionLink::new(own[l.event()], l.error));
            let leads_out =
                |l: &TransitionLink| part_of[l.event()] != part_of[i] && graph.has_live_successor(l.event(), &alive);
            let links: Vec<_> = links.filter(leads_out).take(TO_OTHERS.min(room)).collect();
            graph.links[i].extend(links);
            choose::sort(&mut graph.links[i]);
        }
        Ok(())
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
