//! The crowd as the world of agent brains: what they see of it, and how they act in it.

use super::layout::CrowdLayout;
use super::things::{Handler, Things};
use crate::scenario::{Handling, ScenarioStage, ShownGesture, Signal, Stance, StanceError};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::{ops::Range, sync::Arc, time::Instant};
use throng_base::{Error, Result};
use throng_core::{blend::ActivityId, body::ArmLayer};
use throng_crowd::{
    AgentOrder, AtEnd, Crowd, CrowdError, CrowdEvent, CrowdEventKind, Id, InterestLocation, PersonalInterest, Route,
    RouteBegin, Sense, Space,
};

/// Time at the present speed in which an agent covers the way that it needs to stop as people do, without passing the end (s).
const HALT_S: f32 = 0.5;
/// Most positions that are tried for an agent that enters.
const TRIES: usize = 8;

/// Crowd with the numbers of its agents and the last order of each.
#[derive(Clone, Debug)]
pub(crate) struct CrowdStage<V> {
    pub crowd: Crowd,
    pub layout: CrowdLayout<V>,
    /// Id of each agent in the crowd; `None` before it has entered.
    pub ids: Vec<Option<Id>>,
    /// Agent that has each row of the crowd, or had it last.
    pub agent_of: Vec<u32>,
    /// Copy of `agent_of` at the end of the last step, for reported events.
    pub agents_reported: Vec<u32>,
    /// Number of orders that each agent was given.
    pub sent: Vec<u32>,
    /// Happening that sent each agent last; `None` for an agent that follows its own goal.
    pub ordered_happenings: Vec<Option<u16>>,
    /// Activity of each agent's body.
    pub shown: Vec<BodyActivity>,
    /// Gesture of each agent's arms.
    pub gestures: Vec<Option<ShownGesture>>,
    pub things: Things,
    /// Agents that have entered since the last step of bodies.
    pub newcomers: Vec<u32>,
    /// Computing time of finding paths, where it is measured (s).
    pub paths_s: Option<f64>,
}

/// Activity of a body beside walking.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct BodyActivity {
    /// Number of a tag of motion in the scenario.
    pub motion: Option<u16>,
    /// Position that it faces (m).
    pub faces: Option<Vec3>,
    /// Number of the agent that it faces, in place of the position.
    pub other: Option<u32>,
    /// Activity that it performs once, in place of repeated motion of the tag: it takes a thing, or puts it down.
    pub once: Option<ActivityId>,
    /// Position at which the body stands meanwhile, whatever moves its disc about (m).
    pub stands: Option<Vec3>,
}

impl<V: Space> CrowdStage<V> {
    /// Creates the crowd with all agents that are there at the start.
    pub fn new(layout: CrowdLayout<V>) -> Result<Self> {
        let num = layout.num_agents();
        let mut setup = layout.setup.clone();
        let is_there: Vec<bool> = (0..num).map(|m| layout.is_there_at_start(m)).collect();
        let mut kept = is_there.iter();
        setup.agents.retain(|_| kept.next().copied().unwrap_or(true));
        setup.config.capacity = num;
        let weakest_mps2 = layout.setup.agents.iter().map(|a| a.acceleration).reduce(f32::min);
        setup.config.least_acceleration_mps2 = weakest_mps2.unwrap_or(0.0);
        setup.config.largest_radius_m = layout.setup.agents.iter().map(|a| a.radius).fold(0.01, f32::max);
        let setup = setup.map(V::to_world);
        let crowd = if V::DIMENSIONS == 2 { Crowd::on_ground(setup) } else { Crowd::in_air(setup) };
        let crowd = crowd.map_err(|e| layout.explain_crowd_error(&e))?;
        let mut names = crowd.ids();
        let ids: Vec<Option<Id>> = is_there.iter().map(|&is| if is { names.next() } else { None }).collect();
        drop(names);
        let mut agent_of = vec![0; num];
        for (m, id) in (0..).zip(&ids).filter_map(|(m, id)| Some((m, (*id)?))) {
            agent_of[id.index()] = m;
        }
        Ok(Self {
            crowd,
            ids,
            agents_reported: agent_of.clone(),
            agent_of,
            sent: vec![0; num],
            ordered_happenings: vec![None; num],
            shown: vec![BodyActivity::default(); num],
            gestures: vec![None; num],
            things: Things::new(&layout.scene.things),
            newcomers: Vec::with_capacity(num),
            paths_s: None,
            layout,
        })
    }

    /// Makes an agent walk with those of its companions that are there.
    pub fn join_companions(&mut self, agent: u32) -> Result<()> {
        let group = self.layout.companions_of(agent as usize);
        if group.len() < 2 {
            return Ok(());
        }
        let there: Vec<Id> = group.filter_map(|m| self.present_id(m as u32)).collect();
        if there.is_empty() {
            return Ok(());
        }
        self.crowd.set_companions(&there).map_err(|e| self.layout.explain_crowd_error(&e))
    }

    /// Position that the body of an agent faces, if any (m).
    pub fn faced_position(&self, agent: usize) -> Option<Vec3> {
        let shown = self.shown[agent];
        shown.other.and_then(|other| self.position(other)).or(shown.faces)
    }

    /// Gesture of an agent's arms at the moment, and the position at which it is aimed (m).
    pub fn gesture_now(&self, agent: usize) -> Option<(ArmLayer, Option<Vec3>)> {
        let gesture = self.gestures[agent].filter(|g| self.crowd.time_s() < g.until_s)?;
        Some((gesture.arm, gesture.other.and_then(|other| self.position(other)).or(gesture.at)))
    }

    /// Signal to the brains for an event of the engine; `None` for events that do not concern them.
    pub fn brain_signal(&self, event: &CrowdEvent) -> Option<Signal> {
        let agent = self.agent_of[event.agent.index()];
        Some(match event.kind {
            CrowdEventKind::Met { other } => {
                let other = self.agent_of[other.index()];
                Signal::Met(agent.min(other), agent.max(other))
            }
            CrowdEventKind::CameTo { zone } => Signal::CameTo(agent, zone as u16),
            CrowdEventKind::WentFrom { zone } => Signal::WentFrom(agent, zone as u16),
            CrowdEventKind::Crossed { .. } => Signal::Crossed(agent),
            CrowdEventKind::Arrived => Signal::Arrived(agent),
            CrowdEventKind::Left => Signal::Left(agent),
            CrowdEventKind::Stuck => Signal::Stuck(agent),
            CrowdEventKind::Timer => Signal::Timer(agent),
            _ => return None,
        })
    }

    /// Gives an order; false where no path leads there.
    fn order(&mut self, agent: u32, order: AgentOrder) -> Result<bool> {
        let m = agent as usize;
        let Some(id) = self.present_id(agent) else { return Ok(false) };
        let begin = self.paths_s.map(|_| Instant::now());
        let ordered = self.crowd.order(id, order);
        if let (Some(paths_s), Some(begin)) = (&mut self.paths_s, begin) {
            *paths_s += begin.elapsed().as_secs_f64();
        }
        match ordered {
            Ok(()) => {
                self.sent[m] += 1;
                self.crowd.wake(id).map(|()| true).map_err(|e| self.layout.explain_crowd_error(&e))
            }
            Err(CrowdError::Goal { .. } | CrowdError::Inside { .. } | CrowdError::Other(Error::NoPath { .. })) => {
                Ok(false)
            }
            Err(e) => Err(self.layout.explain_crowd_error(&e)),
        }
    }

    fn current_position(&self, agent: u32) -> Option<V> {
        self.crowd.position(self.ids[agent as usize]?, self.crowd.time_s()).map(V::from_world)
    }

    fn handler(&self, agent: u32, motion: Option<u16>) -> Handler {
        let number = self.ids[agent as usize].map_or(0, |id| id.index());
        Handler { agent, number, from: self.position(agent).unwrap_or_default(), motion }
    }

    /// Id of an agent that is there; an agent that has left may still get messages.
    fn present_id(&self, agent: u32) -> Option<Id> {
        self.ids[agent as usize].filter(|_| self.current_position(agent).is_some())
    }
}

impl<V: Space> ScenarioStage for CrowdStage<V> {
    fn position(&self, agent: u32) -> Option<Vec3> {
        self.current_position(agent).map(V::to_world)
    }

    fn companions(&self, agent: u32) -> Range<u32> {
        let all = self.layout.companions_of(agent as usize);
        all.start as u32..all.end as u32
    }

    fn velocity(&self, agent: u32) -> Vec3 {
        let velocity = |id| self.crowd.velocity(id, self.crowd.time_s());
        self.ids[agent as usize].and_then(velocity).unwrap_or_default()
    }

    fn order_walk(&mut self, agent: u32, at: Vec3, arrival_m: f32, leaves: bool) -> Result<bool> {
        let then = if leaves { AtEnd::Leave } else { AtEnd::Stay };
        let from = self.current_position(agent);
        let goes = self.order(agent, AgentOrder::to_goal(at).with_arrival(arrival_m).then_at_end(then))?;
        if let (true, Some(from)) = (goes, from) {
            let path = &mut self.layout.paths[agent as usize];
            path.clear();
            path.extend([from, V::from_world(at)]);
            self.layout.arrivals[agent as usize] = arrival_m;
        }
        Ok(goes)
    }

    fn order_route(&mut self, agent: u32, points: &[Vec3], again: bool, begin: Option<u32>) -> Result<bool> {
        let then = if again { AtEnd::Again } else { AtEnd::Stay };
        if let Some(from) = self.current_position(agent) {
            let path = &mut self.layout.paths[agent as usize];
            path.clear();
            // Rounds have no end to which a path leads.
            if !again {
                path.extend(std::iter::once(from).chain(points.iter().map(|p| V::from_world(*p))));
            }
            self.layout.arrivals[agent as usize] = 1.0;
        }
        let begin = begin.map_or(RouteBegin::Nearest, RouteBegin::Leg);
        let order = AgentOrder::along_subgoals(points.to_vec()).with_arrival(1.0).then_at_end(then);
        self.order(agent, order.beginning_at(begin))
    }

    fn route_leg(&self, agent: u32) -> u32 {
        self.present_id(agent).and_then(|id| self.crowd.route_leg(id)).unwrap_or(0)
    }

    fn follow_happening(&mut self, agent: u32, happening: u16) -> Result<()> {
        let m = agent as usize;
        let Some(from) = self.current_position(agent) else { return Ok(()) };
        let scene = Arc::clone(&self.layout.scene);
        let h = &scene.happenings[usize::from(happening)];
        let Route { subgoals, arrival_radius, at_end } = self.layout.new_path(m, from, h)?.map(V::to_world);
        self.ordered_happenings[m] = Some(happening);
        if let Some(speed) = h.speed_mps {
            self.set_speed(agent, speed)?;
        }
        let order = AgentOrder::along_subgoals(subgoals).with_arrival(arrival_radius).then_at_end(at_end);
        self.order(agent, order).map(|_| ())
    }

    fn resume_route(&mut self, agent: u32) -> Result<()> {
        match (self.ordered_happenings[agent as usize], self.layout.setup.agents[agent as usize].route) {
            (Some(happening), _) => self.follow_happening(agent, happening),
            (None, Some(route)) => self.order(agent, AgentOrder::on_route(route)).map(|_| ()),
            (None, None) => Ok(()),
        }
    }

    fn order_halt(&mut self, agent: u32) -> Result<()> {
        let Some(id) = self.present_id(agent) else { return Ok(()) };
        let now = self.crowd.time_s();
        let motion = self.crowd.position(id, now).zip(self.crowd.velocity(id, now));
        let Some((from, velocity)) = motion else { return Ok(()) };
        let ahead = velocity * HALT_S;
        self.order_walk(agent, from + ahead, ahead.length().max(0.3), false).map(|_| ())
    }

    fn set_speed(&mut self, agent: u32, speed_mps: f32) -> Result<()> {
        let Some(id) = self.present_id(agent) else { return Ok(()) };
        let most = self.layout.setup.config.largest_speed_mps;
        self.crowd.set_speed(id, speed_mps.min(most)).map_err(|e| self.layout.explain_crowd_error(&e))
    }

    fn show_activity(&mut self, agent: u32, motion: Option<u16>, faces: Option<Vec3>) {
        self.shown[agent as usize] = BodyActivity { motion, faces, ..BodyActivity::default() };
    }

    fn show_gesture(&mut self, agent: u32, gesture: Option<ShownGesture>) {
        self.gestures[agent as usize] = gesture;
    }

    fn face_agent(&mut self, agent: u32, other: u32) {
        self.shown[agent as usize].other = Some(other);
    }

    fn sees(&self, from: Vec3, to: Vec3, clearance_m: f32, through_doors: bool) -> bool {
        self.crowd.sees(from, to, clearance_m, through_doors)
    }

    fn thing_position(&self, thing: u16) -> Vec3 {
        self.things.all[usize::from(thing)].at
    }

    fn has_in_hand(&self, agent: u32, thing: u16) -> bool {
        self.things.all[usize::from(thing)].keeper == Some(agent)
    }

    fn stance(&self, agent: u32, motion: Option<u16>, handling: Handling, side: u32) -> Result<Stance, StanceError> {
        self.things.stance(self.handler(agent, motion), handling, side)
    }

    fn begin_handling(&mut self, agent: u32, motion: Option<u16>, handling: Handling) {
        let begun = self.things.begin_handling(self.handler(agent, motion), handling);
        self.shown[agent as usize] = begun.unwrap_or_default();
    }

    fn end_handling(&mut self, agent: u32, thing: u16, is_done: bool) -> bool {
        self.things.end_handling(agent, thing, is_done)
    }

    fn count_miss(&mut self) {
        self.things.counts.missed += 1;
    }

    fn is_handling_over(&self, agent: u32, thing: u16) -> bool {
        self.things.is_handling_over(agent, thing)
    }

    fn drop_thing(&mut self, thing: u16) {
        self.things.drop_thing(thing);
    }

    fn set_door_open(&mut self, door: u16, open: bool) -> Result<bool> {
        let obstacle = self.layout.first_door + usize::from(door);
        if !open && self.crowd.is_reserved(&self.layout.scene.environment.door_wall(usize::from(door))) {
            return Ok(false);
        }
        match self.crowd.set_open(obstacle, open) {
            Ok(()) => Ok(true),
            Err(CrowdError::Inside { .. }) => Ok(false),
            Err(e) => Err(self.layout.explain_crowd_error(&e)),
        }
    }

    fn enter_agent(&mut self, agent: u32) -> Result<bool> {
        for k in 0..TRIES {
            let mut start = self.layout.setup.agents[agent as usize];
            start.position = self.layout.entrance(agent as usize, k as u32 + 16 * self.sent[agent as usize]);
            let spawned = self.crowd.spawn(start.map(V::to_world));
            if let Err(e) = &spawned
                && !matches!(e, CrowdError::Overlap { .. } | CrowdError::Inside { .. })
            {
                return Err(self.layout.explain_crowd_error(e));
            }
            if let Ok(id) = spawned {
                self.ids[agent as usize] = Some(id);
                self.agent_of[id.index()] = agent;
                self.newcomers.push(agent);
                (self.ordered_happenings[agent as usize], self.shown[agent as usize]) = (None, BodyActivity::default());
                self.gestures[agent as usize] = None;
                self.layout.paths[agent as usize].clear();
                self.layout.paths[agent as usize].push(start.position);
                self.sent[agent as usize] = 0;
                self.join_companions(agent)?;
                return Ok(true);
            }
        }
        self.sent[agent as usize] += 1;
        Ok(false)
    }

    fn set_senses(&mut self, agent: u32, sends: u32, receives: u32) -> Result<()> {
        let Some(id) = self.present_id(agent) else { return Ok(()) };
        // Meetings count when two come near, or one of them begins there; news pass wherever two are.
        let (before, since) = self.crowd.senses(id);
        let begins = before == Sense::default() || before.once == 0 && since == self.crowd.time_s();
        let once = if begins { 0 } else { 1 << 31 };
        let (zones, cells) = (self.layout.senses_zones, self.layout.senses_cells);
        let sense = Sense { sends, receives, once, zones, cells, arrivals: true };
        self.crowd.set_senses(id, sense).map_err(|e| self.layout.explain_crowd_error(&e))
    }

    fn set_timer(&mut self, agent: u32, time_s: Option<f64>) -> Result<()> {
        let Some(id) = self.present_id(agent) else { return Ok(()) };
        let now = self.crowd.time_s();
        self.crowd.set_timer(id, time_s.map(|t| t.max(now))).map_err(|e| self.layout.explain_crowd_error(&e))
    }

    fn set_interest(&mut self, agent: u32, n: usize, interest: Option<(Vec3, f32, f32)>) -> Result<()> {
        let Some(id) = self.present_id(agent) else { return Ok(()) };
        let interest =
            interest.map(|(at, strength, reach)| PersonalInterest { at: InterestLocation::Place(at), strength, reach });
        self.crowd.set_interest(id, n, interest).map_err(|e| self.layout.explain_crowd_error(&e))
    }

    fn agents_within(&self, at: Vec3, radius_m: f32, out: &mut Vec<u32>) {
        let is_near = |m: &u32| self.position(*m).is_some_and(|p| p.distance_squared(at) <= radius_m * radius_m);
        out.extend((0..self.ids.len() as u32).filter(is_near));
    }
}
