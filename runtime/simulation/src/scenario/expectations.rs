//! Expectations of a scene, measured while it runs.

use super::agent_brain::{ActionPhase, EventContext};
use super::language::{Program, run_program};
use super::tables::{CompiledAction, LearningMode, NONE, Scenario};
use super::{agent_brains::AgentBrains, perceive::AgentView, stage::ScenarioStage};
use crate::scene::{ExpectConfig, ExpectedQuantity, ExpectedStatistic};
use glam::{Vec2, Vec3};
use serde::Serialize;
use std::sync::Arc;

/// Lead in a line from which on the order counts (s).
const LEAD_S: f64 = 1.0;
/// Largest time between the two halves of a mutual action (s), and cosine of the largest angle off each other (15 degrees).
const MUTUAL_S: f64 = 1.0;
const FACING: f32 = 0.965_925_8;
/// Distance from which on the speed of news counts (m).
const FAR_M: f32 = 5.0;
/// Most agents that are named for an expectation.
const MAX_NAMED: usize = 3;

/// Outcome of an expectation in one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ExpectationOutcome {
    /// Sentence of the expectation.
    pub name: String,
    /// The statistic; null where nothing was measured, or where it is infinite.
    pub figure: f64,
    /// Number of values that it is taken of.
    pub values: usize,
    /// Least and greatest value that were expected; null for no limit.
    pub bounds: [f64; 2],
    /// Whether it is met.
    pub holds: bool,
    /// Agents with the worst values, at most three.
    pub worst: Vec<WorstAgent>,
}

/// Agent that breaks an expectation.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WorstAgent {
    /// Number of the agent.
    pub agent: usize,
    /// Time (s).
    pub time_s: f64,
    /// Its value; null where it is infinite.
    pub value: f64,
    /// Position then, x and z (m).
    pub at: [f32; 2],
    /// What the agent did then, and why.
    pub why: String,
}

/// Measurements of all expectations of a scene.
#[derive(Clone, Debug)]
pub(crate) struct ExpectationMeters {
    configs: Vec<ExpectConfig>,
    /// Brains of agents that have only goals.
    idle: AgentBrains,
    meters: Vec<ExpectationMeter>,
}

#[derive(Clone, Debug, Default)]
struct ExpectationMeter {
    values: Vec<f32>,
    worst: Vec<WorstAgent>,
    agents: Vec<AgentMeter>,
    /// Times since when agents stood in line that have been let in (s).
    let_in: Vec<f64>,
}

/// Measurements of one agent.
#[derive(Clone, Copy, Debug)]
struct AgentMeter {
    /// Number of measurements, and of those in which a predicate held.
    seen: u32,
    held: u32,
    /// Number of predicates that it has met, and those that have not held at some moment, as bits.
    passed: usize,
    unmet: u64,
    /// Begin of a spell, or of the time to pass; infinite for none (s).
    since: f64,
    /// Other agent of a mutual action, and whether it was one.
    other: u32,
    is_mutual: bool,
    /// Last slot in the queue.
    slot: u32,
    /// Number of its entries and of services so far.
    entries: u32,
    served: u32,
}

const UNSEEN: AgentMeter = AgentMeter {
    seen: 0,
    held: 0,
    passed: 0,
    unmet: 0,
    since: f64::INFINITY,
    other: NONE,
    is_mutual: false,
    slot: NONE,
    entries: 0,
    served: 0,
};
/// Number of passed predicates of an agent that met a later one before an earlier one.
const OUT_OF_ORDER: usize = usize::MAX;

/// Brains of agents at one time, and their stage.
struct BrainsView<'a, S> {
    brains: &'a AgentBrains,
    agents: AgentsView<'a, S>,
}

/// Agents at one time.
pub(crate) struct AgentsView<'a, S> {
    pub brains: Option<&'a AgentBrains>,
    pub stage: &'a S,
    /// Number of the first agent among the characters of the simulation.
    pub first: usize,
    /// Direction that the body of an agent faces.
    pub facing: &'a dyn Fn(u32) -> Option<Vec3>,
    pub now: f64,
}

impl<S: ScenarioStage> BrainsView<'_, S> {
    fn evaluate(&self, agent: u32, program: Program) -> f64 {
        let (brains, stage, now) = (self.brains, self.agents.stage, self.agents.now);
        let context = EventContext::default();
        run_program(
            &brains.scenario.code,
            program,
            &mut AgentView { brains, stage, agent, context, now, draws: &mut 0 },
        )
    }

    fn holds(&self, agent: u32, program: Program) -> bool {
        self.evaluate(agent, program) != 0.0
    }

    /// Agents of some groups that are there.
    fn members(&self, who: u64) -> impl Iterator<Item = u32> + '_ {
        let is_in = move |a: &u32| who >> self.brains.brains[*a as usize].group & 1 == 1;
        (0..self.brains.brains.len() as u32).filter(is_in).filter(|a| self.brains.brains[*a as usize].is_there)
    }

    /// Other agent with which an agent does an action.
    fn partner(&self, agent: u32, action: u16) -> Option<u32> {
        let brain = &self.brains.brains[agent as usize];
        let is_it = brain.is_there && brain.phase == ActionPhase::Standing && brain.action != NONE;
        let is_it = is_it
            && matches!(self.brains.action(brain.action), CompiledAction::Primitive { number, .. } if number == action);
        (is_it && brain.context.other != NONE).then_some(brain.context.other)
    }

    fn faces(&self, agent: u32, other: u32) -> bool {
        let place = |a: u32| self.agents.stage.position(a);
        let (Some(from), Some(to), Some(facing)) = (place(agent), place(other), (self.agents.facing)(agent)) else {
            return false;
        };
        (to - from).with_y(0.0).try_normalize().is_none_or(|to| to.dot(facing) >= FACING)
    }
}

impl ExpectationMeter {
    /// Adds a value of an agent, and remembers the agent where it is among the worst outside the bounds.
    fn add<S: ScenarioStage>(&mut self, view: &BrainsView<'_, S>, config: &ExpectConfig, agent: u32, value: f64) {
        self.values.push(value as f32);
        self.blame(view, config, agent, value);
    }

    fn blame<S: ScenarioStage>(&mut self, view: &BrainsView<'_, S>, config: &ExpectConfig, agent: u32, value: f64) {
        let who = view.agents.first + agent as usize;
        let excess = |value: f64| excess(config, value);
        let is_worse =
            self.worst.len() < MAX_NAMED || self.worst.last().is_some_and(|w| excess(w.value) < excess(value));
        let is_known = self.worst.iter().any(|w| w.agent == who && excess(w.value) >= excess(value));
        if excess(value) <= 0.0 || !is_worse || is_known {
            return;
        }
        self.worst.retain(|w| w.agent != who);
        let at = view.agents.stage.position(agent).unwrap_or_default();
        let why = view.brains.explain(agent as usize, view.agents.now).to_string();
        let why = why.lines().take(2).collect::<Vec<_>>().join(", ");
        let place = self.worst.partition_point(|w| excess(w.value) >= excess(value));
        self.worst.insert(place, WorstAgent { agent: who, time_s: view.agents.now, value, at: [at.x, at.z], why });
        self.worst.truncate(MAX_NAMED);
    }

    fn observe<S: ScenarioStage>(&mut self, view: &BrainsView<'_, S>, n: usize, config: &ExpectConfig) {
        let table = &view.brains.scenario.expectations[n];
        let new = view.brains.engagements[self.agents.len()..].iter();
        self.agents.extend(new.map(|own| AgentMeter { entries: own.entries, served: own.served, ..UNSEEN }));
        let first = table.programs.first().copied().unwrap_or_default();
        for a in 0..self.agents.len() as u32 {
            let (own, entries) = (self.agents[a as usize], view.brains.engagements[a as usize].entries);
            if own.entries != entries {
                // It has left and entered again, as another one.
                self.finish_agent(view, n, config, a);
                self.agents[a as usize] = AgentMeter { entries, ..UNSEEN };
            }
        }
        match &config.that {
            ExpectedQuantity::Always(_) | ExpectedQuantity::Never(_) => {
                let is_wanted = matches!(config.that, ExpectedQuantity::Always(_));
                for a in view.members(table.who) {
                    let holds = view.holds(a, first) == is_wanted;
                    let own = &mut self.agents[a as usize];
                    (own.seen, own.held) = (own.seen + 1, own.held + u32::from(holds));
                    if !holds && own.seen - own.held == 1 {
                        self.blame(view, config, a, f64::NEG_INFINITY);
                    }
                }
            }
            ExpectedQuantity::Passes(_) => {
                for a in view.members(table.who) {
                    let own = &mut self.agents[a as usize];
                    if own.seen == 0 {
                        (own.seen, own.since) = (1, view.agents.now);
                    }
                    let before = own.passed;
                    while let Some(next) = table.programs.get(own.passed).filter(|p| view.holds(a, **p)) {
                        if own.passed == 0 && *next != table.programs[table.programs.len() - 1] {
                            own.since = view.agents.now;
                        }
                        own.passed += 1;
                    }
                    let skipped = (0u32..).zip(&table.programs).skip(own.passed.saturating_add(1));
                    let (mut unmet, mut is_early) = (own.unmet, false);
                    for (n, program) in skipped {
                        // What holds from the beginning has not been met early: somebody comes in, and goes out again.
                        let holds = view.holds(a, *program);
                        is_early |= holds && unmet.checked_shr(n).is_some_and(|bits| bits & 1 == 1);
                        unmet |= if holds { 0 } else { 1u64.checked_shl(n).unwrap_or(0) };
                    }
                    own.unmet = unmet;
                    if own.passed < table.programs.len() && is_early {
                        own.passed = OUT_OF_ORDER;
                        self.add(view, config, a, f64::INFINITY);
                    } else if own.passed != before && own.passed == table.programs.len() {
                        let value = view.agents.now - own.since;
                        self.add(view, config, a, value);
                    }
                }
            }
            ExpectedQuantity::Amount(_) => {
                view.members(table.who).for_each(|a| self.add(view, config, a, view.evaluate(a, first)))
            }
            ExpectedQuantity::Queue(_) => self.observe_queue(view, config, table.number),
            ExpectedQuantity::Lasts(_) | ExpectedQuantity::Mutual(_) => {
                for a in 0..self.agents.len() as u32 {
                    let brain = &view.brains.brains[a as usize];
                    let is_one = brain.is_there && table.who >> brain.group & 1 == 1;
                    // A spell that only has to last is one of the agent with itself.
                    let with = match config.that {
                        ExpectedQuantity::Mutual(_) => view.partner(a, table.number).filter(|_| is_one),
                        _ => (is_one && view.holds(a, first)).then_some(a),
                    };
                    self.end_spell(view, config, a, with.unwrap_or(NONE) != self.agents[a as usize].other);
                    let own = &mut self.agents[a as usize];
                    if let Some(with) = with {
                        (own.since, own.other) = (own.since.min(view.agents.now), with);
                    }
                }
                for a in 0..self.agents.len() as u32 {
                    let own = self.agents[a as usize];
                    let Some(theirs) = self.agents.get(own.other as usize).filter(|o| o.other == a) else { continue };
                    let is_together = (own.since - theirs.since).abs() <= MUTUAL_S + 1e-6;
                    if is_together && view.faces(a, own.other) && view.faces(own.other, a) {
                        self.agents[a as usize].is_mutual = true;
                    }
                }
            }
            ExpectedQuantity::Wait(_) => {
                for a in 0..self.agents.len() as u32 {
                    let (brain, done) = (&view.brains.brains[a as usize], &view.brains.engagements[a as usize]);
                    let is_new = std::mem::replace(&mut self.agents[a as usize].served, done.served) != done.served;
                    if is_new && done.served_by == table.number && table.who >> brain.group & 1 == 1 {
                        self.add(view, config, a, done.waited);
                    }
                }
            }
            ExpectedQuantity::News(_) | ExpectedQuantity::Figure(_) => {}
        }
    }

    /// Adds what only the end of an agent's stay tells.
    fn finish_agent<S: ScenarioStage>(&mut self, view: &BrainsView<'_, S>, n: usize, config: &ExpectConfig, a: u32) {
        let table = &view.brains.scenario.expectations[n];
        let own = self.agents[a as usize];
        match config.that {
            ExpectedQuantity::Always(_) | ExpectedQuantity::Never(_) if own.seen > 0 => {
                self.values.push(own.held as f32 / own.seen as f32);
            }
            ExpectedQuantity::Passes(_) if own.seen > 0 && own.passed < table.programs.len() => {
                self.add(view, config, a, f64::INFINITY);
            }
            ExpectedQuantity::Lasts(_) | ExpectedQuantity::Mutual(_) => {
                // An action that has only begun may still become mutual.
                let is_new =
                    matches!(config.that, ExpectedQuantity::Mutual(_)) && view.agents.now - own.since < MUTUAL_S;
                self.end_spell(view, config, a, !is_new);
            }
            ExpectedQuantity::Wait(_) => {
                let brain = &view.brains.brains[a as usize];
                let joined = view.brains.engagements[a as usize].joined;
                let lines = &view.brains.scenario.services[usize::from(table.number)].lines;
                let slot = view.brains.scenario.slots.get(brain.slot as usize);
                let waits = slot.is_some_and(|slot| lines.contains(&slot.place)) && joined.is_finite();
                if waits && table.who >> brain.group & 1 == 1 {
                    self.add(view, config, a, view.agents.now - joined);
                }
            }
            _ => {}
        }
    }

    /// Ends the spell of an agent where it is over, and adds its duration, or whether it was mutual.
    fn end_spell<S: ScenarioStage>(&mut self, view: &BrainsView<'_, S>, config: &ExpectConfig, a: u32, is_over: bool) {
        let own = self.agents[a as usize];
        if !is_over || own.since == f64::INFINITY {
            return;
        }
        self.agents[a as usize] = AgentMeter { entries: own.entries, ..UNSEEN };
        let value = match config.that {
            ExpectedQuantity::Mutual(_) => f64::from(u8::from(own.is_mutual)),
            _ => view.agents.now - own.since,
        };
        self.add(view, config, a, value);
    }

    fn observe_queue<S: ScenarioStage>(&mut self, view: &BrainsView<'_, S>, config: &ExpectConfig, place: u16) {
        let slots = &view.brains.scenario.slots;
        let head = view.brains.scenario.places[usize::from(place)].slots[0];
        for a in 0..self.agents.len() as u32 {
            let brain = &view.brains.brains[a as usize];
            let stands = view.brains.is_in_line(a);
            let slot = slots.get(brain.slot as usize).filter(|s| s.place == place).map_or(NONE, |_| brain.slot);
            let own = &mut self.agents[a as usize];
            if slot != NONE && stands {
                own.since = own.since.min(view.agents.now);
            }
            let left = (own.since < f64::INFINITY && slot == NONE).then_some((own.since, own.slot));
            own.slot = slot;
            let Some((since, last)) = left else { continue };
            *own = AgentMeter { entries: own.entries, ..UNSEEN };
            // A till may call an agent from behind others.
            let is_called = slots
                .get(brain.slot as usize)
                .is_some_and(|s| !view.brains.scenario.places[usize::from(s.place)].is_queue);
            if last != head && !is_called {
                // It gave up.
                continue;
            }
            let apart = self.let_in.iter().filter(|before| (**before - since).abs() > LEAD_S);
            self.values.extend(apart.map(|before| f32::from(u8::from(*before < since))));
            self.let_in.push(since);
            if self.agents.iter().any(|o| o.since < since - LEAD_S) {
                self.blame(view, config, a, 0.0);
            }
        }
    }

    /// Adds what only the end of a run tells.
    fn finish<S: ScenarioStage>(&mut self, view: &BrainsView<'_, S>, n: usize, config: &ExpectConfig) {
        let table = &view.brains.scenario.expectations[n];
        match config.that {
            ExpectedQuantity::Queue(_) => {
                // Agents that still wait were passed by those that came later.
                let passed = |own: &AgentMeter| self.let_in.iter().filter(|since| own.since < **since - LEAD_S).count();
                let passed = self.agents.iter().map(passed).sum();
                self.values.extend(std::iter::repeat_n(0.0, passed));
            }
            ExpectedQuantity::News(_) => {
                let of = |a: u32| view.brains.learnt_event(a as usize, usize::from(table.number)).copied();
                let all: Vec<_> = (0..view.brains.len() as u32).filter_map(|a| Some((a, of(a)?))).collect();
                for (a, informed) in all.iter().filter(|(_, l)| l.how == LearningMode::PassedOn) {
                    let sources =
                        all.iter().filter(|(_, l)| l.how != LearningMode::PassedOn && l.time_s <= informed.time_s);
                    let speed = |from: &super::LearntEvent| {
                        let far = Vec2::from(informed.at).distance(from.at.into());
                        (far >= FAR_M).then(|| f64::from(far) / (informed.time_s - from.time_s).max(1e-3))
                    };
                    let slowest = sources.map(|(_, from)| speed(from).unwrap_or(0.0)).reduce(f64::min);
                    if let Some(mps) = slowest.filter(|mps| *mps > 0.0) {
                        self.add(view, config, *a, mps);
                    }
                }
            }
            _ => (0..self.agents.len() as u32).for_each(|a| self.finish_agent(view, n, config, a)),
        }
    }

    fn statistic(&mut self, take: ExpectedStatistic) -> f64 {
        let all = &mut self.values;
        all.sort_by(f32::total_cmp);
        let rank = |share: f64| all[((all.len() - 1) as f64 * share).round() as usize];
        if all.is_empty() {
            return f64::NAN;
        }
        f64::from(match take {
            ExpectedStatistic::Min => all[0],
            ExpectedStatistic::P10 => rank(0.1),
            ExpectedStatistic::Median => rank(0.5),
            ExpectedStatistic::P90 => rank(0.9),
            ExpectedStatistic::P95 => rank(0.95),
            ExpectedStatistic::Max => all[all.len() - 1],
            ExpectedStatistic::Mean => {
                return all.iter().map(|v| f64::from(*v)).sum::<f64>() / all.len() as f64;
            }
            ExpectedStatistic::Share => {
                return all.iter().filter(|v| v.is_finite()).count() as f64 / all.len() as f64;
            }
        })
    }
}

/// Distance of a value beyond the bounds of an expectation; a value that is never reached is beyond all. Of a share only those count.
fn excess(config: &ExpectConfig, value: f64) -> f64 {
    let [least, most] = config.bounds();
    match config.statistic() {
        ExpectedStatistic::Share if config.least.is_none() && config.most.is_some() => {
            if value.is_finite() {
                f64::INFINITY
            } else {
                0.0
            }
        }
        _ if value.is_infinite() => f64::INFINITY,
        ExpectedStatistic::Share => 0.0,
        _ => (least - value).max(value - most),
    }
}

impl ExpectationMeters {
    /// Meters of a compiled scene, without measurements.
    pub fn new(scenario: &Arc<Scenario>, configs: &[ExpectConfig]) -> Self {
        let idle = AgentBrains::new(scenario.clone(), 0, &[]);
        Self { configs: configs.to_vec(), idle, meters: vec![ExpectationMeter::default(); configs.len()] }
    }

    /// Observes agents at one time, or at the end of a run.
    pub fn observe<S: ScenarioStage>(&mut self, agents: AgentsView<'_, S>, is_end: bool) {
        self.idle.now = agents.now;
        if agents.brains.is_none() {
            for (a, brain) in self.idle.brains.iter_mut().enumerate() {
                brain.is_there = agents.stage.position(a as u32).is_some();
            }
        }
        let view = BrainsView { brains: agents.brains.unwrap_or(&self.idle), agents };
        for (n, (config, meter)) in self.configs.iter().zip(&mut self.meters).enumerate() {
            let [from, to] = config.between_s.unwrap_or([0.0, f64::INFINITY]);
            if is_end {
                meter.finish(&view, n, config);
            } else if (from - 1e-6..=to + 1e-6).contains(&view.agents.now) {
                meter.observe(&view, n, config);
            }
        }
    }

    /// Outcomes at the end of a run.
    ///
    /// - `figure`: figure of that key, of all or of a group.
    ///
    /// # Errors
    /// Number and key of an expectation of a figure that there is not.
    pub fn finish(
        self,
        figure: impl Fn(Option<&str>, &str) -> Option<f64>,
    ) -> Result<Vec<ExpectationOutcome>, (usize, String)> {
        let all = self.configs.into_iter().zip(self.meters).enumerate();
        all.map(|(n, (config, mut meter))| {
            if let ExpectedQuantity::Figure(key) = &config.that {
                let value = figure(config.who.first().map(String::as_str), key);
                meter.values = vec![value.ok_or_else(|| (n, key.clone()))? as f32];
            }
            let (values, bounds) = (meter.values.len(), config.bounds());
            let figure = meter.statistic(config.statistic());
            let holds = bounds[0] <= figure && figure <= bounds[1];
            let worst = if holds { Vec::new() } else { meter.worst };
            Ok(ExpectationOutcome { name: config.name, figure, values, bounds, holds, worst })
        })
        .collect()
    }
}
