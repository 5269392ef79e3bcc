//! Decision of an agent at its event.

use super::safety::PlanAim;
use crate::events::schemes::{FirstContact, SchemeRef};
use crate::routes::passages::{PassageAdvice, PassageTurns};
use crate::routes::path::{OPEN_M, RouteCursor};
use crate::steering::company::{Companion, GroupAhead, companion_force};
use crate::steering::forces::{ForceSurroundings, SteeredAgent, contact_horizon, felt_within, sum_forces};
use crate::steering::keep_right::between_walls;
use crate::steering::neighbours::{NeighbourQuery, NeighbourRows, PerceptionLimits};
use crate::steering::relationships::{MOST_COMPANIONS, RelationshipTable};
use crate::steering::retreat::{BlockedAgent, CorridorHalf};
use crate::steering::sight::{ROUNDING, SeenNeighbour};
use crate::{AtEnd, Forces, NONE, Space, space::plan::MotionPlan, steering::far_field::oncoming};
use crate::{routes::guide::Guide, safety::bound::Bound, scenery::CrowdScenery, space::cells::CellGrid};
use crate::{safety::nearby_plans::NearbyPlans, steering::density_grid::DensityGrid, steering::filter::VelocityFilter};
use serde::{Deserialize, Serialize};
use throng_base::{ground::ExternalObstacles, simd::LANES, thresholds::RUNS_MPS};
use throng_geometry::Bounds2d;

/// Longest plan of an agent near an external obstacle, whose motion may change at any time (s).
const DECIDE_AGAIN_S: f32 = 0.25;

/// Longest plan of an agent that walks together with others (s).
const TOGETHER_S: f32 = 0.4;

/// Factor on the braking distance: an agent begins to brake this much earlier.
const BRAKES_EARLY: f32 = 1.1;
/// Longest plan while braking, as a share of the braking time: longer ones would pass the goal.
const BRAKING_PLANS: f32 = 0.5;

/// Forces that add up to more than this count no more than this (m/s^2).
const STRONGEST_MPS2: f32 = 5.0;

/// Distance from a closed door within which an agent waits for it to open (m).
pub(crate) const BEFORE_DOOR_M: f32 = 8.0;
/// Room behind another one who waits for it (m).
const BEHIND_M: f32 = 0.5;
/// Difference between velocity and desired velocity of a runner from which plans are short, as a share of the latter.
const TURNS_FROM: f32 = 0.5;
/// Share of the acceleration with which a speed is chosen to turn to a point, and the least such speed (m/s).
const TURNING_SHARE: f32 = 0.16;
const CREEPS_MPS: f32 = 0.3;
/// Longest plan of an agent that waits before a passage (s).
const WAITING_S: f32 = 0.5;

/// Time without progress after which an agent arrives behind others who stand at its goal (s).
const SETTLES_S: f64 = 0.6;
/// Room between such an agent and the one before it; it stays as long as that is no larger than the second (m).
const SETTLES_WITHIN_M: [f32; 2] = [0.5, 0.8];
/// Distance of goals that are one (m).
pub(crate) const SAME_GOAL_M: f32 = 0.05;

/// Cause of an agent's next event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Cause {
    /// The bound leaves its region.
    #[default]
    Region,
    /// The bound touches that of an agent.
    Agent(u32),
    /// The bound touches an obstacle.
    Obstacle(u32),
}

/// State of an agent beside its plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct AgentState<V> {
    pub route: u32,
    pub field: u32,
    pub generation: u32,
    /// Cell that it is registered in; [`NONE`] for a free place.
    pub cell: u32,
    pub speed: f32,
    pub cursor: RouteCursor<V>,
    pub filter: VelocityFilter<V>,
    pub cause: Cause,
    /// Shortest distance left along the route since it stepped back last (m).
    pub least_left: f32,
    /// Time at which it last made progress (s).
    pub progressed_at: f64,
    /// Unit vector along which it wants to go, as others see it; zero at its goal.
    pub intent: V,
    pub is_there: bool,
    pub is_stuck: bool,
    /// True where it waits before a closed door, or for its turn at a passage.
    pub waits: bool,
    /// Number of the closed door on its way, or 0.
    pub door: u8,
    /// A moving obstacle is in its place.
    pub is_struck: bool,
    /// True where it acts before its plan ends, see `Engine::woken_at`.
    pub is_woken: bool,
    /// True where it keeps its plan to its end, as it was woken and found no other safe one.
    pub goes_on: bool,
}

/// Scratch memory of decisions, one for each thread.
#[derive(Clone, Debug, Default)]
pub(crate) struct DecisionScratch<V> {
    /// For the numbers of neighbours.
    room: Vec<u32>,
    seen: Vec<SeenNeighbour<V>>,
    pub rows: NeighbourRows,
    /// Plans that may be in conflict with the agent's.
    pub(super) others: NearbyPlans,
}

impl<V: Space> DecisionScratch<V> {
    pub fn new(capacity: usize, num_movers: usize) -> Self {
        let most = capacity + num_movers;
        let (room, rows) = (CellGrid::<V>::agent_buffer(capacity), NeighbourRows::new(capacity.div_ceil(LANES)));
        Self { room, seen: Vec::with_capacity(most), rows, others: NearbyPlans::new(most) }
    }
}

/// The result of an event.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decision<V> {
    pub plan: MotionPlan<V>,
    pub state: AgentState<V>,
    pub leaves: bool,
    /// Moving obstacle that is in its place.
    pub struck_by: u32,
}

/// Desired motion of an agent by the force field, before the safety rule.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DesiredMotion<V> {
    pub state: AgentState<V>,
    /// A plan from now on that has no end and no acceleration of its own yet.
    pub fresh: MotionPlan<V>,
    pub forces: Forces<V>,
    /// Region around its cell, which it must not leave.
    pub region: (V, V),
    /// First contact of its bound with that of another agent.
    pub meeting: FirstContact<V>,
    /// Longest plan: near its goal, not so long that it would pass it (s).
    pub longest: f32,
}

/// Decides for agents at a time; holds all that a decision may read.
pub(crate) struct Decider<'a, V> {
    pub scenery: &'a CrowdScenery<V>,
    pub cells: &'a CellGrid<V>,
    pub states: &'a [AgentState<V>],
    pub grid: &'a DensityGrid<V>,
    pub turns: &'a PassageTurns,
    pub external_obstacles: &'a ExternalObstacles,
    pub relationships: &'a RelationshipTable<V>,
    pub time: f64,
}

impl<V: Space> Decider<'_, V> {
    /// Desired motion of an agent by the force field; with a scheme, also collects the inputs of a plan.
    pub fn desired_motion(
        &self,
        agent: u32,
        scheme: Option<SchemeRef<'_>>,
        scratch: &mut DecisionScratch<V>,
    ) -> DesiredMotion<V> {
        let old = self.cells.plan(agent);
        let (position, velocity) = old.motion_at(self.time);
        let mut state = self.states[agent as usize];
        self.update(&mut state, &old, position, velocity);
        let mut walker = self.walker(&state, &old, position, velocity);
        if self.is_kept_from_goal(agent, &state, &walker, &mut scratch.room) {
            // Who stands nearer to the goal keeps it from going on: it has come as near as it can.
            (walker.speed, state.is_there, state.is_stuck) = (0.0, true, false);
            (state.progressed_at, state.least_left) = (self.time, walker.distance_left);
        }
        state.intent = if state.is_there { V::default() } else { walker.desired };
        state.waits = self.take_turns(agent, &mut state, &mut walker, &mut scratch.room);
        let is_together = self.keep_company(agent, &state, &mut walker);
        let at = self.cells.coordinates(position);
        state.cell = self.cells.number(at);
        let (centre, half) = (self.cells.centre(at), V::from_coordinates([self.cells.side; 3]));
        let region = (centre - half, centre + half);
        let fresh = MotionPlan { start: self.time, position, velocity, moving: f32::INFINITY, ..old };
        let mut meeting = FirstContact::new(&fresh, scheme.map(|_| region));
        self.find_neighbours(agent, at, &walker, &state, scheme.map(|t| (t, &mut meeting)), scratch);
        let sees_external_obstacles = self.sees_external_obstacles(&walker, scratch);
        let CrowdScenery { fields, solids, interests, steering, .. } = self.scenery;
        let (near, walls) = (self.scenery.solids_near(state.cell), self.scenery.walls_seen(state.cell));
        let around =
            ForceSurroundings { seen: &scratch.seen, solids, near, walls, grid: self.grid, interests, steering };
        let mut forces = sum_forces(&walker, &fields[state.field as usize], &around);
        forces.interaction += self.relationships.interest_acceleration(agent, position, |id| {
            let other = &self.states[id.index()];
            let is_there = other.cell != NONE && other.generation == id.generation;
            is_there.then(|| self.cells.plan(id.index).motion_at(self.time).0)
        });
        let slow = steering.slow_mps;
        let soon = 2.0 * fields[state.field as usize].relaxation_s;
        let fast = velocity.length();
        // Until it has to slow down for its goal: a longer plan would pass it.
        let until_slow = (walker.distance_left - BRAKES_EARLY * soon * state.speed) / fast.max(slow);
        let longest = match (fast > slow, until_slow > 0.0) {
            (false, _) => f32::INFINITY,
            (true, true) => until_slow,
            (true, false) => BRAKING_PLANS * soon,
        };
        let longest = if sees_external_obstacles { longest.min(DECIDE_AGAIN_S) } else { longest };
        let longest = if is_together { longest.min(TOGETHER_S) } else { longest };
        let longest = if state.waits { longest.min(WAITING_S) } else { longest };
        // A long plan takes little of the acceleration: a runner who turns or sets off acts again soon.
        let error = (walker.desired * walker.speed - velocity).length();
        let turns = state.speed > RUNS_MPS[0] && error > TURNS_FROM * walker.speed.max(0.6 * state.speed);
        let longest = if turns { longest.min(soon) } else { longest };
        DesiredMotion { state, fresh, forces, region, meeting, longest }
    }

    /// New plan for an agent; `None` if it has to keep the present one.
    pub fn decide(&self, agent: u32, scheme: SchemeRef<'_>, scratch: &mut DecisionScratch<V>) -> Option<Decision<V>> {
        let old = self.cells.plan(agent);
        let DesiredMotion { mut state, fresh, forces, region, meeting, longest } =
            self.desired_motion(agent, Some(scheme), scratch);
        let near = self.scenery.solids_near(state.cell);
        let first = scheme.lists.map_or(meeting.first, |lists| lists.first_meeting(self, &fresh));
        let (cause, length) = self.first_obstacle(&meeting.bound, near, first);
        let (cause, length) = if length > longest { (Cause::Region, longest) } else { (cause, length) };
        let length = length.max(self.scenery.interval);
        // A plan longer than the relaxation time reaches the desired velocity and does not pass it.
        let share = (self.scenery.fields[state.field as usize].relaxation_s / length).min(1.0);
        let desired = (total(&forces).at_most(STRONGEST_MPS2.max(old.limit)) * share).at_most(old.limit);
        self.collect_nearby_plans(&fresh, length, scratch);
        let fastest = self.max_speed(&state);
        let aim = PlanAim { acceleration: desired, fastest, length };
        let mut taken = self.find_safe_plan(&fresh, &aim, region, near, scratch);
        if taken.is_none() && !self.scenery.movers.is_empty() {
            // It may be too late to avoid a moving obstacle: get out of its way as far as other agents allow.
            scratch.others.leave_out_movers();
            let aim = PlanAim { length: self.scenery.interval, ..aim };
            taken = self.find_safe_plan(&fresh, &aim, region, near, scratch);
        }
        let plan = match taken {
            Some(plan) => plan,
            None if old.end <= self.time => {
                // A trapped agent that stands can wait: its neighbours make it act when they do. No longer than this: cells are
                // sized by it (`CrowdScenery::side`).
                let stands = fresh.velocity.length_squared() < 1e-6;
                let intervals = if stands { self.scenery.steering.blocked_intervals } else { 1.0 };
                let length = intervals * self.scenery.interval;
                let mut plan = MotionPlan { end: self.time + f64::from(length), ..fresh };
                plan.brake();
                plan
            }
            None => return None,
        };
        (state.cause, state.is_woken, state.goes_on) = (cause, false, false);
        let leaves = self.leaves(&state);
        let struck_by = self.striking_obstacle(&plan);
        state.is_struck = struck_by != NONE;
        Some(Decision { plan, state, leaves, struck_by })
    }

    /// The forces on an agent now.
    pub fn forces(&self, agent: u32, scratch: &mut DecisionScratch<V>) -> Forces<V> {
        let forces = self.desired_motion(agent, None, scratch).forces;
        Forces { taken: self.cells.plan(agent).acceleration, ..forces }
    }

    /// Guide by which agents find their paths.
    pub fn guide(&self) -> Guide<'_, V> {
        let CrowdScenery { streets, goals, steering, .. } = self.scenery;
        Guide { streets: streets.as_ref(), goals, grid: self.grid, steering, reached_m: 0.0 }
    }

    /// Follows the route, filters the velocity, and notes whether the agent makes progress.
    fn update(&self, state: &mut AgentState<V>, plan: &MotionPlan<V>, position: V, velocity: V) {
        state.filter.observe(velocity, (self.time - plan.start) as f32, &self.scenery.steering);
        let path = &self.scenery.paths[state.route as usize];
        let leg = state.cursor.leg;
        let again = path.pass_subgoals(&mut state.cursor, position);
        let steering = &self.scenery.steering;
        let (rest, near) = (state.cursor.rest, steering.corner_m);
        let is_at_corner = rest > 0.0 && (state.cursor.aim - position).length_squared() < near * near;
        if self.time >= state.cursor.look_at || is_at_corner || leg != state.cursor.leg {
            state.door = self.guide().find_aim(path, &mut state.cursor, position, plan.radius);
            state.cursor.look_at = self.time + steering.look_s;
        }
        state.is_there = again || path.has_arrived(&state.cursor, position);
        if again {
            state.least_left = f32::INFINITY;
        }
        let left = path.distance_left(&state.cursor, position);
        if state.is_there || state.speed == 0.0 || left < state.least_left - self.scenery.steering.progress_m {
            state.least_left = left;
            state.progressed_at = self.time;
            state.is_stuck = false;
        } else if self.time - state.progressed_at > self.scenery.steering.stuck_after_s {
            state.is_stuck = true;
        }
    }

    /// True where an agent stays behind others who stand at its goal.
    fn is_kept_from_goal(
        &self,
        agent: u32,
        state: &AgentState<V>,
        walker: &SteeredAgent<V>,
        room: &mut Vec<u32>,
    ) -> bool {
        let path = &self.scenery.paths[state.route as usize];
        let was_there = self.states[agent as usize].is_there;
        let waits = was_there || self.time - state.progressed_at > SETTLES_S;
        if state.is_there || !waits || state.speed == 0.0 || state.cursor.rest > 0.0 || path.route.at_end != AtEnd::Stay
        {
            return false;
        }
        let within_m = SETTLES_WITHIN_M[usize::from(was_there)];
        // Who has arrived may stand where it stopped, within the same place.
        let same_m = path.route.arrival_radius.max(SAME_GOAL_M);
        self.is_behind_one(agent, walker, path.goal(), within_m, room, |its| {
            let its_goal = self.scenery.paths[its.route as usize].goal();
            its.is_there && (its_goal - path.goal()).length_squared() < same_m * same_m
        })
    }

    /// True where another agent in some state is nearer to a place than an agent, and within a distance of it (m).
    fn is_behind_one(
        &self,
        agent: u32,
        walker: &SteeredAgent<V>,
        goal: V,
        within_m: f32,
        room: &mut Vec<u32>,
        is_one: impl Fn(&AgentState<V>) -> bool,
    ) -> bool {
        let at = walker.position;
        let mut others = self.cells.agents_around(self.cells.coordinates(at), room).iter();
        others.any(|&other| {
            other != agent && is_one(&self.states[other as usize]) && {
                let plan = self.cells.plan(other);
                let place = plan.motion_at(self.time).0;
                let is_before = (place - goal).length_squared() < (at - goal).length_squared();
                is_before && (place - at).length() < walker.radius + plan.radius + within_m
            }
        })
    }

    /// Steering state of an agent: its position, goal and desired speed.
    pub fn walker(&self, state: &AgentState<V>, plan: &MotionPlan<V>, position: V, velocity: V) -> SteeredAgent<V> {
        let path = &self.scenery.paths[state.route as usize];
        let field = &self.scenery.fields[state.field as usize];
        let (desired, distance) = (state.cursor.aim - position).unit_and_length();
        let mut speed = state.speed;
        if path.route.at_end == AtEnd::Stay && state.cursor.rest == 0.0 {
            // The agent comes to rest at the goal.
            speed = speed.min(distance / (2.0 * field.relaxation_s));
            // At its goal the agent yields to others that pass.
            speed *= (distance / path.route.arrival_radius).min(1.0);
        }
        if speed > RUNS_MPS[0] {
            speed = speed.min(self.turning_speed(state, plan.limit, position, velocity));
        }
        let centre = plan.position + plan.velocity * (self.time - plan.start) as f32;
        SteeredAgent {
            position,
            velocity,
            radius: plan.radius,
            limit: plan.limit,
            desired,
            speed,
            distance_left: path.distance_left(&state.cursor, position),
            retreats: false,
            off_centre: position - centre,
        }
    }

    /// Speed of a runner who has to turn to a near point, and does not circle round it (m/s).
    ///
    /// - `limit`: its largest acceleration (m/s2).
    fn turning_speed(&self, state: &AgentState<V>, limit: f32, position: V, velocity: V) -> f32 {
        let (path, leg) = (&self.scenery.paths[state.route as usize], state.cursor.leg);
        let (desired, distance) = (state.cursor.aim - position).unit_and_length();
        let (along, fast) = (velocity.dot(desired), velocity.length());
        let across = if along < 0.0 { 1.0 } else { (velocity - desired * along).length() / fast.max(1e-3) };
        let turning = TURNING_SHARE * limit.min(STRONGEST_MPS2);
        let speed = (turning * distance / across.max(0.05)).sqrt().max(CREEPS_MPS);
        let is_near_subgoal = (path.subgoal(leg).0 - state.cursor.aim).length() < 2.0 * OPEN_M;
        if leg as usize + 1 >= path.num_legs() || !is_near_subgoal {
            return speed;
        }
        // It brakes before a point at which it turns.
        let after = (path.subgoal(leg + 1).0 - state.cursor.aim).unit_and_length().0;
        let at_point = 2.0 * turning * OPEN_M / (1.0 - desired.dot(after)).max(0.05);
        speed.min((at_point + limit * (distance - OPEN_M).max(0.0)).sqrt())
    }

    /// Lets an agent wait before a passage that is granted to others, or give way where it is blocked; true where it waits.
    fn take_turns(
        &self,
        agent: u32,
        state: &mut AgentState<V>,
        walker: &mut SteeredAgent<V>,
        room: &mut Vec<u32>,
    ) -> bool {
        let at = walker.position.on_ground();
        let door = self.scenery.streets.as_ref().and_then(|s| Some((s, s.closed_door(state.door)?)));
        if let Some((streets, door)) = door.filter(|(_, door)| !state.is_there && door.distance(at) < BEFORE_DOOR_M) {
            let advice =
                door.advise(agent as usize, at, walker.radius, |to| streets.sees_place(at, to, walker.radius, false));
            let is_behind = advice == PassageAdvice::Queue
                && self.is_behind_one(agent, walker, V::over_ground(door.middle()), BEHIND_M, room, |its| {
                    its.waits && its.door == state.door
                });
            self.take_advice(if is_behind { PassageAdvice::Stand } else { advice }, state, walker);
            return true;
        }
        let found = self.scenery.passages.find_use(at, state.cursor.aim.on_ground(), 0.0).filter(|_| !state.is_there);
        let Some(found) = found else {
            if self.give_way(agent, state, walker, false) {
                // Regaining the ground it yielded counts as progress.
                state.least_left = state.least_left.max(walker.distance_left);
            }
            return false;
        };
        let advice = self.turns.advise(&found, at, walker.radius);
        if advice == PassageAdvice::Enter {
            if !found.is_inside {
                self.give_way(agent, state, walker, true);
            }
            return false;
        }
        self.take_advice(advice, state, walker);
        true
    }

    /// Makes an agent wait as it is advised.
    fn take_advice(&self, advice: PassageAdvice, state: &mut AgentState<V>, walker: &mut SteeredAgent<V>) {
        match advice {
            PassageAdvice::Enter | PassageAdvice::Queue => {}
            PassageAdvice::Stand => walker.speed = 0.0,
            PassageAdvice::GiveWay(direction, share) => {
                walker.desired = V::over_ground(direction);
                walker.speed = share * self.scenery.steering.retreat_speed * state.speed;
                walker.retreats = true;
            }
        }
        // Who waits for its turn is in no jam.
        state.progressed_at = self.time;
        state.least_left = state.least_left.max(walker.distance_left);
    }

    /// Makes a blocked agent step back if others can only pass then, or by chance; true where it yields its ground to
    /// others.
    ///
    /// - `has_turn`: it goes to a passage that is granted to it, and steps back by chance alone.
    fn give_way(&self, agent: u32, state: &AgentState<V>, walker: &mut SteeredAgent<V>, has_turn: bool) -> bool {
        let (waited, steering) = (self.time - state.progressed_at, &self.scenery.steering);
        if waited < steering.patience_on_left_s || state.is_there {
            return false;
        }
        let walls = self.scenery.walls_seen(self.cells.number(self.cells.coordinates(walker.position)));
        let between = between_walls(&self.scenery.solids, walls, walker, steering).filter(|b| b.at_hand);
        let half = between.map(|b| if b.place < 0.0 { CorridorHalf::Left } else { CorridorHalf::Right });
        let blocked = BlockedAgent { position: walker.position, ahead: walker.desired, waited, half };
        let direction = if has_turn { None } else { blocked.retreat_direction(self.grid, steering) };
        let by_chance = || blocked.random_retreat_direction(agent, self.time, self.grid, steering);
        if let Some(direction) = direction.or_else(by_chance) {
            (walker.desired, walker.speed) = (direction, steering.retreat_speed * state.speed);
            walker.retreats = true;
        }
        direction.is_some()
    }

    /// Steers an agent to its place in its group; true where it has one.
    fn keep_company(&self, agent: u32, state: &AgentState<V>, walker: &mut SteeredAgent<V>) -> bool {
        let Some(relationship) = self.relationships.relationships_of(agent).filter(|b| b.companions[0] != NONE) else {
            return false;
        };
        if V::DIMENSIONS == 3 || walker.retreats || state.is_there || walker.speed == 0.0 {
            return false;
        }
        let mut others = [Companion::default(); MOST_COMPANIONS];
        let mut num = 0;
        for index in relationship.companions() {
            let its = &self.states[index as usize];
            // Companions that have arrived, or have no goal, are not waited for.
            if !its.is_there {
                let offset = self.cells.plan(index).motion_at(self.time).0 - walker.position;
                others[num] = Companion { index, offset, intent: its.intent, speed: its.speed };
                num += 1;
            }
        }
        let (grid, steering) = (self.grid, &self.scenery.steering);
        let cell = self.cells.number(self.cells.coordinates(walker.position));
        let ahead = GroupAhead {
            solids: &self.scenery.solids,
            near: self.scenery.solids_near(cell),
            density: [walker.desired, -walker.desired]
                .map(|along| grid.density(walker.position, along, &steering.density_places)),
            coming: oncoming(grid, walker.position, walker.desired, walker.distance_left, steering)[0],
        };
        companion_force(agent, walker, &others[..num], &ahead);
        num > 0
    }

    /// Finds the neighbours that an agent reacts to; for a new plan also all others in its own and the neighbouring
    /// cells, and, if the scheme asks for it, which of them it meets first.
    fn find_neighbours(
        &self,
        agent: u32,
        at: [i32; 3],
        me: &SteeredAgent<V>,
        state: &AgentState<V>,
        aim: Option<(SchemeRef<'_>, &mut FirstContact<V>)>,
        scratch: &mut DecisionScratch<V>,
    ) {
        scratch.seen.clear();
        let field = &self.scenery.fields[state.field as usize];
        let limits = PerceptionLimits {
            perception: field.perception_m,
            felt: felt_within(me, field),
            horizon: contact_horizon(field, &self.scenery.steering),
            room: field.comfort_m + ROUNDING,
        };
        let query = NeighbourQuery { cells: self.cells, at, time: self.time, agent, me, perception: limits };
        let DecisionScratch { room, seen, rows, .. } = &mut *scratch;
        match aim {
            None => query.find_neighbours(room, seen, None),
            Some((SchemeRef { lists: Some(_) }, _)) => query.find_neighbours(room, seen, Some(rows)),
            Some((SchemeRef { lists: None }, meeting)) => {
                query.find_neighbours(room, seen, Some(rows));
                meeting.find_among(self.cells, rows);
            }
        }
        for mover in &self.scenery.movers {
            let plan = mover.plan(self.time, 1.0);
            let offset = plan.position - me.position;
            let distance = offset.length();
            let radii = me.radius + mover.radius;
            if distance - mover.radius < 2.0 * self.cells.side {
                scratch.seen.push(SeenNeighbour { offset, velocity: plan.velocity, distance, radii, yields: false });
            }
        }
    }

    /// Adds the external obstacles that an agent sees; true where there are any.
    fn sees_external_obstacles(&self, me: &SteeredAgent<V>, scratch: &mut DecisionScratch<V>) -> bool {
        if self.external_obstacles.is_empty() {
            return false;
        }
        let before = scratch.seen.len();
        let around = Bounds2d::around_disc(me.position.on_ground(), 2.0 * self.cells.side);
        self.external_obstacles.visit_bodies_near(&around, |_, other| {
            let offset = V::over_ground(other.place) - me.position;
            let (velocity, radii) = (V::over_ground(other.velocity), me.radius + other.radius_m);
            scratch.seen.push(SeenNeighbour { offset, velocity, distance: offset.length(), radii, yields: false });
            true
        });
        // Sorts them independently of the grid's order.
        scratch.seen[before..].sort_by(|a, b| {
            let key = |s: &SeenNeighbour<V>| (s.distance, s.offset.coordinates());
            let ((d, x), (e, y)) = (key(a), key(b));
            d.total_cmp(&e).then(x[0].total_cmp(&y[0])).then(x[1].total_cmp(&y[1]))
        });
        scratch.seen.len() > before
    }

    /// Time at which a bound touches an obstacle, if that is before `first`.
    #[inline]
    pub fn first_obstacle(&self, bound: &Bound<V>, near: &[u32], mut first: (Cause, f32)) -> (Cause, f32) {
        for &s in near {
            let contact = bound.first_contact_with(&self.scenery.solids[s as usize], self.time, first.1);
            if contact < first.1 {
                first = (Cause::Obstacle(self.scenery.owners[s as usize]), contact);
            }
        }
        for mover in &self.scenery.movers {
            let plan = mover.plan(self.time, 1.0);
            let still = Bound { limit: 0.0, ..Bound::from(&plan) };
            let contact = bound.first_contact(&still, self.time, first.1);
            // The obstacle's motion is known up to the next point of its path; the agent decides again there.
            let known = (plan.end - self.time) as f32;
            let cause = if contact <= known { Cause::Obstacle(mover.obstacle) } else { Cause::Region };
            let time = contact.min(known);
            if time < first.1 {
                first = (cause, time);
            }
        }
        first
    }

    /// True if an agent is to leave the crowd, as it is at the end of its route.
    pub fn leaves(&self, state: &AgentState<V>) -> bool {
        state.is_there && self.scenery.paths[state.route as usize].route.at_end == AtEnd::Leave
    }

    /// Moving obstacle that overlaps an agent at the start of a plan; [`NONE`] if there is none.
    pub fn striking_obstacle(&self, plan: &MotionPlan<V>) -> u32 {
        let hits = |m: &&crate::scenery::MovingObstacle<V>| {
            let apart = (m.plan(self.time, 1.0).position - plan.position).length();
            apart < m.radius + plan.radius - 1e-3
        };
        self.scenery.movers.iter().find(hits).map_or(NONE, |m| m.obstacle)
    }
}

/// Sum of the terms.
pub(crate) fn total<V: Space>(f: &Forces<V>) -> V {
    f.driving + f.interaction + f.decelerating + f.damping + f.turning + f.safety
}
