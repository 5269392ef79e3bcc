//! Events of the scene, entries and exits of agents, and how agents learn of events.

use super::boards::Note;
use super::mind::{Context, Feeling, Learnt, Phase};
use super::minds::{Minds, Signal, at_place};
use super::perceive::hashed;
use super::stage::Stage;
use super::tables::{How, NONE, Party, Schedule, trigger};
use throng_base::{Error, Result};

/// Most places that attract one agent at a time, in the order of the file.
const INTERESTS: usize = 4;
/// Attraction of a place for the most curious agents (m/s2), and its range in radii of the place (1).
const INTEREST_MPS2: f32 = 1.0;
const INTEREST_RADII: f32 = 4.0;

/// Time after which a door that could not close is tried again, and a source that found no room (s).
pub(super) const RETRY_S: f64 = 0.5;

impl Minds {
    /// Runs all external events that are due: events of the scene, closing doors, and entries of agents.
    ///
    /// # Errors
    /// As [`Minds::begin`].
    pub fn external(&mut self, stage: &mut impl Stage, now: f64) -> Result<()> {
        self.now = now;
        for e in 0..self.due.len() {
            if self.due[e] <= now {
                self.times[e] += 1;
                self.due[e] = self.next_time(e, now);
                self.occur(stage, e)?;
            }
        }
        for door in 0..self.closing.len() {
            if self.closing[door] <= now {
                self.set_open(stage, door, false)?;
            }
        }
        for g in 0..self.enters.len() {
            if self.enters[g] <= now {
                let agent = self.scenario.groups[g].agents[0] + self.entered[g];
                if stage.enter(agent)? {
                    self.entered[g] += 1;
                    self.enters[g] = self.next_entry(g, now);
                    self.arrive(stage, agent)?;
                } else {
                    self.enters[g] = now + RETRY_S;
                }
            }
        }
        self.finish(stage)
    }

    /// Raises an event on request of the application.
    ///
    /// # Errors
    /// As [`Minds::begin`]; [`Error::Unknown`] for a name that no event has.
    pub fn raise(&mut self, stage: &mut impl Stage, now: f64, event: &str) -> Result<()> {
        let Some(e) = self.scenario.names.events.find(event) else {
            let known = self.scenario.names.events.0.clone();
            return Err(Error::Unknown { what: "event", name: event.into(), known });
        };
        self.now = now;
        self.occur(stage, e)?;
        self.finish(stage)
    }

    /// Handles a signal of the crowd.
    ///
    /// # Errors
    /// As [`Minds::begin`].
    pub fn signal(&mut self, stage: &mut impl Stage, now: f64, signal: Signal) -> Result<()> {
        self.now = now;
        self.touch(signal.agent());
        match signal {
            Signal::Met(a, b) => {
                self.touch(b);
                self.meet(stage, a, b);
            }
            Signal::CameTo(agent, place) => self.come_to(stage, agent, place)?,
            Signal::WentFrom(agent, place) => self.push(agent, trigger::LEAVES, at_place(place)),
            Signal::Crossed(agent) => {
                self.read(stage, agent);
                self.push(agent, trigger::CROSSES, Context::default());
            }
            Signal::Arrived(agent) => match self.minds[agent as usize].phase {
                Phase::Walking | Phase::Waiting => {
                    if self.arrived(stage, agent)? {
                        self.next_action(stage, agent)?;
                    }
                }
                _ => self.push(agent, trigger::ARRIVES, Context::default()),
            },
            Signal::Left(agent) => self.leave(stage, agent)?,
            Signal::Stuck(agent) => {
                self.push(agent, trigger::STUCK, Context::default());
                self.give_up(stage, agent)?;
            }
            Signal::Timer(agent) => self.act_in_time(stage, agent)?,
        }
        self.finish(stage)
    }

    /// Starts an agent that has entered: draws its values, and begins its graph.
    pub(super) fn arrive(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
        let m = agent as usize;
        let scenario = self.scenario.clone();
        let group = &scenario.groups[usize::from(self.minds[m].group)];
        self.minds[m].is_there = true;
        self.minds[m].home = stage.position(agent).unwrap_or_default().to_array();
        for (v, table) in scenario.values.iter().enumerate() {
            let [low, high] = table.start;
            let value = low + (high - low) * self.chance(agent) as f32;
            self.feelings[m * scenario.values.len() + v] = Feeling { value, rate: table.rate, since: self.now };
            for t in table.thresholds[0]..table.thresholds[1] {
                let is_passed = scenario.thresholds[usize::from(t)].is_passed(value);
                self.minds[m].passed |= u32::from(is_passed) << t;
            }
        }
        self.find_crossing(agent);
        self.touch(agent);
        if group.start != NONE {
            self.enter_state(stage, agent, group.start, Context::default())?;
        }
        self.attract(stage, agent)?;
        self.push(agent, trigger::STARTS, Context::default());
        if scenario.senses_zones {
            let at = stage.position(agent).unwrap_or_default();
            let is_at = |place: &&super::tables::PlaceTable| place.at.distance(at) <= place.radius_m;
            let inside = scenario.places.iter().enumerate().filter(|(_, p)| is_at(p));
            for (p, _) in inside {
                self.come_to(stage, agent, p as u16)?;
            }
        }
        Ok(())
    }

    /// Sets the places that attract or repel an agent by its curiosity; places of one visit no longer do after it.
    pub(super) fn attract(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
        if !self.scenario.relations.iter().any(|r| matches!(r.to, Party::Place(_))) {
            return Ok(());
        }
        let mut n = 0;
        for (p, place) in self.scenario.places.iter().enumerate() {
            let is_seen = place.once.is_some_and(|bit| self.minds[agent as usize].entered >> bit & 1 == 1);
            let curiosity = if is_seen { 0.0 } else { self.curiosity(agent, Party::Place(p as u16)) };
            if curiosity != 0.0 && n < INTERESTS {
                stage.attract(
                    agent,
                    n,
                    Some((place.at, curiosity * INTEREST_MPS2, INTEREST_RADII * place.radius_m)),
                )?;
                n += 1;
            }
        }
        (n..INTERESTS).try_for_each(|n| stage.attract(agent, n, None))
    }

    pub(super) fn leave(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
        self.release(stage, agent)?;
        self.let_go(stage, agent);
        let mind = &mut self.minds[agent as usize];
        (mind.is_there, mind.action, mind.phase) = (false, NONE, Phase::Idle);
        (mind.until, mind.again, mind.most) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        (mind.timer, mind.crossing_at) = (f64::INFINITY, f64::INFINITY);
        Ok(())
    }

    /// Runs an event: agents to whom it happens learn of it, and doors move.
    pub(super) fn occur(&mut self, stage: &mut impl Stage, e: usize) -> Result<()> {
        let scenario = self.scenario.clone();
        let event = &scenario.events[e];
        self.happened[e] = self.now;
        if event.posted {
            self.boards.post(e as u16, None, Note { by: NONE, since: self.now, until: self.now + event.fresh_s });
        }
        self.ended |= scenario.end.event == Some(e as u16);
        for &(door, open) in &event.doors {
            self.set_open(stage, usize::from(door), open)?;
        }
        if event.nobody {
            return Ok(());
        }
        let context = Context { event: e as u16, how: How::Happens, ..Context::default() };
        for agent in 0..self.minds.len() as u32 {
            if self.minds[agent as usize].is_there
                && event.who.is_none_or(|who| self.is_true(stage, agent, context, who))
            {
                self.learn(stage, agent, context);
            }
        }
        Ok(())
    }

    /// Records that an agent learns of an event, which happens to it, or which it is told, reads or feels.
    pub(super) fn learn(&mut self, stage: &impl Stage, agent: u32, context: Context) {
        let (m, e) = (agent as usize, usize::from(context.event));
        let bit = 1u64 << e;
        let is_known = self.minds[m].news & bit != 0;
        if is_known && matches!(context.how, How::Told | How::Read) {
            return;
        }
        self.minds[m].news |= bit;
        if !is_known {
            let at = stage.position(agent).unwrap_or_default();
            let learnt = Learnt { time_s: self.now, from: context.other, how: context.how, at: [at.x, at.z] };
            self.learnt[m * self.scenario.events.len() + e] = Some(learnt);
        }
        self.push(agent, trigger::EVENTS + context.event, context);
        self.touch(agent);
    }

    /// Events that agents still pass on, as bits.
    pub(super) fn told_now(&self) -> u64 {
        let is_told = |e: &usize| {
            let event = &self.scenario.events[*e];
            event.channel.is_some() && self.now - self.happened[*e] <= event.fresh_s
        };
        (0..self.happened.len()).filter(is_told).fold(0, |bits, e| bits | 1 << e)
    }

    /// Handles a meeting: both agents tell each other the events that they know.
    pub(super) fn meet(&mut self, stage: &mut impl Stage, a: u32, b: u32) {
        let told = self.told_now();
        for (from, to) in [(a, b), (b, a)] {
            let mut news = self.minds[from as usize].news & !self.minds[to as usize].news & told;
            while news != 0 {
                let event = news.trailing_zeros() as u16;
                news &= news - 1;
                self.learn(stage, to, Context { other: from, event, how: How::Told, ..Context::default() });
            }
        }
        if self.scenario.meets {
            for (agent, other) in [(a, b), (b, a)] {
                self.push(agent, trigger::MEETS, Context { other, ..Context::default() });
            }
        }
    }

    pub(super) fn come_to(&mut self, stage: &mut impl Stage, agent: u32, place: u16) -> Result<()> {
        let (once, guidepost) = {
            let table = &self.scenario.places[usize::from(place)];
            (table.once, table.guidepost)
        };
        if let Some(bit) = once {
            let bit = 1u64 << bit;
            if self.minds[agent as usize].entered & bit != 0 {
                return Ok(());
            }
            self.minds[agent as usize].entered |= bit;
            self.attract(stage, agent)?;
        }
        if guidepost {
            self.read(stage, agent);
        }
        self.push(agent, trigger::ENTERS, at_place(place));
        Ok(())
    }

    /// Lets an agent read the blackboards at its position.
    pub(super) fn read(&mut self, stage: &impl Stage, agent: u32) {
        let Some(at) = stage.position(agent) else { return };
        let known = self.minds[agent as usize].news;
        let mut news = self.boards.at(at, self.now) & !known;
        while news != 0 {
            let event = news.trailing_zeros() as u16;
            news &= news - 1;
            self.learn(stage, agent, Context { event, how: How::Read, ..Context::default() });
        }
    }

    /// Conveys an event to the agents around one.
    pub(super) fn convey(
        &mut self,
        stage: &impl Stage,
        from: u32,
        event: u16,
        within_m: f32,
        strength: f32,
        friends: bool,
    ) {
        let Some(at) = stage.position(from) else { return };
        self.happened[usize::from(event)] = self.now;
        let mut nearby = std::mem::take(&mut self.nearby);
        nearby.clear();
        stage.within(at, within_m, &mut nearby);
        for &agent in &nearby {
            if agent == from || !self.minds[agent as usize].is_there {
                continue;
            }
            let far = stage.position(agent).map_or(within_m, |p| p.distance(at));
            let near = 1.0 - far / within_m.max(1e-3);
            let liking = if friends { self.friendship(agent, from).max(0.0) } else { 1.0 };
            let strength = strength * near * liking;
            if strength > 0.0 {
                self.learn(
                    stage,
                    agent,
                    Context { other: from, event, how: How::Felt, strength, ..Context::default() },
                );
            }
        }
        self.nearby = nearby;
    }

    /// Time of the next occurrence of an event after a time (s).
    pub(super) fn next_time(&self, e: usize, now: f64) -> f64 {
        let times = self.times[e];
        let chance = hashed(self.seed ^ 0x5EED_E7E7, e as u32, times);
        match self.scenario.events[e].schedule {
            Schedule::At(at) if times == 0 => at,
            Schedule::Between(from, to) if times == 0 => from + (to - from) * chance,
            Schedule::Poisson(mean) => now - mean * throng_base::maths::ln(1.0 - chance),
            Schedule::Period(period) => now + period,
            _ => f64::INFINITY,
        }
    }

    /// Time of the next entry of a group's agents after a time, by thinning (Lewis and Shedler 1979) (s).
    pub(super) fn next_entry(&self, g: usize, now: f64) -> f64 {
        let group = &self.scenario.groups[g];
        let most = group.rates.iter().map(|r| r[1]).fold(0.0, f64::max);
        if self.entered[g] >= group.agents[1] - group.agents[0] || most <= 0.0 {
            return f64::INFINITY;
        }
        let (mut at, mut draw) = (now, 0);
        loop {
            let chance = |side| hashed(self.seed ^ side, self.entered[g] | (g as u32) << 24, draw);
            at -= throng_base::maths::ln(1.0 - chance(0xA5A5)) / most;
            let next = group.rates.partition_point(|r| r[0] <= at);
            let rate = next.checked_sub(1).map_or(0.0, |i| group.rates[i][1]);
            if chance(0x5A5A) * most < rate {
                return at;
            }
            draw += 1;
            // No agent enters after the last rate where it is 0.
            if next == group.rates.len() && rate == 0.0 || draw > 100_000 {
                return f64::INFINITY;
            }
        }
    }
}
