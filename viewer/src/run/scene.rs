//! A scene: groups with any source of motion, played, stopped, and rewound over its last minute.
//!
//! Bodies are not recorded. The state of every second is, and every input; a step in between is reproduced by
//! repeating the steps after the state before it, bit for bit.

mod state;

pub use state::{detail_level, is_at_target, target_home};

use super::agents::{AgentEvent, AgentEventKind, EventLog, OtherParty, SpreadLog, StateEntry, first_agent};
use super::figures::{BlowMark, StepFigures, record_blows};
use super::{RunInput, STEP_HZ, choices::RunGoal, reel::PlayHead};
use glam::{Vec2, Vec3};
use state::SceneRunState;
use std::{collections::VecDeque, time::Instant};
use throng_core::Result;
use throng_crowd::{CrowdEvent, Space};
use throng_precompute::run::policy_characters;
use throng_simulation::agents::{SceneAgents, world_vector};
use throng_simulation::{AnyCharacterGroup, CompiledScene, MotionKind, Simulation, SimulationEvent};

/// Steps between two states.
const STATE_EVERY: u32 = 60;
/// Steps that can be gone back: one minute.
const RECORDED_STEPS: u32 = 3600;
/// Memory that states may take (bytes).
const MAX_BYTES: usize = 512 << 20;
/// Approximate size of a state for a character with a blended body, for one with policies, for an agent without a body,
/// and for a node of a world, about which a planner keeps data (bytes).
const BODY_BYTES: usize = 16 << 10;
const POLICY_BYTES: usize = 3 << 10;
const AGENT_BYTES: usize = 1 << 10;
const NODE_BYTES: usize = 64;
/// States that are kept whatever their size: two, so that one can go back by a second.
const LEAST_STATES: usize = 2;
/// Steps between two points of a trail.
const TRAIL_EVERY: u32 = 6;

/// A scene that runs, with the record of its last minute.
pub struct SceneRun {
    state: SceneRunState,
    /// Position of the eye, x and z (m). Only the number of fully posed characters depends on it.
    pub eye: Vec2,
    /// Number of the first agent; none without agents.
    first_agent: Option<usize>,
    /// Approximate size of a state (bytes).
    state_bytes: usize,
    /// Which of the recorded steps is shown.
    pub head: PlayHead,
    /// States at steps, before the inputs that were given there, ascending; the first is that of the first recorded
    /// step.
    keyframes: VecDeque<(u32, SceneRunState)>,
    /// Inputs that took effect after the steps that they were given at, in order.
    inputs: VecDeque<(u32, RunInput)>,
    /// Events of the recorded steps, with their steps.
    events: VecDeque<(u32, SimulationEvent)>,
    /// All events of agents, including recorded ones after the shown step.
    pub log: EventLog,
    /// Times at which agents learnt messages, including recorded ones after the shown step.
    pub spread: SpreadLog,
    /// Blows, ascending by step.
    marks: VecDeque<BlowMark>,
    /// Figures of the recorded steps, without times of phases.
    figures: VecDeque<(u32, StepFigures)>,
    /// Places of all characters at every [`TRAIL_EVERY`]th step; `None` for one that has left (m).
    trails: VecDeque<(u32, Vec<Option<Vec3>>)>,
}

/// Approximate size of a state of a simulation (bytes).
fn state_bytes(simulation: &Simulation) -> usize {
    let of_group = |group: &AnyCharacterGroup| match (group, policy_characters(group)) {
        (_, Some(people)) => people.ids().len() * POLICY_BYTES,
        (AnyCharacterGroup::Patches(p), _) => p.num_characters() * BODY_BYTES + p.graph().num_nodes() * NODE_BYTES,
        (group, _) => (0..group.num_characters()).filter(|&c| group.pose(c).is_some()).count() * BODY_BYTES,
    };
    let groups = simulation.character_groups().iter().map(of_group);
    simulation.num_characters() * AGENT_BYTES + groups.sum::<usize>()
}

impl SceneRun {
    /// All characters where they start, or in a saved state.
    ///
    /// - `kept`: what [`Simulation::snapshot`] gave for the same scene.
    /// - `wanders`: targets to which characters have come move on.
    ///
    /// # Errors
    /// [`throng_core::Error`] for starts or goals that are impossible, or bytes that do not belong to the scene.
    pub fn new(scene: &CompiledScene, kept: Option<&[u8]>, wanders: bool) -> Result<Self> {
        let mut simulation = Simulation::new(scene)?;
        if let Some(bytes) = kept {
            simulation.restore(bytes)?;
        }
        for group in 0..simulation.character_groups().len() {
            match simulation.character_group_mut(group) {
                AnyCharacterGroup::Ground(agents) => agents.record_events(),
                AnyCharacterGroup::Air(agents) => agents.record_events(),
                _ => {}
            }
        }
        let step = (simulation.time_s() * f64::from(STEP_HZ) + 1e-6) as u32;
        let state = SceneRunState::new(simulation, wanders);
        let mut head = PlayHead::default();
        head.record(step..=step, step);
        let mut run = Self {
            spread: SpreadLog::from_agent_brains(state.simulation.brains()),
            figures: VecDeque::from([(step, state.figures)]),
            first_agent: first_agent(&state.simulation),
            state_bytes: state_bytes(&state.simulation),
            keyframes: VecDeque::from([(step, state.clone())]),
            state,
            eye: Vec2::ZERO,
            head,
            inputs: VecDeque::new(),
            events: VecDeque::new(),
            log: EventLog::default(),
            marks: VecDeque::new(),
            trails: VecDeque::new(),
        };
        run.log_totals();
        run.keep_trail(step);
        Ok(run)
    }

    /// The scene at the step shown.
    pub fn simulation(&self) -> &Simulation {
        &self.state.simulation
    }

    /// A copy that goes on by itself.
    pub fn fork(&self) -> SceneFork {
        SceneFork { state: self.state.clone(), step: self.head.shown_step() }
    }

    /// Figures of the shown step.
    pub fn figures(&self) -> StepFigures {
        let now = self.head.shown_step();
        let kept = self.figures.partition_point(|f| f.0 < now);
        self.figures.get(kept).map_or(self.state.figures, |f| f.1)
    }

    /// Steps and figures of the recording up to the shown step.
    pub fn history(&self) -> impl Iterator<Item = (u32, &StepFigures)> {
        let now = self.head.shown_step();
        self.figures.iter().take_while(move |f| f.0 <= now).map(|(step, f)| (*step, f))
    }

    /// How an agent came to its state at a level, 0 for the highest; none for an agent without a brain (level < 3).
    pub fn entry(&self, who: usize, level: usize) -> Option<StateEntry> {
        Some(self.state.traces.get(who.checked_sub(self.first_agent?)?)?.entry_at(level))
    }

    /// Number of characters that are there.
    pub fn num_present(&self) -> usize {
        self.simulation().roots().flatten().count()
    }

    /// One step forward: a recorded one, or a new one.
    ///
    /// # Errors
    /// [`throng_core::Error`] where the step cannot be taken.
    pub fn step(&mut self) -> Result<()> {
        let step = self.head.shown_step() + 1;
        let begin = Instant::now();
        self.state.advance_to(step, self.eye)?;
        if self.head.advance_recorded() {
            self.take_inputs(step)
        } else {
            self.state.figures.wall_s = begin.elapsed().as_secs_f64();
            self.record(step);
            Ok(())
        }
    }

    /// Shows the nearest recorded step.
    ///
    /// # Errors
    /// [`throng_core::Error`] where a step cannot be repeated.
    pub fn seek(&mut self, step: u32) -> Result<()> {
        let shown = self.head.shown_step();
        self.head.seek(step);
        let step = self.head.shown_step();
        let after = self.keyframes.partition_point(|k| k.0 <= step);
        let (before, state) = &self.keyframes[after.saturating_sub(1)];
        let mut at = shown;
        if step < shown || *before > shown {
            self.state.clone_from(state);
            at = *before;
            self.take_inputs(at)?;
        }
        while at < step {
            let done = self.state.advance_to(at + 1, self.eye).and_then(|()| self.take_inputs(at + 1));
            // The play head stays at the last step that could be repeated.
            done.inspect_err(|_| self.head.seek(at))?;
            at += 1;
        }
        Ok(())
    }

    fn take_inputs(&mut self, step: u32) -> Result<()> {
        let from = self.inputs.partition_point(|i| i.0 < step);
        let here = self.inputs.iter().skip(from).take_while(|i| i.0 == step);
        here.map(|i| &i.1).try_for_each(|input| self.state.apply_input(input))
    }

    /// Applies an input now. The recording after the shown step is dropped, since it did not have the input. A target
    /// is kept within [`super::MAX_TARGET_M`]; a target that is not a number is ignored.
    ///
    /// # Errors
    /// [`throng_core::Error`] for what cannot be done; nothing has changed then.
    pub fn input(&mut self, input: RunInput) -> Result<()> {
        let Some(input) = input.limited() else { return Ok(()) };
        self.state.apply_input(&input)?;
        let now = self.head.shown_step();
        self.keyframes.truncate(self.keyframes.partition_point(|k| k.0 <= now).max(1));
        self.events.truncate(self.events.partition_point(|e| e.0 <= now));
        self.marks.truncate(self.marks.partition_point(|m| m.step <= now));
        self.figures.truncate(self.figures.partition_point(|f| f.0 <= now));
        self.trails.truncate(self.trails.partition_point(|t| t.0 <= now));
        self.inputs.truncate(self.inputs.partition_point(|i| i.0 <= now));
        let now_s = self.state.simulation.time_s();
        self.log.forget_after(now_s);
        self.spread.forget_after(now_s);
        if matches!(input, RunInput::Event(_)) {
            self.log_brain_events();
        }
        // Of many drags of one target at a step only the last one counts.
        self.inputs.pop_back_if(|last| last.0 == now && input.replaces(&last.1));
        self.inputs.push_back((now, input));
        let first = *self.head.recorded().start();
        self.head.record(first..=now, now);
        Ok(())
    }

    /// Events of the recorded steps up to the one shown, the latest first.
    pub fn events(&self) -> impl Iterator<Item = &SimulationEvent> {
        let now = self.head.shown_step();
        self.events.iter().rev().skip_while(move |e| e.0 > now).map(|e| &e.1)
    }

    /// Blows of the last `seconds`, the latest first.
    pub fn blow_marks(&self, seconds: f32) -> impl Iterator<Item = &BlowMark> {
        let now = self.head.shown_step();
        let from = (now + 1).saturating_sub((seconds * STEP_HZ) as u32);
        self.marks.iter().rev().skip_while(move |m| m.step > now).take_while(move |m| m.step >= from)
    }

    /// Past positions of a character during the last `seconds`, at intervals, and the present one (m).
    pub fn trail(&self, who: usize, seconds: f32) -> impl Iterator<Item = Vec3> {
        let now = self.head.shown_step();
        let from = now.saturating_sub((seconds * STEP_HZ) as u32);
        let recorded = self.trails.iter().filter(move |t| (from..now).contains(&t.0));
        recorded.filter_map(move |t| *t.1.get(who)?).chain(self.place(who))
    }

    /// Position of a character: the middle of an agent in the air, else on the ground below it; `None` if it has left
    /// (m).
    pub fn place(&self, who: usize) -> Option<Vec3> {
        if let Some(disc) = self.simulation().disc(who) {
            return Some(disc.centre);
        }
        let root = self.simulation().root(who)?.translation();
        let Some(pose) = self.simulation().pose(who) else { return Some(root) };
        use throng_core::Joint::{LeftFoot, RightFoot};
        let ankle = [LeftFoot, RightFoot].map(|j| pose[j.index()].translation().y);
        Some(root.with_y(ankle[0].min(ankle[1])))
    }

    /// Recorded choice of a character: goals, weights, its last choice, and its number in the group; none for a
    /// character that does not choose.
    pub(crate) fn recorded_choice(&self, who: usize) -> Option<(&[RunGoal], &[f32], &super::RecordedChoice, usize)> {
        let c = self.state.choosing.iter().rev().find(|c| c.first <= who)?;
        let number = who - c.first;
        (number < c.choices.len()).then(|| (&*c.goals, &*c.weights, c.choices.last(number), number))
    }

    /// Records a new step, which is shown.
    fn record(&mut self, step: u32) {
        let simulation = &self.state.simulation;
        self.events.extend(simulation.events().iter().map(|&e| (step, e)));
        record_blows(simulation, step, &mut self.marks);
        self.figures.push_back((step, self.state.figures));
        self.log_events();
        self.log_brain_events();
        self.log_totals();
        self.keep_trail(step);
        if step.is_multiple_of(STATE_EVERY) {
            self.keyframes.push_back((step, self.state.clone()));
        }
        let mut first = *self.head.recorded().start();
        let is_large = self.keyframes.len() * self.state_bytes > MAX_BYTES && self.keyframes.len() > LEAST_STATES;
        let is_full = step - first > RECORDED_STEPS + STATE_EVERY || is_large;
        if let Some(second) = self.keyframes.get(1).map(|k| k.0).filter(|_| is_full) {
            self.keyframes.pop_front();
            while self.inputs.pop_front_if(|i| i.0 < second).is_some() {}
            while self.events.pop_front_if(|e| e.0 < second).is_some() {}
            while self.marks.pop_front_if(|m| m.step < second).is_some() {}
            while self.figures.pop_front_if(|f| f.0 < second).is_some() {}
            while self.trails.pop_front_if(|t| t.0 < second).is_some() {}
            first = second;
        }
        self.head.record(first..=step, step);
    }

    /// Writes the events of agents into the log, with where they happened.
    fn log_events(&mut self) {
        let Some(first) = self.first_agent else { return };
        let last = self.trails.back().map_or(&[][..], |t| &t.1);
        for group in self.state.simulation.character_groups() {
            match group {
                AnyCharacterGroup::Ground(agents) => log_engine_events(&mut self.log, first, agents, last),
                AnyCharacterGroup::Air(agents) => log_engine_events(&mut self.log, first, agents, last),
                _ => {}
            }
        }
    }

    /// Writes the events of agent brains into the log.
    fn log_brain_events(&mut self) {
        let (simulation, Some(first)) = (&self.state.simulation, self.first_agent) else { return };
        let position = |who: usize| {
            let last = || *self.trails.back()?.1.get(who)?;
            simulation.disc(who).map(|d| d.centre).or_else(last)
        };
        for turn in simulation.brains().map_or(&[][..], |m| m.turns()) {
            self.spread.record_turn(turn);
            let Some((kind, other_party)) = AgentEventKind::from_brain_event(turn, first) else { continue };
            let (time_s, agent, message) = (turn.time_s, first + turn.agent, turn.event);
            let at = position(agent).unwrap_or_default();
            let other_at = other_party.other().and_then(position).filter(|_| kind == AgentEventKind::Learnt);
            let place = turn.place;
            self.log.add(AgentEvent { time_s, agent, kind, other_party, place, message, at, other_at });
        }
    }

    /// Notes in the log how many events there were until now.
    fn log_totals(&mut self) {
        if let Some(agents) = self.state.figures.agents {
            self.log.record_totals(self.state.simulation.time_s(), agents.present);
        }
    }

    fn keep_trail(&mut self, step: u32) {
        if step.is_multiple_of(TRAIL_EVERY) {
            let places = (0..self.simulation().num_characters()).map(|who| self.place(who)).collect();
            self.trails.push_back((step, places));
        }
    }
}

/// A scene that goes on by itself, beside the run that is shown, without its later inputs.
#[derive(Clone)]
pub struct SceneFork {
    state: SceneRunState,
    step: u32,
}

impl SceneFork {
    /// The scene at its present step.
    pub fn simulation(&self) -> &Simulation {
        &self.state.simulation
    }

    /// Applies an input, as [`SceneRun::input`] does.
    ///
    /// # Errors
    /// [`throng_core::Error`] for what cannot be done; nothing has changed then.
    pub fn input(&mut self, input: RunInput) -> Result<()> {
        input.limited().map_or(Ok(()), |input| self.state.apply_input(&input))
    }

    /// One step forward, with all characters posed in full.
    ///
    /// # Errors
    /// [`throng_core::Error`] where the step cannot be taken.
    pub fn step(&mut self) -> Result<()> {
        self.step += 1;
        self.state.advance_to(self.step, Vec2::ZERO)
    }
}

/// Writes the events of the last step into a log.
///
/// - `last`: places of all characters at the end of their trails; `None` for one that has left (m).
fn log_engine_events<V: Space>(log: &mut EventLog, first: usize, agents: &SceneAgents<V>, last: &[Option<Vec3>]) {
    let place = |agent: usize, event: &CrowdEvent| {
        agents.position(agent, event.time).map(world_vector).or_else(|| *last.get(first + agent)?)
    };
    for event in agents.engine_events() {
        let named = AgentEventKind::from_engine_event(&event.kind, |id| agents.agent_of(id));
        let (Some((kind, party)), Some(agent)) = (named, agents.agent_of(event.agent)) else { continue };
        let (other_party, other_at) = match party {
            OtherParty::Agent(other) => (OtherParty::Agent(first + other), place(other, event)),
            party => (party, None),
        };
        let (at, time_s) = (place(agent, event).unwrap_or_default(), event.time);
        let (agent, place, message) = (first + agent, None, None);
        log.add(AgentEvent { time_s, agent, kind, other_party, place, message, at, other_at });
    }
}

#[cfg(test)]
mod tests;
