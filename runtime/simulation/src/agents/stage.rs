//! The crowd as the world of agent brains: what they see of it, and how they act in it.

use super::layout::Layout;
use super::things::{Things, Who};
use crate::scenario::{Handling, NoStance, Signal, Stage};
use crate::scene::GoalConfig;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::time::Instant;
use throng_base::Result;
use throng_core::blend::ActivityId;
use throng_crowd::{
    AtEnd, Crowd, CrowdError, Event, EventKind, Go, Id, InterestAt, PersonalInterest, Route, Sense, Space,
};

/// Most positions that are tried for an agent that enters.
const TRIES: usize = 8;

/// Crowd with the numbers of its agents and the last order of each.
#[derive(Clone, Debug)]
pub(crate) struct Outside<V> {
    pub crowd: Crowd,
    pub layout: Layout<V>,
    /// Id of each agent in the crowd; `None` before it has entered.
    pub ids: Vec<Option<Id>>,
    /// Agent that has each row of the crowd, or had it last.
    pub agent_of: Vec<u32>,
    /// Copy of `agent_of` at the end of the last step, for reported events.
    pub agents_told: Vec<u32>,
    /// Number of orders that each agent was given.
    pub sent: Vec<u32>,
    /// Happening that sent each agent last; `None` for an agent that follows its own goal.
    pub told: Vec<Option<u16>>,
    /// Activity of each agent's body.
    pub shown: Vec<Shown>,
    pub things: Things,
    /// Agents that have entered since the last step of bodies.
    pub newcomers: Vec<u32>,
    /// Whether agents have brains.
    pub is_minded: bool,
    /// Computing time of finding paths, where it is measured (s).
    pub ways_s: Option<f64>,
}

/// Activity of a body beside walking.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Shown {
    /// Number of a tag of motion in the scenario.
    pub motion: Option<u16>,
    /// Position that it faces (m).
    pub faces: Option<Vec3>,
    /// Activity that it performs once, in place of repeated motion of the tag: it takes a thing, or puts it down.
    pub once: Option<ActivityId>,
    /// Position at which the body stands meanwhile, whatever moves its disc about (m).
    pub stands: Option<Vec3>,
}

impl<V: Space> Outside<V> {
    /// Creates the crowd with all agents that are there at the start.
    pub fn new(layout: Layout<V>) -> Result<Self> {
        let num = layout.num_agents();
        let mut setup = layout.setup.clone();
        let is_there: Vec<bool> = (0..num).map(|m| layout.is_there_at_start(m)).collect();
        let mut kept = is_there.iter();
        setup.agents.retain(|_| kept.next().copied().unwrap_or(true));
        setup.config.capacity = num;
        setup.config.largest_radius_m = layout.setup.agents.iter().map(|a| a.radius).fold(0.01, f32::max);
        let setup = setup.map(V::to_world);
        let crowd = if V::DIMENSIONS == 2 { Crowd::on_ground(setup) } else { Crowd::in_air(setup) };
        let crowd = crowd.map_err(|e| layout.explain(&e))?;
        let mut names = crowd.ids();
        let ids: Vec<Option<Id>> = is_there.iter().map(|&is| if is { names.next() } else { None }).collect();
        drop(names);
        let mut agent_of = vec![0; num];
        for (m, id) in ids.iter().enumerate() {
            if let Some(id) = id {
                agent_of[id.index()] = m as u32;
            }
        }
        Ok(Self {
            crowd,
            ids,
            agents_told: agent_of.clone(),
            agent_of,
            sent: vec![0; num],
            told: vec![None; num],
            shown: vec![Shown::default(); num],
            things: Things::new(&layout.scene.things),
            newcomers: Vec::with_capacity(num),
            is_minded: false,
            ways_s: None,
            layout,
        })
    }

    /// Makes an agent walk with those of its companions that are there.
    pub fn join(&mut self, agent: u32) -> Result<()> {
        let group = self.layout.companions_of(agent as usize);
        if group.len() < 2 {
            return Ok(());
        }
        let there: Vec<Id> = group.filter_map(|m| self.here(m as u32)).collect();
        if there.is_empty() {
            return Ok(());
        }
        self.crowd.set_companions(&there).map_err(|e| self.layout.explain(&e))
    }

    /// Signal to the brains for an event of the engine; `None` for events that do not concern them.
    pub fn signal(&self, event: &Event) -> Option<Signal> {
        let agent = self.agent_of[event.agent.index()];
        Some(match event.kind {
            EventKind::Met { other } => {
                let other = self.agent_of[other.index()];
                Signal::Met(agent.min(other), agent.max(other))
            }
            EventKind::CameTo { zone } => Signal::CameTo(agent, zone as u16),
            EventKind::WentFrom { zone } => Signal::WentFrom(agent, zone as u16),
            EventKind::Crossed { .. } => Signal::Crossed(agent),
            EventKind::Arrived => Signal::Arrived(agent),
            EventKind::Left => Signal::Left(agent),
            EventKind::Stuck => Signal::Stuck(agent),
            EventKind::Timer => Signal::Timer(agent),
            _ => return None,
        })
    }

    /// Gives an order; false where no path leads there.
    fn order(&mut self, agent: u32, order: Go) -> Result<bool> {
        let m = agent as usize;
        let Some(id) = self.here(agent) else { return Ok(false) };
        self.sent[m] += 1;
        let begin = self.ways_s.map(|_| Instant::now());
        let ordered = self.crowd.order(id, order);
        if let (Some(ways_s), Some(begin)) = (&mut self.ways_s, begin) {
            *ways_s += begin.elapsed().as_secs_f64();
        }
        match ordered {
            Ok(()) => {
                self.crowd.wake(id).map_err(|e| self.layout.explain(&e))?;
                Ok(true)
            }
            Err(CrowdError::Goal { .. } | CrowdError::Inside { .. }) => Ok(false),
            Err(CrowdError::Other(throng_base::Error::NoWay { .. })) => Ok(false),
            Err(e) => Err(self.layout.explain(&e)),
        }
    }

    fn now(&self, agent: u32) -> Option<V> {
        self.crowd.position(self.ids[agent as usize]?, self.crowd.now()).map(V::from_world)
    }

    fn who(&self, agent: u32) -> Who {
        Who { agent, number: self.ids[agent as usize].map_or(0, |id| id.index()) }
    }

    /// Id of an agent that is there; an agent that has left may still get messages.
    fn here(&self, agent: u32) -> Option<Id> {
        self.ids[agent as usize].filter(|_| self.now(agent).is_some())
    }
}

impl<V: Space> Stage for Outside<V> {
    fn position(&self, agent: u32) -> Option<Vec3> {
        self.now(agent).map(super::in_world)
    }

    fn velocity(&self, agent: u32) -> Vec3 {
        let velocity = |id| self.crowd.velocity(id, self.crowd.now());
        self.ids[agent as usize].and_then(velocity).unwrap_or_default()
    }

    fn go(&mut self, agent: u32, at: Vec3, arrival_m: f32, leaves: bool) -> Result<bool> {
        let then = if leaves { AtEnd::Leave } else { AtEnd::Stay };
        if let Some(from) = self.now(agent) {
            let way = &mut self.layout.ways[agent as usize];
            way.clear();
            way.extend([from, V::from_world(at)]);
            self.layout.arrivals[agent as usize] = arrival_m;
        }
        self.order(agent, Go::to(at).within(arrival_m).then(then))
    }

    fn follow(&mut self, agent: u32, points: &[Vec3], again: bool) -> Result<bool> {
        let then = if again { AtEnd::Again } else { AtEnd::Stay };
        self.order(agent, Go::along(points.to_vec()).within(1.0).then(then))
    }

    fn follow_happening(&mut self, agent: u32, happening: u16) -> Result<()> {
        let m = agent as usize;
        let Some(from) = self.now(agent) else { return Ok(()) };
        let scene = self.layout.scene();
        let h = &scene.happenings[usize::from(happening)];
        let (goal, how, speed): (GoalConfig, _, _) = (h.goal.clone(), (h.arrival_m, h.at_end), h.speed_mps);
        let route = self.layout.new_way(m, from, &goal, how)?;
        let Route { subgoals, arrival_radius, at_end } = route.map(V::to_world);
        self.told[m] = Some(happening);
        if let Some(speed) = speed {
            self.set_speed(agent, speed)?;
        }
        self.order(agent, Go::along(subgoals).within(arrival_radius).then(at_end)).map(|_| ())
    }

    fn resume(&mut self, agent: u32) -> Result<()> {
        match self.told[agent as usize] {
            Some(happening) => self.follow_happening(agent, happening),
            None => {
                let Some(route) = self.layout.setup.agents[agent as usize].route else { return Ok(()) };
                self.order(agent, Go::on_route(route)).map(|_| ())
            }
        }
    }

    fn halt(&mut self, agent: u32) -> Result<()> {
        let end = self.ids[agent as usize].and_then(|id| self.crowd.stop_region(id));
        let Some((_, at)) = end else { return Ok(()) };
        self.go(agent, at, 0.3, false).map(|_| ())
    }

    fn set_speed(&mut self, agent: u32, speed_mps: f32) -> Result<()> {
        let Some(id) = self.here(agent) else { return Ok(()) };
        let most = self.layout.setup.config.largest_speed_mps;
        self.crowd.set_speed(id, speed_mps.min(most)).map_err(|e| self.layout.explain(&e))
    }

    fn show(&mut self, agent: u32, motion: Option<u16>, faces: Option<Vec3>) {
        self.shown[agent as usize] = Shown { motion, faces, ..Shown::default() };
    }

    fn thing_at(&self, thing: u16) -> Vec3 {
        self.things.all[usize::from(thing)].at
    }

    fn has_in_hand(&self, agent: u32, thing: u16) -> bool {
        self.things.all[usize::from(thing)].keeper == Some(agent)
    }

    fn stance(
        &self,
        agent: u32,
        motion: Option<u16>,
        handling: Handling,
        side: u32,
    ) -> std::result::Result<(Vec3, f32), NoStance> {
        let from = self.position(agent).unwrap_or_default();
        self.things.stance(self.who(agent), motion, handling, (from, side))
    }

    fn handle(&mut self, agent: u32, motion: Option<u16>, handling: Handling) {
        let from = self.position(agent).unwrap_or_default();
        let begun = self.things.begin(self.who(agent), motion, handling, from);
        self.shown[agent as usize] = match begun {
            Some((once, faces, stands)) => Shown { motion, faces: Some(faces), once: Some(once), stands: Some(stands) },
            None => Shown::default(),
        };
    }

    fn settle(&mut self, agent: u32, thing: u16, is_done: bool) -> bool {
        self.things.settle(agent, thing, is_done)
    }

    fn missed(&mut self) {
        self.things.handled.missed += 1;
    }

    fn is_over(&self, agent: u32, thing: u16) -> bool {
        self.things.is_over(agent, thing)
    }

    fn let_go(&mut self, thing: u16) {
        self.things.let_go(thing);
    }

    fn set_open(&mut self, door: u16, open: bool) -> Result<bool> {
        let obstacle = self.layout.first_door + usize::from(door);
        match self.crowd.set_open(obstacle, open) {
            Ok(()) => Ok(true),
            Err(CrowdError::Inside { .. }) => Ok(false),
            Err(e) => Err(self.layout.explain(&e)),
        }
    }

    fn enter(&mut self, agent: u32) -> Result<bool> {
        for k in 0..TRIES {
            let mut start = self.layout.setup.agents[agent as usize];
            start.position = self.layout.entrance(agent as usize, k as u32 + 16 * self.sent[agent as usize]);
            if let Ok(id) = self.crowd.spawn(start.map(V::to_world)) {
                self.ids[agent as usize] = Some(id);
                self.agent_of[id.index()] = agent;
                self.newcomers.push(agent);
                self.layout.ways[agent as usize].clear();
                self.layout.ways[agent as usize].push(start.position);
                self.sent[agent as usize] = 0;
                self.join(agent)?;
                return Ok(true);
            }
        }
        self.sent[agent as usize] += 1;
        Ok(false)
    }

    fn sense(&mut self, agent: u32, tells: u32, hears: u32) -> Result<()> {
        let Some(id) = self.here(agent) else { return Ok(()) };
        // Meetings count when two come near; news pass wherever two are.
        let (zones, cells) = (self.layout.senses_zones, self.layout.senses_cells);
        let sense = Sense { tells, hears, once: 1 << 31, zones, cells, arrivals: true };
        self.crowd.sense(id, sense).map_err(|e| self.layout.explain(&e))
    }

    fn set_timer(&mut self, agent: u32, time_s: Option<f64>) -> Result<()> {
        let Some(id) = self.here(agent) else { return Ok(()) };
        let now = self.crowd.now();
        self.crowd.set_timer(id, time_s.map(|t| t.max(now))).map_err(|e| self.layout.explain(&e))
    }

    fn attract(&mut self, agent: u32, n: usize, interest: Option<(Vec3, f32, f32)>) -> Result<()> {
        let Some(id) = self.here(agent) else { return Ok(()) };
        let interest =
            interest.map(|(at, strength, reach)| PersonalInterest { at: InterestAt::Place(at), strength, reach });
        self.crowd.set_interest(id, n, interest).map_err(|e| self.layout.explain(&e))
    }

    fn within(&self, at: Vec3, radius_m: f32, out: &mut Vec<u32>) {
        let is_near = |m: &u32| self.position(*m).is_some_and(|p| p.distance_squared(at) <= radius_m * radius_m);
        out.extend((0..self.ids.len() as u32).filter(is_near));
    }
}
