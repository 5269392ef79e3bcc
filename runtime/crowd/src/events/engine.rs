//! The engine: the state of all agents, and the loop that takes events in the order of time.

use crate::error::{CrowdError, Result};
use crate::events::decide::{AgentState, Cause, Decider, Decision, DecisionScratch};
use crate::events::event::{CrowdEvent, CrowdEventKind, EventCounts};
use crate::events::schemes::{REGISTRATION, SchemeRef};
use crate::routes::passages::{PassageTurns, TURN_S};
use crate::{CrowdSetup, Id, NONE, Scheme, Sense, Space, steering::relationships::RelationshipTable};
use crate::{events::occupancy::Occupancy, events::prefetch::Prefetcher, steering::density_grid::DensityGrid};
use crate::{events::queue::Calendar, scenery::CrowdScenery, senses::Sensors, space::cells::CellGrid};
use crate::{events::watchdog::Watchdog, routes::path::RoutePath, space::plan::MotionPlan};
use serde::{Deserialize, Serialize};
use throng_base::ground::ExternalObstacles;

/// Most agents of a crowd that is taken to fit the processor's caches; in tests, none does. With 8000 it costs 4 to 8 %
/// to prefetch, with 16 000 it saves 4 to 11 %, with 100 000 a quarter to a third.
const FEW: usize = if cfg!(test) { 0 } else { 12_000 };

/// Number of events after which the engine returns, so that they can be reported before there are more.
const FULL: usize = 1024;

/// An agent as it is seen from afar.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct SeenAgent<V> {
    position: V,
    velocity: V,
    /// Unit vector along which it wants to go, or zero.
    intent: V,
    /// (m)
    aim: V,
}

/// A crowd in two or three dimensions. See [`crate::Crowd`].
#[derive(Clone, Debug)]
pub(crate) struct Engine<V: Space> {
    pub scenery: CrowdScenery<V>,
    pub cells: CellGrid<V>,
    pub states: Vec<AgentState<V>>,
    /// Route that belongs to the place of an agent alone; [`NONE`] where there is none (capacity).
    pub own_routes: Vec<u32>,
    /// Spare routes, so that spawning takes no memory.
    pub spare: Vec<RoutePath<V>>,
    /// Places for which memory is taken at once.
    pub room: usize,
    pub queue: Calendar,
    pub prefetcher: Prefetcher,
    /// Places that are free, the next one last.
    pub free: Vec<u32>,
    pub grid: DensityGrid<V>,
    pub turns: PassageTurns,
    /// External obstacles.
    pub external_obstacles: ExternalObstacles,
    /// Number of times that the grid was filled so far.
    pub refreshes: u64,
    pub now: f64,
    pub counts: EventCounts,
    /// Events since the last call of [`Engine::run`].
    pub events: Vec<CrowdEvent>,
    /// Lists of [`crate::Scheme::Occupancy`], if that runs.
    pub occupancy: Option<Occupancy>,
    /// Steps of `Scheme::Fixed` and `Scheme::Pairs`, if one of them runs.
    #[cfg(feature = "fixed-steps")]
    pub fixed: Option<crate::events::fixed::Fixed<V>>,
    pub scratch: DecisionScratch<V>,
    pub sensors: Sensors<V>,
    pub relationships: RelationshipTable<V>,
    pub watchdog: Watchdog,
    /// Hash of all that a snapshot is meaningless without.
    pub setup_hash: u128,
    pub windows: crate::events::parallel::EventWindows<V>,
}

impl<V: Space> Engine<V> {
    /// Places all agents at their starts, and takes all memory that [`Engine::run`] needs.
    ///
    /// # Errors
    /// [`CrowdError`] for a setting out of its range, or an impossible start or subgoal.
    pub fn new(setup: CrowdSetup<V>) -> Result<Self> {
        let (scenery, cells, grid) = CrowdScenery::new(&setup)?;
        let capacity = setup.config.capacity.max(setup.agents.len());
        // An event comes with a few others; a fixed step with some of every agent.
        let most_events = FULL + 4 * capacity.max(64);
        let mut engine = Self {
            watchdog: Watchdog::new(capacity, scenery.interval, setup.config.scheme.most_events()),
            scratch: DecisionScratch::new(capacity, scenery.movers.len()),
            turns: PassageTurns::new(&scenery.passages, TURN_S),
            sensors: Sensors::new(&setup.senses, capacity),
            relationships: RelationshipTable::new(capacity),
            occupancy: (setup.config.scheme == Scheme::Occupancy).then(|| Occupancy::new(cells.num_cells, capacity)),
            #[cfg(feature = "fixed-steps")]
            fixed: crate::events::fixed::Fixed::new(&setup.config, capacity),
            setup_hash: Self::hash_setup(&setup, &scenery, &cells),
            scenery,
            cells,
            states: vec![AgentState { cell: NONE, ..AgentState::default() }; capacity],
            own_routes: vec![NONE; capacity],
            spare: Vec::new(),
            room: setup.config.capacity,
            // Events of agents, what they sense, and their timers.
            queue: Calendar::new(3 * capacity),
            prefetcher: Prefetcher::default(),
            free: (0..capacity as u32).rev().collect(),
            grid,
            external_obstacles: ExternalObstacles::default(),
            refreshes: 0,
            now: 0.0,
            windows: crate::events::parallel::EventWindows::default(),
            counts: EventCounts::default(),
            events: Vec::with_capacity(most_events),
        };
        for agent in &setup.agents {
            engine.spawn(*agent)?;
        }
        engine.fill_spare();
        Ok(engine)
    }

    /// Advances time to `until_s`, or until there are many events to report; true where it reached the end.
    ///
    /// # Errors
    /// [`CrowdError::Other`] for a time in the past, [`CrowdError::Stalled`].
    pub fn run(&mut self, until_s: f64) -> Result<bool> {
        self.check_time(until_s)?;
        self.events.clear();
        let result = self.run_scheme(until_s);
        // A signal has to be answered before time goes on.
        let is_done = result? && self.sensors.signals.is_empty();
        if is_done {
            self.now = until_s;
        }
        Ok(is_done)
    }

    fn run_scheme(&mut self, until_s: f64) -> Result<bool> {
        // Taken out, so that they can be changed together with the rest.
        if let Some(mut occupancy) = self.occupancy.take() {
            let result = self.run_occupancy(&mut occupancy, until_s);
            self.occupancy = Some(occupancy);
            return result;
        }
        #[cfg(feature = "fixed-steps")]
        if let Some(mut fixed) = self.fixed.take() {
            let result = self.run_steps(&mut fixed, until_s);
            self.fixed = Some(fixed);
            return result;
        }
        self.run_events(until_s, |engine, agent| {
            if engine.states.len() - engine.free.len() > FEW {
                engine.prefetch();
            }
            engine.process_event(agent).map(|_| ())
        })
    }

    /// True where agents act by [`Scheme::Registration`].
    pub fn is_of_registration(&self) -> bool {
        #[cfg(feature = "fixed-steps")]
        if self.fixed.is_some() {
            return false;
        }
        self.occupancy.is_none()
    }

    /// Runs the events of agents by `process`, in order, until a time or as long as there is room for more.
    #[inline]
    pub fn run_events(&mut self, until_s: f64, mut process: impl FnMut(&mut Self, u32) -> Result<()>) -> Result<bool> {
        while let Some((time, agent)) = self.queue.first(until_s) {
            if self.is_full() {
                return Ok(false);
            }
            self.refresh_grid_until(time);
            self.now = time;
            if agent as usize >= self.states.len() {
                self.process_sense(agent);
            } else {
                process(self, agent)?;
            }
        }
        Ok(true)
    }

    /// True where events have to be reported before there are more, or a signal has to be answered.
    pub fn is_full(&self) -> bool {
        self.events.len() >= FULL || !self.sensors.signals.is_empty()
    }

    pub fn check_time(&self, until_s: f64) -> Result<()> {
        let is_good = (self.now..=1e9).contains(&until_s);
        let expected = "at most 1e9, and not before the present: time does not go back, load a snapshot instead";
        Ok(throng_base::error::check_value("time", None, until_s, is_good, expected)?)
    }

    pub fn check_id(&self, id: Id) -> Result<()> {
        let is_here = self.states.get(id.index()).is_some_and(|s| s.cell != NONE && s.generation == id.generation);
        if is_here { Ok(()) } else { Err(throng_base::Error::Gone(id).into()) }
    }

    pub fn id(&self, index: u32) -> Id {
        Id { index, generation: self.states[index as usize].generation }
    }

    /// Removes an agent from cells and queue; its place is not free yet.
    pub fn take_out(&mut self, index: u32) {
        let state = &mut self.states[index as usize];
        self.cells.remove(state.cell, index);
        self.queue.remove(index);
        state.cell = NONE;
        state.generation = state.generation.wrapping_add(1);
        self.forget_senses(index);
        self.relationships.forget(index);
    }

    /// Time at which the grid is filled next, which does not depend on calls.
    pub fn next_refresh(&self) -> f64 {
        self.refreshes as f64 * self.scenery.steering.refresh_s
    }

    /// Fills the density grid, if it is time to.
    pub fn refresh_grid_until(&mut self, time: f64) {
        let Some(now) = self.begin_refresh(time) else { return };
        for index in 0..self.states.len() as u32 {
            if let Some(agent) = self.seen_agent(index, now) {
                self.add_seen(&agent);
            }
        }
        self.turns.update(&self.scenery.passages, now);
    }

    /// Adds an agent to what is seen from afar.
    pub fn add_seen(&mut self, agent: &SeenAgent<V>) {
        let SeenAgent { position, velocity, intent, aim } = *agent;
        self.grid.add(position, velocity, intent);
        let found = self.scenery.passages.find_use(position.on_ground(), aim.on_ground(), 0.0);
        found.iter().for_each(|found| self.turns.count(found));
    }

    /// Empties the density grid, if it is time to fill it; the time that it is to show.
    pub fn begin_refresh(&mut self, time: f64) -> Option<f64> {
        if self.next_refresh() > time {
            return None;
        }
        // No agent acts between refreshes that are due together: the last one shows the same as all of them.
        self.refreshes = (time / self.scenery.steering.refresh_s) as u64;
        let now = self.next_refresh();
        self.refreshes += 1;
        self.grid.clear();
        Some(now)
    }

    /// An agent as it is seen from afar at a time; `None` for a free place.
    #[inline]
    pub fn seen_agent(&self, index: u32, now: f64) -> Option<SeenAgent<V>> {
        let state = &self.states[index as usize];
        if state.cell == NONE {
            return None;
        }
        let plan = self.cells.plan(index);
        let (position, velocity) = plan.motion_at(now.max(plan.start));
        let aim = if state.is_there || state.speed == 0.0 { position } else { state.cursor.aim };
        Some(SeenAgent { position, velocity, intent: state.intent, aim })
    }

    /// Processes the next event of an agent, and of the agent whose bound it touches; returns that one, if it acted
    /// too.
    pub fn process_event(&mut self, agent: u32) -> Result<Option<u32>> {
        let cause = self.cause(agent);
        let partner = self.partner(cause);
        self.note_for_watchdog(agent, partner)?;
        self.report_event(agent, self.kind(cause));
        let renewed = partner.filter(|&p| self.is_renewed_with(p, agent, self.now));
        self.decide(agent, REGISTRATION);
        let renewed = renewed.filter(|&p| self.states[p as usize].cell != NONE);
        if let Some(renewed) = renewed {
            self.decide(renewed, REGISTRATION);
        }
        Ok(renewed)
    }

    /// True if the partner of a colliding event acts too: it has not acted since the agent did, so that its present
    /// bound is the touched one, nor within the smallest interval.
    pub fn is_renewed_with(&self, partner: u32, agent: u32, time: f64) -> bool {
        if self.states[partner as usize].cell == NONE {
            return false;
        }
        let start = self.cells.plan(partner).start;
        start <= self.cells.plan(agent).start && time - start >= f64::from(self.scenery.interval)
    }

    /// Lets an agent take a new plan; false where it has to keep the present one.
    pub fn decide(&mut self, agent: u32, scheme: SchemeRef<'_>) -> bool {
        let Self { scenery, cells, states, grid, turns, external_obstacles, relationships, scratch, .. } = self;
        let decider =
            Decider { scenery, cells, states, grid, turns, external_obstacles, relationships, time: self.now };
        let Some(decision) = decider.decide(agent, scheme, scratch) else {
            self.resume_plan(agent);
            return false;
        };
        self.queue.set(agent, decision.plan.end);
        if self.apply(agent, &decision) {
            self.free.push(agent);
        }
        true
    }

    /// Cause of an agent's due event.
    pub fn cause(&self, agent: u32) -> Cause {
        let state = &self.states[agent as usize];
        if state.is_woken { Cause::Region } else { state.cause }
    }

    /// Time at which an agent that was woken at a time acts: as soon as possible. `None` where its plan ends about
    /// then.
    pub fn woken_at(&self, plan: &MotionPlan<V>, now: f64) -> Option<f64> {
        let interval = f64::from(self.scenery.interval);
        let soonest = now.max(plan.start + interval);
        // It may have to keep its plan, and acts at its end then.
        (soonest + interval < plan.end).then_some(soonest)
    }

    /// Time at which an agent with a plan acts next, unless another one makes it act before.
    pub fn due_time(&self, plan: &MotionPlan<V>) -> f64 {
        let is_woken = self.states[plan.index as usize].is_woken;
        is_woken.then(|| self.woken_at(plan, self.now)).flatten().unwrap_or(plan.end)
    }

    /// True for an event of an agent that is still to come: it has not acted since the event was queued.
    pub fn is_due(&self, agent: u32, time: f64) -> bool {
        let state = &self.states[agent as usize];
        state.cell != NONE && (state.is_woken || self.cells.plan(agent).end == time)
    }

    /// Lets an agent keep its plan to its end: others rely on it, and no other safe plan was found.
    pub fn resume_plan(&mut self, agent: u32) {
        let state = &mut self.states[agent as usize];
        if std::mem::take(&mut state.is_woken) {
            state.goes_on = true;
            self.queue.set(agent, self.cells.plan(agent).end);
        }
    }

    /// Applies a decision; returns true if the agent left.
    pub fn apply(&mut self, agent: u32, decision: &Decision<V>) -> bool {
        self.counts.decisions += 1;
        let before = self.states[agent as usize];
        let state = decision.state;
        self.cells.set(before.cell, state.cell, &decision.plan);
        self.states[agent as usize] = state;
        if state.is_there && !before.is_there {
            self.report_event(agent, CrowdEventKind::Arrived);
        }
        if state.is_stuck && !before.is_stuck {
            self.report_event(agent, CrowdEventKind::Stuck);
        }
        if state.is_struck && !before.is_struck {
            self.report_event(agent, CrowdEventKind::Struck { obstacle: decision.struck_by as usize });
        }
        if decision.leaves {
            self.report_event(agent, CrowdEventKind::Left);
            self.take_out(agent);
        } else if self.sensors.states[agent as usize].sense != Sense::default() {
            self.sense_neighbours(agent);
        }
        decision.leaves
    }

    /// The agent behind a cause, if it is still there.
    pub fn partner(&self, cause: Cause) -> Option<u32> {
        match cause {
            Cause::Agent(other) => Some(other).filter(|&o| self.states[o as usize].cell != NONE),
            _ => None,
        }
    }

    pub fn kind(&self, cause: Cause) -> CrowdEventKind {
        match cause {
            Cause::Region => CrowdEventKind::Resetting,
            Cause::Agent(other) => CrowdEventKind::Colliding { other: self.id(other) },
            Cause::Obstacle(obstacle) => CrowdEventKind::Meeting { obstacle: obstacle as usize },
        }
    }

    /// Counts and notes an event of an agent at this time.
    pub fn report_event(&mut self, agent: u32, kind: CrowdEventKind) {
        self.counts.add(kind);
        let event = CrowdEvent { time: self.now, agent: self.id(agent), kind };
        self.events.push(event);
        if self.sensors.stops && kind.is_signal(self.sensors.states[agent as usize].sense.arrivals) {
            self.sensors.signals.push_back(event);
        }
    }

    /// Shows an event of an agent to the watchdog.
    #[inline]
    pub fn note_for_watchdog(&mut self, agent: u32, partner: Option<u32>) -> Result<()> {
        let noted = self.watchdog.note_event(agent, partner.unwrap_or(NONE), self.now);
        noted.map_err(|storm| CrowdError::Stalled {
            first: self.id(agent),
            second: Some(storm.partner).filter(|&p| p != NONE).map(|p| self.id(p)),
            events: storm.events.into(),
            most: storm.most.into(),
            seconds: storm.seconds,
        })
    }
}
