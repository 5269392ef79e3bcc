//! Agents of a scene, with bodies and without: they keep clear of each other, hear of happenings, and tell others.

mod followers;
mod layout;
mod message;
mod places;
mod snapshot;
pub(crate) mod troop;
mod ways;

pub use layout::Layout;

use crate::compile::CompiledScene;
use crate::kind::{Kind, Tick};
use crate::scene::{HappeningConfig, Motion, NearConfig, point};
use crate::{Event, Happened};
use followers::Followers;
use glam::{Vec2, Vec3};
use throng_base::ground::Held;
use throng_base::maths;
use throng_base::{Result, Run};
use throng_core::{Contacts, Mat3x4, NUM_JOINTS, Planar};
use throng_crowd::{Crowd, CrowdError, Event as CrowdEvent, EventKind, Go, Id, Route, Space};

/// Time between moments at which news are told on, whatever the times that are looked at (s).
const NEWS_S: f64 = 1.0 / 30.0;

/// All agents of a scene: their crowd, their ways, who knows of what, and the bodies that follow them.
#[derive(Clone, Debug)]
pub struct Agents<V> {
    pub(super) crowd: Crowd,
    pub(super) layout: Layout<V>,
    ids: Vec<Id>,
    /// In the order of their times.
    happenings: Vec<HappeningConfig>,
    /// How many of them have happened.
    pub(super) happened: usize,
    /// Of each agent: the last happening that it knows of, from 1; 0 where it knows of none.
    pub(super) knows: Vec<usize>,
    /// Of each agent: how often it was given another way.
    pub(super) sent: Vec<u32>,
    /// (who is told, of which happening), since news were last told on.
    pub(super) told: Vec<(usize, usize)>,
    /// Moments at which news were told on.
    pub(super) ticks: u64,
    /// Bodies of the groups that have any, in the order of groups.
    followers: Vec<Followers>,
    /// All events of the last step, where they are recorded.
    recorded: Option<Vec<CrowdEvent>>,
}

/// Agents from which on an engine gains by being run in parts.
const PARALLEL_FROM: usize = 2000;

impl<V: Space> Agents<V> {
    /// Puts everybody where they start.
    ///
    /// # Errors
    /// As [`Layout::new`], and for impossible starts, with the names of their groups.
    pub fn new(compiled: &CompiledScene) -> Result<Self> {
        let scene = compiled.shared();
        let layout = Layout::new(scene)?;
        let setup = layout.setup.clone().map(V::to_world);
        let crowd = if V::DIMENSIONS == 2 { Crowd::on_ground(setup) } else { Crowd::in_air(setup) };
        let crowd = crowd.map_err(|e| layout.explain(&e))?;
        let mut happenings = scene.happenings.clone();
        happenings.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let num = layout.num_agents();
        let mut agents = Self {
            ids: crowd.ids().collect(),
            crowd,
            happenings,
            happened: 0,
            knows: vec![0; num],
            sent: vec![0; num],
            told: Vec::with_capacity(4 * num),
            ticks: 0,
            followers: Vec::new(),
            recorded: None,
            layout,
        };
        for (g, group) in scene.groups.iter().enumerate() {
            if group.is_of_agents() && group.motion == Motion::Blend {
                let bodies = Followers::new(compiled, g, &agents)?;
                agents.followers.push(bodies);
            }
        }
        Ok(agents)
    }

    /// Records all events of the engine from now on, for [`Agents::engine_events`].
    pub fn record_events(&mut self) {
        self.recorded.get_or_insert_default();
    }

    /// All events of the engine in the last step, in their order; empty unless they are recorded.
    pub fn engine_events(&self) -> &[CrowdEvent] {
        self.recorded.as_deref().unwrap_or_default()
    }

    /// Lets time pass until `until_s`, without bodies. What happens depends neither on `run` nor on how often this is called
    /// on the way; all of it is told to `on_event` in its order.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] where the engine does not get on, or a happening's goal cannot be reached.
    pub fn advance(&mut self, until_s: f64, run: &dyn Run, on_event: &mut impl FnMut(&CrowdEvent)) -> Result<()> {
        loop {
            let next = self.happenings.get(self.happened).map_or(f64::INFINITY, |h| h.time_s);
            let tick = if self.is_told_on() { (self.ticks + 1) as f64 * NEWS_S } else { f64::INFINITY };
            let stop = until_s.min(next).min(tick);
            self.advance_engine(stop, run, on_event)?;
            if stop == next {
                self.happen()?;
            } else if stop == tick {
                self.ticks += 1;
                self.tell_on()?;
            } else {
                return Ok(());
            }
        }
    }

    fn is_told_on(&self) -> bool {
        self.happenings[..self.happened].iter().any(|h| h.told_on)
    }

    fn advance_engine(&mut self, until_s: f64, run: &dyn Run, on_event: &mut impl FnMut(&CrowdEvent)) -> Result<()> {
        let (knows, told, happenings) = (&self.knows, &mut self.told, &self.happenings);
        let mut hear = |e: &CrowdEvent| {
            on_event(e);
            let EventKind::Colliding { other } = e.kind else { return };
            let (a, b) = (e.agent.index(), other.index());
            let (who, news) = if knows[a] < knows[b] { (a, knows[b]) } else { (b, knows[a]) };
            if knows[who] < news && happenings[news - 1].told_on {
                told.push((who, news));
            }
        };
        advance(&mut self.crowd, until_s, run, &mut hear).map_err(|e| self.layout.explain(&e))
    }

    /// The next happening: those who are near hear of it.
    fn happen(&mut self) -> Result<()> {
        let happening = self.happenings[self.happened].clone();
        self.happened += 1;
        self.ticks = (happening.time_s / NEWS_S).floor() as u64;
        for m in 0..self.num_agents() {
            let Some(at) = self.position(m, happening.time_s) else { continue };
            let is_near = |n: &NearConfig| (at - point(&n.at)).length() <= n.radius_m;
            if happening.near.as_ref().is_none_or(is_near) {
                self.learn(m, self.happened, happening.time_s)?;
            }
        }
        Ok(())
    }

    /// Those who met somebody that knows more know it too.
    fn tell_on(&mut self) -> Result<()> {
        for i in 0..self.told.len() {
            let (m, news) = self.told[i];
            if self.knows[m] < news {
                self.learn(m, news, self.crowd.now())?;
            }
        }
        self.told.clear();
        Ok(())
    }

    /// An agent knows of a happening, and takes the way to its goal.
    fn learn(&mut self, m: usize, news: usize, time_s: f64) -> Result<()> {
        self.knows[m] = news;
        let Some(at) = self.position(m, time_s) else { return Ok(()) };
        let h = &self.happenings[news - 1];
        let route = self.layout.new_way(m, at, &h.goal, (h.arrival_m, h.at_end))?;
        let speed = h.speed_mps.unwrap_or(self.layout.setup.agents[m].speed);
        let Route { subgoals, arrival_radius, at_end } = route.map(V::to_world);
        let order = Go::along(subgoals).within(arrival_radius).then(at_end).at_speed(speed);
        let sent = self.crowd.order(self.ids[m], order);
        self.sent[m] += 1;
        sent.map_err(|e| self.layout.explain(&e))
    }

    /// The engine.
    pub fn crowd(&self) -> &Crowd {
        &self.crowd
    }

    /// Who is there.
    pub fn layout(&self) -> &Layout<V> {
        &self.layout
    }

    /// Number of agents that started.
    pub fn num_agents(&self) -> usize {
        self.ids.len()
    }

    /// Name of an agent in the engine (agent < num_agents).
    pub fn id(&self, agent: usize) -> Id {
        self.ids[agent]
    }

    /// Where an agent is at a time that the engine knows; `None` where it has left (agent < num_agents).
    pub fn position(&self, agent: usize, time_s: f64) -> Option<V> {
        self.crowd.position(self.ids[agent], time_s).map(V::from_world)
    }

    /// How an agent moves (m/s, agent < num_agents).
    pub fn velocity(&self, agent: usize, time_s: f64) -> Option<V> {
        self.crowd.velocity(self.ids[agent], time_s).map(V::from_world)
    }

    /// How an agent moves as a Kalman filter sees it (m/s, agent < num_agents).
    pub fn smooth_velocity(&self, agent: usize) -> Option<V> {
        self.crowd.smooth_velocity(self.ids[agent]).map(V::from_world)
    }

    /// True for a scene in which something happens from outside.
    pub fn has_happenings(&self) -> bool {
        !self.happenings.is_empty()
    }

    /// Number of happenings of which an agent knows, itself or from others (agent < num_agents).
    pub fn knows(&self, agent: usize) -> usize {
        self.knows[agent]
    }

    /// How often an agent was given another way (agent < num_agents).
    pub fn times_sent(&self, agent: usize) -> u32 {
        self.sent[agent]
    }
}

impl<V: Space> Kind for Agents<V> {
    fn step(&mut self, tick: &Tick<'_>, events: &mut Vec<Event>) -> Result<()> {
        let first = tick.first;
        // Taken out, so that the engine can be told to move on.
        let mut recorded = self.recorded.take();
        recorded.iter_mut().for_each(Vec::clear);
        let mut tell = |e: &CrowdEvent| {
            recorded.iter_mut().for_each(|all| all.push(*e));
            let who = first + e.agent.index();
            events.extend(happened(e.kind).map(|happened| Event { time_s: e.time, who, happened }));
        };
        let done = self.advance(tick.until_s, tick.run, &mut tell);
        self.recorded = recorded;
        done?;
        self.followers.iter_mut().try_for_each(|f| f.step(&self.crowd, tick))
    }

    /// Nobody in the air holds ground.
    fn hold(&mut self, out: &mut Held) {
        if V::DIMENSIONS == 2 {
            for (body, ground) in self.ids.iter().filter_map(|&id| self.crowd.held(id)) {
                out.bodies.push(body);
                out.ground.push(ground);
            }
        }
    }

    fn mind<'a>(&mut self, others: impl Iterator<Item = &'a Held>) {
        self.crowd.mind(others);
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
            Some(f) => self.position(number, self.crowd.now()).map(|_| f.root(number)),
            None => self.disc(number).map(|d| d.root),
        }
    }

    fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        let followers = self.followers_of(number)?;
        self.position(number, self.crowd.now()).map(|_| followers.pose(number))
    }

    fn contacts(&self, number: usize) -> Contacts {
        self.followers_of(number).map_or(Contacts::NONE, |f| f.contacts(number))
    }

    fn soles(&self, number: usize) -> Option<[[Vec3; 2]; 2]> {
        self.followers_of(number).map(|f| f.soles(number))
    }
}

/// An agent without its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Where it is, and where it goes or went last, over the ground.
    pub root: Planar,
    /// Its centre; y is 0 on the ground (m).
    pub centre: Vec3,
    /// How it moves (m/s).
    pub velocity: Vec3,
    /// (m)
    pub radius: f32,
    /// It knows of a happening.
    pub knows: bool,
}

impl<V: Space> Agents<V> {
    /// An agent as it is now; `None` where it has left (agent < num_agents).
    pub fn disc(&self, agent: usize) -> Option<Disc> {
        let now = self.crowd.now();
        let (at, velocity) = (self.position(agent, now)?, self.velocity(agent, now)?);
        let ahead = self.crowd.smooth_velocity(self.ids[agent]).map_or(Vec2::ZERO, plan);
        let (centre, radius) = (in_world(at), self.layout.setup.agents[agent].radius);
        let root = Planar { x: centre.x, z: centre.z, heading: maths::atan2(ahead.x, ahead.y) };
        Some(Disc { root, centre, velocity: in_world(velocity), radius, knows: self.knows[agent] > 0 })
    }

    /// The bodies among which that of an agent is.
    fn followers_of(&self, agent: usize) -> Option<&Followers> {
        self.followers.iter().find(|f| f.holds(agent))
    }
}

/// Lets time pass for a crowd, in parts where that pays.
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

/// What an event of a crowd is to those who watch; `None` where agents only look at each other anew.
pub(crate) fn happened(kind: EventKind) -> Option<Happened> {
    match kind {
        EventKind::Arrived => Some(Happened::Arrived),
        EventKind::Left => Some(Happened::Left),
        EventKind::Stuck => Some(Happened::Stuck),
        EventKind::Struck { obstacle } => Some(Happened::RunInto { obstacle }),
        _ => None,
    }
}

/// (x, z) of a place.
pub fn plan<V: Space>(at: V) -> Vec2 {
    let [a, b, c] = at.coordinates();
    if V::DIMENSIONS == 2 { Vec2::new(a, b) } else { Vec2::new(a, c) }
}

/// A vector of a crowd as one of the world; y is 0 on the ground.
pub fn in_world<V: Space>(v: V) -> Vec3 {
    let [a, b, c] = v.coordinates();
    if V::DIMENSIONS == 2 { Vec3::new(a, 0.0, b) } else { Vec3::new(a, b, c) }
}
