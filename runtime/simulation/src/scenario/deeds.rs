//! Execution of behaviours: actions one after the other, the slots that they claim, and their effects.

use super::boards::Note;
use super::language::{Amount, Spot};
use super::mind::{Context, NO, Phase};
use super::minds::{Minds, at_place};
use super::perceive::View;
use super::stage::Stage;
use super::tables::{Action, Claims, NONE, trigger};
use super::verbs::{Deed, Effect, Operand, Said, Sight, WORDS, Walk};
use glam::Vec3;
use throng_base::Result;

/// Distance from a slot at which an agent has arrived (m).
const SLOT_M: f32 = 0.15;
/// Largest amount of an argument of an action; larger ones are clamped.
pub(super) const MOST: f64 = 1e9;

impl Minds {
    /// Starts a behaviour in the context of an event.
    pub(super) fn start(&mut self, stage: &mut impl Stage, agent: u32, actions: u32, context: Context) -> Result<()> {
        self.settle(stage, agent, false);
        let mind = &mut self.minds[agent as usize];
        (mind.context, mind.begun) = (context, mind.begun.wrapping_add(1));
        self.enter_action(stage, agent, actions)
    }

    /// Ends the action of an agent, and begins the next one.
    pub(super) fn next_action(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
        self.end_action(stage, agent)?;
        self.enter_action(stage, agent, self.minds[agent as usize].action + 1)
    }

    fn end_action(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
        self.settle(stage, agent, true);
        let mind = self.minds[agent as usize];
        if let Action::Primitive { .. } = self.action(mind.action) {
            // The action's own speed and motion end with it.
            stage.set_speed(agent, mind.speed)?;
            stage.show(agent, None, None);
        }
        Ok(())
    }

    /// Runs actions that take no time, up to the first one that takes time.
    fn enter_action(&mut self, stage: &mut impl Stage, agent: u32, first: u32) -> Result<()> {
        let m = agent as usize;
        let mut at = first;
        loop {
            let mind = &mut self.minds[m];
            (mind.action, mind.phase) = (at, Phase::Idle);
            (mind.until, mind.again, mind.most) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
            match self.action(at) {
                Action::End => return self.end_behaviour(stage, agent),
                Action::Primitive { .. } => {
                    if !self.perform(stage, agent, false)? {
                        return Ok(());
                    }
                    self.end_action(stage, agent)?;
                }
                action => {
                    let context = self.minds[m].context;
                    self.affect(stage, agent, action, context)?;
                }
            }
            at += 1;
        }
    }

    /// Ends a behaviour after its last action: resumes what a rule had interrupted, or raises `done`.
    fn end_behaviour(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
        let mind = &mut self.minds[agent as usize];
        if !mind.is_busy {
            self.push(agent, trigger::DONE, Context::default());
            return Ok(());
        }
        (mind.is_busy, mind.priority) = (false, i8::MIN);
        let resumed = std::mem::replace(&mut mind.resumed, NONE);
        mind.context = mind.resumed_context;
        mind.action = resumed;
        if resumed == NONE {
            return if mind.states[0] == NO && mind.states[1] == NO && mind.states[2] == NO {
                stage.resume(agent)
            } else {
                Ok(())
            };
        }
        self.enter_action(stage, agent, resumed)
    }

    /// Runs actions that take no time.
    pub(super) fn do_at_once(
        &mut self,
        stage: &mut impl Stage,
        agent: u32,
        first: u32,
        context: Context,
    ) -> Result<()> {
        let mut at = first;
        loop {
            match self.action(at) {
                Action::End => return Ok(()),
                action => self.affect(stage, agent, action, context)?,
            }
            at += 1;
        }
    }

    /// Begins a primitive behaviour, or calls its function again; true where it is over at once.
    pub(super) fn perform(&mut self, stage: &mut impl Stage, agent: u32, is_again: bool) -> Result<bool> {
        let m = agent as usize;
        let mind = self.minds[m];
        let Action::Primitive { number, words, motion, way, claims } = self.action(mind.action) else {
            return Ok(false);
        };
        let context = mind.context;
        let mut said = self.said(stage, agent, context, &words);
        if matches!(claims, Claims::Take(_) | Claims::Put(_)) {
            self.release(stage, agent)?;
            return self.fetch(stage, agent, claims, &said);
        }
        if claims == Claims::Nothing {
            self.release(stage, agent)?;
            if let Some(place) = self.place_of(&words[0], context) {
                said.arrival_m = self.nearness(place);
            }
        } else if let Some(place) = self.place_of(&words[0], context) {
            let [first, last] = self.scenario.places[usize::from(place)].slots;
            if first == last {
                said.arrival_m = self.nearness(place);
            } else if let Some(slot) = self.claim(stage, agent, place, claims)? {
                let slot = self.scenario.slots[slot as usize];
                (said.targets[0], said.facing, said.arrival_m) = (Some(slot.at), Some(slot.facing), SLOT_M);
            } else {
                self.push(agent, trigger::FULL, at_place(place));
                return Ok(true);
            }
        }
        let position = stage.position(agent).unwrap_or_default();
        let sight = Sight {
            time_s: self.now,
            position,
            velocity: stage.velocity(agent),
            desired_mps: mind.speed,
            home: Vec3::from_array(mind.home),
            chance: [self.chance(agent) as f32, self.chance(agent) as f32],
        };
        let deed = (self.scenario.primitives.get(number).act)(&sight, &said);
        if let Some(speed) = deed.speed_mps {
            stage.set_speed(agent, speed)?;
        }
        let mind = &mut self.minds[m];
        if !is_again {
            mind.most = self.now + deed.most_s;
        }
        mind.again = if deed.again_s > 0.0 { self.now + deed.again_s } else { f64::INFINITY };
        let goes = match deed.walk {
            Walk::Keep => return self.stand_until(agent, deed.stay_s),
            Walk::Halt => {
                stage.halt(agent)?;
                stage.show(agent, motion, deed.faces);
                return if deed.stay_s > 0.0 { self.stand_until(agent, deed.stay_s) } else { Ok(true) };
            }
            Walk::To { at, arrival_m } if position.distance(at) <= arrival_m => {
                self.minds[m].phase = Phase::Walking;
                return self.arrived(stage, agent);
            }
            Walk::To { at, arrival_m } => stage.go(agent, at, arrival_m, false)?,
            Walk::Out { at, arrival_m } => stage.go(agent, at, arrival_m, true)?,
            Walk::Along => {
                let scenario = self.scenario.clone();
                let points = way.map_or(&[] as &[Vec3], |w| &scenario.ways[usize::from(w)]);
                stage.follow(agent, points, words[2] == Operand::Flag(true))?
            }
        };
        self.minds[m].phase = Phase::Walking;
        if !goes {
            self.push(agent, trigger::STUCK, Context::default());
            return Ok(true);
        }
        Ok(false)
    }

    pub(super) fn stand_until(&mut self, agent: u32, stay_s: f64) -> Result<bool> {
        let mind = &mut self.minds[agent as usize];
        (mind.phase, mind.until) = (Phase::Standing, self.now + stay_s);
        Ok(false)
    }

    /// Handles the arrival of an agent at the place of its action; true where the action is over.
    pub(super) fn arrived(&mut self, stage: &mut impl Stage, agent: u32) -> Result<bool> {
        let m = agent as usize;
        let mind = self.minds[m];
        let Action::Primitive { number, words, motion, claims, .. } = self.action(mind.action) else {
            return Ok(false);
        };
        let mut said = self.said(stage, agent, mind.context, &words);
        if let Some(slot) = self.scenario.slots.get(mind.slot as usize) {
            (said.targets[0], said.facing) = (Some(slot.at), Some(slot.facing));
        }
        if matches!(claims, Claims::Take(_) | Claims::Put(_)) {
            return self.use_hands(stage, agent, (claims, motion), &said);
        }
        if let Claims::Queue(into) = claims {
            let held = self.scenario.slots.get(mind.slot as usize).map(|slot| slot.place);
            let Some(place) = self.place_of(&words[0], mind.context).filter(|place| held == Some(*place)) else {
                // No agent waits at a place without slots.
                return Ok(true);
            };
            stage.show(agent, motion, said.facing);
            let table = &self.scenario.places[usize::from(place)];
            let (is_queue, is_first) = (table.is_queue, mind.slot == table.slots[0]);
            self.minds[m].phase = Phase::Waiting;
            // Agents move up in queues alone.
            let goes_on =
                !is_queue || is_first && into.is_none_or(|into| self.free_slot(into, stage.position(agent)).is_some());
            if !goes_on {
                return Ok(false);
            }
            if let Some(into) = into {
                self.claim(stage, agent, into, Claims::Slot)?;
            }
            return Ok(true);
        }
        let sight = Sight {
            time_s: self.now,
            position: stage.position(agent).unwrap_or_default(),
            velocity: Vec3::ZERO,
            desired_mps: mind.speed,
            home: Vec3::from_array(mind.home),
            chance: [0.0; 2],
        };
        let deed: Deed = (self.scenario.primitives.get(number).act)(&sight, &said);
        if deed.walk == Walk::Along && words[2] == Operand::Flag(true) {
            // The route begins again.
            return Ok(false);
        }
        if deed.stay_s <= 0.0 {
            return Ok(true);
        }
        stage.show(agent, motion, deed.faces);
        self.stand_until(agent, deed.stay_s)
    }

    /// Evaluates the arguments of an action.
    fn said(&mut self, stage: &impl Stage, agent: u32, context: Context, words: &[Operand; WORDS]) -> Said {
        let mut said = Said { arrival_m: 0.5, ..Said::default() };
        for (i, word) in words.iter().enumerate() {
            match *word {
                Operand::Amount(amount) => said.amounts[i] = Some(self.amount(stage, agent, context, amount)),
                Operand::Flag(flag) => said.amounts[i] = Some(f64::from(u8::from(flag))),
                Operand::Point(at) => said.targets[i] = Some(Vec3::from_array(at)),
                Operand::Spot(spot) => {
                    let mut draws = 0;
                    said.targets[i] = View { minds: self, stage, agent, context, draws: &mut draws }.spot(spot);
                }
                Operand::Arrow => {
                    let arrow = self.scenario.places.get(usize::from(context.place)).and_then(|p| p.arrow);
                    said.targets[i] = arrow.map(|to| self.scenario.places[usize::from(to)].at);
                }
                Operand::Nothing | Operand::Number(_) => {}
            }
        }
        said
    }

    fn amount(&mut self, stage: &impl Stage, agent: u32, context: Context, amount: Amount) -> f64 {
        let mut draws = self.minds[agent as usize].draws;
        self.evaluations += u64::from(matches!(amount, Amount::Program(_)));
        let value = self.scenario.amount(amount, &mut View { minds: self, stage, agent, context, draws: &mut draws });
        self.minds[agent as usize].draws = draws;
        // Infinities and NaN would spread to all values that are computed with them.
        if value.is_nan() { 0.0 } else { value.clamp(-MOST, MOST) }
    }

    /// Distance from the centre of a place at which an agent has arrived (m).
    fn nearness(&self, place: u16) -> f32 {
        (0.8 * self.scenario.places[usize::from(place)].radius_m).max(0.5)
    }

    fn place_of(&self, word: &Operand, context: Context) -> Option<u16> {
        match *word {
            Operand::Spot(Spot::Place(place)) => Some(place),
            Operand::Spot(Spot::Here) => Some(context.place).filter(|p| *p != NO),
            _ => None,
        }
    }

    /// Applies the effect of an action that takes no time.
    fn affect(&mut self, stage: &mut impl Stage, agent: u32, action: Action, context: Context) -> Result<()> {
        let (effect, words) = match action {
            Action::Effect(effect, words) => (effect, words),
            Action::Happening(number) => return stage.follow_happening(agent, number),
            _ => return Ok(()),
        };
        let said = self.said(stage, agent, context, &words);
        let number = if let Operand::Number(number) = words[0] { number } else { 0 };
        match effect {
            Effect::Set => self.change_value(agent, number, |f| f.value = said.amount(1, 0.0) as f32),
            Effect::Add => self.change_value(agent, number, |f| f.value += said.amount(1, 0.0) as f32),
            Effect::Rate => self.change_value(agent, number, |f| f.rate = said.amount(1, 0.0) as f32),
            Effect::Speed => {
                let speed = said.amount(0, 0.0).clamp(0.0, 100.0) as f32;
                self.minds[agent as usize].speed = speed;
                stage.set_speed(agent, speed)?;
            }
            Effect::Post => {
                self.happened[usize::from(number)] = self.now;
                let until = self.now + said.amount(2, f64::INFINITY);
                let at = stage.position(agent).unwrap_or_default();
                let cell = said.amounts[1].map(|level| (at, level.clamp(0.0, 30.0) as u32));
                self.boards.post(number, cell, Note { by: agent, since: self.now, until });
            }
            Effect::Learn => {
                let event = usize::from(number);
                if self.happened[event] == f64::NEG_INFINITY {
                    self.happened[event] = self.now;
                }
                let context = Context { event: number, ..Context::default() };
                self.learn(stage, agent, context);
            }
            Effect::Convey => {
                let (within_m, strength) = (said.amount(1, 5.0) as f32, said.amount(2, 1.0) as f32);
                self.convey(stage, agent, number, within_m, strength, said.amount(3, 0.0) > 0.0);
            }
            Effect::Befriend if context.other != NONE => {
                self.befriend(agent, context.other, said.amount(0, 0.0) as f32)
            }
            Effect::Befriend => {}
            Effect::Open => self.set_open(stage, usize::from(number), true)?,
            Effect::Close => self.set_open(stage, usize::from(number), false)?,
            Effect::Release => self.release(stage, agent)?,
            Effect::Timer => self.minds[agent as usize].timer = self.now + said.amount(0, 0.0).max(0.0),
        }
        Ok(())
    }

    /// Changes the liking of an agent for another one; replaces the oldest of four relationships.
    fn befriend(&mut self, agent: u32, other: u32, by: f32) {
        let bonds = &mut self.bonds[agent as usize];
        let old = bonds.iter().position(|b| b.0 == other);
        let liking = old.map_or(0.0, |i| bonds[i].1) + by;
        bonds[..=old.unwrap_or(3)].rotate_right(1);
        bonds[0] = (other, liking.clamp(-2.0, 2.0));
    }

    /// Free slot of a place that is nearest to a position; in a queue, the slot behind the last agent that waits.
    fn free_slot(&self, place: u16, near: Option<Vec3>) -> Option<u32> {
        let table = &self.scenario.places[usize::from(place)];
        let [first, last] = table.slots;
        let is_free = |slot: &u32| self.holders[*slot as usize] == NONE;
        if table.is_queue {
            let behind = (first..last).rev().find(|s| !is_free(s)).map_or(first, |s| s + 1);
            return (behind < last).then_some(behind);
        }
        let near = near.unwrap_or(table.at);
        let far = |slot: &u32| self.scenario.slots[*slot as usize].at.distance_squared(near);
        (first..last).filter(is_free).min_by(|a, b| far(a).total_cmp(&far(b)))
    }

    /// Claims a slot of a place for an agent, and releases any other; keeps a slot that the agent has there.
    fn claim(&mut self, stage: &mut impl Stage, agent: u32, place: u16, claims: Claims) -> Result<Option<u32>> {
        let held = self.minds[agent as usize].slot;
        if held != NONE && self.scenario.slots[held as usize].place == place {
            return Ok(Some(held));
        }
        debug_assert!(claims != Claims::Nothing);
        let Some(slot) = self.free_slot(place, stage.position(agent)) else { return Ok(None) };
        self.holders[slot as usize] = agent;
        self.release(stage, agent)?;
        self.minds[agent as usize].slot = slot;
        Ok(Some(slot))
    }

    /// Releases the slot of an agent: agents behind it in a queue move up, and one that waits for the slot goes on.
    pub(super) fn release(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
        let slot = std::mem::replace(&mut self.minds[agent as usize].slot, NONE);
        if slot == NONE {
            return Ok(());
        }
        self.holders[slot as usize] = NONE;
        let place = self.scenario.slots[slot as usize].place;
        let table = &self.scenario.places[usize::from(place)];
        let ([_, last], is_queue) = (table.slots, table.is_queue);
        if is_queue {
            for behind in slot + 1..last {
                let holder = self.holders[behind as usize];
                if holder == NONE {
                    break;
                }
                self.holders[behind as usize - 1] = std::mem::replace(&mut self.holders[behind as usize], NONE);
                self.minds[holder as usize].slot = behind - 1;
                self.touch(holder);
                if matches!(self.minds[holder as usize].phase, Phase::Walking | Phase::Waiting) {
                    self.minds[holder as usize].phase = Phase::Walking;
                    stage.show(holder, None, None);
                    stage.go(holder, self.scenario.slots[behind as usize - 1].at, SLOT_M, false)?;
                }
            }
            return Ok(());
        }
        // Agents at the heads of queues that lead here.
        for queue in 0..self.scenario.places.len() {
            let table = &self.scenario.places[queue];
            if !table.is_queue || table.slots[0] == table.slots[1] {
                continue;
            }
            let head = self.holders[table.slots[0] as usize];
            if head == NONE || self.minds[head as usize].phase != Phase::Waiting {
                continue;
            }
            if let Action::Primitive { claims: Claims::Queue(Some(into)), .. } =
                self.action(self.minds[head as usize].action)
                && into == place
            {
                self.touch(head);
                if self.arrived(stage, head)? {
                    return self.next_action(stage, head);
                }
                return Ok(());
            }
        }
        Ok(())
    }
}
