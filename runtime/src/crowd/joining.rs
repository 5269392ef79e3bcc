//! Who comes into the crowd, leaves it, and is sent elsewhere.

use super::decide::{Cause, Mind};
use super::filter::Filter;
use super::others::lack;
use super::plan::Plan;
use super::safety::{Candidate, MARGIN, lack_of_solid, room};
use super::spline::Spline;
use super::tracing::Trace;
use super::world::{HURRY, check_member};
use super::{Crowd, CrowdError, Id, Member, NONE, Route, Space};

impl<V: Space> Crowd<V> {
    /// Lets somebody in, now.
    ///
    /// # Errors
    /// [`CrowdError`] where there is no room, nor for its settings; nothing has changed then.
    pub fn enter(&mut self, member: Member<V>) -> Result<Id, CrowdError> {
        let number = self.num_members();
        check_member(number, &member, self.world.splines.len(), self.world.fields.len())?;
        let value = |field, got, expected| CrowdError::Value { what: "member", index: number, field, got, expected };
        if member.radius > self.world.radius {
            return Err(value("radius", member.radius, "at most `largest_radius_m` of the config"));
        }
        let speed = member.speed.max(member.velocity.length() / HURRY);
        if speed > self.world.speed {
            return Err(value("speed", speed, "at most `largest_speed_mps` of the config"));
        }
        let fastest = HURRY * self.world.speed;
        if fastest * fastest > 2.0 * member.acceleration * self.world.stopping * 1.001 {
            return Err(value("acceleration", member.acceleration, "at least that of the weakest at the start"));
        }
        self.trace.check(number, &member, self.cells.side(), self.world.interval)?;
        let Some(&index) = self.free.last() else {
            return Err(CrowdError::Full { capacity: self.minds.len() });
        };
        let plan = Plan {
            start: self.now,
            end: self.now,
            position: member.position,
            velocity: member.velocity,
            acceleration: V::default(),
            moving: f32::INFINITY,
            radius: member.radius,
            limit: member.acceleration,
            index,
        };
        self.world.check_place(number, member.position)?;
        self.check_room(&plan)?;
        self.free.pop();
        let cell = self.cells.number(self.cells.coordinates(member.position));
        let spline = &self.world.splines[member.route];
        let cursor = spline.begin(member.position);
        let mind = &mut self.minds[index as usize];
        *mind = Mind {
            route: member.route as u32,
            field: member.field as u32,
            generation: mind.generation,
            cell,
            speed: member.speed,
            cursor,
            filter: Filter { velocity: member.velocity, variance: 0.0 },
            cause: Cause::Region,
            least_left: spline.left(cursor, member.position),
            got_on: self.now,
            intent: (spline.ahead(cursor, self.world.fields[member.field].look_ahead_m) - member.position)
                .unit_and_length()
                .0,
            is_there: false,
            is_stuck: false,
            is_struck: false,
        };
        self.cells.insert(cell, &plan);
        self.watchdog.forget(index);
        self.queue.set(index, self.now);
        if let Trace::Occupancy(occupancy) = &mut self.trace {
            occupancy.list(&self.cells, &plan);
        }
        Ok(Id { index, generation: self.minds[index as usize].generation })
    }

    /// There is room for somebody, who may brake at once.
    fn check_room(&self, plan: &Plan<V>) -> Result<(), CrowdError> {
        let at = self.cells.coordinates(plan.position);
        let candidate = Candidate::new(*plan);
        let mut error = None;
        self.cells.around(at, |cell| {
            self.cells.each(cell, |other| {
                // Two who could brake at once need no more than to be apart.
                let room = if other.end <= self.now {
                    room(plan, other) - MARGIN
                } else {
                    lack(&candidate, other).map_or(1.0, |l| -l.lack)
                };
                if room < 0.0 {
                    let (first, second) = (other.index as usize, plan.index as usize);
                    error = Some(CrowdError::Overlap { first, second, overlap_m: -room });
                }
            });
        });
        for &s in self.world.near(self.cells.number(at)) {
            if lack_of_solid(&candidate, &self.world.solids[s as usize]).is_some() {
                let obstacle = self.world.owners[s as usize] as usize;
                error = Some(CrowdError::Inside { member: plan.index as usize, obstacle });
            }
        }
        error.map_or(Ok(()), Err)
    }

    /// Takes somebody out, now.
    ///
    /// # Errors
    /// [`CrowdError::Gone`].
    pub fn leave(&mut self, id: Id) -> Result<(), CrowdError> {
        self.check_id(id)?;
        self.take_out(id.index);
        self.free.push(id.index);
        let mut trace = std::mem::take(&mut self.trace);
        if let Trace::Occupancy(occupancy) = &mut trace {
            self.forget(occupancy, id.index, &mut |_| ());
        }
        self.trace = trace;
        Ok(())
    }

    /// Another route for members to come, or for [`Crowd::send`]; its number.
    ///
    /// # Errors
    /// [`CrowdError`] for a route that cannot be.
    pub fn add_route(&mut self, route: Route<V>) -> Result<usize, CrowdError> {
        let number = self.world.splines.len();
        let spline = Spline::new(number, &route)?;
        self.world.check_route(number, &spline)?;
        self.world.splines.push(spline);
        Ok(number)
    }

    /// Gives a member another route and desired speed from its next event on.
    ///
    /// # Errors
    /// [`CrowdError::Gone`], [`CrowdError::Index`], [`CrowdError::Value`].
    pub fn send(&mut self, id: Id, route: usize, speed: f32) -> Result<(), CrowdError> {
        self.check_id(id)?;
        let Some(spline) = self.world.splines.get(route) else {
            return Err(CrowdError::Index { what: "route", got: route, limit: self.world.splines.len() });
        };
        self.check_speed(id, speed)?;
        let (position, _) = self.cells.plan(id.index).at(self.now);
        let mind = &mut self.minds[id.index()];
        mind.cursor = if mind.route == route as u32 { mind.cursor } else { spline.begin(position) };
        (mind.route, mind.speed) = (route as u32, speed);
        (mind.least_left, mind.got_on) = (spline.left(mind.cursor, position), self.now);
        (mind.is_there, mind.is_stuck) = (false, false);
        Ok(())
    }

    /// Gives a member a route of its own and another desired speed from its next event on, as [`Crowd::add_route`] and
    /// [`Crowd::send`] do. It takes the place of the last one that a member of that number was given so: memory does not
    /// grow however often they are sent.
    ///
    /// # Errors
    /// [`CrowdError`] as of both; nothing has changed then.
    pub fn send_along(&mut self, id: Id, route: Route<V>, speed: f32) -> Result<(), CrowdError> {
        self.check_id(id)?;
        self.check_speed(id, speed)?;
        let own = self.own[id.index()];
        let number = if own == NONE { self.world.splines.len() } else { own as usize };
        let spline = Spline::new(number, &route)?;
        self.world.check_route(number, &spline)?;
        if own == NONE {
            self.world.splines.push(spline);
        } else {
            self.world.splines[number] = spline;
        }
        self.own[id.index()] = number as u32;
        // Whatever route it was on before, it begins this one.
        self.minds[id.index()].route = NONE;
        self.send(id, number, speed)
    }

    fn check_speed(&self, id: Id, got: f32) -> Result<(), CrowdError> {
        if (0.0..=self.world.speed).contains(&got) {
            return Ok(());
        }
        let expected = "at most `largest_speed_mps` of the config";
        Err(CrowdError::Value { what: "member", index: id.index(), field: "speed", got, expected })
    }
}
