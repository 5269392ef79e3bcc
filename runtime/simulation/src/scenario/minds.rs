//! The minds of all agents: stimuli come in, behaviours go out.

use super::boards::{Boards, Note};
use super::language::{Program, run};
use super::mind::{Context, Feeling, Learnt, Mind, NO, Phase, Reason};
use super::perceive::{View, hashed};
use super::stage::Stage;
use super::tables::{Action, Edge, How, NONE, Party, Scenario, Schedule, trigger};
use super::turns::{Turn, TurnKind};
use std::collections::VecDeque;
use std::sync::Arc;
use throng_base::{Error, Result};

/// Stimuli of one agent at one time, from which on it is taken to run in a circle.
const MOST_AT_ONCE: u32 = 100;

/// Bit of what agents sense of each other for meetings.
const MEETINGS: u32 = 1 << 31;

/// Most things that draw one agent at a time, in the order of the file.
const INTERESTS: usize = 4;
/// How strongly a place draws those who are most curious (m/s2), and from how many of its radii on.
const INTEREST_MPS2: f32 = 1.0;
const INTEREST_RADII: f32 = 4.0;

/// After this time a door that could not close tries again, and a source that found no room (s).
const RETRY_S: f64 = 0.5;

/// Something that happens to an agent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stimulus {
    pub trigger: u16,
    pub context: Context,
    /// Behaviours that the agent had begun by then.
    pub begun: u16,
}

/// What a crowd tells minds of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Signal {
    /// Two come within telling distance.
    Met(u32, u32),
    /// An agent comes to a place.
    CameTo(u32, u16),
    /// An agent goes from a place.
    WentFrom(u32, u16),
    /// An agent crosses the side of a cell.
    Crossed(u32),
    /// An agent is at the end of its way.
    Arrived(u32),
    /// An agent has left.
    Left(u32),
    /// An agent makes no progress.
    Stuck(u32),
    /// It is time for an agent to act by itself.
    Timer(u32),
}

impl Signal {
    /// To whom it happens; of two, the one with the smaller number.
    fn agent(self) -> u32 {
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

/// Everybody's minds, and what they share.
#[derive(Clone, Debug)]
pub struct Minds {
    pub(super) scenario: Arc<Scenario>,
    pub(super) seed: u64,
    pub(super) now: f64,
    pub(super) minds: Vec<Mind>,
    /// (agents x values)
    pub(super) feelings: Vec<Feeling>,
    /// (agents x events)
    pub(super) learnt: Vec<Option<Learnt>>,
    /// When agents followed rules with a pause last (agents x such rules) (s).
    pub(super) followed: Vec<f64>,
    /// Whom agents like more or less than their relations say: the last four (agents).
    pub(super) bonds: Vec<[(u32, f32); 4]>,
    /// Who holds each slot; [`NONE`] for nobody.
    pub(super) holders: Vec<u32>,
    /// Who has each thing in hand, or goes to take it; [`NONE`] for nobody.
    pub(super) keepers: Vec<u32>,
    pub(super) is_open: Vec<bool>,
    /// Doors that are to close, once nobody stands in them.
    pub(super) closing: Vec<f64>,
    /// When each event happens next (s), and how often it has.
    pub(super) due: Vec<f64>,
    pub(super) times: Vec<u32>,
    /// When each event happened last (s).
    pub(super) happened: Vec<f64>,
    /// Whether the condition of each event was true.
    pub(super) was_true: Vec<bool>,
    /// When the next of each group enters (s), and how many have.
    pub(super) enters: Vec<f64>,
    pub(super) entered: Vec<u32>,
    pub(super) boards: Boards,
    pub(super) queue: VecDeque<(u32, Stimulus)>,
    /// Agents whose timers and senses have to be set anew.
    pub(super) touched: Vec<u32>,
    pub(super) is_touched: Vec<bool>,
    pub(super) nearby: Vec<u32>,
    pub(super) ended: bool,
    /// Predicates and amounts that were worked out.
    pub(super) evaluations: u64,
    /// What happened, where somebody watches.
    pub(super) turns: Option<Vec<Turn>>,
}

impl Minds {
    /// Minds of all agents of a scenario, before anybody is there.
    pub fn new(scenario: Arc<Scenario>, seed: u64, doors: &[bool]) -> Self {
        let num = scenario.groups.last().map_or(0, |g| g.agents[1] as usize);
        let mut minds = Vec::with_capacity(num);
        for (g, group) in scenario.groups.iter().enumerate() {
            minds.extend((group.agents[0]..group.agents[1]).map(|_| Mind::new(g as u16)));
        }
        let num_events = scenario.events.len();
        let mut out = Self {
            seed,
            now: 0.0,
            minds,
            feelings: vec![Feeling::default(); num * scenario.values.len()],
            learnt: vec![None; num * num_events],
            followed: vec![f64::NEG_INFINITY; num * scenario.num_pauses],
            bonds: vec![[(NONE, 0.0); 4]; if scenario.befriends() { num } else { 0 }],
            holders: vec![NONE; scenario.slots.len()],
            keepers: vec![NONE; scenario.things.len()],
            is_open: doors.to_vec(),
            closing: vec![f64::INFINITY; doors.len()],
            due: vec![f64::INFINITY; num_events],
            times: vec![0; num_events],
            happened: vec![f64::NEG_INFINITY; num_events],
            was_true: vec![false; num_events],
            enters: vec![f64::INFINITY; scenario.groups.len()],
            entered: scenario.groups.iter().map(|g| g.there).collect(),
            boards: Boards::new(scenario.boards, num_events),
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
            out.due[e] = out.next_time(e, 0.0);
        }
        for g in 0..out.enters.len() {
            out.enters[g] = out.next_entry(g, 0.0);
        }
        out
    }

    /// Lets all who are there at the start begin.
    ///
    /// # Errors
    /// Those of the stage, and [`Error::Text`] where rules run in a circle.
    pub fn begin(&mut self, stage: &mut impl Stage, speeds: &[f32]) -> Result<()> {
        for agent in 0..self.minds.len() as u32 {
            self.minds[agent as usize].speed = speeds[agent as usize];
            let group = &self.scenario.groups[usize::from(self.minds[agent as usize].group)];
            if agent - group.agents[0] < group.there {
                self.arrive(stage, agent)?;
            }
        }
        self.finish(stage)
    }

    /// When something happens from outside next (s).
    pub fn next_external_s(&self) -> f64 {
        let all = self.due.iter().chain(&self.enters).chain(&self.closing);
        all.copied().fold(f64::INFINITY, f64::min)
    }

    /// Everything from outside that is due now happens.
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

    /// An event happens, by the will of whoever watches.
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

    /// What a crowd tells.
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
                Phase::Walking | Phase::Waiting => self.arrived(stage, agent)?,
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

    /// Somebody is there.
    fn arrive(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
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

    /// What an agent is curious about draws it near, or drives it away; what it has seen and enters once no longer does.
    fn attract(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
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

    fn leave(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
        self.release(stage, agent)?;
        self.let_go(stage, agent);
        let mind = &mut self.minds[agent as usize];
        (mind.is_there, mind.action, mind.phase) = (false, NONE, Phase::Idle);
        (mind.until, mind.again, mind.most) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        (mind.timer, mind.crossing_at) = (f64::INFINITY, f64::INFINITY);
        Ok(())
    }

    /// Tells an event to whom it happens.
    fn occur(&mut self, stage: &mut impl Stage, e: usize) -> Result<()> {
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

    /// An agent learns of an event: it happens to it, or it is told, reads or feels it.
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

    /// Events that are still told on.
    fn told_now(&self) -> u64 {
        let is_told = |e: &usize| {
            let event = &self.scenario.events[*e];
            event.channel.is_some() && self.now - self.happened[*e] <= event.fresh_s
        };
        (0..self.happened.len()).filter(is_told).fold(0, |bits, e| bits | 1 << e)
    }

    /// Two tell each other what they know.
    fn meet(&mut self, stage: &mut impl Stage, a: u32, b: u32) {
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

    fn come_to(&mut self, stage: &mut impl Stage, agent: u32, place: u16) -> Result<()> {
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

    /// An agent reads the boards where it is.
    fn read(&mut self, stage: &impl Stage, agent: u32) {
        let Some(at) = stage.position(agent) else { return };
        let known = self.minds[agent as usize].news;
        let mut news = self.boards.at(at, self.now) & !known;
        while news != 0 {
            let event = news.trailing_zeros() as u16;
            news &= news - 1;
            self.learn(stage, agent, Context { event, how: How::Read, ..Context::default() });
        }
    }

    /// An event is conveyed to those around an agent.
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

    pub(super) fn push(&mut self, agent: u32, trigger: u16, context: Context) {
        let begun = self.minds[agent as usize].begun;
        self.queue.push_back((agent, Stimulus { trigger, context, begun }));
    }

    pub(super) fn touch(&mut self, agent: u32) {
        if !std::mem::replace(&mut self.is_touched[agent as usize], true) {
            self.touched.push(agent);
        }
    }

    /// Handles all that follows at this time, and tells the stage what those who were touched sense.
    fn finish(&mut self, stage: &mut impl Stage) -> Result<()> {
        loop {
            while let Some((agent, stimulus)) = self.queue.pop_front() {
                if self.minds[agent as usize].is_there {
                    self.touch(agent);
                    self.handle(stage, agent, stimulus)?;
                }
            }
            if !self.check_conditions(stage)? {
                break;
            }
        }
        for i in 0..self.touched.len() {
            let agent = self.touched[i];
            self.is_touched[agent as usize] = false;
            let mind = &self.minds[agent as usize];
            if !mind.is_there {
                continue;
            }
            let next = mind.next_s();
            let (tells, hears) = self.senses(agent);
            stage.set_timer(agent, Some(next).filter(|n| n.is_finite()))?;
            stage.sense(agent, tells, hears)?;
        }
        self.touched.clear();
        let left = |g: usize| {
            let group = &self.scenario.groups[g];
            let is_there = |a: u32| self.minds[a as usize].is_there;
            self.entered[g] == group.agents[1] - group.agents[0] && !(group.agents[0]..group.agents[1]).any(is_there)
        };
        let end = self.scenario.end;
        self.ended |= end.left != 0 && (0..self.enters.len()).all(|g| end.left >> g & 1 == 0 || left(g));
        self.ended |= end.known.is_some_and(|e| {
            let mut there = self.minds.iter().filter(|m| m.is_there);
            there.all(|m| m.news >> e & 1 == 1)
        });
        Ok(())
    }

    /// What an agent tells and hears of others.
    fn senses(&self, agent: u32) -> (u32, u32) {
        let news = self.minds[agent as usize].news;
        let meets = if self.scenario.meets { MEETINGS } else { 0 };
        let (mut tells, mut hears) = (meets, meets);
        for (e, event) in self.scenario.events.iter().enumerate() {
            let Some(channel) = event.channel else { continue };
            match news >> e & 1 == 1 {
                true if self.now - self.happened[e] <= event.fresh_s => tells |= 1 << channel,
                true => {}
                false => hears |= 1 << channel,
            }
        }
        (tells, hears)
    }

    /// Raises the events whose conditions have become true; true where one has.
    fn check_conditions(&mut self, stage: &mut impl Stage) -> Result<bool> {
        let mut any = false;
        for e in 0..self.was_true.len() {
            let Some(condition) = self.scenario.events[e].condition else { continue };
            let is_true = !self.minds.is_empty() && self.is_true(stage, 0, Context::default(), condition);
            if is_true && !std::mem::replace(&mut self.was_true[e], is_true) {
                self.occur(stage, e)?;
                any = true;
            }
            self.was_true[e] = is_true;
        }
        Ok(any)
    }

    /// Something happens to an agent: a rule is followed, or a graph goes on.
    fn handle(&mut self, stage: &mut impl Stage, agent: u32, stimulus: Stimulus) -> Result<()> {
        let m = agent as usize;
        let mind = &mut self.minds[m];
        let is_of_behaviour = [trigger::DONE, trigger::FULL, trigger::STUCK].contains(&stimulus.trigger);
        if is_of_behaviour && stimulus.begun != mind.begun {
            // That behaviour has given way to another one.
            return Ok(());
        }
        if mind.handled_at != self.now {
            (mind.handled_at, mind.handled) = (self.now, 0);
        }
        mind.handled += 1;
        if mind.handled > MOST_AT_ONCE {
            return Err(self.circle(agent, stimulus.trigger));
        }
        self.note_sensed(agent, stimulus);
        if self.follow_rule(stage, agent, stimulus)? {
            return Ok(());
        }
        let upwards = stimulus.trigger == trigger::DONE;
        for i in 0..3 {
            let level = if upwards { 2 - i } else { i };
            let state = self.minds[m].states[level];
            if state == NO {
                continue;
            }
            let [first, last] = self.scenario.states[usize::from(state)].edges;
            if let Some(edge) = self.choose_edge(stage, agent, stimulus, first..last) {
                let Edge { to, number, .. } = self.scenario.edges[edge as usize];
                let graph = usize::from(self.scenario.states[usize::from(state)].of);
                let kind = TurnKind::Takes { level, graph, edge: usize::from(number), changes: to != state };
                self.note(agent, stimulus, kind);
                self.minds[m].reason = Reason { edge, ..self.reason(stimulus) };
                if to != state {
                    self.enter_state(stage, agent, u32::from(to), stimulus.context)?;
                }
                return Ok(());
            }
        }
        Ok(())
    }

    /// Follows the first rule that fits; true where its behaviour lasts.
    fn follow_rule(&mut self, stage: &mut impl Stage, agent: u32, stimulus: Stimulus) -> Result<bool> {
        let m = agent as usize;
        let scenario = self.scenario.clone();
        let [first, last] = scenario.rules_of[usize::from(stimulus.trigger)];
        for &number in &scenario.rule_order[first as usize..last as usize] {
            let rule = &scenario.rules[number as usize];
            if rule.who >> self.minds[m].group & 1 == 0 {
                continue;
            }
            let pause = m * scenario.num_pauses + rule.pause as usize;
            let mind = &self.minds[m];
            let is_held = !rule.is_instant && mind.is_busy && mind.priority > rule.priority;
            if is_held || rule.pause_s > 0.0 && self.now - self.followed[pause] < f64::from(rule.pause_s) {
                continue;
            }
            let context = stimulus.context;
            if !rule.when.is_none_or(|when| self.is_true(stage, agent, context, when)) {
                continue;
            }
            if rule.probability < 1.0 && self.chance(agent) >= f64::from(rule.probability) {
                continue;
            }
            if rule.pause_s > 0.0 {
                self.followed[pause] = self.now;
            }
            self.minds[m].reason = Reason { rule: number, ..self.reason(stimulus) };
            self.note(agent, stimulus, TurnKind::Follows(number as usize));
            if rule.is_instant {
                self.do_at_once(stage, agent, rule.actions, context)?;
                return Ok(false);
            }
            let mind = &mut self.minds[m];
            if !mind.is_busy {
                (mind.resumed, mind.resumed_context) = (mind.action, mind.context);
            }
            (mind.is_busy, mind.priority) = (true, rule.priority);
            self.start(stage, agent, rule.actions, context)?;
            return Ok(true);
        }
        Ok(false)
    }

    /// Chooses among the edges that an event opens, by their probabilities.
    fn choose_edge(
        &mut self,
        stage: &impl Stage,
        agent: u32,
        stimulus: Stimulus,
        all: std::ops::Range<u32>,
    ) -> Option<u32> {
        let scenario = self.scenario.clone();
        let (mut open, mut shared, mut sum) = (0u64, 0, 0.0_f32);
        let edges: &[Edge] = &scenario.edges[all.start as usize..all.end as usize];
        for (i, edge) in edges.iter().enumerate().take(64) {
            if edge.trigger == stimulus.trigger
                && edge.when.is_none_or(|when| self.is_true(stage, agent, stimulus.context, when))
            {
                open |= 1 << i;
                if edge.probability < 0.0 { shared += 1 } else { sum += edge.probability }
            }
        }
        if open == 0 {
            return None;
        }
        let share = if shared > 0 { (1.0 - sum).max(0.0) / shared as f32 } else { 0.0 };
        let scale = sum.max(1.0).recip();
        let is_single = open.count_ones() == 1 && (shared == 1 || sum >= 1.0);
        let mut left = if is_single { 0.0 } else { self.chance(agent) as f32 };
        for (i, edge) in edges.iter().enumerate().take(64).filter(|(i, _)| open >> i & 1 == 1) {
            left -= if edge.probability < 0.0 { share } else { edge.probability * scale };
            if left < 0.0 || is_single {
                return Some(all.start + i as u32);
            }
        }
        None
    }

    /// A state begins, and all below it anew.
    fn enter_state(&mut self, stage: &mut impl Stage, agent: u32, state: u32, context: Context) -> Result<()> {
        let m = agent as usize;
        let scenario = self.scenario.clone();
        let mut next = state;
        self.minds[m].resumed = NONE;
        (self.minds[m].is_busy, self.minds[m].priority) = (false, i8::MIN);
        loop {
            let table = &scenario.states[next as usize];
            let level = usize::from(table.level);
            let mind = &mut self.minds[m];
            if mind.states[..level].iter().all(|s| *s == NO) {
                mind.state_since = self.now;
            }
            mind.states[level] = next as u16;
            mind.states[level + 1..].fill(NO);
            if table.graph == NONE {
                return self.start(stage, agent, table.actions, context);
            }
            if table.actions != NONE {
                self.do_at_once(stage, agent, table.actions, context)?;
            }
            next = table.graph;
        }
    }

    /// All that an agent does by itself by now.
    fn act_in_time(&mut self, stage: &mut impl Stage, agent: u32) -> Result<()> {
        let m = agent as usize;
        while self.minds[m].crossing_at <= self.now {
            let t = self.minds[m].crossing;
            let threshold = self.scenario.thresholds[usize::from(t)];
            let v = m * self.scenario.values.len() + usize::from(threshold.value);
            // Exactly the threshold: rounding would put it on either side.
            self.feelings[v] = Feeling { value: threshold.at, since: self.now, ..self.feelings[v] };
            self.minds[m].passed |= 1 << t;
            self.push(agent, trigger::EVENTS + self.scenario.events.len() as u16 + t, Context::default());
            self.find_crossing(agent);
        }
        if self.minds[m].timer <= self.now {
            self.minds[m].timer = f64::INFINITY;
            self.push(agent, trigger::TIMER, Context::default());
        }
        if self.minds[m].until <= self.now || self.minds[m].most <= self.now {
            self.next_action(stage, agent)
        } else if self.minds[m].again <= self.now {
            self.perform(stage, agent, true)
        } else {
            Ok(())
        }
    }

    /// A value becomes another one now, or changes at another rate.
    pub(super) fn change_value(&mut self, agent: u32, value: u16, change: impl FnOnce(&mut Feeling)) {
        let (m, scenario) = (agent as usize, self.scenario.clone());
        let table = &scenario.values[usize::from(value)];
        let feeling = &mut self.feelings[m * scenario.values.len() + usize::from(value)];
        *feeling = Feeling { value: feeling.at(table, self.now), since: self.now, ..*feeling };
        change(feeling);
        feeling.value = feeling.value.clamp(table.limits[0], table.limits[1]);
        let now = feeling.value;
        for t in table.thresholds[0]..table.thresholds[1] {
            let bit = 1u32 << t;
            let (was, is) = (self.minds[m].passed & bit != 0, scenario.thresholds[usize::from(t)].is_passed(now));
            if is {
                self.minds[m].passed |= bit;
            } else {
                self.minds[m].passed &= !bit;
            }
            if is && !was {
                self.push(agent, trigger::EVENTS + scenario.events.len() as u16 + t, Context::default());
            }
        }
        self.find_crossing(agent);
        self.touch(agent);
    }

    /// Finds the next threshold that an agent's values pass by themselves.
    fn find_crossing(&mut self, agent: u32) {
        let m = agent as usize;
        let scenario = &self.scenario;
        let (mut next, mut when) = (NO, f64::INFINITY);
        for (t, threshold) in scenario.thresholds.iter().enumerate() {
            let v = usize::from(threshold.value);
            let (feeling, table) = (&self.feelings[m * scenario.values.len() + v], &scenario.values[v]);
            if self.minds[m].passed >> t & 1 == 1 {
                // On its way back it is armed again, though it cannot pass before the value is changed.
                continue;
            }
            if let Some(at) = feeling.reaches(table, threshold).filter(|at| *at < when) {
                (next, when) = (t as u16, at.max(self.now));
            }
        }
        (self.minds[m].crossing, self.minds[m].crossing_at) = (next, when);
    }

    pub(super) fn set_open(&mut self, stage: &mut impl Stage, door: usize, open: bool) -> Result<()> {
        if stage.set_open(door as u16, open)? {
            (self.is_open[door], self.closing[door]) = (open, f64::INFINITY);
        } else {
            self.closing[door] = self.now + RETRY_S;
        }
        Ok(())
    }

    /// When an event happens next, after a time (s).
    fn next_time(&self, e: usize, now: f64) -> f64 {
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

    /// When the next of a group enters, after a time, by thinning (Lewis and Shedler 1979) (s).
    fn next_entry(&self, g: usize, now: f64) -> f64 {
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
            // Nobody comes after the last rate where it is 0.
            if next == group.rates.len() && rate == 0.0 || draw > 100_000 {
                return f64::INFINITY;
            }
        }
    }

    /// True for a scene in which something happens that agents may know of.
    pub fn has_events(&self) -> bool {
        !self.scenario.events.is_empty()
    }

    /// Number of agents, of whom some may enter later or have left.
    pub fn len(&self) -> usize {
        self.minds.len()
    }

    /// True where there is nobody.
    pub fn is_empty(&self) -> bool {
        self.minds.is_empty()
    }

    /// Agents that know of any event.
    pub fn num_informed(&self) -> usize {
        self.minds.iter().filter(|m| m.news != 0).count()
    }

    /// True once the end of the scene has come.
    pub fn has_ended(&self) -> bool {
        self.ended
    }

    /// Number of events that an agent knows of (agent < number of agents).
    pub fn num_known(&self, agent: usize) -> u32 {
        self.minds[agent].news.count_ones()
    }

    /// A number by chance, from 0 up to 1: the next one of an agent.
    pub(super) fn chance(&mut self, agent: u32) -> f64 {
        let draws = &mut self.minds[agent as usize].draws;
        *draws += 1;
        hashed(self.seed, agent, *draws)
    }

    pub(super) fn is_true(&mut self, stage: &impl Stage, agent: u32, context: Context, program: Program) -> bool {
        self.evaluations += 1;
        let mut draws = self.minds[agent as usize].draws;
        let mut view = View { minds: self, stage, agent, context, draws: &mut draws };
        let value = run(&self.scenario.code, program, &mut view);
        self.minds[agent as usize].draws = draws;
        value != 0.0
    }

    /// A reason that names neither rule nor edge yet.
    fn reason(&self, Stimulus { trigger, context, .. }: Stimulus) -> Reason {
        let Context { other, place, .. } = context;
        Reason { time_s: self.now, trigger, rule: NONE, edge: NONE, other, place }
    }

    fn circle(&self, agent: u32, trigger: u16) -> Error {
        let mind = &self.minds[agent as usize];
        let rule = match mind.reason {
            Reason { rule, .. } if rule != NONE => format!("rule \"{}\"", self.scenario.rules[rule as usize].name),
            Reason { edge, .. } if edge != NONE => {
                let to = self.scenario.edges[edge as usize].to;
                format!("an edge to `{}`", self.scenario.states[usize::from(to)].name)
            }
            _ => "no rule".into(),
        };
        let event = self.scenario.trigger_name(trigger);
        let why = format!(
            "agent {agent} handles more than {MOST_AT_ONCE} events at {:.3} s, the last one `{event}`, before that {rule}: \
             rules or states follow each other in a circle; let one of them take time, such as `stay`",
            self.now
        );
        self.scenario.source.at(if mind.reason.rule == NONE { "graphs" } else { "rules" }, why)
    }

    pub(super) fn action(&self, number: u32) -> Action {
        self.scenario.actions[number as usize]
    }
}

pub(super) fn at_place(place: u16) -> Context {
    Context { place, ..Context::default() }
}
