//! Entry, removal, displacement and orders of agents.

use crate::error::{CrowdError, Result, check};
use crate::events::decide::{AgentState, Cause};
use crate::routes::order::{AgentOrder, OrderDestination};
use crate::routes::path::{RouteCursor, RoutePath};
use crate::safety::nearby_plans::find_violation;
use crate::safety::rule::{MARGIN, PlanCandidate, clearance};
use crate::scenery::{CrowdScenery, Door, check_agent};
use crate::{Agent, AtEnd, Id, InterestLocation, NONE, Obstacle, PersonalInterest, Route, RouteBegin, Space};
use crate::{events::engine::Engine, space::plan::MotionPlan, steering::filter::VelocityFilter};
use glam::Vec3Swizzles;
use throng_base::{Error, error::check_index};

impl<V: Space> Engine<V> {
    /// Spawns an agent, now.
    ///
    /// # Errors
    /// [`CrowdError`] for a place that is taken, a full crowd, or a setting out of its range; nothing has changed then.
    pub fn spawn(&mut self, agent: Agent<V>) -> Result<Id> {
        let Some(&index) = self.free.last() else { return Err(Error::Full { capacity: self.states.len() }.into()) };
        let id = self.id(index);
        check_agent(id.index(), &agent, self.scenery.paths.len(), self.scenery.fields.len())?;
        agent.route.map_or(Ok(()), |route| self.check_shared(id, route))?;
        self.check_limits(id, &agent)?;
        let plan = self.standing_plan(index, agent.position, agent.velocity, agent.radius, agent.acceleration);
        self.scenery.check_place(id, agent.position)?;
        self.check_clearance(id, &plan)?;
        let route = agent.route.unwrap_or_else(|| self.stay_at(index, agent.position));
        self.free.pop();
        let cursor = self.begin_route(route, agent.position, agent.radius, RouteBegin::Nearest);
        self.states[index as usize] = AgentState {
            route: route as u32,
            field: agent.field as u32,
            generation: id.generation,
            cell: self.cells.number(self.cells.coordinates(agent.position)),
            speed: agent.speed,
            cursor,
            filter: VelocityFilter { velocity: agent.velocity, variance: 0.0 },
            cause: Cause::Region,
            least_left: self.scenery.paths[route].distance_left(&cursor, agent.position),
            progressed_at: self.now,
            intent: (cursor.aim - agent.position).unit_and_length().0,
            ..AgentState::default()
        };
        self.insert(&plan);
        Ok(id)
    }

    /// A plan of an agent that appears now, and decides at once.
    fn standing_plan(&self, index: u32, position: V, velocity: V, radius: f32, limit: f32) -> MotionPlan<V> {
        let (acceleration, moving) = (V::default(), f32::INFINITY);
        MotionPlan { start: self.now, end: self.now, position, velocity, acceleration, moving, radius, limit, index }
    }

    /// Registers the plan of an agent whose state is set.
    fn insert(&mut self, plan: &MotionPlan<V>) {
        self.cells.insert(self.states[plan.index as usize].cell, plan);
        self.watchdog.forget(plan.index);
        self.queue.set(plan.index, self.now);
        self.list(plan);
    }

    /// An agent is within what the crowd was made for.
    fn check_limits(&self, id: Id, agent: &Agent<V>) -> Result<()> {
        let (scenery, n) = (&self.scenery, id.index());
        let expected = "at most `largest_radius_m` of the config";
        check("agent.radius", n, agent.radius, agent.radius <= scenery.radius, expected)?;
        let speed = agent.speed.max(agent.velocity.length() / scenery.steering.largest_speed_ratio);
        check("agent.speed", n, speed, speed <= scenery.speed, "at most `largest_speed_mps` of the config")?;
        let stops = scenery.fastest * scenery.fastest <= 2.0 * agent.acceleration * scenery.stopping * 1.001;
        check(
            "agent.acceleration",
            n,
            agent.acceleration,
            stops,
            "at least that of the weakest at the start, or `least_acceleration_mps2` of the config",
        )?;
        self.check_occupancy(n, agent)
    }

    /// A route is not another agent's own, which leads elsewhere with its next order (the route exists).
    fn check_shared(&self, id: Id, route: usize) -> Result<()> {
        let good = [NONE, id.index].contains(&self.scenery.paths[route].owner);
        let expected = "one of the setup or of `add_route`; this one is another agent's own";
        Ok(throng_base::error::check_value("route", Some(id), route as f64, good, expected)?)
    }

    /// Checks that an agent that brakes at once overlaps nothing.
    fn check_clearance(&self, id: Id, plan: &MotionPlan<V>) -> Result<()> {
        let at = self.cells.coordinates(plan.position);
        let candidate = PlanCandidate::new(*plan);
        let mut error = None;
        self.cells.for_each_cell_around(at, |cell| {
            self.cells.for_each_in_cell(cell, |other| {
                if other.index == plan.index {
                    return;
                }
                // Two that could brake at once only have to be apart.
                let clearance = match other.end <= self.now {
                    true => clearance(plan, other) - MARGIN,
                    false => find_violation(&candidate, other).map_or(1.0, |v| -v.depth),
                };
                if clearance < 0.0 {
                    let first = self.id(other.index);
                    error = Some(CrowdError::Overlap { first, second: id, overlap_m: -clearance });
                }
            });
        });
        for &s in self.scenery.solids_near(self.cells.number(at)) {
            if candidate.violation_of_solid(&self.scenery.solids[s as usize]).is_some() {
                let obstacle = self.scenery.owners[s as usize] as usize;
                error = Some(CrowdError::Inside { agent: id, obstacle });
            }
        }
        self.external_obstacles.visit_reserved_near(&candidate.bounds(), |ground| {
            if candidate.reserved_region().intersects(ground) {
                let by = "somebody whom the crowd does not move".into();
                error = Some(Error::Occupied { who: id, by }.into());
            }
            true
        });
        error.map_or(Ok(()), Err)
    }

    /// Removes an agent, now.
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn despawn(&mut self, id: Id) -> Result<()> {
        self.check_id(id)?;
        self.take_out(id.index);
        self.free.push(id.index);
        self.unlist(id.index);
        Ok(())
    }

    /// Moves an agent elsewhere, at rest. It goes on with its order from there, or stays without one.
    ///
    /// # Errors
    /// [`CrowdError`] for a place that is taken or out of range, or from which no path leads to its goal; nothing has
    /// changed then.
    pub fn place(&mut self, id: Id, position: V) -> Result<()> {
        self.check_id(id)?;
        let good = position.is_finite() && position.length() <= 1e5;
        let far = f64::from(position.length());
        throng_base::error::check_value("position", Some(id), far, good, "finite and within 1e5 m")?;
        self.scenery.check_place(id, position)?;
        let old = self.cells.plan(id.index);
        let plan = self.standing_plan(id.index, position, V::default(), old.radius, old.limit);
        self.check_clearance(id, &plan)?;
        let state = self.states[id.index()];
        let path = &self.scenery.paths[state.route as usize];
        let is_own = state.route == self.own_routes[id.index()];
        if is_own && path.route.at_end == AtEnd::Stay && path.has_arrived(&state.cursor, old.motion_at(self.now).0) {
            self.stay_at(id.index, position);
        } else if let Some(&goal) = path.goals.last().filter(|_| is_own) {
            self.check_path(id, position, path.goal(), goal)?;
        }
        self.cells.remove(state.cell, id.index);
        self.unlist(id.index);
        let cursor = self.begin_route(state.route as usize, position, plan.radius, RouteBegin::Nearest);
        let left = self.scenery.paths[state.route as usize].distance_left(&cursor, position);
        let state = &mut self.states[id.index()];
        state.cell = self.cells.number(self.cells.coordinates(position));
        state.cursor = cursor;
        state.filter = VelocityFilter { velocity: V::default(), variance: 0.0 };
        (state.cause, state.is_struck) = (Cause::Region, false);
        (state.least_left, state.progressed_at) = (left, self.now);
        (state.is_there, state.is_stuck) = (false, false);
        (state.is_woken, state.goes_on) = (false, false);
        self.insert(&plan);
        Ok(())
    }

    /// Another route for agents to come; its number.
    ///
    /// # Errors
    /// [`CrowdError`] for a route that cannot be.
    pub fn add_route(&mut self, route: Route<V>) -> Result<usize> {
        let number = self.scenery.paths.len();
        let path = self.scenery.prepare_path(number, &route)?;
        self.scenery.paths.push(path);
        self.scenery.paths.reserve(self.spare.len());
        Ok(number)
    }

    /// Gives an agent an order, from its next event on.
    ///
    /// # Errors
    /// [`Error::NoPath`], and [`CrowdError`] for an impossible order; nothing has changed then.
    pub fn order(&mut self, id: Id, order: &AgentOrder<V>) -> Result<()> {
        self.check_id(id)?;
        let speed = order.speed_mps.unwrap_or(self.states[id.index()].speed);
        self.check_speed(id, speed)?;
        let plan = self.cells.plan(id.index);
        let position = plan.motion_at(self.now).0;
        let kept = self.states[id.index()];
        let on_route = &self.scenery.paths[kept.route as usize];
        // An agent that gets the same order again goes on; a single goal may be another one at the same place.
        let is_same = |subgoals: &Vec<V>| {
            let Route { subgoals: own, arrival_radius, at_end } = &on_route.route;
            on_route.owner == id.index && (own, *arrival_radius, *at_end) == (subgoals, order.arrival_m, order.at_end)
        };
        let is_on_it = match &order.destination {
            OrderDestination::Route(number) => kept.route as usize == *number,
            OrderDestination::AlongSubgoals(subgoals) => is_same(subgoals),
            OrderDestination::ToGoal(_) => false,
        };
        let number = match &order.destination {
            OrderDestination::AlongSubgoals(_) if is_on_it => kept.route as usize,
            OrderDestination::Route(number) => {
                check_index("route", Some(id), *number, self.scenery.paths.len())?;
                self.check_shared(id, *number)?;
                *number
            }
            OrderDestination::ToGoal(goal) => self.lead_agent_to(id, position, *goal, order.arrival_m, order.at_end)?,
            OrderDestination::AlongSubgoals(subgoals) => {
                let subgoals = subgoals.clone();
                let route = Route { subgoals, arrival_radius: order.arrival_m, at_end: order.at_end };
                self.set_own_route(id.index, &route)?
            }
        };
        let cursor = if is_on_it { kept.cursor } else { self.begin_route(number, position, plan.radius, order.begin) };
        let left = self.scenery.paths[number].distance_left(&cursor, position);
        let state = &mut self.states[id.index()];
        (state.cursor, state.route, state.speed) = (cursor, number as u32, speed);
        (state.least_left, state.progressed_at) = (left, self.now);
        (state.is_there, state.is_stuck) = (false, false);
        Ok(())
    }

    /// Opens an obstacle, or closes it.
    ///
    /// # Errors
    /// [`CrowdError::Inside`] with an agent that stands where it closes, or could not stop before it; nothing has changed then.
    pub fn set_open(&mut self, obstacle: usize, open: bool) -> Result<()> {
        check_index("obstacle", None, obstacle, self.scenery.obstacles.len())?;
        let stands = !matches!(self.scenery.obstacles[obstacle], Obstacle::Mover { .. });
        throng_base::error::check_value("obstacle", None, obstacle as f64, stands, "one that does not move")?;
        if self.scenery.is_open(obstacle) == open {
            return Ok(());
        }
        if !open {
            for agent in (0..self.states.len() as u32).filter(|&m| self.states[m as usize].cell != NONE) {
                let plan = self.cells.plan(agent);
                let is_clear = |s| crate::safety::saved_plans::is_clear_of(&plan, s, self.now);
                if !self.scenery.solids_of(obstacle).iter().all(is_clear) {
                    return Err(CrowdError::Inside { agent: self.id(agent), obstacle });
                }
            }
        }
        let mut doors = self.scenery.doors.clone();
        doors[obstacle] = if open { Door::Open } else { Door::Closed };
        self.scenery.set_doors(&doors, &self.cells)?;
        // Every agent plans its path again at its next event.
        self.states.iter_mut().for_each(|s| s.cursor.look_at = 0.0);
        Ok(())
    }

    /// Sets an interest that attracts or repels an agent, from its next event on.
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::Index`], [`Error::Value`].
    pub fn set_interest(&mut self, id: Id, n: usize, interest: Option<PersonalInterest<V>>) -> Result<()> {
        self.check_id(id)?;
        if let Some(PersonalInterest { at: InterestLocation::Agent(other), .. }) = interest {
            self.check_id(other)?;
        }
        self.relationships.set_interest(id, n, interest)
    }

    /// Lets agents walk together.
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::Value`].
    pub fn set_companions(&mut self, ids: &[Id]) -> Result<()> {
        ids.iter().try_for_each(|&id| self.check_id(id))?;
        self.relationships.set_companions(ids)
    }

    /// Desired speed of an agent from its next event on.
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::Value`].
    pub fn set_speed(&mut self, id: Id, speed: f32) -> Result<()> {
        self.check_id(id)?;
        self.check_speed(id, speed)?;
        self.states[id.index()].speed = speed;
        Ok(())
    }

    fn check_speed(&self, id: Id, speed: f32) -> Result<()> {
        let good = (0.0..=self.scenery.speed).contains(&speed);
        let expected = "at least 0, and at most `largest_speed_mps` of the config";
        Ok(throng_base::error::check_value("speed", Some(id), speed, good, expected)?)
    }

    /// Lets an agent act as soon as possible, once for each plan. Others rely on the plan: the agent keeps it where no
    /// other one is safe.
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn wake(&mut self, id: Id) -> Result<()> {
        self.check_id(id)?;
        if !self.is_of_registration() {
            return Ok(());
        }
        let plan = self.cells.plan(id.index);
        if let Some(time) = self.woken_at(&plan, self.now).filter(|_| !self.states[id.index()].goes_on) {
            self.states[id.index()].is_woken = true;
            self.queue.set(id.index, time);
        }
        Ok(())
    }

    /// Checks that a path leads from a place to a goal, as far as the crowd knows its streets.
    ///
    /// - `number`: that of the goal.
    fn check_path(&self, id: Id, from: V, goal: V, number: u32) -> Result<()> {
        let CrowdScenery { streets: Some(streets), goals, .. } = &self.scenery else { return Ok(()) };
        let (from, to) = (from.to_world(), goal.to_world());
        streets.check_path(from.xz(), goals.costs(number)).map_err(|_| Error::NoPath { who: Some(id), from, to }.into())
    }

    /// Sends an agent to a goal, on a route of its own. Allocates nothing where it has one. Returns its number.
    fn lead_agent_to(&mut self, id: Id, from: V, goal: V, arrival_m: f32, at_end: AtEnd) -> Result<usize> {
        let own = self.own_routes[id.index()];
        let number = if own == NONE { self.scenery.paths.len() } else { own as usize };
        RoutePath::check_goal(number, goal, arrival_m)?;
        let route = self.own_route(id.index, from);
        self.reserve_goal(route);
        let CrowdScenery { streets, goals, .. } = &mut self.scenery;
        let new = streets.as_ref().map(|s| goals.take_goal(s, goal.to_world()));
        let way = new.map_or(Ok(()), |new| self.check_path(id, from, goal, new));
        if let Err(refused) = way.and_then(|()| self.scenery.check_goal(number, 0, goal)) {
            new.into_iter().for_each(|new| self.scenery.goals.release(new));
            return Err(refused);
        }
        self.release_goals(route);
        let path = &mut self.scenery.paths[route];
        path.lead_to(goal, arrival_m, at_end);
        path.goals.extend(new);
        Ok(route)
    }

    /// Takes memory for a goal of an agent's own route, for its first one.
    fn reserve_goal(&mut self, route: usize) {
        let CrowdScenery { paths, goals, streets, .. } = &mut self.scenery;
        if let Some(streets) = streets.as_ref().filter(|_| paths[route].goals.capacity() == 0) {
            paths[route].goals.reserve(1);
            goals.reserve(streets);
        }
    }

    /// Forgets the goals of a route.
    fn release_goals(&mut self, number: usize) {
        let CrowdScenery { paths, goals, .. } = &mut self.scenery;
        paths[number].goals.drain(..).for_each(|g| goals.release(g));
    }

    /// Cursor of an agent at the start of a route.
    fn begin_route(&self, route: usize, x: V, radius: f32, begin: RouteBegin) -> RouteCursor<V> {
        let path = &self.scenery.paths[route];
        let mut cursor = path.begin_at(x, begin);
        path.pass_subgoals(&mut cursor, x);
        self.decider(self.now).guide().find_aim(path, &mut cursor, x, radius);
        cursor
    }

    /// Lets an agent stay at a place, on a route of its own. Returns its number.
    fn stay_at(&mut self, index: u32, at: V) -> usize {
        let number = self.own_route(index, at);
        self.release_goals(number);
        self.scenery.paths[number].set_stay(at);
        number
    }

    /// Number of the route that belongs to the place of an agent alone; at first, it stays.
    fn own_route(&mut self, index: u32, at: V) -> usize {
        let own = &mut self.own_routes[index as usize];
        if *own == NONE {
            *own = self.scenery.paths.len() as u32;
            let mut path = self.spare.pop().unwrap_or_else(|| RoutePath::stay_path(at));
            path.owner = index;
            self.scenery.paths.push(path);
        }
        *own as usize
    }

    /// Takes memory for the first routes of agents to come.
    pub fn fill_spare(&mut self) {
        let missing = self.own_routes.iter().take(self.room).filter(|&&own| own == NONE).count();
        self.spare.resize_with(missing, || RoutePath::stay_path(V::default()));
        self.scenery.paths.reserve(missing);
    }

    /// Gives an agent a route of its own, which replaces the last one of its place: memory does not grow, however often
    /// agents are sent. Returns its number.
    fn set_own_route(&mut self, index: u32, route: &Route<V>) -> Result<usize> {
        let own = self.own_routes[index as usize];
        let number = if own == NONE { self.scenery.paths.len() } else { own as usize };
        let mut path = self.scenery.prepare_path(number, route)?;
        path.owner = index;
        let number = self.own_route(index, V::default());
        self.reserve_goal(number);
        self.release_goals(number);
        self.scenery.paths[number] = path;
        Ok(number)
    }
}
