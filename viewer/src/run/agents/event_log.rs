//! Event log of a crowd: the last events of every kind, and those of one agent.

use super::rates::EventRates;
use AgentEventKind::*;
use glam::Vec3;
use std::collections::VecDeque;
use throng_crowd::{CrowdEventKind, Id};
use throng_simulation::scenario::{Turn, TurnKind};

/// Events of a kind that are kept.
const KEPT: usize = 1500;

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AgentEventKind {
    /// A bound touched the side of its region.
    Resetting,
    /// Two bounds touched.
    Colliding,
    /// A bound touched an obstacle.
    Meeting,
    /// A bound occupies cells that it did not.
    Entering,
    /// A bound occupies cells no more.
    Leaving,
    /// Two agents touch and stay together.
    Contacting,
    /// Two agents that touched separate.
    Separating,
    /// An agent reached the end of its route.
    Arrived,
    /// An agent left the crowd.
    Left,
    /// An obstacle that moves ran into an agent.
    Struck,
    /// An agent made no progress for 10 s.
    Stuck,
    /// An agent came to a place.
    EnteredPlace,
    /// An agent went from a place.
    LeftPlace,
    /// An agent came to know of a message.
    Learnt,
    /// An agent followed a rule.
    Rule,
    /// An agent took an edge of a graph.
    Edge,
}

/// The other party of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OtherParty {
    /// No other party.
    None,
    /// Another agent.
    Agent(usize),
    /// An obstacle.
    Obstacle(usize),
    /// How a message was learnt, and the sender.
    Message(&'static str, Option<usize>),
    /// Number of a rule, and the other agent.
    Rule(usize, Option<usize>),
    /// Number of a graph and of its edge, and the other agent.
    Edge(usize, usize, Option<usize>),
}

impl OtherParty {
    /// The other agent.
    pub fn other(self) -> Option<usize> {
        match self {
            Self::None | Self::Obstacle(_) => None,
            Self::Agent(other) => Some(other),
            Self::Message(_, other) | Self::Rule(_, other) | Self::Edge(_, _, other) => other,
        }
    }
}

/// Which events are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EventFilter {
    /// Kinds that are listed.
    pub kinds: [bool; AgentEventKind::COUNT],
    /// About this place alone.
    pub place: Option<usize>,
    /// About this message alone.
    pub message: Option<usize>,
}

impl EventFilter {
    /// All of some kinds.
    pub fn of_kinds(kinds: [bool; AgentEventKind::COUNT]) -> Self {
        Self { kinds, place: None, message: None }
    }

    fn matches_until(&self, until_s: f64, h: &AgentEvent) -> bool {
        h.time_s <= until_s
            && self.kinds[h.kind.number()]
            && self.place.is_none_or(|p| h.place == Some(p))
            && self.message.is_none_or(|m| h.message == Some(m))
    }
}

/// All kinds in their order, with names, meanings, and colours on dark and on light ground.
const KINDS: [(AgentEventKind, &str, &str, [u32; 2]); AgentEventKind::COUNT] = [
    (Resetting, "resetting", "A bound touched the side of its region R and was reset", [0x7d93b2, 0x5b7196]),
    (Colliding, "colliding", "Two bounds touched; both were reset", [0xff6b8a, 0xc2185b]),
    (Meeting, "meeting", "A bound touched an obstacle and was reset", [0xd9c24a, 0x8a7400]),
    (Entering, "entering", "A bound touched a face of a cell and occupies the cells behind it", [0xb493ff, 0x6b3fd0]),
    (Leaving, "leaving", "A bound no longer occupies the cells behind a face", [0x8f9bff, 0x4048c8]),
    (Contacting, "contacting", "Two agents touch and rest against each other", [0xf2877d, 0xa33a2e]),
    (Separating, "separating", "Two agents that touched separate", [0xb9c97a, 0x5d7010]),
    (Arrived, "arrived", "An agent reached the end of its route", [0x55d98b, 0x14803f]),
    (Left, "left", "An agent left the crowd at the end of its route", [0x4fd0d9, 0x0b7a86]),
    (Struck, "struck", "An obstacle that moves ran into an agent", [0xff5df0, 0x9c0f9c]),
    (Stuck, "stuck", "An agent made no progress toward its goal for 10 s", [0xff5f50, 0xc01f14]),
    (EnteredPlace, "came", "An agent came to a place", [0xe6b06a, 0x95600f]),
    (LeftPlace, "went", "An agent went from a place", [0xb8926a, 0x7a5a33]),
    (Learnt, "learnt", "An agent came to know of a message", [0x6fd3ff, 0x0a6c9c]),
    (Rule, "rule", "An agent followed a rule", [0xd9a0ff, 0x8324b8]),
    (Edge, "edge", "An agent took an edge of a state-transition graph", [0xc8e06a, 0x557000]),
];

impl AgentEventKind {
    /// Number of kinds.
    pub const COUNT: usize = 16;

    /// All kinds, in their order.
    pub fn all() -> [Self; Self::COUNT] {
        KINDS.map(|k| k.0)
    }

    /// The kind of an event and the other party; none for an unknown kind.
    ///
    /// - `agent`: number of an agent by its name in the engine; none where it has left.
    pub fn from_engine_event(kind: &CrowdEventKind, agent: impl Fn(Id) -> Option<usize>) -> Option<(Self, OtherParty)> {
        let with = |other: Id| agent(other).map_or(OtherParty::None, OtherParty::Agent);
        Some(match *kind {
            CrowdEventKind::Resetting => (Self::Resetting, OtherParty::None),
            CrowdEventKind::Colliding { other } => (Self::Colliding, with(other)),
            CrowdEventKind::Meeting { obstacle } => (Self::Meeting, OtherParty::Obstacle(obstacle)),
            CrowdEventKind::Entering => (Self::Entering, OtherParty::None),
            CrowdEventKind::Leaving => (Self::Leaving, OtherParty::None),
            CrowdEventKind::Contacting { other } => (Self::Contacting, with(other)),
            CrowdEventKind::Separating { other } => (Self::Separating, with(other)),
            CrowdEventKind::Arrived => (Self::Arrived, OtherParty::None),
            CrowdEventKind::Left => (Self::Left, OtherParty::None),
            CrowdEventKind::Struck { obstacle } => (Self::Struck, OtherParty::Obstacle(obstacle)),
            CrowdEventKind::Stuck => (Self::Stuck, OtherParty::None),
            _ => return None,
        })
    }

    /// The kind of an event of an agent's brain and the other party; none for events that are not listed.
    pub fn from_brain_event(turn: &Turn, first: usize) -> Option<(Self, OtherParty)> {
        let other = turn.other.map(|agent| first + agent);
        Some(match turn.kind {
            TurnKind::Starts => return None,
            TurnKind::Enters => (Self::EnteredPlace, OtherParty::None),
            TurnKind::Leaves => (Self::LeftPlace, OtherParty::None),
            TurnKind::Learns(how) => (Self::Learnt, OtherParty::Message(how, other)),
            TurnKind::Follows(rule) => (Self::Rule, OtherParty::Rule(rule, other)),
            TurnKind::Takes { graph, edge, .. } => (Self::Edge, OtherParty::Edge(graph, edge, other)),
        })
    }

    /// True for events of the crowd engine, false for those of agents.
    pub fn is_of_engine(self) -> bool {
        self.number() <= Self::Separating.number()
    }

    /// Number of the kind.
    pub fn number(self) -> usize {
        self as usize
    }

    /// Name of the kind.
    pub fn name(self) -> &'static str {
        KINDS[self.number()].1
    }

    /// Meaning of the kind, in a sentence.
    pub fn meaning(self) -> &'static str {
        KINDS[self.number()].2
    }

    /// Colours of the kind on dark and on light ground (0xRRGGBB).
    pub fn colours(self) -> [u32; 2] {
        KINDS[self.number()].3
    }
}

/// Something that happened to an agent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgentEvent {
    /// When (s).
    pub time_s: f64,
    /// The character.
    pub agent: usize,
    /// Kind of the event.
    pub kind: AgentEventKind,
    /// The other party.
    pub other_party: OtherParty,
    /// Number of the place of the event.
    pub place: Option<usize>,
    /// Number of the message of the event.
    pub message: Option<usize>,
    /// Position of the agent (m).
    pub at: Vec3,
    /// Position of the other agent (m).
    pub other_at: Option<Vec3>,
}

impl AgentEvent {
    /// True where it has to do with an agent.
    pub fn is_about(&self, agent: usize) -> bool {
        self.agent == agent || self.other_party.other() == Some(agent)
    }
}

/// Events so far, as many as are kept.
#[derive(Clone, Debug, Default)]
pub struct EventLog {
    /// In order of time. Kinds are kept apart, so that the many do not drive out the few.
    kinds: [VecDeque<AgentEvent>; AgentEventKind::COUNT],
    watched: Option<usize>,
    of_watched: VecDeque<AgentEvent>,
    totals: [u64; AgentEventKind::COUNT],
    /// Event rates: numbers of events of every kind over time.
    pub rates: EventRates,
}

impl EventLog {
    /// Adds an event, later than all others.
    pub fn add(&mut self, happened: AgentEvent) {
        self.totals[happened.kind.number()] += 1;
        push(&mut self.kinds[happened.kind.number()], happened);
        if self.watched.is_some_and(|m| happened.is_about(m)) {
            push(&mut self.of_watched, happened);
        }
    }

    /// Notes how many events there were until a time.
    pub fn record_totals(&mut self, time_s: f64, present: usize) {
        self.rates.record_totals(time_s, present, self.totals);
    }

    /// Keeps the events of another agent separately from now on; starts with its earlier ones that are still kept.
    pub fn watch(&mut self, agent: Option<usize>) {
        self.watched = agent;
        let all = self.kinds.iter().flatten();
        let mut old: Vec<AgentEvent> = all.filter(|h| agent.is_some_and(|m| h.is_about(m))).copied().collect();
        old.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        self.of_watched = old.into();
    }

    /// Removes the events after a time.
    pub fn forget_after(&mut self, time_s: f64) {
        for list in self.kinds.iter_mut().chain([&mut self.of_watched]) {
            list.truncate(list.partition_point(|h| h.time_s <= time_s));
        }
        self.totals = self.rates.forget_after(time_s);
    }

    /// The last events that a filter accepts until a time, the latest first.
    pub fn last(&self, filter: &EventFilter, until_s: f64, most: usize) -> Vec<AgentEvent> {
        let kinds = self.kinds.iter().zip(filter.kinds).filter(|k| k.1);
        let of_kind = |k: &VecDeque<AgentEvent>| {
            k.iter().rev().filter(|h| filter.matches_until(until_s, h)).take(most).copied().collect::<Vec<_>>()
        };
        let mut all: Vec<AgentEvent> = kinds.flat_map(|(k, _)| of_kind(k)).collect();
        // Events of one agent at the same time stay in order.
        all.sort_by(|a, b| b.time_s.total_cmp(&a.time_s));
        all.truncate(most);
        all
    }

    /// The last events of the watched agent that a filter accepts, the latest first.
    pub fn last_of_watched(&self, filter: &EventFilter, until_s: f64, most: usize) -> Vec<AgentEvent> {
        self.of_watched.iter().rev().filter(|h| filter.matches_until(until_s, h)).take(most).copied().collect()
    }
}

fn push(list: &mut VecDeque<AgentEvent>, happened: AgentEvent) {
    if list.len() == KEPT {
        list.pop_front();
    }
    list.push_back(happened);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(time_s: f64, what: AgentEventKind, agent: usize, with: OtherParty) -> AgentEvent {
        AgentEvent {
            time_s,
            agent,
            kind: what,
            other_party: with,
            place: None,
            message: None,
            at: Vec3::ZERO,
            other_at: None,
        }
    }

    #[test]
    fn each_kind_has_its_own_place() {
        assert!(KINDS.iter().enumerate().all(|(i, k)| k.0.number() == i));
    }

    #[test]
    fn frequent_events_do_not_displace_rare_ones() {
        let mut log = EventLog::default();
        log.add(event(0.5, AgentEventKind::Stuck, 7, OtherParty::None));
        for i in 0..3 * KEPT {
            log.add(event(1.0 + i as f64, AgentEventKind::Resetting, i, OtherParty::None));
        }
        let all = EventFilter::of_kinds([true; AgentEventKind::COUNT]);
        let newest = log.last(&all, f64::INFINITY, 2);
        assert_eq!(newest.iter().map(|h| h.agent).collect::<Vec<_>>(), [3 * KEPT - 1, 3 * KEPT - 2]);
        let mut rare = EventFilter::of_kinds([false; AgentEventKind::COUNT]);
        rare.kinds[AgentEventKind::Stuck.number()] = true;
        assert_eq!(log.last(&rare, f64::INFINITY, 9)[0].agent, 7);
        assert!(log.last(&rare, 0.4, 9).is_empty(), "it has not happened yet");
        let then = (2 * KEPT + 10) as f64 + 1.5;
        assert_eq!(log.last(&all, then, 1)[0].agent, 2 * KEPT + 10);
    }

    #[test]
    fn events_of_the_selected_agent_include_those_it_takes_part_in() {
        let mut log = EventLog::default();
        log.add(event(1.0, AgentEventKind::Colliding, 3, OtherParty::Agent(5)));
        log.add(event(2.0, AgentEventKind::Colliding, 1, OtherParty::Agent(2)));
        log.watch(Some(5));
        log.add(event(3.0, AgentEventKind::Resetting, 5, OtherParty::None));
        let all = EventFilter::of_kinds([true; AgentEventKind::COUNT]);
        let times = |until| log.last_of_watched(&all, until, 9).iter().map(|h| h.time_s).collect::<Vec<_>>();
        assert_eq!((times(9.0), times(2.5)), (vec![3.0, 1.0], vec![1.0]));
        log.forget_after(2.0);
        let times = |until| log.last_of_watched(&all, until, 9).iter().map(|h| h.time_s).collect::<Vec<_>>();
        assert_eq!((times(9.0), log.last(&all, 9.0, 9).len()), (vec![1.0], 2));
    }

    #[test]
    fn events_are_filtered_by_place_and_message() {
        let mut log = EventLog::default();
        let told = OtherParty::Message("passed_on", Some(2));
        log.add(AgentEvent { message: Some(1), ..event(1.0, AgentEventKind::Learnt, 5, told) });
        log.add(AgentEvent {
            message: Some(0),
            ..event(2.0, AgentEventKind::Learnt, 6, OtherParty::Message("happens", None))
        });
        log.add(AgentEvent { place: Some(3), ..event(3.0, AgentEventKind::EnteredPlace, 5, OtherParty::None) });
        log.add(AgentEvent {
            place: Some(3),
            message: Some(1),
            ..event(4.0, AgentEventKind::Edge, 7, OtherParty::Edge(0, 1, None))
        });
        let all = EventFilter::of_kinds([true; AgentEventKind::COUNT]);
        let times = |filter: &EventFilter| log.last(filter, 9.0, 9).iter().map(|h| h.time_s).collect::<Vec<_>>();
        assert_eq!(times(&all), [4.0, 3.0, 2.0, 1.0]);
        assert_eq!(times(&EventFilter { place: Some(3), ..all }), [4.0, 3.0]);
        assert_eq!(times(&EventFilter { message: Some(1), ..all }), [4.0, 1.0]);
        assert_eq!(times(&EventFilter { place: Some(3), message: Some(0), ..all }), [0.0; 0]);
        log.watch(Some(2));
        assert_eq!(log.last_of_watched(&all, 9.0, 9).len(), 1, "who tells takes part");
    }
}
