//! Agents of a scene, with and without bodies: they avoid each other, learn of happenings, and tell others.

mod followers;
mod layout;
mod message;
mod places;
mod route_map;
mod snapshot;
mod stage;
mod things;
pub(crate) mod troop;

pub use layout::CrowdLayout;
pub use things::HandlingCounts;

use crate::motion_kind::{GroupStep, MotionKind, single_pose};
use crate::scenario::{AgentBrains, BrainChange, ScenarioStage};
use crate::scene::{GroupConfig, GroupMotion};
use crate::{CharacterEvent, Order, SimulationEvent, compile::CompiledScene};
use followers::Followers;
use glam::{Quat, Vec2, Vec3};
use stage::CrowdStage;
use std::{sync::Arc, time::Instant};
use throng_base::{Error, Executor, Result, error::ensure, ground::ReservedRegion, maths};
use throng_core::{Contacts, Mat3x4, NUM_JOINTS, Planar, walkers::Walkers};
use throng_crowd::{Crowd, CrowdError, CrowdEvent, CrowdEventKind, Id, Space};

/// All agents of a scene: their crowd, paths, brains, and the bodies that follow them.
#[derive(Clone, Debug)]
pub struct SceneAgents<V> {
    pub(super) stage: CrowdStage<V>,
    /// Brains of the agents, where the scene has rules, events or graphs beside goals.
    brains: Option<AgentBrains>,
    /// Bodies of the groups that have any, in the order of groups.
    followers: Vec<Followers>,
    /// All events of the last step, where they are recorded.
    recorded: Option<Vec<CrowdEvent>>,
    /// Computing times so far, where they are measured.
    timings: Option<AgentTimings>,
}

/// Distance of the point to which an agent turns for a heading (m).
const FACES_M: f32 = 100.0;

/// Number of agents from which on a crowd runs faster on several threads.
const PARALLEL_FROM: usize = 2000;

impl<V: Space> SceneAgents<V> {
    /// Creates all agents at their starts.
    ///
    /// # Errors
    /// As [`CrowdLayout::new`], and for impossible starts, with the names of their groups; as [`crate::scenario::Scenario::new`].
    pub fn new(compiled: &CompiledScene) -> Result<Self> {
        let scene = &compiled.scene;
        let mut layout = CrowdLayout::new(scene)?;
        layout.check_sources()?;
        if let Some(scenario) = compiled.scenario() {
            layout.set_senses(scenario);
            layout.check_goals(scenario)?;
        }
        let mut outside = CrowdStage::new(layout)?;
        for (d, door) in scene.environment.doors.iter().enumerate() {
            if !door.open && !outside.set_door_open(d as u16, false)? {
                let why = "somebody starts in it: move the group, or let it be `open` at the start";
                return Err(scene.fault(&format!("environment.doors[{d}]"), why));
            }
        }
        let mut m = 0;
        while m < outside.layout.num_agents() {
            outside.join_companions(m as u32)?;
            m = outside.layout.companions_of(m).end;
        }
        let mut agents = Self { stage: outside, brains: None, followers: Vec::new(), recorded: None, timings: None };
        let has_bodies = |group: &GroupConfig| group.is_of_agents() && group.motion == GroupMotion::Blend;
        for (g, _) in scene.groups.iter().enumerate().filter(|(_, group)| has_bodies(group)) {
            let bodies = Followers::new(compiled, g, &agents)?;
            agents.stage.things.register_bodies(&bodies);
            agents.followers.push(bodies);
        }
        if let Some(scenario) = compiled.scenario() {
            let doors: Vec<bool> = scene.environment.doors.iter().map(|d| d.open).collect();
            let mut brains = AgentBrains::new(Arc::clone(scenario), scene.seed, &doors);
            let speeds: Vec<f32> = agents.stage.layout.setup.agents.iter().map(|a| a.speed).collect();
            brains.begin_scene(&mut agents.stage, &speeds)?;
            agents.brains = Some(brains);
        }
        Ok(agents)
    }

    /// Starts to record all events of the engine, for [`SceneAgents::engine_events`], and all turns of agent brains, for
    /// [`AgentBrains::turns`].
    pub fn record_events(&mut self) {
        self.recorded.get_or_insert_default();
        self.brains.iter_mut().for_each(AgentBrains::record_turns);
    }

    /// All events of the engine in the last step, in their order; empty unless they are recorded.
    pub fn engine_events(&self) -> &[CrowdEvent] {
        self.recorded.as_deref().unwrap_or_default()
    }

    /// Advances the crowd and brains to a time, without bodies. The result depends neither on `run` nor on the number of calls
    /// until then; all events are reported to `on_event` in order.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] where the engine does not get on, a goal cannot be reached, or rules run in a circle.
    pub fn advance(&mut self, until_s: f64, run: &dyn Executor, on_event: &mut impl FnMut(&CrowdEvent)) -> Result<()> {
        let begin = self.timings.is_some().then(Instant::now);
        let done = self.advance_with_brains(until_s, run, on_event);
        if let (Some(spent), Some(begin)) = (&mut self.timings, begin) {
            spent.all_s += begin.elapsed().as_secs_f64();
        }
        done
    }

    /// Advances a crowd and the brains of its agents to a time.
    fn advance_with_brains(
        &mut self,
        until_s: f64,
        run: &dyn Executor,
        on_event: &mut impl FnMut(&CrowdEvent),
    ) -> Result<()> {
        let Self { stage: outside, brains, timings, .. } = self;
        let Some(brains) = brains else {
            let done = advance_crowd(&mut outside.crowd, until_s, run, on_event);
            return done.map_err(|e| outside.layout.explain_crowd_error(&e));
        };
        loop {
            let next = brains.next_external_s();
            let stop = until_s.min(next);
            let signal = outside.crowd.advance_to_signal(stop, on_event);
            let begin = timings.is_some().then(Instant::now);
            if let Some(event) = signal.map_err(|e| outside.layout.explain_crowd_error(&e))? {
                if let Some(signal) = outside.brain_signal(&event) {
                    brains.handle_signal(outside, event.time, signal)?;
                }
            } else if stop == next {
                brains.run_external_events(outside, stop)?;
            } else {
                return Ok(());
            }
            if let (Some(spent), Some(begin)) = (timings.as_mut(), begin) {
                // Finding paths counts for the crowd.
                let paths_s = outside.paths_s.replace(0.0).unwrap_or(0.0);
                spent.brains_s += begin.elapsed().as_secs_f64() - paths_s;
            }
        }
    }

    /// Starts to measure the computing times of crowd, brains and bodies.
    pub fn set_timed(&mut self) {
        self.timings = Some(AgentTimings::default());
        self.stage.paths_s = Some(0.0);
    }

    /// Computing times of crowd, brains and bodies since [`SceneAgents::set_timed`].
    pub fn timings(&self) -> Option<AgentTimings> {
        self.timings
    }

    /// Changes the brain of an agent, or of all.
    ///
    /// # Errors
    /// [`Error::Unknown`] for a name that there is not, [`Error::Gone`] for an agent that is not there, and as
    /// [`SceneAgents::advance`].
    pub(crate) fn change_brain(&mut self, agent: usize, change: BrainChange<'_>) -> Result<()> {
        let (now, is_there) = (self.stage.crowd.time_s(), self.disc(agent).is_some());
        ensure(is_there || matches!(change, BrainChange::Event(_)), || Error::Gone(Id::first(agent)))?;
        let Some(brains) = &mut self.brains else {
            let (what, name) = match change {
                BrainChange::Event(name) | BrainChange::Learn(name) => ("event", name),
                BrainChange::Value(name, _) => ("value", name),
                BrainChange::Suspend(_) => return Ok(()),
            };
            return Err(Error::Unknown { what, name: name.into(), known: Vec::new() });
        };
        brains.clear_turns();
        brains.change(&mut self.stage, now, agent as u32, change)
    }

    /// Brains of the agents; `None` in a scene that has only goals.
    pub fn brains(&self) -> Option<&AgentBrains> {
        self.brains.as_ref()
    }

    /// The engine.
    pub fn crowd(&self) -> &Crowd {
        &self.stage.crowd
    }

    /// Layout of the agents.
    pub fn layout(&self) -> &CrowdLayout<V> {
        &self.stage.layout
    }

    /// Number of agents that started.
    pub fn num_agents(&self) -> usize {
        self.stage.layout.num_agents()
    }

    /// Id of an agent in the engine; `None` before it has entered (agent < num_agents).
    pub fn id(&self, agent: usize) -> Option<Id> {
        self.stage.ids[agent]
    }

    /// Number of an agent by its id in the engine; `None` once another agent has that id.
    pub fn agent_of(&self, id: Id) -> Option<usize> {
        let agent = *self.stage.agent_of.get(id.index())? as usize;
        (self.id(agent) == Some(id)).then_some(agent)
    }

    /// Position of an agent at a time that the engine covers; `None` where it has left (m, agent < num_agents).
    pub fn position(&self, agent: usize, time_s: f64) -> Option<V> {
        self.crowd().position(self.id(agent)?, time_s).map(V::from_world)
    }

    /// Velocity of an agent (m/s, agent < num_agents).
    pub fn velocity(&self, agent: usize, time_s: f64) -> Option<V> {
        self.crowd().velocity(self.id(agent)?, time_s).map(V::from_world)
    }

    /// Velocity of an agent, smoothed by a Kalman filter (m/s, agent < num_agents).
    pub fn smooth_velocity(&self, agent: usize) -> Option<V> {
        self.crowd().smooth_velocity(self.id(agent)?).map(V::from_world)
    }

    /// Number of events of which an agent knows, itself or from others (agent < num_agents).
    pub fn num_known_events(&self, agent: usize) -> u32 {
        self.brains.as_ref().map_or(0, |m| m.num_known(agent))
    }

    /// True for a door that is open (door < number of doors).
    pub fn is_open(&self, door: usize) -> bool {
        self.crowd().is_open(self.layout().first_door + door)
    }

    /// Number of orders that an agent was given (agent < num_agents).
    pub fn num_orders(&self, agent: usize) -> u32 {
        self.stage.sent[agent]
    }

    /// True once the scene's end has come.
    pub fn has_ended(&self) -> bool {
        self.brains.as_ref().is_some_and(AgentBrains::has_ended)
    }

    /// An agent as it is now; `None` where it has left (agent < num_agents).
    pub fn disc(&self, agent: usize) -> Option<Disc> {
        let now = self.crowd().time_s();
        let (at, velocity) = (self.position(agent, now)?, self.velocity(agent, now)?);
        let ahead = self.smooth_velocity(agent).map_or(Vec2::ZERO, V::on_ground);
        let (centre, radius) = (at.to_world(), self.layout().setup.agents[agent].radius);
        let root = Planar { x: centre.x, z: centre.z, heading: maths::atan2(ahead.x, ahead.y) };
        Some(Disc { root, centre, velocity: velocity.to_world(), radius, knows: self.num_known_events(agent) > 0 })
    }

    /// Moves things along with the hands that hold them.
    fn move_things(&mut self, dt_s: f32) {
        if !self.stage.things.all.is_empty() {
            let mut things = std::mem::take(&mut self.stage.things);
            things.update_things(&self.followers, |agent| self.disc(agent as usize).map(|d| d.root), dt_s);
            self.stage.things = things;
        }
    }

    /// Things of the scene, in its order: where they are (m), how they are turned, and the agent that has them in hand.
    pub fn things(&self) -> impl ExactSizeIterator<Item = (Vec3, Quat, Option<usize>)> + '_ {
        let all = self.stage.things.all.iter();
        all.map(|t| (t.at, Quat::from_array(t.turn), t.keeper.map(|agent| agent as usize)))
    }

    /// Counts of what hands have done so far.
    pub fn handling_counts(&self) -> HandlingCounts {
        self.stage.things.counts
    }

    /// Bodies of an agent's group.
    fn walkers_of(&self, agent: usize) -> Option<(&Walkers, usize)> {
        self.followers.iter().find(|f| f.agents.contains(&agent)).map(|f| f.walkers_of(agent))
    }
}

impl<V: Space> MotionKind for SceneAgents<V> {
    fn step(&mut self, tick: &GroupStep<'_>, events: &mut Vec<SimulationEvent>) -> Result<()> {
        let first = tick.first;
        // Taken out, so that the engine can be borrowed mutably. Events of agents that enter meanwhile are reported from the next step on.
        let agent_of = std::mem::take(&mut self.stage.agents_reported);
        let mut recorded = self.recorded.take();
        recorded.iter_mut().for_each(Vec::clear);
        self.brains.iter_mut().for_each(AgentBrains::clear_turns);
        let mut tell = |e: &CrowdEvent| {
            recorded.iter_mut().for_each(|all| all.push(*e));
            let Some(&agent) = agent_of.get(e.agent.index()) else { return };
            let who = first + agent as usize;
            events.extend(character_event(e.kind).map(|kind| SimulationEvent { time_s: e.time, who, kind }));
        };
        let done = self.advance(tick.until_s, tick.run, &mut tell);
        self.recorded = recorded;
        self.stage.agents_reported = agent_of;
        self.stage.agents_reported.clone_from(&self.stage.agent_of);
        done?;
        let begin = self.timings.is_some().then(Instant::now);
        self.stage.things.order_reaches(&mut self.followers, tick.dt_s);
        for (bodies, agent) in self.followers.iter().flat_map(|f| f.agents.clone().map(move |agent| (f, agent))) {
            let wait_s = if bodies.puts_off_gesture(&self.stage, agent) { f64::from(tick.dt_s) } else { 0.0 };
            self.stage.gestures[agent].iter_mut().for_each(|g| g.until_s += wait_s);
        }
        self.followers.iter_mut().try_for_each(|f| f.step(&self.stage, tick))?;
        self.move_things(tick.dt_s);
        if let (Some(spent), Some(begin)) = (&mut self.timings, begin) {
            spent.bodies_s += begin.elapsed().as_secs_f64();
        }
        self.stage.newcomers.clear();
        Ok(())
    }

    /// Reserves ground for agents on the ground; agents in the air need none.
    fn add_reserved_regions(&mut self, out: &mut ReservedRegion) {
        if V::DIMENSIONS == 2 {
            for (body, ground) in self.stage.ids.iter().filter_map(|id| self.stage.crowd.body_and_region((*id)?)) {
                out.bodies.push(body);
                out.ground.push(ground);
            }
        }
    }

    fn set_external_obstacles<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
        self.stage.crowd.set_external_obstacles(others);
    }

    fn save(&self, out: &mut Vec<u8>) {
        self.write_snapshot(out);
    }

    fn load(&mut self, bytes: &[u8], time_s: f64) -> Result<()> {
        self.read_snapshot(bytes, time_s)
    }

    fn num_characters(&self) -> usize {
        self.num_agents()
    }

    fn order(&mut self, number: usize, goal: Option<(Vec3, f32)>, order: &Order) -> Result<()> {
        let (agent, disc) = (number as u32, self.disc(number));
        let (from, radius) = disc.map_or((Vec3::ZERO, 0.0), |disc| (disc.centre, disc.radius));
        let goes = match goal {
            Some((at, _)) if order.is_steered() && !self.stage.sees(from, at, radius, false) => false,
            Some((at, arrival_m)) => self.stage.order_walk(agent, at, arrival_m, false)?,
            None => true,
        };
        ensure(goes, || Error::NoPath { who: Some(Id::first(number)), from, to: goal.map_or(from, |(at, _)| at) })?;
        self.change_brain(number, BrainChange::Suspend(order.speed_mps))?;
        let own = || self.brains.as_ref().map_or(self.stage.layout.setup.agents[number].speed, |b| b.own_speed(number));
        let speed = order.speed_mps().unwrap_or_else(own);
        self.stage.set_speed(agent, speed)?;
        self.stage.show_activity(agent, None, None);
        match (goal, order.heading) {
            (Some(_), _) => Ok(()),
            (None, Some(heading)) => self.stage.order_halt(agent).and_then(|()| self.turn_to(number, heading)),
            (None, None) => self.stage.order_halt(agent),
        }
    }

    fn turn_to(&mut self, number: usize, heading: f32) -> Result<()> {
        let at = self.disc(number).map_or(Vec3::ZERO, |disc| disc.centre);
        let ahead = Vec3::new(maths::sin(heading), 0.0, maths::cos(heading));
        self.stage.show_activity(number as u32, None, Some(at + ahead * FACES_M));
        Ok(())
    }

    fn root(&self, number: usize) -> Option<Planar> {
        match self.walkers_of(number) {
            Some((walkers, row)) => self.position(number, self.crowd().time_s()).map(|_| walkers.root(row)),
            None => self.disc(number).map(|d| d.root),
        }
    }

    fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        let (walkers, row) = self.walkers_of(number)?;
        self.position(number, self.crowd().time_s()).map(|_| single_pose(walkers.pose(row)))
    }

    fn contacts(&self, number: usize) -> Contacts {
        self.walkers_of(number).map_or(Contacts::NONE, |(walkers, row)| walkers.contacts(row))
    }

    fn soles(&self, number: usize) -> Option<[[Vec3; 2]; 2]> {
        self.walkers_of(number).map(|(walkers, row)| walkers.soles(row))
    }
}

/// Computing times of the parts of a step of agents (s).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AgentTimings {
    /// Crowd and brains.
    pub all_s: f64,
    /// Brains: rules, graphs and orders to the crowd, without finding the paths of these orders.
    pub brains_s: f64,
    /// Bodies.
    pub bodies_s: f64,
}

/// An agent without its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Position, and direction of its current or last movement, on the ground.
    pub root: Planar,
    /// Its centre; y is 0 on the ground (m).
    pub centre: Vec3,
    /// Velocity (m/s).
    pub velocity: Vec3,
    /// (m)
    pub radius: f32,
    /// Whether it knows of a happening.
    pub knows: bool,
}

/// Advances a crowd to a time, on several threads where that is faster.
pub(crate) fn advance_crowd(
    crowd: &mut Crowd,
    until_s: f64,
    run: &dyn Executor,
    on_event: &mut impl FnMut(&CrowdEvent),
) -> std::result::Result<(), CrowdError> {
    match run.is_parallel() && crowd.num_agents() >= PARALLEL_FROM {
        true => crowd.par_advance(until_s, run, on_event),
        false => crowd.advance(until_s, on_event),
    }
}

/// Character event of a crowd event; `None` for events that only concern the engine.
pub(crate) fn character_event(kind: CrowdEventKind) -> Option<CharacterEvent> {
    match kind {
        CrowdEventKind::Arrived => Some(CharacterEvent::Arrived),
        CrowdEventKind::Left => Some(CharacterEvent::Left),
        CrowdEventKind::Stuck => Some(CharacterEvent::Stuck),
        CrowdEventKind::Struck { obstacle } => Some(CharacterEvent::RunInto { obstacle }),
        _ => None,
    }
}

/// Ground coordinates (x, z) of a position.
pub fn ground_coordinates<V: Space>(at: V) -> Vec2 {
    at.on_ground()
}

/// World vector of a vector of the crowd's space; y is 0 on the ground.
pub fn world_vector<V: Space>(v: V) -> Vec3 {
    v.to_world()
}
