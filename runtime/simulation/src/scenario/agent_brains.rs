//! Brains of all agents: they take stimuli and decide on behaviours.

use super::agent_brain::{AgentBrain, AgentEngagement, EventContext, Feeling, LearntEvent, Occasion};
use super::blackboards::Blackboards;
use super::language::{Program, run_program};
use super::perceive::{AgentView, hashed_chance};
use super::tables::{CompiledAction, GroupTable, NONE, Scenario};
use super::{reactions::MOST_ROUNDS, services::ServiceRecord, stage::ScenarioStage, turns::Turn};
use serde::{Deserialize, Serialize};
use std::{collections::VecDeque, sync::Arc};
use throng_base::{Result, error::ensure};

/// Time between two looks at the conditions of events (s).
const LOOKS_S: f64 = 0.25;
/// Bit for meetings among those that agents sense of each other.
const MEETINGS: u32 = 1 << 31;

/// Stimulus: a trigger that happens to an agent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stimulus {
    pub trigger: u16,
    pub on: Occasion,
    /// Number of behaviours that the agent had begun by then.
    pub begun: u16,
}

/// Signal from the crowd to the brains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Signal {
    /// Two agents come within talking distance.
    Met(u32, u32),
    /// An agent comes to a place.
    CameTo(u32, u16),
    /// An agent leaves a place.
    WentFrom(u32, u16),
    /// An agent crosses the side of a cell.
    Crossed(u32),
    /// An agent reaches the end of its path.
    Arrived(u32),
    /// An agent has left.
    Left(u32),
    /// An agent makes no progress.
    Stuck(u32),
    /// A timer of an agent is due.
    Timer(u32),
}

impl Signal {
    /// Agent to which it happens; of two, the one with the smaller number.
    pub(super) fn agent(self) -> u32 {
        match self {
            Self::Met(agent, _)
            | Self::CameTo(agent, _)
            | Self::WentFrom(agent, _)
            | Self::Crossed(agent)
            | Self::Arrived(agent)
            | Self::Left(agent)
            | Self::Stuck(agent)
            | Self::Timer(agent) => agent,
        }
    }
}

/// Brains of all agents, and their shared state. Snapshots keep all but what is skipped, in this order.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AgentBrains {
    #[serde(skip)]
    pub(super) scenario: Arc<Scenario>,
    #[serde(skip)]
    pub(super) seed: u64,
    pub(super) now: f64,
    /// Time of the last rule without duration that any agent followed (s), and its number, for messages.
    #[serde(skip)]
    pub(super) at_once: (f64, u32),
    pub(super) brains: Vec<AgentBrain>,
    pub(super) engagements: Vec<AgentEngagement>,
    /// (agents x values)
    pub(super) feelings: Vec<Feeling>,
    /// (agents x events)
    pub(super) learnt: Vec<Option<LearntEvent>>,
    /// Time at which each agent last followed each rule with a pause (s, agents x such rules).
    pub(super) followed: Vec<f64>,
    /// Relationships that differ from the relations of the scene: the last four agents of each, with added liking (agents).
    pub(super) relationships: Vec<[(u32, f32); 4]>,
    /// Agent that holds each slot; [`NONE`] for none. Those of a queue are held without a gap: `release_slot` closes gaps,
    /// `join_before_absent` changes the order.
    pub(super) holders: Vec<u32>,
    /// What tills and lines of each service have done.
    pub(super) services: Vec<ServiceRecord>,
    /// Agent that has each thing in hand, or a claim to take it; [`NONE`] for none.
    pub(super) keepers: Vec<u32>,
    pub(super) is_open: Vec<bool>,
    /// Time of the next try to close each door that is blocked (s).
    pub(super) closing: Vec<f64>,
    /// Next time of each event (s), and number of its occurrences.
    pub(super) due: Vec<f64>,
    pub(super) times: Vec<u32>,
    /// Last time of each event (s).
    pub(super) happened: Vec<f64>,
    /// Whether the condition of each event was true.
    pub(super) was_true: Vec<bool>,
    /// Time of the next entry of each group (s), and number of agents that have entered.
    pub(super) enters: Vec<f64>,
    pub(super) entered: Vec<u32>,
    /// Number of entries of agents of each group that had left, and of tries of its source that found no room.
    pub(super) reused: Vec<u32>,
    pub(super) refused: Vec<u32>,
    pub(super) blackboards: Blackboards,
    /// Desired speed of each agent as it enters (m/s).
    #[serde(skip)]
    pub(super) first_speeds: Vec<f32>,
    #[serde(skip)]
    pub(super) queue: VecDeque<Stimulus>,
    /// Agents whose timers and senses have to be updated.
    #[serde(skip)]
    pub(super) touched: Vec<u32>,
    #[serde(skip)]
    pub(super) is_touched: Vec<bool>,
    #[serde(skip)]
    pub(super) nearby: Vec<u32>,
    pub(super) ended: bool,
    /// Number of predicates and amounts evaluated.
    #[serde(skip)]
    pub(super) evaluations: u64,
    /// Turns of the last step, where they are recorded.
    #[serde(skip)]
    pub(super) turns: Option<Vec<Turn>>,
}

impl AgentBrains {
    /// Brains of all agents of a scenario, before any agent has entered.
    pub fn new(scenario: Arc<Scenario>, seed: u64, doors: &[bool]) -> Self {
        let num = scenario.groups.last().map_or(0, |g| g.agents[1] as usize);
        let of_group =
            |(g, group): (u16, &GroupTable)| (group.agents[0]..group.agents[1]).map(move |_| AgentBrain::new(g));
        let brains = (0u16..).zip(&scenario.groups).flat_map(of_group).collect();
        let num_events = scenario.events.len();
        let mut out = Self {
            seed,
            now: 0.0,
            at_once: (-1.0, NONE),
            brains,
            engagements: vec![AgentEngagement::default(); num],
            feelings: vec![Feeling::default(); num * scenario.values.len()],
            learnt: vec![None; num * num_events],
            followed: vec![f64::NEG_INFINITY; num * scenario.num_pauses],
            relationships: vec![[(NONE, 0.0); 4]; if scenario.changes_relationships() { num } else { 0 }],
            holders: vec![NONE; scenario.slots.len()],
            services: scenario.service_records(),
            keepers: vec![NONE; scenario.things.len()],
            is_open: doors.to_vec(),
            closing: vec![f64::INFINITY; doors.len()],
            due: vec![f64::INFINITY; num_events],
            times: vec![0; num_events],
            happened: vec![f64::NEG_INFINITY; num_events],
            was_true: vec![false; num_events],
            enters: vec![f64::INFINITY; scenario.groups.len()],
            entered: scenario.groups.iter().map(|g| g.num_at_start).collect(),
            reused: vec![0; scenario.groups.len()],
            refused: vec![0; scenario.groups.len()],
            first_speeds: Vec::new(),
            blackboards: Blackboards::new(scenario.blackboards, num_events),
            queue: VecDeque::with_capacity(4 * num + 64),
            touched: Vec::with_capacity(num),
            is_touched: vec![false; num],
            nearby: Vec::with_capacity(num),
            ended: false,
            evaluations: 0,
            turns: None,
            scenario,
        };
        for e in 0..num_events {
            out.due[e] = out.next_event_time(e, 0.0);
        }
        for g in 0..out.enters.len() {
            out.enters[g] = out.next_entry_time(g, 0.0);
        }
        out
    }

    /// Starts all agents that are there at the start.
    ///
    /// # Errors
    /// Errors of the stage, and [`throng_base::Error::Text`] where rules run in a circle.
    pub fn begin_scene(&mut self, stage: &mut impl ScenarioStage, speeds: &[f32]) -> Result<()> {
        self.first_speeds = speeds.to_vec();
        for agent in 0..self.brains.len() as u32 {
            self.brains[agent as usize].speed = speeds[agent as usize];
            let group = &self.scenario.groups[usize::from(self.brains[agent as usize].group)];
            if agent - group.agents[0] < group.num_at_start {
                self.begin_agent(stage, agent)?;
            }
        }
        self.process_stimuli(stage)
    }

    /// Time of the next external event (s).
    pub fn next_external_s(&self) -> f64 {
        let all = self.due.iter().chain(&self.enters).chain(&self.closing);
        let looks = self.scenario.events.iter().any(|event| event.condition.is_some());
        // Conditions become true while nobody acts, too.
        let next_look_s = if looks { (self.now / LOOKS_S).floor() * LOOKS_S + LOOKS_S } else { f64::INFINITY };
        all.copied().fold(next_look_s, f64::min)
    }

    pub(super) fn push_stimulus(&mut self, agent: u32, trigger: u16, context: EventContext) {
        let begun = self.brains[agent as usize].begun;
        self.queue.push_back(Stimulus { trigger, on: Occasion { agent, context }, begun });
    }

    pub(super) fn mark_touched(&mut self, agent: u32) {
        if !std::mem::replace(&mut self.is_touched[agent as usize], true) {
            self.touched.push(agent);
        }
    }

    /// Handles all stimuli of this time, and updates timers and senses of the touched agents on the stage.
    pub(super) fn process_stimuli(&mut self, stage: &mut impl ScenarioStage) -> Result<()> {
        let mut rounds = 0;
        loop {
            while let Some(stimulus) = self.queue.pop_front() {
                let Occasion { agent, .. } = stimulus.on;
                if self.brains[agent as usize].is_there {
                    self.mark_touched(agent);
                    self.handle_stimulus(stage, stimulus)?;
                }
            }
            if !self.check_conditions(stage)? {
                break;
            }
            rounds += 1;
            ensure(rounds <= MOST_ROUNDS, || self.event_circle_error())?;
        }
        for i in 0..self.touched.len() {
            let agent = self.touched[i];
            self.is_touched[agent as usize] = false;
            let brain = &self.brains[agent as usize];
            if !brain.is_there {
                continue;
            }
            let wake_s = brain.wake_times().into_iter().fold(f64::INFINITY, f64::min);
            let (sends, receives) = self.senses_of(agent);
            stage.set_timer(agent, Some(wake_s).filter(|t| t.is_finite()))?;
            stage.set_senses(agent, sends, receives)?;
        }
        self.touched.clear();
        let left = |g: usize| {
            let group = &self.scenario.groups[g];
            let is_there = |a: u32| self.brains[a as usize].is_there;
            self.entered[g] == group.agents[1] - group.agents[0] && !(group.agents[0]..group.agents[1]).any(is_there)
        };
        let end = self.scenario.end;
        self.ended |= end.left != 0 && (0..self.enters.len()).all(|g| end.left >> g & 1 == 0 || left(g));
        self.ended |= end.known.is_some_and(|e| {
            let mut there = self.brains.iter().filter(|m| m.is_there);
            there.all(|m| m.news >> e & 1 == 1)
        });
        Ok(())
    }

    /// Events that an agent tells and hears of, as bits: (tells, hears).
    fn senses_of(&self, agent: u32) -> (u32, u32) {
        let AgentBrain { news, told_at, .. } = self.brains[agent as usize];
        let meets = if self.scenario.meets { MEETINGS } else { 0 };
        let (mut sends, mut receives) = (meets, meets);
        for (e, event) in self.scenario.events.iter().enumerate() {
            let Some(channel) = event.channel else { continue };
            match news >> e & 1 == 1 {
                true if self.now - self.happened[e] <= event.fresh_s => sends |= 1 << channel,
                // An agent listens to one at a time.
                false if told_at == f64::INFINITY => receives |= 1 << channel,
                _ => {}
            }
        }
        (sends, receives)
    }

    /// True for a scene with events.
    pub fn has_events(&self) -> bool {
        !self.scenario.events.is_empty()
    }

    /// Number of agents, including those that enter later or have left.
    pub fn len(&self) -> usize {
        self.brains.len()
    }

    /// True for an agent that acts by a rule or in a state (agent < number of agents).
    pub(crate) fn acts(&self, agent: usize) -> bool {
        self.brains[agent].action != NONE
    }

    /// Desired speed of an agent beside its actions (m/s, agent < number of agents).
    pub(crate) fn own_speed(&self, agent: usize) -> f32 {
        self.brains[agent].speed
    }

    /// True where there are no agents.
    pub fn is_empty(&self) -> bool {
        self.brains.is_empty()
    }

    /// Number of agents that know of any event.
    pub fn num_informed(&self) -> usize {
        self.brains.iter().filter(|m| m.news != 0).count()
    }

    /// Number of motion tags that actions ask for.
    pub(crate) fn num_motions(&self) -> usize {
        self.scenario.motions.len()
    }

    /// True for an agent that has entered, whether it has left or not (agent < number of agents).
    pub(crate) fn has_entered(&self, agent: usize) -> bool {
        let group = usize::from(self.brains[agent].group);
        (agent as u32) < self.scenario.groups[group].agents[0] + self.entered[group]
    }

    /// True once the scene has ended.
    pub fn has_ended(&self) -> bool {
        self.ended
    }

    /// Number of events that an agent knows of (agent < number of agents).
    pub fn num_known(&self, agent: usize) -> u32 {
        self.brains[agent].news.count_ones()
    }

    /// Next random number of an agent, from 0 up to 1.
    pub(super) fn draw_chance(&mut self, agent: u32) -> f64 {
        let draws = &mut self.brains[agent as usize].draws;
        *draws += 1;
        hashed_chance(self.seed, agent, *draws)
    }

    pub(super) fn evaluate_predicate(&mut self, stage: &impl ScenarioStage, on: Occasion, program: Program) -> bool {
        self.evaluate_program(stage, on, program) != 0.0
    }

    /// Evaluates an amount or a predicate for an agent.
    pub(super) fn evaluate_program(&mut self, stage: &impl ScenarioStage, on: Occasion, program: Program) -> f64 {
        let Occasion { agent, context } = on;
        self.evaluations += 1;
        let mut draws = self.brains[agent as usize].draws;
        let mut view = AgentView { brains: self, stage, agent, context, now: self.now, draws: &mut draws };
        let value = run_program(&self.scenario.code, program, &mut view);
        self.brains[agent as usize].draws = draws;
        value
    }

    pub(super) fn action(&self, number: u32) -> CompiledAction {
        self.scenario.actions[number as usize]
    }
}

pub(super) fn place_context(place: u16) -> EventContext {
    EventContext { place, ..EventContext::default() }
}
