//! Agents of a scene, with and without bodies: they avoid each other, learn of happenings, and tell others.

mod followers;
mod layout;
mod message;
mod places;
mod snapshot;
mod stage;
mod things;
pub(crate) mod troop;
mod ways;

pub use layout::Layout;
pub use things::Handled;

use crate::compile::CompiledScene;
use crate::kind::{Kind, Tick};
use crate::scenario::{Minds, Stage};
use crate::scene::Motion;
use crate::{Event, Happened};
use followers::Followers;
use glam::{Quat, Vec2, Vec3};
use stage::Outside;
use std::sync::Arc;
use std::time::Instant;
use throng_base::ground::Held;
use throng_base::maths;
use throng_base::{Result, Run};
use throng_core::{Contacts, Mat3x4, NUM_JOINTS, Planar};
use throng_crowd::{Crowd, CrowdError, Event as CrowdEvent, EventKind, Id, Space};

/// All agents of a scene: their crowd, paths, brains, and the bodies that follow them.
#[derive(Clone, Debug)]
pub struct Agents<V> {
    pub(super) outside: Outside<V>,
    /// Brains of the agents, where the scene has rules, events or graphs beside goals.
    minds: Option<Minds>,
    /// Bodies of the groups that have any, in the order of groups.
    followers: Vec<Followers>,
    /// All events of the last step, where they are recorded.
    recorded: Option<Vec<CrowdEvent>>,
    /// Computing times so far, where they are measured.
    spent: Option<Spent>,
}

/// Number of agents from which on a crowd runs faster on several threads.
const PARALLEL_FROM: usize = 2000;

impl<V: Space> Agents<V> {
    /// Creates all agents at their starts.
    ///
    /// # Errors
    /// As [`Layout::new`], and for impossible starts, with the names of their groups; as [`crate::scenario::Scenario::new`].
    pub fn new(compiled: &CompiledScene) -> Result<Self> {
        let scene = compiled.shared();
        let mut layout = Layout::new(scene)?;
        if let Some(scenario) = compiled.scenario() {
            layout.sense(scenario);
        }
        let mut outside = Outside::new(layout)?;
        for (d, door) in scene.environment.doors.iter().enumerate() {
            if !door.open && !outside.set_open(d as u16, false)? {
                let why = "somebody starts in it: move the group, or let it be `open` at the start";
                return Err(scene.fault(&format!("environment.doors[{d}]"), why));
            }
        }
        let mut m = 0;
        while m < outside.layout.num_agents() {
            outside.join(m as u32)?;
            m = outside.layout.companions_of(m).end;
        }
        let mut agents = Self { outside, minds: None, followers: Vec::new(), recorded: None, spent: None };
        for (g, group) in scene.groups.iter().enumerate() {
            if group.is_of_agents() && group.motion == Motion::Blend {
                let bodies = Followers::new(compiled, g, &agents)?;
                agents.outside.things.know(&bodies);
                agents.followers.push(bodies);
            }
        }
        if let Some(scenario) = compiled.scenario() {
            let doors: Vec<bool> = scene.environment.doors.iter().map(|d| d.open).collect();
            let mut minds = Minds::new(Arc::clone(scenario), scene.seed, &doors);
            let speeds: Vec<f32> = agents.outside.layout.setup.agents.iter().map(|a| a.speed).collect();
            agents.outside.is_minded = true;
            minds.begin(&mut agents.outside, &speeds)?;
            agents.minds = Some(minds);
        }
        Ok(agents)
    }

    /// Starts to record all events of the engine, for [`Agents::engine_events`], and all turns of agent brains, for
    /// [`Minds::turns`].
    pub fn record_events(&mut self) {
        self.recorded.get_or_insert_default();
        self.minds.iter_mut().for_each(Minds::record_turns);
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
    pub fn advance(&mut self, until_s: f64, run: &dyn Run, on_event: &mut impl FnMut(&CrowdEvent)) -> Result<()> {
        let Self { outside, minds, spent, .. } = self;
        let begin = spent.is_some().then(Instant::now);
        let done = live(outside, minds.as_mut(), until_s, run, on_event, spent);
        if let (Some(spent), Some(begin)) = (spent, begin) {
            spent.all_s += begin.elapsed().as_secs_f64();
        }
        done
    }

    /// Starts to measure the computing times of crowd, brains and bodies.
    pub fn set_timed(&mut self) {
        self.spent = Some(Spent::default());
        self.outside.ways_s = Some(0.0);
    }

    /// Computing times of crowd, brains and bodies since [`Agents::set_timed`].
    pub fn spent(&self) -> Option<Spent> {
        self.spent
    }

    /// Raises an event of the scene now.
    ///
    /// # Errors
    /// [`throng_base::Error::Unknown`] with the events that there are, and as [`Agents::advance`].
    pub fn raise(&mut self, event: &str) -> Result<()> {
        let now = self.outside.crowd.now();
        match &mut self.minds {
            Some(minds) => {
                minds.clear_turns();
                minds.raise(&mut self.outside, now, event)
            }
            None => Err(throng_base::Error::Unknown { what: "event", name: event.into(), known: Vec::new() }),
        }
    }

    /// Brains of the agents; `None` in a scene that has only goals.
    pub fn minds(&self) -> Option<&Minds> {
        self.minds.as_ref()
    }

    /// The engine.
    pub fn crowd(&self) -> &Crowd {
        &self.outside.crowd
    }

    /// Layout of the agents.
    pub fn layout(&self) -> &Layout<V> {
        &self.outside.layout
    }

    /// Number of agents that started.
    pub fn num_agents(&self) -> usize {
        self.outside.layout.num_agents()
    }

    /// Id of an agent in the engine; `None` before it has entered (agent < num_agents).
    pub fn id(&self, agent: usize) -> Option<Id> {
        self.outside.ids[agent]
    }

    /// Number of an agent by its id in the engine; `None` once another agent has that id.
    pub fn agent_of(&self, id: Id) -> Option<usize> {
        let agent = *self.outside.agent_of.get(id.index())? as usize;
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
    pub fn knows(&self, agent: usize) -> u32 {
        self.minds.as_ref().map_or(0, |m| m.num_known(agent))
    }

    /// True for a door that is open (door < number of doors).
    pub fn is_open(&self, door: usize) -> bool {
        self.crowd().is_open(self.layout().first_door + door)
    }

    /// Number of orders that an agent was given (agent < num_agents).
    pub fn times_sent(&self, agent: usize) -> u32 {
        self.outside.sent[agent]
    }

    /// True once the scene's end has come.
    pub fn has_ended(&self) -> bool {
        self.minds.as_ref().is_some_and(Minds::has_ended)
    }
}

impl<V: Space> Kind for Agents<V> {
    fn step(&mut self, tick: &Tick<'_>, events: &mut Vec<Event>) -> Result<()> {
        let first = tick.first;
        // Taken out, so that the engine can be borrowed mutably. Events of agents that enter meanwhile are reported from the next step on.
        let agent_of = std::mem::take(&mut self.outside.agents_told);
        let mut recorded = self.recorded.take();
        recorded.iter_mut().for_each(Vec::clear);
        self.minds.iter_mut().for_each(Minds::clear_turns);
        let mut tell = |e: &CrowdEvent| {
            recorded.iter_mut().for_each(|all| all.push(*e));
            let Some(&agent) = agent_of.get(e.agent.index()) else { return };
            let who = first + agent as usize;
            events.extend(happened(e.kind).map(|happened| Event { time_s: e.time, who, happened }));
        };
        let done = self.advance(tick.until_s, tick.run, &mut tell);
        self.recorded = recorded;
        self.outside.agents_told = agent_of;
        self.outside.agents_told.clone_from(&self.outside.agent_of);
        done?;
        let begin = self.spent.is_some().then(Instant::now);
        self.outside.things.direct(&mut self.followers, tick.dt_s);
        self.followers.iter_mut().try_for_each(|f| f.step(&self.outside, tick))?;
        self.move_things(tick.dt_s);
        if let (Some(spent), Some(begin)) = (&mut self.spent, begin) {
            spent.bodies_s += begin.elapsed().as_secs_f64();
        }
        self.outside.newcomers.clear();
        Ok(())
    }

    /// Reserves ground for agents on the ground; agents in the air need none.
    fn hold(&mut self, out: &mut Held) {
        if V::DIMENSIONS == 2 {
            for (body, ground) in self.outside.ids.iter().filter_map(|id| self.outside.crowd.held((*id)?)) {
                out.bodies.push(body);
                out.ground.push(ground);
            }
        }
    }

    fn mind<'a>(&mut self, others: impl Iterator<Item = &'a Held>) {
        self.outside.crowd.mind(others);
    }

    fn save(&self, out: &mut Vec<u8>) {
        self.write(out);
    }

    fn load(&mut self, bytes: &[u8], time_s: f64) -> Result<()> {
        self.read(bytes, time_s)
    }

    fn num_characters(&self) -> usize {
        self.num_agents()
    }

    fn root(&self, number: usize) -> Option<Planar> {
        match self.followers_of(number) {
            Some(f) => self.position(number, self.crowd().now()).map(|_| f.root(number)),
            None => self.disc(number).map(|d| d.root),
        }
    }

    fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        let followers = self.followers_of(number)?;
        self.position(number, self.crowd().now()).map(|_| followers.pose(number))
    }

    fn contacts(&self, number: usize) -> Contacts {
        self.followers_of(number).map_or(Contacts::NONE, |f| f.contacts(number))
    }

    fn soles(&self, number: usize) -> Option<[[Vec3; 2]; 2]> {
        self.followers_of(number).map(|f| f.soles(number))
    }
}

/// Computing times of the parts of a step of agents (s).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Crowd and brains.
    pub all_s: f64,
    /// Brains: rules, graphs and orders to the crowd, without finding the paths of these orders.
    pub minds_s: f64,
    /// Bodies.
    pub bodies_s: f64,
}

/// Advances a crowd and the brains of its agents to a time.
fn live<V: Space>(
    outside: &mut Outside<V>,
    minds: Option<&mut Minds>,
    until_s: f64,
    run: &dyn Run,
    on_event: &mut impl FnMut(&CrowdEvent),
    spent: &mut Option<Spent>,
) -> Result<()> {
    let Some(minds) = minds else {
        let done = advance(&mut outside.crowd, until_s, run, on_event);
        return done.map_err(|e| outside.layout.explain(&e));
    };
    loop {
        let next = minds.next_external_s();
        let stop = until_s.min(next);
        let signal = outside.crowd.advance_to_signal(stop, on_event);
        let begin = spent.is_some().then(Instant::now);
        if let Some(event) = signal.map_err(|e| outside.layout.explain(&e))? {
            if let Some(signal) = outside.signal(&event) {
                minds.signal(outside, event.time, signal)?;
            }
        } else if stop == next {
            minds.external(outside, stop)?;
        } else {
            return Ok(());
        }
        if let (Some(spent), Some(begin)) = (spent.as_mut(), begin) {
            // Finding paths counts for the crowd.
            let ways_s = outside.ways_s.replace(0.0).unwrap_or(0.0);
            spent.minds_s += begin.elapsed().as_secs_f64() - ways_s;
        }
    }
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

impl<V: Space> Agents<V> {
    /// An agent as it is now; `None` where it has left (agent < num_agents).
    pub fn disc(&self, agent: usize) -> Option<Disc> {
        let now = self.crowd().now();
        let (at, velocity) = (self.position(agent, now)?, self.velocity(agent, now)?);
        let ahead = self.smooth_velocity(agent).map_or(Vec2::ZERO, plan);
        let (centre, radius) = (in_world(at), self.layout().setup.agents[agent].radius);
        let root = Planar { x: centre.x, z: centre.z, heading: maths::atan2(ahead.x, ahead.y) };
        Some(Disc { root, centre, velocity: in_world(velocity), radius, knows: self.knows(agent) > 0 })
    }

    /// Moves things along with the hands that hold them.
    fn move_things(&mut self, dt_s: f32) {
        if !self.outside.things.all.is_empty() {
            let mut things = std::mem::take(&mut self.outside.things);
            things.follow(&self.followers, |agent| self.disc(agent as usize).map(|d| d.root), dt_s);
            self.outside.things = things;
        }
    }

    /// Things of the scene, in its order: where they are (m), how they are turned, and the agent that has them in hand.
    pub fn things(&self) -> impl ExactSizeIterator<Item = (Vec3, Quat, Option<usize>)> + '_ {
        let all = self.outside.things.all.iter();
        all.map(|t| (t.at, Quat::from_array(t.turn), t.keeper.map(|agent| agent as usize)))
    }

    /// Counts of what hands have done so far.
    pub fn handled(&self) -> Handled {
        self.outside.things.handled
    }

    /// Bodies of an agent's group.
    fn followers_of(&self, agent: usize) -> Option<&Followers> {
        self.followers.iter().find(|f| f.holds(agent))
    }
}

/// Advances a crowd to a time, on several threads where that is faster.
pub(crate) fn advance(
    crowd: &mut Crowd,
    until_s: f64,
    run: &dyn Run,
    on_event: &mut impl FnMut(&CrowdEvent),
) -> std::result::Result<(), CrowdError> {
    match run.is_parallel() && crowd.num_agents() >= PARALLEL_FROM {
        true => crowd.par_advance(until_s, run, on_event),
        false => crowd.advance(until_s, on_event),
    }
}

/// Character event of a crowd event; `None` for events that only concern the engine.
pub(crate) fn happened(kind: EventKind) -> Option<Happened> {
    match kind {
        EventKind::Arrived => Some(Happened::Arrived),
        EventKind::Left => Some(Happened::Left),
        EventKind::Stuck => Some(Happened::Stuck),
        EventKind::Struck { obstacle } => Some(Happened::RunInto { obstacle }),
        _ => None,
    }
}

/// Ground coordinates (x, z) of a position.
pub fn plan<V: Space>(at: V) -> Vec2 {
    let [a, b, c] = at.coordinates();
    if V::DIMENSIONS == 2 { Vec2::new(a, b) } else { Vec2::new(a, c) }
}

/// World vector of a vector of the crowd's space; y is 0 on the ground.
pub fn in_world<V: Space>(v: V) -> Vec3 {
    let [a, b, c] = v.coordinates();
    if V::DIMENSIONS == 2 { Vec3::new(a, 0.0, b) } else { Vec3::new(a, b, c) }
}
