//! What can be asked of a crowd between its events.

use super::bound::Bound;
use super::decide::{Decider, Scratch};
use super::{Counts, Crowd, Forces, Id, Member, NONE, Space};
use crate::crowd::plan::Plan;

impl<V: Space> Crowd<V> {
    /// The present. [Unit: s]
    pub fn now(&self) -> f64 {
        self.now
    }

    /// Everybody in the crowd, in the order of their numbers.
    pub fn ids(&self) -> impl Iterator<Item = Id> + '_ {
        let there = (0u32..).zip(&self.minds).filter(|(_, m)| m.cell != NONE);
        there.map(|(index, m)| Id { index, generation: m.generation })
    }

    /// Number of members.
    pub fn num_members(&self) -> usize {
        self.minds.len() - self.free.len()
    }

    fn plan(&self, id: Id) -> Option<Plan<V>> {
        self.check_id(id).is_ok().then(|| self.cells.plan(id.index))
    }

    /// What a member is; position and velocity are those of now.
    pub fn member(&self, id: Id) -> Option<Member<V>> {
        let plan = self.plan(id)?;
        let mind = &self.minds[id.index()];
        let (position, velocity) = plan.at(self.now);
        Some(Member {
            position,
            velocity,
            radius: plan.radius,
            acceleration: plan.limit,
            speed: mind.speed,
            route: mind.route as usize,
            field: mind.field as usize,
        })
    }

    /// Where a member is at `time_s`: exact from its last event to its next one, and a guess before and after. [Unit:
    /// m]
    pub fn position(&self, id: Id, time_s: f64) -> Option<V> {
        self.plan(id).map(|p| p.at(time_s).0)
    }

    /// How it moves at `time_s`. [Unit: m/s]
    pub fn velocity(&self, id: Id, time_s: f64) -> Option<V> {
        self.plan(id).map(|p| p.at(time_s).1)
    }

    /// Its velocity as a Kalman filter saw it at its last event, without abrupt changes: what a motion is to follow
    /// (001 section 2.1). [Unit: m/s]
    pub fn smooth_velocity(&self, id: Id) -> Option<V> {
        self.check_id(id).is_ok().then(|| self.minds[id.index()].filter.velocity)
    }

    /// Its acceleration at `time_s`. [Unit: m/s2]
    pub fn acceleration(&self, id: Id, time_s: f64) -> Option<V> {
        let plan = self.plan(id)?;
        let moves = ((time_s - plan.start) as f32) < plan.moving;
        Some(if moves { plan.acceleration } else { V::default() })
    }

    /// Its time-varying bound at `time_s`: centre and radius (001 eq. 3 and 4). [Unit: m] [Limit: from its last event
    /// on]
    pub fn bound(&self, id: Id, time_s: f64) -> Option<(V, f32)> {
        self.plan(id).map(|p| Bound::from(&p).at(time_s))
    }

    /// When it acts next, unless somebody makes it act before. [Unit: s]
    pub fn next_event(&self, id: Id) -> Option<f64> {
        self.plan(id).map(|p| p.end)
    }

    /// When it acted last. [Unit: s]
    pub fn last_event(&self, id: Id) -> Option<f64> {
        self.plan(id).map(|p| p.start)
    }

    /// Both ends of the way that its centre takes if it brakes now with all its force. [Unit: m]
    pub fn stop_region(&self, id: Id) -> Option<(V, V)> {
        self.plan(id).map(|p| p.stop_region((self.now - p.start) as f32))
    }

    /// Way along its route that is left. [Unit: m]
    pub fn way_left(&self, id: Id) -> Option<f32> {
        let plan = self.plan(id)?;
        let mind = &self.minds[id.index()];
        let (position, spline) = (plan.at(self.now).0, &self.world.splines[mind.route as usize]);
        let mut cursor = mind.cursor;
        spline.follow(&mut cursor, position, self.world.fields[mind.field as usize].look_ahead_m);
        Some(spline.left(cursor, position))
    }

    /// Unit vector in which it wants to go now; zero where it is at its goal.
    pub fn desired_direction(&self, id: Id) -> Option<V> {
        let plan = self.plan(id)?;
        let (position, velocity) = plan.at(self.now);
        Some(self.decider(self.now).walker(&self.minds[id.index()], &plan, position, velocity).desired)
    }

    /// What moves it now, term by term. Computed anew, and allocates: for one who is looked at.
    pub fn forces(&self, id: Id) -> Option<Forces<V>> {
        self.check_id(id).ok()?;
        Some(self.decider(self.now).forces(id.index, &mut Scratch::default()))
    }

    /// How many events there were.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// What a member may look at.
    pub(super) fn decider(&self, time: f64) -> Decider<'_, V> {
        let Self { world, cells, minds, flow, .. } = self;
        Decider { world, cells, minds, flow, time }
    }
}
