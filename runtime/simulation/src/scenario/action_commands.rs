//! Execution of behaviours: actions one after the other, the slots that they claim, and their effects.

use super::action_registry::{
    ActionArguments, ActionCommand, ActionOperand, ActionWords, Effect, GESTURES, PrimitiveInput, WalkCommand,
};
use super::agent_brain::{ActionPhase, AgentBrain, EventContext, NO_NUMBER, Occasion};
use super::agent_brains::{AgentBrains, place_context};
use super::language::{Amount, SpotName};
use super::stage::{ScenarioStage, ShownGesture};
use super::tables::{ActionClaim, CompiledAction, NONE, trigger};
use super::{blackboards::BlackboardNote, courses::CourseBegin, perceive::AgentView, slots::IN_LINE_M};
use glam::Vec3;
use std::f32::consts::PI;
use throng_base::{Result, maths};

/// Distance from a slot at which an agent has arrived (m).
pub(super) const SLOT_M: f32 = 0.15;
/// Distance from the end of a line at which an agent joins it (m), and time between two looks where it ends (s).
pub(super) const JOIN_M: f32 = 1.5;
const JOIN_S: f64 = 0.5;
/// Clearance from walls of a place that is seen (m), and most draws of one.
const NEAR_M: f32 = 0.5;
const NEAR_TRIES: u32 = 20;
/// Clearance from walls of the line along which an agent flees (m), number of directions that are tried, and of positions in each.
const FLEE_CLEARANCE_M: f32 = 0.2;
const FLEE_DIRECTIONS: u32 = 9;
const FLEE_STEPS: u32 = 10;
/// Time after which an agent that flees looks again for a place (s).
const FLEE_AGAIN_S: f64 = 0.5;
/// Largest amount of an argument of an action; larger ones are clamped.
pub(super) const MAX_AMOUNT: f64 = 1e9;

impl AgentBrains {
    /// Starts a behaviour in the context of an event.
    pub(super) fn start_behaviour(&mut self, stage: &mut impl ScenarioStage, on: Occasion, actions: u32) -> Result<()> {
        let Occasion { agent, context } = on;
        self.end_handling(stage, agent, false);
        let brain = &mut self.brains[agent as usize];
        (brain.context, brain.begun) = (context, brain.begun.wrapping_add(1));
        self.enter_action(stage, agent, actions)
    }

    /// Ends the action of an agent, and begins the next one.
    pub(super) fn next_action(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        self.end_action(stage, agent)?;
        self.enter_action(stage, agent, self.brains[agent as usize].action + 1)
    }

    fn end_action(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        self.end_handling(stage, agent, true);
        let brain = self.brains[agent as usize];
        if let CompiledAction::Primitive { .. } = self.action(brain.action) {
            // The action's own speed and motion end with it.
            stage.set_speed(agent, brain.speed)?;
            stage.show_activity(agent, None, None);
        }
        Ok(())
    }

    /// Runs actions that take no time, up to the first one that takes time.
    pub(super) fn enter_action(&mut self, stage: &mut impl ScenarioStage, agent: u32, first: u32) -> Result<()> {
        let m = agent as usize;
        let mut at = first;
        loop {
            let brain = &mut self.brains[m];
            (brain.action, brain.phase) = (at, ActionPhase::Idle);
            (brain.stands_until_s, brain.acts_again_at_s, brain.gives_up_at_s) =
                (f64::INFINITY, f64::INFINITY, f64::INFINITY);
            match self.action(at) {
                CompiledAction::End => return self.end_behaviour(stage, agent),
                CompiledAction::Primitive { .. } => {
                    if !self.run_primitive(stage, agent, false)? {
                        return Ok(());
                    }
                    self.end_action(stage, agent)?;
                }
                action => {
                    let context = self.brains[m].context;
                    self.apply_effect(stage, Occasion { agent, context }, action)?;
                }
            }
            // A service that is not had ends the list.
            at = self.brains[m].action + 1;
        }
    }

    /// Ends a behaviour after its last action: resumes what a rule had interrupted, or raises `done`.
    fn end_behaviour(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        let brain = &mut self.brains[agent as usize];
        if !brain.is_busy {
            self.push_stimulus(agent, trigger::DONE, EventContext::default());
            return Ok(());
        }
        (brain.is_busy, brain.priority) = (false, i8::MIN);
        let resumed = std::mem::replace(&mut brain.resumed, NONE);
        brain.context = brain.resumed_context;
        brain.action = resumed;
        if resumed == NONE {
            return if brain.states == [NO_NUMBER; 3] { stage.resume_route(agent) } else { Ok(()) };
        }
        self.enter_action(stage, agent, resumed)
    }

    /// Runs actions that take no time.
    pub(super) fn apply_effects(&mut self, stage: &mut impl ScenarioStage, on: Occasion, first: u32) -> Result<()> {
        for at in first.. {
            match self.action(at) {
                CompiledAction::End => break,
                action => self.apply_effect(stage, on, action)?,
            }
        }
        Ok(())
    }

    /// Begins a primitive behaviour, or calls its function again; true where it is over at once.
    pub(super) fn run_primitive(&mut self, stage: &mut impl ScenarioStage, agent: u32, is_again: bool) -> Result<bool> {
        let m = agent as usize;
        let brain = self.brains[m];
        let CompiledAction::Primitive { number, words, motion, route, claims } = self.action(brain.action) else {
            return Ok(false);
        };
        let context = brain.context;
        let mut said = self.evaluate_arguments(stage, Occasion { agent, context }, &words);
        let mut joins = None;
        if matches!(claims, ActionClaim::Take(_) | ActionClaim::Put(_)) {
            self.release_slot(stage, agent)?;
            return self.fetch_thing(stage, agent, claims, &said);
        }
        if claims == ActionClaim::Nothing {
            self.release_slot(stage, agent)?;
            if let Some(place) = self.place_of(&words[0], context) {
                said.arrival_m = self.arrival_distance(place);
            }
        } else if let Some(place) = self.line_of(stage, agent, claims, &words[0]) {
            let [first, last] = self.scenario.places[usize::from(place)].slots;
            if first == last {
                said.arrival_m = self.arrival_distance(place);
            } else if let Some(slot) = self.queue_end(stage, agent, place) {
                // Agents join a line where they come to its end.
                self.release_slot(stage, agent)?;
                joins = Some(slot);
                (said.targets[0], said.arrival_m) = (Some(self.scenario.slots[slot as usize].at), 0.8 * JOIN_M);
            } else if let Some(slot) = match claims {
                ActionClaim::Serve(service) => {
                    match self.join_line(stage, Occasion { agent, context }, place, service)? {
                        None => return Ok(true),
                        slot => slot,
                    }
                }
                _ => self.claim_slot(stage, agent, place)?,
            } {
                let slot = self.scenario.slots[slot as usize];
                let is_queue = self.scenario.places[usize::from(place)].is_queue;
                let comes = is_queue && brain.phase != ActionPhase::Waiting;
                (said.targets[0], said.facing) = (Some(slot.at), Some(slot.facing));
                said.arrival_m = if comes { IN_LINE_M } else { SLOT_M };
            } else if self.waits_beside(stage, agent, place)? {
                return Ok(false);
            } else {
                self.push_stimulus(agent, trigger::FULL, place_context(place));
                return Ok(true);
            }
        }
        let position = stage.position(agent).unwrap_or_default();
        let chance = [self.draw_chance(agent) as f32, self.draw_chance(agent) as f32];
        let velocity = stage.velocity(agent);
        let sight = PrimitiveInput { velocity, chance, ..self.primitive_input(&brain, position) };
        let mut command = (self.scenario.primitives.get(number).act)(&sight, &said);
        let mut tries = 0;
        while let WalkCommand::Near { middle, at, arrival_m } = command.walk {
            tries += 1;
            let middle = free_ground_towards(stage, position, middle);
            if tries > NEAR_TRIES || stage.sees(middle, at, NEAR_M, false) {
                let at = if tries > NEAR_TRIES { middle } else { at };
                command.walk = WalkCommand::To { at, arrival_m };
            } else {
                let chance = [self.draw_chance(agent) as f32, self.draw_chance(agent) as f32];
                command = (self.scenario.primitives.get(number).act)(&PrimitiveInput { chance, ..sight }, &said);
            }
        }
        if let WalkCommand::Away { from, at, arrival_m } = command.walk {
            let to = farthest_seen(stage, [from, position, at]);
            command.again_s = if to.is_some_and(|to| to.distance(at) < SLOT_M) { 0.0 } else { FLEE_AGAIN_S };
            command.walk = to.map_or(WalkCommand::Halt, |at| WalkCommand::To { at, arrival_m });
        }
        let own = self.brains[m].slot;
        let stands =
            brain.phase == ActionPhase::Waiting || !matches!(claims, ActionClaim::Queue(_) | ActionClaim::Serve(_));
        let aim = joins.unwrap_or(if stands { NONE } else { own });
        let before = std::mem::replace(&mut self.brains[m].aim, aim);
        if let Some(slot) = joins {
            command.again_s = JOIN_S;
            if is_again && before == slot && brain.phase == ActionPhase::Walking {
                command.walk = WalkCommand::Keep;
            }
        }
        if let Some(speed) = command.speed_mps {
            stage.set_speed(agent, speed)?;
        }
        let brain = &mut self.brains[m];
        if !is_again {
            brain.gives_up_at_s = brain.gives_up_at_s.min(self.now + command.most_s);
        }
        brain.acts_again_at_s = if command.again_s > 0.0 { self.now + command.again_s } else { f64::INFINITY };
        if !matches!(command.walk, WalkCommand::Keep | WalkCommand::Along) {
            self.engagements[m].runs_course = false;
        }
        if brain.phase == ActionPhase::Standing && !matches!(command.walk, WalkCommand::Keep | WalkCommand::Halt) {
            // Who walks on faces where it goes.
            stage.show_activity(agent, None, None);
        }
        let goes = match command.walk {
            WalkCommand::Keep if joins.is_some() => return Ok(false),
            // An agent that stands already does not stop anew.
            WalkCommand::Halt if is_again && brain.phase == ActionPhase::Standing => return Ok(false),
            WalkCommand::Keep => return self.stand_until(agent, command.stay_s),
            WalkCommand::Halt => {
                stage.order_halt(agent)?;
                self.show_action(stage, agent, motion, command.faces);
                return if command.stay_s > 0.0 { self.stand_until(agent, command.stay_s) } else { Ok(true) };
            }
            WalkCommand::To { at, arrival_m } if position.distance(at) <= arrival_m => {
                self.brains[m].phase = ActionPhase::Walking;
                return self.handle_arrival(stage, agent);
            }
            WalkCommand::To { at, arrival_m }
            | WalkCommand::Near { at, arrival_m, .. }
            | WalkCommand::Away { at, arrival_m, .. } => stage.order_walk(agent, at, arrival_m, false)?,
            WalkCommand::Out { at, arrival_m } => stage.order_walk(agent, at, arrival_m, true)?,
            WalkCommand::Along if is_again => {
                self.watch_course(stage, agent, &said);
                return Ok(false);
            }
            WalkCommand::Along => match self.begin_course(stage, agent, route.unwrap_or(NO_NUMBER), &said)? {
                CourseBegin::Over => return Ok(true),
                begin => begin == CourseBegin::Goes,
            },
        };
        self.brains[m].phase = ActionPhase::Walking;
        if !goes {
            self.push_stimulus(agent, trigger::STUCK, EventContext::default());
            return Ok(true);
        }
        Ok(false)
    }

    pub(super) fn stand_until(&mut self, agent: u32, stay_s: f64) -> Result<bool> {
        let brain = &mut self.brains[agent as usize];
        (brain.phase, brain.stands_until_s) = (ActionPhase::Standing, self.now + stay_s);
        Ok(false)
    }

    /// Handles the arrival of an agent at the place of its action; true where the action is over.
    pub(super) fn handle_arrival(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<bool> {
        let m = agent as usize;
        let brain = self.brains[m];
        let CompiledAction::Primitive { number, words, motion, claims, .. } = self.action(brain.action) else {
            return Ok(false);
        };
        let mut said = self.evaluate_arguments(stage, Occasion { agent, context: brain.context }, &words);
        if let Some(slot) = self.scenario.slots.get(brain.slot as usize) {
            (said.targets[0], said.facing) = (Some(slot.at), Some(slot.facing));
        }
        if matches!(claims, ActionClaim::Take(_) | ActionClaim::Put(_)) {
            return self.use_hands(stage, agent, claims, motion, &said);
        }
        if matches!(claims, ActionClaim::Queue(_) | ActionClaim::Serve(_)) {
            let held = self.scenario.slots.get(brain.slot as usize).map(|slot| slot.place);
            let line = self.line_of(stage, agent, claims, &words[0]);
            let Some(place) = line.filter(|place| held == Some(*place)) else {
                // No agent waits at a place without slots.
                let Some(place) = line.filter(|p| self.scenario.places[usize::from(*p)].is_queue) else {
                    return Ok(true);
                };
                // At the end of a line it joins the line, unless another one has been faster.
                let is_plain = matches!(claims, ActionClaim::Queue(_));
                if is_plain && brain.aim != NONE && self.free_slot(place, None) == Some(brain.aim) {
                    self.claim_slot(stage, agent, place)?;
                }
                return self.run_primitive(stage, agent, true);
            };
            let comes = std::mem::replace(&mut self.brains[m].aim, NONE) != NONE;
            if comes && self.scenario.places[usize::from(place)].is_queue {
                self.join_before_absent(stage, agent, place)?;
                if let ActionClaim::Serve(service) = claims {
                    self.call_next(stage, service)?;
                }
                return Ok(false);
            }
            stage.show_activity(agent, motion, said.facing);
            let table = &self.scenario.places[usize::from(place)];
            let (is_queue, is_first) = (table.is_queue, brain.slot == table.slots[0]);
            self.brains[m].phase = ActionPhase::Waiting;
            let into = match claims {
                ActionClaim::Serve(service) => {
                    self.call_next(stage, service)?;
                    return Ok(false);
                }
                ActionClaim::Queue(into) => into,
                _ => None,
            };
            // Agents move up in queues alone.
            let goes_on =
                !is_queue || is_first && into.is_none_or(|into| self.free_slot(into, stage.position(agent)).is_some());
            if !goes_on {
                return Ok(false);
            }
            if let Some(into) = into {
                self.claim_slot(stage, agent, into)?;
            }
            return Ok(true);
        }
        if let ActionOperand::Duration(service) = words[2] {
            self.begin_service(agent, service);
        }
        let sight = self.primitive_input(&brain, stage.position(agent).unwrap_or_default());
        let command: ActionCommand = (self.scenario.primitives.get(number).act)(&sight, &said);
        if command.walk == WalkCommand::Along {
            return Ok(self.ends_course(agent, &said));
        }
        if command.stay_s <= 0.0 {
            return Ok(true);
        }
        if command.walk == WalkCommand::Halt {
            // It would go on to the middle of its goal.
            stage.order_halt(agent)?;
        }
        self.show_action(stage, agent, motion, command.faces);
        self.stand_until(agent, command.stay_s)
    }

    /// Shows the motion of an action; an agent that faces the other one goes on facing it.
    fn show_action(&self, stage: &mut impl ScenarioStage, agent: u32, motion: Option<u16>, faces: Option<Vec3>) {
        stage.show_activity(agent, motion, faces);
        let brain = &self.brains[agent as usize];
        if let CompiledAction::Primitive { words, .. } = self.action(brain.action)
            && words.contains(&ActionOperand::Spot(SpotName::Other))
            && brain.context.other != NONE
            && faces.is_some()
        {
            stage.face_agent(agent, brain.context.other);
        }
    }

    /// Input of a primitive behaviour for an agent that stands still.
    fn primitive_input(&self, brain: &AgentBrain, position: Vec3) -> PrimitiveInput {
        let (desired_mps, home) = (brain.speed, Vec3::from_array(brain.home));
        PrimitiveInput { time_s: self.now, position, velocity: Vec3::ZERO, desired_mps, home, chance: [0.0; 2] }
    }

    /// Evaluates the arguments of an action.
    fn evaluate_arguments(&mut self, stage: &impl ScenarioStage, on: Occasion, words: &ActionWords) -> ActionArguments {
        let Occasion { agent, context } = on;
        let mut said = ActionArguments { arrival_m: 0.5, ..ActionArguments::default() };
        for (i, word) in words.iter().enumerate() {
            match *word {
                ActionOperand::Amount(amount) => said.amounts[i] = Some(self.evaluate_amount(stage, on, amount)),
                ActionOperand::Duration(service) => said.amounts[i] = Some(self.draw_service_time(agent, service)),
                ActionOperand::Flag(flag) => said.amounts[i] = Some(f64::from(u8::from(flag))),
                ActionOperand::Point(at) => said.targets[i] = Some(Vec3::from_array(at)),
                ActionOperand::Spot(spot) => {
                    let mut draws = 0;
                    said.targets[i] =
                        AgentView { brains: self, stage, agent, context, now: self.now, draws: &mut draws }
                            .spot_position(spot);
                }
                ActionOperand::Arrow => {
                    let arrow = self.scenario.places.get(usize::from(context.place)).and_then(|p| p.arrow);
                    said.targets[i] = arrow.map(|to| self.scenario.places[usize::from(to)].at);
                }
                ActionOperand::Nothing | ActionOperand::Number(_) => {}
            }
        }
        said
    }

    fn evaluate_amount(&mut self, stage: &impl ScenarioStage, on: Occasion, amount: Amount) -> f64 {
        let value = match amount {
            Amount::Number(number) => number,
            Amount::Program(program) => self.evaluate_program(stage, on, program),
        };
        // Infinities and NaN would spread to all values that are computed with them.
        if value.is_nan() { 0.0 } else { value.clamp(-MAX_AMOUNT, MAX_AMOUNT) }
    }

    /// Distance from the centre of a place at which an agent has arrived (m).
    fn arrival_distance(&self, place: u16) -> f32 {
        (0.8 * self.scenario.places[usize::from(place)].radius_m).max(0.5)
    }

    /// Line in which an action lets an agent stand, or place of which it takes a slot.
    fn line_of(&self, stage: &impl ScenarioStage, agent: u32, claim: ActionClaim, word: &ActionOperand) -> Option<u16> {
        match claim {
            ActionClaim::Serve(service) => self.choose_line(stage, agent, service),
            _ => self.place_of(word, self.brains[agent as usize].context),
        }
    }

    fn place_of(&self, word: &ActionOperand, context: EventContext) -> Option<u16> {
        match *word {
            ActionOperand::Spot(SpotName::Place(place)) => Some(place),
            ActionOperand::Spot(SpotName::Here) => Some(context.place).filter(|p| *p != NO_NUMBER),
            _ => None,
        }
    }

    /// Applies the effect of an action that takes no time.
    fn apply_effect(&mut self, stage: &mut impl ScenarioStage, on: Occasion, action: CompiledAction) -> Result<()> {
        let Occasion { agent, context } = on;
        let (effect, words) = match action {
            CompiledAction::Effect(effect, words) => (effect, words),
            CompiledAction::Happening(number) => return stage.follow_happening(agent, number),
            _ => return Ok(()),
        };
        let said = self.evaluate_arguments(stage, on, &words);
        let number = if let ActionOperand::Number(number) = words[0] { number } else { 0 };
        match effect {
            Effect::Set => self.change_value(agent, number, |f| f.value = said.amount(1, 0.0) as f32),
            Effect::Add => self.change_value(agent, number, |f| f.value += said.amount(1, 0.0) as f32),
            Effect::Rate => self.change_value(agent, number, |f| f.rate = said.amount(1, 0.0) as f32),
            Effect::Speed => {
                let speed = said.amount(0, 0.0).clamp(0.0, 100.0) as f32;
                self.brains[agent as usize].speed = speed;
                stage.set_speed(agent, speed)?;
            }
            Effect::Post => {
                self.happened[usize::from(number)] = self.now;
                let until = self.now + said.amount(2, f64::INFINITY);
                let at = stage.position(agent).unwrap_or_default();
                let cell = said.amounts[1].map(|level| (at, level.clamp(0.0, 30.0) as u32));
                self.blackboards.post_event(number, cell, BlackboardNote { by: agent, since: self.now, until });
            }
            Effect::Learn => self.learn_here(stage, agent, number),
            Effect::Convey => self.convey_event(stage, agent, number, &said),
            Effect::Befriend if context.other != NONE => {
                self.change_relationship(agent, context.other, said.amount(0, 0.0) as f32)
            }
            Effect::Befriend => {}
            Effect::Open => self.set_door_open(stage, usize::from(number), true)?,
            Effect::Close => self.set_door_open(stage, usize::from(number), false)?,
            Effect::Release => self.release_slot(stage, agent)?,
            Effect::Gesture => {
                let gesture = GESTURES.get(usize::from(number)).map(|&(_, arm, usual_s)| ShownGesture {
                    arm,
                    at: said.targets[1],
                    other: Some(context.other)
                        .filter(|o| *o != NONE && words[1] == ActionOperand::Spot(SpotName::Other)),
                    until_s: self.now + said.amount(2, usual_s).max(0.0),
                });
                stage.show_gesture(agent, gesture);
            }
            Effect::Timer => self.brains[agent as usize].timer = self.now + said.amount(0, 0.0).max(0.0),
        }
        Ok(())
    }

    /// Changes the liking of an agent for another one; replaces the oldest of four relationships.
    fn change_relationship(&mut self, agent: u32, other: u32, by: f32) {
        let relationships = &mut self.relationships[agent as usize];
        let old = relationships.iter().position(|b| b.0 == other);
        let liking = old.map_or(0.0, |i| relationships[i].1) + by;
        relationships[..=old.unwrap_or(3)].rotate_right(1);
        relationships[0] = (other, liking.clamp(-2.0, 2.0));
    }
}

/// Free ground nearest to a place on the straight line from there to an agent: the place itself unless an obstacle is there (m).
fn free_ground_towards(stage: &impl ScenarioStage, position: Vec3, place: Vec3) -> Vec3 {
    let steps = (position.distance(place) / NEAR_M).ceil();
    let mut on_line = (0..steps as u32).map(|k| place.lerp(position, k as f32 / steps));
    on_line.find(|at| stage.sees(*at, *at, NEAR_M, false)).unwrap_or(position)
}

/// Position that an agent sees and that is farthest from a threat, of those on straight lines that never come nearer to it; `None` where
/// none is farther away than the agent.
///
/// - `from`, `position`, `at`: of the threat, of the agent, and of the place to which it would flee without walls (m).
fn farthest_seen(stage: &impl ScenarioStage, [from, position, at]: [Vec3; 3]) -> Option<Vec3> {
    let ahead = at - position;
    let seen = (0..FLEE_DIRECTIONS * FLEE_STEPS).map(|n| {
        let turn = maths::direction_at_angle(PI * (n % FLEE_DIRECTIONS) as f32 / (FLEE_DIRECTIONS - 1) as f32);
        let offset = ahead * turn.y + Vec3::new(ahead.z, 0.0, -ahead.x) * turn.x;
        position + offset * ((n / FLEE_DIRECTIONS + 1) as f32 / FLEE_STEPS as f32)
    });
    let is_seen = |to: &Vec3| stage.sees(position, *to, FLEE_CLEARANCE_M, true) && stage.sees(*to, *to, NEAR_M, true);
    if is_seen(&at) {
        return Some(at);
    }
    let best = seen.filter(is_seen).max_by(|a, b| a.distance(from).total_cmp(&b.distance(from)));
    best.filter(|to| to.distance(from) > position.distance(from) + SLOT_M)
}
