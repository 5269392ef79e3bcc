//! The state of a scene that later steps depend on.

use crate::run::agents::AgentTrace;
use crate::run::choices::{ChoiceRecord, GoalSubject, RunGoal};
use crate::run::figures::{BoutFigures, Slip, StepFigures};
use crate::run::{RunInput, STEP_HZ};
use glam::{Vec2, Vec3, Vec3Swizzles};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::{f32::consts::TAU, ops::RangeInclusive, sync::Arc};
use throng_core::characters::{Detail, DetailLevel};
use throng_core::{Executor as Threads, Inline, Rayon, Result, Skeleton};
use throng_precompute::run::{AgentsMeter, policy_characters};
use throng_precompute::slip::SlipMeter;
use throng_simulation::{AnyCharacterGroup, Simulation, sparring::NO_THREAT_S};

/// Steps between two observations of all agents.
const LOOK_EVERY: u32 = 2;
/// Characters from which on a step is split over threads.
const PARALLEL_FROM: usize = 200;

/// Distance within which a character has come to its target, and from there to the next one (m).
const REACH_M: f32 = 0.5;
const MOVED_ON_M: RangeInclusive<f32> = 2.0..=6.0;
/// Distance from the eye up to which feet are locked, in groups that are not posed in full (m).
const FULL_M: f32 = 20.0;
/// Distance from the eye up to which poses are computed, in such groups (m).
const POSED_M: f32 = 40.0;

/// Characters that choose by policies, in one group.
#[derive(Clone, Debug)]
pub(super) struct ChoosingGroup {
    character_group: usize,
    /// Number of the first of them.
    pub first: usize,
    pub goals: Arc<[RunGoal]>,
    pub weights: Arc<[f32]>,
    pub choices: ChoiceRecord,
}

/// State that later steps depend on, and figures.
#[derive(Clone)]
pub(super) struct SceneRunState {
    pub simulation: Simulation,
    /// True if targets to which characters have come move on.
    wanders: bool,
    pub choosing: Vec<ChoosingGroup>,
    feet: SlipMeter,
    agents: Option<AgentsMeter>,
    /// How agents came to their states (agents with brains).
    pub traces: Vec<AgentTrace>,
    pub figures: StepFigures,
}

impl SceneRunState {
    pub fn new(simulation: Simulation, wanders: bool) -> Self {
        let groups = simulation.groups().iter();
        let choosing = groups.filter_map(|g| ChoosingGroup::new(&simulation, g.character_group, &g.characters));
        let mut state = Self {
            wanders,
            choosing: choosing.collect(),
            feet: SlipMeter::new(simulation.num_characters(), &Skeleton::default()),
            agents: AgentsMeter::new(&simulation),
            traces: AgentTrace::for_all_agents(&simulation),
            figures: StepFigures::default(),
            simulation,
        };
        let simulation = &state.simulation;
        // All characters have chosen already; the data of choices before a saved state are unknown.
        let is_at_start = simulation.time_s() == 0.0;
        for c in &mut state.choosing {
            let (targets, mut threats) = targets_and_threats(&simulation.character_groups()[c.character_group]);
            threats.fill(Vec3::new(0.0, NO_THREAT_S, 0.0));
            let weights = std::mem::replace(&mut c.weights, Arc::from([]));
            if is_at_start {
                c.weights = Arc::clone(&weights);
            }
            c.observe(simulation, &targets, &threats, 0);
            c.weights = weights;
        }
        state.feet.observe_simulation(simulation, 0..simulation.num_characters(), 0.0);
        state.figures.agents = state.agents.as_mut().map(|meter| meter.observe(simulation));
        state.figures.bout = BoutFigures::collect_from(simulation);
        state.figures.at_target = count_at_target(simulation);
        state
    }

    /// One step of all characters, and its measures.
    ///
    /// - `eye`: see [`super::SceneRun::eye`].
    pub fn advance_to(&mut self, step: u32, eye: Vec2) -> Result<()> {
        let simulation = &mut self.simulation;
        for c in &self.choosing {
            if let AnyCharacterGroup::Policy(p) = simulation.character_group_mut(c.character_group) {
                p.set_detail(Detail { eye, full_m: FULL_M, posed_m: POSED_M })?;
            }
        }
        let subjects = |c: &ChoosingGroup| targets_and_threats(&simulation.character_groups()[c.character_group]);
        let before: Vec<_> = self.choosing.iter().map(subjects).collect();
        let was_s = simulation.time_s();
        let is_large = simulation.num_characters() >= PARALLEL_FROM;
        let threads: &dyn Threads = if is_large { &Rayon } else { &Inline };
        simulation.step_to(f64::from(step) / f64::from(STEP_HZ), threads)?;
        self.trace_agent_brains();
        let simulation = &mut self.simulation;
        for (c, (targets, threats)) in self.choosing.iter_mut().zip(&before) {
            c.observe(simulation, targets, threats, step);
        }
        self.feet.clear();
        let dt_s = (simulation.time_s() - was_s) as f32;
        let is_full = |&who: &usize| detail_level(simulation, who) == DetailLevel::Full;
        self.feet.observe_simulation(simulation, (0..simulation.num_characters()).filter(is_full), dt_s);
        self.figures.at_target = count_at_target(simulation);
        self.figures.slip = Slip { mean_mps: self.feet.mean_mps() as f32, p95_mps: self.feet.p95_mps() as f32 };
        self.figures.bout = BoutFigures::collect_from(simulation);
        if let Some(meter) = self.agents.as_mut().filter(|_| step.is_multiple_of(LOOK_EVERY)) {
            self.figures.agents = Some(meter.observe(simulation));
        }
        if self.wanders { self.move_targets_on(step) } else { Ok(()) }
    }

    /// Moves the targets to which characters have come, each to a place in some direction.
    fn move_targets_on(&mut self, step: u32) -> Result<()> {
        let seed = self.simulation.scene().seed;
        for who in 0..self.simulation.num_characters() {
            let home = target_home(&self.simulation, who).filter(|_| is_at_target(&self.simulation, who));
            let Some(home) = home else { continue };
            let draw = u64::from(step) << 32 | who as u64;
            let mut rng = Pcg64Mcg::seed_from_u64(seed ^ draw.wrapping_mul(0x9E37_79B9_7F4A_7C15));
            let (sin, cos) = rng.random_range(0.0..TAU).sin_cos();
            let to = home + rng.random_range(MOVED_ON_M) * Vec3::new(sin, 0.0, cos);
            self.apply_input(&RunInput::Target { character: Some(who), to })?;
        }
        Ok(())
    }

    /// Records the events of agent brains.
    fn trace_agent_brains(&mut self) {
        for turn in self.simulation.brains().map_or(&[][..], |m| m.turns()) {
            self.traces[turn.agent].record_turn(turn);
        }
    }

    /// Applies an input.
    pub fn apply_input(&mut self, input: &RunInput) -> Result<()> {
        match input {
            RunInput::Target { character, to } => {
                for c in &self.choosing {
                    if let AnyCharacterGroup::Policy(p) = self.simulation.character_group_mut(c.character_group) {
                        let own = c.first..c.first + p.practice().targets().len();
                        let moved = character.map_or(own.clone(), |who| who..who + 1);
                        let mut moved = moved.start.max(own.start)..moved.end.min(own.end);
                        moved.try_for_each(|who| p.set_home(who - c.first, *to))?;
                    }
                }
            }
            RunInput::Weights { member: of, weights } => {
                let Some(c) = self.choosing.iter_mut().rev().find(|c| c.first <= *of) else { return Ok(()) };
                match self.simulation.character_group_mut(c.character_group) {
                    AnyCharacterGroup::Policy(practice) => practice.set_weights(weights)?,
                    AnyCharacterGroup::Sparring(bouts) => bouts.set_weights(weights)?,
                    _ => {}
                }
                c.weights = weights.as_slice().into();
            }
            RunInput::Play { character, segment } => {
                let Some(c) = self.choosing.iter().rev().find(|c| c.first <= *character) else { return Ok(()) };
                match self.simulation.character_group_mut(c.character_group) {
                    AnyCharacterGroup::Policy(practice) => practice.play(character - c.first, *segment)?,
                    AnyCharacterGroup::Sparring(bouts) => bouts.play(character - c.first, *segment)?,
                    _ => {}
                }
            }
            RunInput::Event(name) => {
                self.simulation.raise_event(name)?;
                self.trace_agent_brains();
            }
            RunInput::Goal { character, goal } => {
                let number = self.simulation.locate(*character).1;
                let group = self.simulation.groups().iter().find(|g| g.characters.contains(character));
                if let Some(AnyCharacterGroup::Patches(people)) =
                    group.map(|g| g.character_group).map(|c| self.simulation.character_group_mut(c))
                {
                    people.order_goal(number, *goal)?;
                }
            }
        }
        Ok(())
    }
}

impl ChoosingGroup {
    /// The state of a group; none for a group without policies, or with goals.
    fn new(simulation: &Simulation, character_group: usize, characters: &std::ops::Range<usize>) -> Option<Self> {
        let group = &simulation.character_groups()[character_group];
        // Navigation puts a point before people on their way, of which nothing is kept.
        let boxers = policy_characters(group).filter(|_| !matches!(group, AnyCharacterGroup::Travel(_)))?;
        let order = boxers.order_of(*boxers.ids().first()?).ok()?;
        let goal = |&policy: &u32| {
            let is_threat = boxers.motion_set().policy(policy as usize)?.grid().is_space_time();
            let subject = if is_threat { GoalSubject::Threat } else { GoalSubject::Target };
            Some(RunGoal { policy: policy as usize, subject })
        };
        Some(Self {
            character_group,
            first: characters.start,
            goals: order.policies().iter().filter_map(goal).collect(),
            weights: order.weights().into(),
            choices: ChoiceRecord::new(characters.len()),
        })
    }

    fn observe(&mut self, simulation: &Simulation, targets: &[Vec3], threats: &[Vec3], step: u32) {
        let Some(boxers) = policy_characters(&simulation.character_groups()[self.character_group]) else { return };
        self.choices.observe(boxers.characters(), targets, threats, &self.weights, step);
    }
}

/// Place where the target of a character hangs; none for a character without a target of its own (m, who < number of
/// characters).
pub fn target_home(simulation: &Simulation, who: usize) -> Option<Vec3> {
    let (AnyCharacterGroup::Policy(p), member) = simulation.locate(who) else { return None };
    Some(p.practice().targets()[member].home)
}

/// True for a character that has come to its target (who < number of characters).
pub fn is_at_target(simulation: &Simulation, who: usize) -> bool {
    let apart = simulation.root(who).zip(target_home(simulation, who)).map(|(root, at)| root.translation() - at);
    apart.is_some_and(|apart| apart.xz().length() < REACH_M)
}

/// Characters that have come to their targets; none in a scene without such targets.
fn count_at_target(simulation: &Simulation) -> Option<usize> {
    let has_targets = simulation.character_groups().iter().any(|g| matches!(g, AnyCharacterGroup::Policy(_)));
    has_targets.then(|| (0..simulation.num_characters()).filter(|&who| is_at_target(simulation, who)).count())
}

/// Level at which the last step computed a character (who < number of characters).
pub fn detail_level(simulation: &Simulation, who: usize) -> DetailLevel {
    match simulation.locate(who) {
        (AnyCharacterGroup::Policy(p), member) => p.practice().characters().level(member),
        _ => DetailLevel::Full,
    }
}

/// Targets, and coming blows for groups with opponents.
fn targets_and_threats(character_group: &AnyCharacterGroup) -> (Vec<Vec3>, Vec<Vec3>) {
    match character_group {
        AnyCharacterGroup::Policy(p) => (p.practice().targets().iter().map(|t| t.position()).collect(), Vec::new()),
        AnyCharacterGroup::Sparring(s) => (s.sparring().aims().to_vec(), s.sparring().threats().to_vec()),
        _ => Default::default(),
    }
}
