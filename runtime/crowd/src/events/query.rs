//! Queries of a crowd between its events.

use crate::events::decide::{Decider, DecisionScratch};
use crate::{Agent, AtEnd, Forces, Id, NONE, Space, steering::relationships::MOST_COMPANIONS};
use crate::{events::engine::Engine, routes::order::AgentStatus, safety::bound::Bound, space::plan::MotionPlan};

impl<V: Space> Engine<V> {
    /// Bytes that an agent takes, beside its route: those of one place of all vectors that are as long as the crowd.
    pub fn bytes_per_agent(&self) -> usize {
        size_of::<crate::events::decide::AgentState<V>>()
            + size_of::<crate::space::cells::PackedPlan>()
            + size_of::<crate::senses::SensingState>()
            + crate::events::queue::Calendar::BYTES_EACH
            + size_of::<[u32; 2]>()
    }

    pub fn ids(&self) -> impl Iterator<Item = Id> + '_ {
        let there = (0u32..).zip(&self.states).filter(|(_, s)| s.cell != NONE);
        there.map(|(index, s)| Id { index, generation: s.generation })
    }

    pub fn num_agents(&self) -> usize {
        self.states.len() - self.free.len()
    }

    pub fn plan(&self, id: Id) -> Option<MotionPlan<V>> {
        self.check_id(id).is_ok().then(|| self.cells.plan(id.index))
    }

    pub fn agent(&self, id: Id) -> Option<Agent<V>> {
        let plan = self.plan(id)?;
        let state = &self.states[id.index()];
        let (position, velocity) = plan.motion_at(self.now);
        let (radius, route, field) = (plan.radius, Some(state.route as usize), state.field as usize);
        Some(Agent { position, velocity, radius, acceleration: plan.limit, speed: state.speed, route, field })
    }

    pub fn smooth_velocity(&self, id: Id) -> Option<V> {
        self.check_id(id).is_ok().then(|| self.states[id.index()].filter.velocity)
    }

    pub fn acceleration(&self, id: Id, time_s: f64) -> Option<V> {
        let plan = self.plan(id)?;
        let moves = ((time_s - plan.start) as f32) < plan.moving;
        Some(if moves { plan.acceleration } else { V::default() })
    }

    pub fn bound(&self, id: Id, time_s: f64) -> Option<(V, f32)> {
        self.plan(id).map(|p| Bound::from(&p).disc_at(time_s))
    }

    pub fn distance_left(&self, id: Id) -> Option<f32> {
        let plan = self.plan(id)?;
        let state = &self.states[id.index()];
        let (position, path) = (plan.motion_at(self.now).0, &self.scenery.paths[state.route as usize]);
        Some(path.distance_left(&state.cursor, position))
    }

    pub fn desired_direction(&self, id: Id) -> Option<V> {
        let plan = self.plan(id)?;
        let (position, velocity) = plan.motion_at(self.now);
        Some(self.decider(self.now).walker(&self.states[id.index()], &plan, position, velocity).desired)
    }

    pub fn forces(&self, id: Id) -> Option<Forces<V>> {
        self.check_id(id).ok()?;
        Some(self.decider(self.now).forces(id.index, &mut DecisionScratch::default()))
    }

    pub fn route_leg(&self, id: Id) -> Option<u32> {
        self.check_id(id).ok()?;
        Some(self.states[id.index()].cursor.leg)
    }

    pub fn status(&self, id: Id) -> Option<AgentStatus> {
        let left_m = self.distance_left(id)?;
        let state = &self.states[id.index()];
        let position = self.cells.plan(id.index).motion_at(self.now).0;
        let path = &self.scenery.paths[state.route as usize];
        let is_kept_near = state.is_there && path.route.at_end == AtEnd::Stay;
        Some(if is_kept_near || path.has_arrived(&state.cursor, position) {
            AgentStatus::Arrived
        } else if state.is_stuck {
            AgentStatus::Blocked { by: self.in_front_of(id, position) }
        } else {
            AgentStatus::Going { left_m }
        })
    }

    pub fn waits(&self, id: Id) -> bool {
        self.check_id(id).is_ok() && self.states[id.index()].waits
    }

    /// Companions of an agent.
    pub fn companions(&self, id: Id) -> [Option<Id>; MOST_COMPANIONS] {
        let relationship = self.relationships.relationships_of(id.index).filter(|_| self.check_id(id).is_ok());
        let companions = relationship.map_or([NONE; MOST_COMPANIONS], |b| b.companions);
        companions.map(|c| Some(c).filter(|&c| c != NONE).map(|c| self.id(c)))
    }

    /// Nearest agent in front of another one, in its own cell or one next to it.
    fn in_front_of(&self, id: Id, position: V) -> Option<Id> {
        let ahead = self.desired_direction(id)?;
        let mut nearest = (f32::INFINITY, None);
        self.cells.for_each_cell_around(self.cells.coordinates(position), |cell| {
            self.cells.for_each_in_cell(cell, |other| {
                let (toward, distance) = (other.motion_at(self.now).0 - position).unit_and_length();
                // Within 60 degrees of where it wants to go.
                if other.index != id.index && toward.dot(ahead) > 0.5 && distance < nearest.0 {
                    nearest = (distance, Some(self.id(other.index)));
                }
            });
        });
        nearest.1
    }

    /// Decider with all data that a decision may read.
    pub fn decider(&self, time: f64) -> Decider<'_, V> {
        let Self { scenery, cells, states, grid, turns, external_obstacles, relationships, .. } = self;
        Decider { scenery, cells, states, grid, turns, external_obstacles, relationships, time }
    }
}
