//! Turns: records of what happens in agent brains, kept only on request.

use super::agent_brain::{NO_NUMBER, Occasion};
use super::agent_brains::{AgentBrains, Stimulus};
use super::tables::{NONE, trigger};

/// Turn: one event in an agent's brain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Time (s).
    pub time_s: f64,
    /// Number of the agent.
    pub agent: usize,
    /// Kind of the turn.
    pub kind: TurnKind,
    /// Number of its trigger, for [`AgentBrains::trigger_name`].
    pub on: u16,
    /// Number of the agent that was met, or that told of the event.
    pub other: Option<usize>,
    /// Number of the place, in [`AgentBrains::place_names`].
    pub place: Option<usize>,
    /// Number of the event, in [`AgentBrains::event_names`].
    pub event: Option<usize>,
}

/// Kind of a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnKind {
    /// The agent entered the scene.
    Starts,
    /// The agent came to a place.
    Enters,
    /// The agent left a place.
    Leaves,
    /// The agent learnt of an event: "happens", "passed_on", "read" or "felt".
    Learns(&'static str),
    /// The agent followed a rule, of this number.
    Follows(usize),
    /// The agent took an edge of a graph.
    Takes {
        /// Level of the graph: 0 is the highest.
        level: usize,
        /// Number of the graph, in the order of their names.
        graph: usize,
        /// Number of the edge in its graph, as in the scene file.
        edge: usize,
        /// Whether it led to another state, so that all graphs below began anew.
        changes: bool,
    },
}

/// Current state of an agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurrentState<'a> {
    /// Name of the graph.
    pub graph: &'a str,
    /// Name of the state.
    pub state: &'a str,
}

impl AgentBrains {
    /// Starts to record turns, for [`AgentBrains::turns`].
    pub(crate) fn record_turns(&mut self) {
        self.turns.get_or_insert_default();
    }

    /// Removes the recorded turns.
    pub(crate) fn clear_turns(&mut self) {
        self.turns.iter_mut().for_each(Vec::clear);
    }

    /// Turns of the last step, or of the last external call, in order; empty unless they are recorded
    /// ([`crate::agents::SceneAgents::record_events`]).
    pub fn turns(&self) -> &[Turn] {
        self.turns.as_deref().unwrap_or_default()
    }

    /// States of an agent, the highest level first (agent < number of agents).
    pub fn states_of(&self, agent: usize) -> [Option<CurrentState<'_>>; 3] {
        self.brains[agent].states.map(|s| {
            let state = self.scenario.states.get(usize::from(s)).filter(|_| s != NO_NUMBER)?;
            Some(CurrentState { graph: &self.scenario.graphs[usize::from(state.graph_number)], state: &state.name })
        })
    }

    /// Name of a trigger of turns: an event, `enters`, `done` and others.
    pub fn trigger_name(&self, on: u16) -> String {
        self.scenario.trigger_name(on)
    }

    /// Name of a rule; empty where it has none.
    pub fn rule_name(&self, number: usize) -> &str {
        self.scenario.rules.get(number).map_or("", |r| &r.name)
    }

    /// Names of places.
    pub fn place_names(&self) -> &[String] {
        &self.scenario.names.places.0
    }

    /// Records a stimulus as a turn of its own, where turns are recorded and the stimulus is of interest by itself.
    pub(super) fn record_sensed(&mut self, stimulus: Stimulus) {
        if self.turns.is_none() {
            return;
        }
        let kind = match stimulus.trigger {
            trigger::STARTS => TurnKind::Starts,
            trigger::ENTERS => TurnKind::Enters,
            trigger::LEAVES => TurnKind::Leaves,
            _ => match self.newly_learnt(stimulus.on) {
                Some(how) => TurnKind::Learns(how),
                None => return,
            },
        };
        self.record_turn(stimulus, kind);
    }

    /// Way in which an agent has just learnt of the event of a context; `None` where it knew of it before.
    fn newly_learnt(&self, Occasion { agent, context }: Occasion) -> Option<&'static str> {
        if context.event == NO_NUMBER {
            return None;
        }
        let of = agent as usize * self.scenario.events.len() + usize::from(context.event);
        let is_it =
            self.learnt[of].is_some_and(|l| (l.time_s, l.from, l.how) == (self.now, context.other, context.how));
        is_it.then(|| context.how.name())
    }

    /// Records a turn, where turns are recorded.
    pub(super) fn record_turn(&mut self, stimulus: Stimulus, kind: TurnKind) {
        let (time_s, Occasion { agent, context }) = (self.now, stimulus.on);
        let some = |number: u16| (number != NO_NUMBER).then_some(usize::from(number));
        if let Some(turns) = &mut self.turns {
            let other = (context.other != NONE).then_some(context.other as usize);
            let (place, event) = (some(context.place), some(context.event));
            turns.push(Turn { time_s, agent: agent as usize, kind, on: stimulus.trigger, other, place, event });
        }
    }
}
