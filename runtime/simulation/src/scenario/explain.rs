//! Explanations of agents: why an agent does what it does, what it knows and from whom.

use super::agent_brain::{LearntEvent, NO_NUMBER};
use super::agent_brains::AgentBrains;
use super::blackboards::{BlackboardPost, Blackboards};
use super::tables::{CompiledAction, LearningMode, NONE, Scenario};
use serde::Serialize;
use std::fmt;
use throng_base::Error;

/// Activity of an agent, and its causes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Explanation {
    /// Time (s).
    pub time_s: f64,
    /// Number of the agent.
    pub agent: usize,
    /// Name of the agent's group.
    pub group: String,
    /// Whether the agent has entered and not left.
    pub is_there: bool,
    /// Names of the agent's states, the highest level first.
    pub states: Vec<String>,
    /// Name of the current primitive behaviour; empty where the agent follows its goal.
    pub action: String,
    /// Whether a rule's behaviour has interrupted another one.
    pub interrupted: bool,
    /// Place where the agent holds a slot.
    pub slot_of: Option<String>,
    /// Cause of the current activity.
    pub because: ActionCause,
    /// Current values of the agent.
    pub values: Vec<CurrentValue>,
    /// Events that the agent knows of.
    pub knows: Vec<KnownEvent>,
}

/// Cause of an agent's activity.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ActionCause {
    /// Time (s).
    pub time_s: f64,
    /// Name of the event.
    pub event: String,
    /// Name of the rule that was followed.
    pub rule: Option<String>,
    /// Name of the state to which an edge led.
    pub edge_to: Option<String>,
    /// Number of the agent that was met, or that told of the event.
    pub other: Option<usize>,
    /// Name of the event's place.
    pub place: Option<String>,
}

/// Named value of an agent.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CurrentValue {
    /// Name of the value.
    pub name: String,
    /// Current value.
    pub value: f32,
}

/// Knowledge of an event, and how an agent came by it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KnownEvent {
    /// Name of the event.
    pub event: String,
    /// Way in which it was learnt: "happens", "passed_on", "read" or "felt".
    pub how: String,
    /// Number of the agent that it was learnt from.
    pub from: Option<usize>,
    /// Time (s).
    pub time_s: f64,
    /// Position of the agent when it learnt of the event, x and z (m).
    pub at: [f32; 2],
}

/// Spread of an event among agents.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct EventSpread {
    /// Name of the event.
    pub event: String,
    /// Number of agents that know of the event.
    pub informed: usize,
    /// Number of these that learnt of it from others.
    pub passed_on: usize,
    /// Time at which the last of them learnt of it (s).
    pub last_s: Option<f64>,
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "agent {} of {} at {:.2} s", self.agent, self.group, self.time_s)?;
        if !self.is_there {
            f.write_str(" is not there")?;
        }
        if !self.states.is_empty() {
            write!(f, ": {}", self.states.join(" > "))?;
        }
        if !self.action.is_empty() {
            write!(f, ", action `{}`", self.action)?;
        }
        let b = &self.because;
        write!(f, "\nbecause of `{}` at {:.2} s", b.event, b.time_s)?;
        if let Some(other) = b.other {
            write!(f, ", with agent {other}")?;
        }
        if let Some(place) = &b.place {
            write!(f, ", at {place}")?;
        }
        match (&b.rule, &b.edge_to) {
            (Some(rule), _) => write!(f, ", by rule \"{rule}\"")?,
            (None, Some(state)) => write!(f, ", by an edge to `{state}`")?,
            (None, None) => {}
        }
        writeln!(f)?;
        self.values.iter().try_for_each(|value| writeln!(f, "{} = {:.3}", value.name, value.value))?;
        for known in &self.knows {
            write!(f, "knows of `{}` since {:.2} s ({}", known.event, known.time_s, known.how)?;
            if let Some(from) = known.from {
                write!(f, " by agent {from}")?;
            }
            writeln!(f, ")")?;
        }
        Ok(())
    }
}

impl AgentBrains {
    /// Explains the activity of an agent, with its values at a time not before the last event (s, agent < number of agents).
    pub fn explain(&self, agent: usize, time_s: f64) -> Explanation {
        let time_s = time_s.max(self.now);
        let (brain, scenario) = (&self.brains[agent], &self.scenario);
        let state = |s: &&u16| **s != NO_NUMBER;
        let reason = &brain.reason;
        let of = |number: u32, name: &dyn Fn(usize) -> String| (number != NONE).then(|| name(number as usize));
        let place = |p: u16| (p != NO_NUMBER).then(|| scenario.names.places.0[usize::from(p)].clone());
        Explanation {
            time_s,
            agent,
            group: scenario.names.groups.0[usize::from(brain.group)].clone(),
            is_there: brain.is_there,
            states: brain.states.iter().filter(state).map(|s| scenario.states[usize::from(*s)].name.clone()).collect(),
            action: match (brain.action != NONE).then(|| self.action(brain.action)) {
                Some(CompiledAction::Primitive { number, .. }) => scenario.primitives.get(number).name.into(),
                _ => String::new(),
            },
            interrupted: brain.is_busy,
            slot_of: (brain.slot != NONE).then(|| scenario.slots[brain.slot as usize].place).and_then(place),
            because: ActionCause {
                time_s: reason.time_s,
                event: scenario.trigger_name(reason.trigger),
                rule: of(reason.rule, &|r| scenario.rules[r].name.clone()),
                edge_to: of(reason.edge, &|e| scenario.states[usize::from(scenario.edges[e].to)].name.clone()),
                other: of(reason.other, &|o| o.to_string()).and_then(|o| o.parse().ok()),
                place: place(reason.place),
            },
            values: self.values_of(agent, time_s),
            knows: (0..scenario.events.len()).filter_map(|e| self.known_event(agent, e)).collect(),
        }
    }

    fn values_of(&self, agent: usize, time_s: f64) -> Vec<CurrentValue> {
        let tables = &self.scenario.values;
        let names = self.scenario.names.values.0.iter();
        let feelings = &self.feelings[agent * tables.len()..][..tables.len()];
        let all = names.zip(feelings.iter().zip(tables));
        all.map(|(name, (f, table))| CurrentValue { name: name.clone(), value: f.value_at(table, time_s) }).collect()
    }

    fn known_event(&self, agent: usize, event: usize) -> Option<KnownEvent> {
        let learnt = self.learnt[agent * self.scenario.events.len() + event]?;
        let (event, how) = (self.scenario.names.events.0[event].clone(), learnt.mode_name().into());
        Some(KnownEvent { event, how, from: learnt.source_agent(), time_s: learnt.time_s, at: learnt.at })
    }

    /// Spread of every event.
    pub fn event_spreads(&self) -> Vec<EventSpread> {
        let num = self.scenario.events.len();
        let of = |e: usize| (0..self.brains.len()).filter_map(move |a| self.learnt[a * num + e]);
        let spread = |e: usize| EventSpread {
            event: self.scenario.names.events.0[e].clone(),
            informed: of(e).count(),
            passed_on: of(e).filter(|l| l.how == LearningMode::PassedOn).count(),
            last_s: of(e).map(|l| l.time_s).reduce(f64::max),
        };
        (0..num).map(spread).collect()
    }

    /// Agents that learnt of an event, in the order of time, and how they did.
    ///
    /// # Errors
    /// [`throng_base::Error::Unknown`] with the names of all events.
    pub fn event_learners(&self, event: &str) -> throng_base::Result<Vec<(usize, KnownEvent)>> {
        let e = self.event_number(event)?;
        let mut all: Vec<_> = (0..self.brains.len()).filter_map(|a| Some((a, self.known_event(a, e)?))).collect();
        all.sort_by(|a, b| a.1.time_s.total_cmp(&b.1.time_s).then(a.0.cmp(&b.0)));
        Ok(all)
    }

    /// Number of the event of that name.
    pub(super) fn event_number(&self, name: &str) -> throng_base::Result<usize> {
        let events = &self.scenario.names.events;
        let unknown = || Error::Unknown { what: "event", name: name.into(), known: events.0.clone() };
        events.number_of(name).ok_or_else(unknown)
    }

    /// Names of the events that may be raised.
    pub fn event_names(&self) -> &[String] {
        &self.scenario.names.events.0
    }

    /// Number of agents that hold more than one slot, which must be 0.
    pub fn num_holding_twice(&self) -> usize {
        let held = |agent: u32| self.holders.iter().filter(|h| **h == agent).count();
        (0..self.brains.len() as u32).filter(|a| held(*a) > 1).count()
    }

    /// Number of agents in each state of the highest level, by name, without agents that have no state.
    pub fn num_in_states(&self) -> Vec<(String, usize)> {
        let mut out: Vec<(String, usize)> = Vec::new();
        for brain in self.brains.iter().filter(|m| m.is_there) {
            let Some(state) = brain.states.iter().find(|s| **s != NO_NUMBER) else { continue };
            let name = &self.scenario.states[usize::from(*state)].name;
            match out.iter_mut().find(|o| o.0 == *name) {
                Some(found) => found.1 += 1,
                None => out.push((name.clone(), 1)),
            }
        }
        out
    }

    /// Memory for each agent, without body, crowd and paths (bytes).
    pub fn bytes_per_agent(&self) -> usize {
        let of = |count: usize, size: usize| count * size / self.brains.len().max(1);
        size_of::<super::agent_brain::AgentBrain>()
            + size_of::<super::agent_brain::AgentEngagement>()
            + of(self.feelings.len(), size_of::<super::agent_brain::Feeling>())
            + of(self.learnt.len(), size_of::<Option<super::agent_brain::LearntEvent>>())
            + of(self.followed.len(), size_of::<f64>())
            + of(self.relationships.len(), size_of::<[(u32, f32); 4]>())
            + size_of::<u32>()
            + size_of::<bool>()
    }

    /// Number of predicates and amounts evaluated so far.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// All posts that blackboards show now: those of the global one, then those of cells.
    pub fn posts(&self) -> impl Iterator<Item = BlackboardPost> + '_ {
        self.blackboards.visible_posts(self.now)
    }

    /// Side of the smallest cells with blackboards (m), and the number of levels, each twice as wide; `None` without cells.
    pub fn blackboard_levels(&self) -> Option<(f32, u32)> {
        let Blackboards { cell_m, levels, .. } = self.blackboards;
        (cell_m > 0.0).then_some((cell_m, levels))
    }

    /// Record of how an agent learnt of an event; `None` where it has not (agent < number of agents, event < number of events).
    pub fn learnt_event(&self, agent: usize, event: usize) -> Option<&LearntEvent> {
        self.learnt[agent * self.scenario.events.len() + event].as_ref()
    }
}

impl LearntEvent {
    /// Number of the agent that it was learnt from.
    pub fn source_agent(&self) -> Option<usize> {
        (self.from != NONE).then_some(self.from as usize)
    }

    /// Way in which it was learnt: "happens", "passed_on", "read" or "felt".
    pub fn mode_name(&self) -> &'static str {
        self.how.name()
    }
}

impl Scenario {
    /// Numbers of rows of all tables, by name.
    pub fn table_sizes(&self) -> [(&'static str, usize); 10] {
        [
            ("events", self.events.len()),
            ("rules", self.rules.len()),
            ("states", self.states.len()),
            ("edges", self.edges.len()),
            ("actions", self.actions.iter().filter(|a| !matches!(a, CompiledAction::End)).count()),
            ("operations", self.code.len()),
            ("places", self.places.len()),
            ("slots", self.slots.len()),
            ("values", self.values.len()),
            ("thresholds", self.thresholds.len()),
        ]
    }

    /// Motion tags that actions ask for.
    pub fn motion_tags(&self) -> &[String] {
        &self.motions
    }
}
