//! Events of the scene, entries and exits of agents, and how agents learn of events.

use super::action_registry::ActionArguments;
use super::agent_brain::{ActionPhase, AgentBrain, AgentEngagement, EventContext, Feeling, LearntEvent, Occasion};
use super::agent_brains::{AgentBrains, Signal, place_context};
use super::tables::{LearningMode, NONE, Party, PlaceTable, Schedule, trigger};
use super::{blackboards::BlackboardNote, perceive::hashed_chance, stage::ScenarioStage};
use throng_base::Result;

/// Most places that attract one agent at a time, in the order of the file.
const INTERESTS: usize = 4;
/// Attraction of a place for the most curious agents (m/s2), and its range in radii of the place (1).
const INTEREST_MPS2: f32 = 1.0;
const INTEREST_RADII: f32 = 4.0;

/// An agent repeats its news after this many times the time that telling takes.
const REPEAT_TELLINGS: f64 = 2.0;
/// Clearance from walls of the line along which agents hear each other (m).
const HEARING_CLEARANCE_M: f32 = 0.01;

/// Time after which a door that could not close is tried again, and a source that found no room (s).
pub(super) const RETRY_S: f64 = 0.5;

/// Change of brains from outside.
#[derive(Clone, Copy, Debug)]
pub(crate) enum BrainChange<'a> {
    /// An event happens, to all whom it concerns.
    Event(&'a str),
    /// The agent alone learns of an event.
    Learn(&'a str),
    /// A value of the agent is set.
    Value(&'a str, f32),
    /// What the agent does ends; it stands until a rule lets it act.
    Suspend(Option<f32>),
}

impl AgentBrains {
    /// Runs all external events that are due: events of the scene, closing doors, and entries of agents.
    ///
    /// # Errors
    /// As [`AgentBrains::begin_scene`].
    pub fn run_external_events(&mut self, stage: &mut impl ScenarioStage, now: f64) -> Result<()> {
        self.account_services(now);
        self.now = now;
        for e in 0..self.due.len() {
            if self.due[e] <= now {
                self.times[e] += 1;
                self.due[e] = self.next_event_time(e, now);
                self.fire_event(stage, e)?;
            }
        }
        for door in 0..self.closing.len() {
            if self.closing[door] <= now {
                self.set_door_open(stage, door, false)?;
            }
        }
        for g in 0..self.enters.len() {
            if self.enters[g] <= now {
                match self.next_newcomer(g) {
                    Some(agent) if stage.enter_agent(agent)? => {
                        let is_new = agent == self.scenario.groups[g].agents[0] + self.entered[g];
                        (self.entered[g], self.reused[g]) =
                            (self.entered[g] + u32::from(is_new), self.reused[g] + u32::from(!is_new));
                        self.enters[g] = self.next_entry_time(g, now);
                        if !is_new {
                            self.renew_agent(agent);
                        }
                        self.begin_agent(stage, agent)?;
                    }
                    _ => {
                        self.refused[g] += 1;
                        self.enters[g] = now + RETRY_S;
                    }
                }
            }
        }
        self.process_stimuli(stage)
    }

    /// Changes what an application asks for, in one agent or in all.
    ///
    /// # Errors
    /// As [`AgentBrains::begin_scene`]; [`throng_base::Error::Unknown`] for a name that no event or value has.
    pub(crate) fn change(
        &mut self,
        stage: &mut impl ScenarioStage,
        now: f64,
        agent: u32,
        change: BrainChange<'_>,
    ) -> Result<()> {
        self.account_services(now);
        self.now = now;
        match change {
            BrainChange::Event(name) => {
                let e = self.event_number(name)?;
                self.fire_event(stage, e)?;
            }
            BrainChange::Learn(name) => {
                let e = self.event_number(name)?;
                self.learn_here(stage, agent, e as u16);
            }
            BrainChange::Value(name, value) => {
                let values = &self.scenario.names.values;
                let unknown =
                    || throng_base::Error::Unknown { what: "value", name: name.into(), known: values.0.clone() };
                let number = values.number_of(name).ok_or_else(unknown)?;
                self.change_value(agent, number as u16, |feeling| feeling.value = value);
            }
            BrainChange::Suspend(speed_mps) => {
                self.suspend(stage, agent)?;
                let brain = &mut self.brains[agent as usize];
                brain.speed = speed_mps.unwrap_or(brain.speed);
            }
        }
        self.process_stimuli(stage)
    }

    /// Lets one agent learn of an event where it is.
    pub(super) fn learn_here(&mut self, stage: &impl ScenarioStage, agent: u32, event: u16) {
        let happened = &mut self.happened[usize::from(event)];
        if *happened == f64::NEG_INFINITY {
            *happened = self.now;
        }
        self.learn_event(stage, agent, EventContext { event, ..EventContext::default() });
    }

    /// Ends what an agent does; it stands until a rule lets it act.
    fn suspend(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        self.end_handling(stage, agent, false);
        self.release_slot(stage, agent)?;
        let brain = &mut self.brains[agent as usize];
        (brain.is_busy, brain.priority, brain.resumed) = (false, i8::MIN, NONE);
        (brain.action, brain.phase, brain.begun) = (NONE, ActionPhase::Idle, brain.begun.wrapping_add(1));
        (brain.stands_until_s, brain.acts_again_at_s, brain.gives_up_at_s) =
            (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        (self.engagements[agent as usize].runs_course, self.engagements[agent as usize].is_done) = (false, false);
        self.mark_touched(agent);
        Ok(())
    }

    /// Handles a signal of the crowd.
    ///
    /// # Errors
    /// As [`AgentBrains::begin_scene`].
    pub fn handle_signal(&mut self, stage: &mut impl ScenarioStage, now: f64, signal: Signal) -> Result<()> {
        self.account_services(now);
        self.now = now;
        self.mark_touched(signal.agent());
        match signal {
            Signal::Met(a, b) => {
                self.mark_touched(b);
                self.exchange_news(stage, a, b);
            }
            Signal::CameTo(agent, place) => self.enter_place(stage, agent, place)?,
            Signal::WentFrom(agent, place) => self.push_stimulus(agent, trigger::LEAVES, place_context(place)),
            Signal::Crossed(agent) => {
                self.read_blackboards(stage, agent);
                self.push_stimulus(agent, trigger::CROSSES, EventContext::default());
            }
            Signal::Arrived(agent) => {
                self.count_lap(agent);
                match self.brains[agent as usize].phase {
                    ActionPhase::Walking | ActionPhase::Waiting => {
                        if self.handle_arrival(stage, agent)? {
                            self.next_action(stage, agent)?;
                        }
                    }
                    _ => self.push_stimulus(agent, trigger::ARRIVES, EventContext::default()),
                }
            }
            Signal::Left(agent) => self.end_agent(stage, agent)?,
            Signal::Stuck(agent) => {
                self.push_stimulus(agent, trigger::STUCK, EventContext::default());
                self.give_up_fetching(stage, agent)?;
            }
            Signal::Timer(agent) => self.run_timers(stage, agent)?,
        }
        self.process_stimuli(stage)
    }

    /// Agent of a group that enters next: one that has never been there, else one that has left; `None` where all are there.
    fn next_newcomer(&self, g: usize) -> Option<u32> {
        let [first, last] = self.scenario.groups[g].agents;
        let new = first + self.entered[g];
        let from = self.reused[g] % (last - first).max(1);
        let left = (0..last - first).map(|k| first + (from + k) % (last - first));
        let mut left = left.filter(|agent| !self.brains[*agent as usize].is_there);
        (new < last).then_some(new).or_else(|| left.next())
    }

    /// Gives an agent that has left and enters again a new brain.
    fn renew_agent(&mut self, agent: u32) {
        let (m, scenario) = (agent as usize, self.scenario.clone());
        let AgentBrain { group, draws, .. } = self.brains[m];
        let speed = self.first_speeds.get(m).copied().unwrap_or_default();
        self.brains[m] = AgentBrain { draws, speed, ..AgentBrain::new(group) };
        let entries = self.engagements[m].entries + 1;
        self.engagements[m] = AgentEngagement { entries, ..AgentEngagement::default() };
        self.learnt[m * scenario.events.len()..][..scenario.events.len()].fill(None);
        self.followed[m * scenario.num_pauses..][..scenario.num_pauses].fill(f64::NEG_INFINITY);
        if let Some(relationships) = self.relationships.get_mut(m) {
            *relationships = [(NONE, 0.0); 4];
        }
    }

    /// Starts an agent that has entered: draws its values, and begins its graph.
    pub(super) fn begin_agent(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        let m = agent as usize;
        let scenario = self.scenario.clone();
        let group = &scenario.groups[usize::from(self.brains[m].group)];
        self.brains[m].is_there = true;
        self.brains[m].home = stage.position(agent).unwrap_or_default().to_array();
        for (v, table) in scenario.values.iter().enumerate() {
            let [low, high] = table.start;
            let value = low + (high - low) * self.draw_chance(agent) as f32;
            self.feelings[m * scenario.values.len() + v] = Feeling { value, rate: table.rate, since: self.now };
            for t in table.thresholds[0]..table.thresholds[1] {
                let is_passed = scenario.thresholds[usize::from(t)].is_passed(value);
                self.brains[m].passed |= u32::from(is_passed) << t;
            }
        }
        self.find_crossing(agent);
        self.mark_touched(agent);
        if group.start != NONE {
            self.enter_state(stage, Occasion { agent, context: EventContext::default() }, group.start)?;
        }
        self.update_interests(stage, agent)?;
        self.push_stimulus(agent, trigger::STARTS, EventContext::default());
        if scenario.senses_zones {
            let at = stage.position(agent).unwrap_or_default();
            let is_at = |place: &PlaceTable| place.at.distance(at) <= place.radius_m;
            for (p, _) in (0u16..).zip(&scenario.places).filter(|(_, place)| is_at(place)) {
                self.enter_place(stage, agent, p)?;
            }
        }
        Ok(())
    }

    /// Sets the places that attract or repel an agent by its curiosity; places of one visit no longer do after it.
    pub(super) fn update_interests(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        if !self.scenario.relations.iter().any(|r| matches!(r.to, Party::Place(_))) {
            return Ok(());
        }
        let mut n = 0;
        for (p, place) in self.scenario.places.iter().enumerate() {
            let is_seen = place.once.is_some_and(|bit| self.brains[agent as usize].entered >> bit & 1 == 1);
            let curiosity = if is_seen { 0.0 } else { self.curiosity(agent, Party::Place(p as u16)) };
            if curiosity != 0.0 && n < INTERESTS {
                let reach_m = INTEREST_RADII * place.radius_m;
                stage.set_interest(agent, n, Some((place.at, curiosity * INTEREST_MPS2, reach_m)))?;
                n += 1;
            }
        }
        (n..INTERESTS).try_for_each(|n| stage.set_interest(agent, n, None))
    }

    pub(super) fn end_agent(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        self.release_slot(stage, agent)?;
        self.drop_all_things(stage, agent);
        let brain = &mut self.brains[agent as usize];
        (brain.is_there, brain.action, brain.phase) = (false, NONE, ActionPhase::Idle);
        (brain.stands_until_s, brain.acts_again_at_s, brain.gives_up_at_s) =
            (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        (brain.timer, brain.crossing_at) = (f64::INFINITY, f64::INFINITY);
        (brain.told_by, brain.aim) = (NONE, NONE);
        (brain.told_at, brain.tells_at) = (f64::INFINITY, f64::INFINITY);
        self.engagements[agent as usize].is_done = false;
        self.leave_party(stage, agent);
        Ok(())
    }

    /// Runs an event: agents to whom it happens learn of it, and doors move.
    pub(super) fn fire_event(&mut self, stage: &mut impl ScenarioStage, e: usize) -> Result<()> {
        let scenario = self.scenario.clone();
        let event = &scenario.events[e];
        self.happened[e] = self.now;
        if event.posted {
            let note = BlackboardNote { by: NONE, since: self.now, until: self.now + event.fresh_s };
            self.blackboards.post_event(e as u16, None, note);
        }
        self.ended |= scenario.end.event == Some(e as u16);
        for &(door, open) in &event.doors {
            self.set_door_open(stage, usize::from(door), open)?;
        }
        if event.nobody {
            return Ok(());
        }
        let context = EventContext { event: e as u16, how: LearningMode::Happens, ..EventContext::default() };
        for agent in 0..self.brains.len() as u32 {
            if self.brains[agent as usize].is_there
                && event.who.is_none_or(|who| self.evaluate_predicate(stage, Occasion { agent, context }, who))
            {
                self.learn_event(stage, agent, context);
            }
        }
        Ok(())
    }

    /// Records that an agent learns of an event, which happens to it, or which it is told, reads or feels.
    pub(super) fn learn_event(&mut self, stage: &impl ScenarioStage, agent: u32, context: EventContext) {
        let (m, e) = (agent as usize, usize::from(context.event));
        let bit = 1u64 << e;
        let is_known = self.brains[m].news & bit != 0;
        if is_known && matches!(context.how, LearningMode::PassedOn | LearningMode::Read) {
            return;
        }
        self.brains[m].news |= bit;
        if self.scenario.events[e].channel.is_some() && self.scenario.telling_s > 0.0 {
            self.brains[m].tells_at = self.now + REPEAT_TELLINGS * self.scenario.telling_s;
        }
        if !is_known {
            let at = stage.position(agent).unwrap_or_default();
            let learnt = LearntEvent { time_s: self.now, from: context.other, how: context.how, at: [at.x, at.z] };
            self.learnt[m * self.scenario.events.len() + e] = Some(learnt);
        }
        self.push_stimulus(agent, trigger::EVENTS + context.event, context);
        self.mark_touched(agent);
    }

    /// Events that agents still pass on, as bits.
    pub(super) fn shared_events(&self) -> u64 {
        let is_told = |e: &usize| {
            let event = &self.scenario.events[*e];
            event.channel.is_some() && self.now - self.happened[*e] <= event.fresh_s
        };
        (0..self.happened.len()).filter(is_told).fold(0, |bits, e| bits | 1 << e)
    }

    /// Handles a meeting: both agents begin to tell each other the events that they know.
    pub(super) fn exchange_news(&mut self, stage: &mut impl ScenarioStage, a: u32, b: u32) {
        let shared = self.shared_events();
        for (from, to) in [(a, b), (b, a)] {
            let news = self.brains[from as usize].news & !self.brains[to as usize].news & shared;
            if self.scenario.telling_s == 0.0 {
                self.learn_news(stage, from, to, news);
            } else if news != 0 && self.brains[to as usize].told_by == NONE && self.hears(stage, to, from) {
                let told_at = self.now + self.scenario.telling_s;
                (self.brains[to as usize].told_by, self.brains[to as usize].told_at) = (from, told_at);
            }
        }
        if self.scenario.meets {
            for (agent, other) in [(a, b), (b, a)] {
                self.push_stimulus(agent, trigger::MEETS, EventContext { other, ..EventContext::default() });
            }
        }
    }

    /// Ends the telling of news to an agent, which learns them where it has heard all.
    pub(super) fn end_telling(&mut self, stage: &mut impl ScenarioStage, agent: u32) {
        let brain = &mut self.brains[agent as usize];
        let from = std::mem::replace(&mut brain.told_by, NONE);
        brain.told_at = f64::INFINITY;
        if from != NONE && self.brains[from as usize].is_there && self.hears(stage, agent, from) {
            let news = self.brains[from as usize].news & !self.brains[agent as usize].news & self.shared_events();
            self.learn_news(stage, from, agent, news);
        }
    }

    /// Tells news again to those around an agent that have not heard them, such as behind a wall.
    pub(super) fn tell_again(&mut self, stage: &mut impl ScenarioStage, agent: u32) -> Result<()> {
        let has_news = self.brains[agent as usize].news & self.shared_events() != 0;
        let again = self.now + REPEAT_TELLINGS * self.scenario.telling_s;
        self.brains[agent as usize].tells_at = if has_news { again } else { f64::INFINITY };
        // Whoever is near counts as met anew once the senses change.
        stage.set_senses(agent, 0, 0)
    }

    /// True where an agent is near another one, without a wall or a closed door between them.
    fn hears(&self, stage: &impl ScenarioStage, agent: u32, other: u32) -> bool {
        let (Some(a), Some(b)) = (stage.position(agent), stage.position(other)) else { return false };
        a.distance(b) <= self.scenario.hearing_m && stage.sees(a, b, HEARING_CLEARANCE_M, true)
    }

    /// Lets an agent learn events from another one, as bits.
    fn learn_news(&mut self, stage: &impl ScenarioStage, from: u32, to: u32, mut news: u64) {
        while news != 0 {
            let (event, how) = (news.trailing_zeros() as u16, LearningMode::PassedOn);
            news &= news - 1;
            self.learn_event(stage, to, EventContext { other: from, event, how, ..EventContext::default() });
        }
    }

    pub(super) fn enter_place(&mut self, stage: &mut impl ScenarioStage, agent: u32, place: u16) -> Result<()> {
        let &PlaceTable { once, guidepost, .. } = &self.scenario.places[usize::from(place)];
        if let Some(bit) = once {
            let bit = 1u64 << bit;
            if self.brains[agent as usize].entered & bit != 0 {
                return Ok(());
            }
            self.brains[agent as usize].entered |= bit;
            self.update_interests(stage, agent)?;
        }
        if guidepost {
            self.read_blackboards(stage, agent);
        }
        self.push_stimulus(agent, trigger::ENTERS, place_context(place));
        Ok(())
    }

    /// Lets an agent read the blackboards at its position.
    pub(super) fn read_blackboards(&mut self, stage: &impl ScenarioStage, agent: u32) {
        let Some(at) = stage.position(agent) else { return };
        let known = self.brains[agent as usize].news;
        let mut news = self.blackboards.events_at(at, self.now) & !known;
        while news != 0 {
            let event = news.trailing_zeros() as u16;
            news &= news - 1;
            self.learn_event(stage, agent, EventContext { event, how: LearningMode::Read, ..EventContext::default() });
        }
    }

    /// Conveys an event to the agents around one.
    pub(super) fn convey_event(&mut self, stage: &impl ScenarioStage, from: u32, event: u16, said: &ActionArguments) {
        let (within_m, strength) = (said.amount(1, 5.0) as f32, said.amount(2, 1.0) as f32);
        let friends = said.amount(3, 0.0) > 0.0;
        let Some(at) = stage.position(from) else { return };
        self.happened[usize::from(event)] = self.now;
        let mut nearby = std::mem::take(&mut self.nearby);
        nearby.clear();
        stage.agents_within(at, within_m, &mut nearby);
        for &agent in &nearby {
            if agent == from || !self.brains[agent as usize].is_there {
                continue;
            }
            let far = stage.position(agent).map_or(within_m, |p| p.distance(at));
            let near = 1.0 - far / within_m.max(1e-3);
            let liking = if friends { self.friendship(agent, from).max(0.0) } else { 1.0 };
            let (how, strength) = (LearningMode::Felt, strength * near * liking);
            if strength > 0.0 {
                let context = EventContext { other: from, event, how, strength, ..EventContext::default() };
                self.learn_event(stage, agent, context);
            }
        }
        self.nearby = nearby;
    }

    /// Time of the next occurrence of an event after a time (s).
    pub(super) fn next_event_time(&self, e: usize, now: f64) -> f64 {
        let times = self.times[e];
        let chance = hashed_chance(self.seed ^ 0x5EED_E7E7, e as u32, times);
        match self.scenario.events[e].schedule {
            Schedule::At(at) if times == 0 => at,
            Schedule::Between(from, to) if times == 0 => from + (to - from) * chance,
            Schedule::Poisson(mean) => now - mean * throng_base::maths::ln(1.0 - chance),
            Schedule::Period(period) => now + period,
            _ => f64::INFINITY,
        }
    }

    /// Time of the next entry of a group's agents after a time, by thinning (Lewis and Shedler 1979) (s).
    pub(super) fn next_entry_time(&self, g: usize, now: f64) -> f64 {
        let group = &self.scenario.groups[g];
        let most = group.rates.iter().map(|r| r[1]).fold(0.0, f64::max);
        let is_over = self.entered[g] >= group.agents[1] - group.agents[0] && !group.reuses;
        if is_over || most <= 0.0 {
            return f64::INFINITY;
        }
        let (mut at, mut draw) = (now, 0);
        loop {
            let number = self.entered[g].wrapping_add(self.reused[g]) & 0xFF_FFFF;
            let chance = |side| hashed_chance(self.seed ^ side, number | (g as u32) << 24, draw);
            at -= throng_base::maths::ln(1.0 - chance(0xA5A5)) / most;
            let of_day = if group.period_s.is_finite() { at % group.period_s } else { at };
            let next = group.rates.partition_point(|r| r[0] <= of_day);
            let rate = next.checked_sub(1).map_or(0.0, |i| group.rates[i][1]);
            if chance(0x5A5A) * most < rate {
                return at;
            }
            draw += 1;
            // No agent enters after the last rate where it is 0.
            let is_last = next == group.rates.len() && group.period_s.is_infinite();
            if is_last && rate == 0.0 || draw > 100_000 {
                return f64::INFINITY;
            }
        }
    }
}
