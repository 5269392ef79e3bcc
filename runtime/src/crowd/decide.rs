//! What a member does at its event.

use super::beside::between_walls;
use super::bound::Bound;
use super::cells::Cells;
use super::filter::Filter;
use super::flow::Flow;
use super::near::{Heed, Look, Rows};
use super::others::Others;
use super::plan::Plan;
use super::reach::Reach;
use super::retreat::{Half, Held, LEAST_PATIENT_S, SLOWLY};
use super::safety::{Candidate, Lack, lack_of_solid, lever};
use super::sight::{ROUNDING, Seen};
use super::spline::Cursor;
use super::steer::{Surroundings, Walker, felt_within, forces, minded_within};
use super::tracing::{Meeting, Tracer};
use super::world::{HURRY, World};
use super::{AtEnd, Forces, NONE, Space};
use crate::lanes::LANES;
use serde::{Deserialize, Serialize};

/// Most tries for a plan near the desired one before a member brakes.
const TRIES: usize = 6;
/// Length of each try after the second, as a share; the first push out of a lack often is enough, and leaves the length as it
/// is. If that shortens it too, members act 3 to 6 % more often, and with 0.6 for all a tenth, and get on no faster.
const SHORTER: f32 = 0.8;
/// How much a push out of a lack goes beyond what a linear guess asks for.
const BEYOND: f32 = 1.1;
/// How many smallest intervals one waits who stands and found no way on.
pub(crate) const PATIENT: f32 = 2.0;
/// Speed below which one does not go past its goal by much. [Unit: m/s]
const SLOW: f32 = 0.1;
/// Way toward the goal that counts as getting on. [Unit: m]
const GETTING_ON: f32 = 0.1;
/// Time without getting on after which a member is stuck. [Unit: s]
pub(crate) const PATIENCE_S: f64 = 10.0;

/// Why a member acts next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Cause {
    /// Its bound leaves its region.
    #[default]
    Region,
    /// Its bound touches that of a member.
    Member(u32),
    /// Its bound touches an obstacle.
    Obstacle(u32),
}

/// What a member remembers beside its plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Mind<V> {
    pub route: u32,
    pub field: u32,
    pub generation: u32,
    /// Cell that it is registered in; [`NONE`] for one who is not there.
    pub cell: u32,
    pub speed: f32,
    pub cursor: Cursor,
    pub filter: Filter<V>,
    pub cause: Cause,
    /// Shortest way that was left since it stepped back last. [Unit: m]
    pub least_left: f32,
    /// When it got on last. [Unit: s]
    pub got_on: f64,
    /// Unit vector along which it wants to go, as others see it; zero for one who is there.
    pub intent: V,
    pub is_there: bool,
    pub is_stuck: bool,
    /// A moving obstacle is in its place.
    pub is_struck: bool,
}

/// Room to think in, one for each thread.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch<V> {
    /// For the numbers of those who are registered near.
    room: Vec<u32>,
    seen: Vec<Seen<V>>,
    pub rows: Rows,
    /// Those whose plans a plan may come in conflict with.
    others: Others,
}

impl<V: Space> Scratch<V> {
    pub fn new(capacity: usize, num_movers: usize) -> Self {
        let most = capacity + num_movers;
        let (room, rows) = (Cells::<V>::room(capacity), Rows::new(capacity.div_ceil(LANES)));
        Self { room, seen: Vec::with_capacity(most), rows, others: Others::new(most) }
    }
}

/// What came of an event.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decision<V> {
    pub plan: Plan<V>,
    pub mind: Mind<V>,
    pub leaves: bool,
    /// Moving obstacle that is in its place.
    pub struck_by: u32,
}

/// What a member would do if it were alone with the forces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wish<V> {
    pub mind: Mind<V>,
    /// A plan from now on without an end, but for its acceleration.
    pub fresh: Plan<V>,
    pub acceleration: V,
    /// Region around its cell, which it does not leave.
    pub region: (V, V),
    /// Whom its bound touches first.
    pub meeting: Meeting<V>,
    /// How long it may do so: at its goal, not so long that it would go past. [Unit: s]
    pub longest: f32,
}

/// A member at an event, with all that it may look at.
pub(crate) struct Decider<'a, V> {
    pub world: &'a World<V>,
    pub cells: &'a Cells<V>,
    pub minds: &'a [Mind<V>],
    pub flow: &'a Flow<V>,
    pub time: f64,
}

impl<V: Space> Decider<'_, V> {
    /// What the force field makes a member wish; with a tracer, also finds what it needs to take a plan.
    pub fn wish(&self, member: u32, tracer: Option<Tracer<'_>>, scratch: &mut Scratch<V>) -> Wish<V> {
        let old = self.cells.plan(member);
        let (position, velocity) = old.at(self.time);
        let mut mind = self.minds[member as usize];
        self.update(&mut mind, &old, position, velocity);
        let mut walker = self.walker(&mind, &old, position, velocity);
        mind.intent = if mind.is_there { V::default() } else { walker.desired };
        self.give_way(&mind, &mut walker);
        if walker.retreats {
            // Whoever makes good again what it gave way gets on.
            mind.least_left = mind.least_left.max(walker.left);
        }
        let at = self.cells.coordinates(position);
        mind.cell = self.cells.number(at);
        let (centre, half) = (self.cells.centre(at), V::from_coordinates([self.cells.side(); 3]));
        let region = (centre - half, centre + half);
        let fresh = Plan { start: self.time, position, velocity, moving: f32::INFINITY, ..old };
        let mut meeting = Meeting::new(&fresh, tracer.map(|_| region));
        self.look_around((member, at), &walker, &mind, tracer.map(|t| (t, &mut meeting)), scratch);
        let near = self.world.near(mind.cell);
        let f = self.feel(&walker, &mind, near, scratch);
        let soon = 2.0 * self.world.fields[mind.field as usize].relaxation_s;
        let slows = walker.left < soon * mind.speed && velocity.length_squared() > SLOW * SLOW;
        let longest = if slows { soon } else { f32::INFINITY };
        Wish { mind, fresh, acceleration: total(&f).at_most(old.limit), region, meeting, longest }
    }

    /// Takes a new plan for a member; none where it has to keep the one it has.
    pub fn decide(&self, member: u32, tracer: Tracer<'_>, scratch: &mut Scratch<V>) -> Option<Decision<V>> {
        let old = self.cells.plan(member);
        let Wish { mut mind, fresh, acceleration, region, meeting, longest } = self.wish(member, Some(tracer), scratch);
        let near = self.world.near(mind.cell);
        let (cause, length) = tracer.first_event(self, &fresh, &meeting, near);
        let (cause, length) = if length > longest { (Cause::Region, longest) } else { (cause, length) };
        let length = length.max(self.world.interval);
        // Over a plan that is longer than the time to relax, the desired velocity is reached and not passed.
        let wish = acceleration * (self.world.fields[mind.field as usize].relaxation_s / length).min(1.0);
        self.look_at_plans(&fresh, length, scratch);
        let mut taken = self.safe(&fresh, wish, length, region, near, scratch);
        if taken.is_none() && !self.world.movers.is_empty() {
            // What does not give way may be past avoiding: out of its way all the same.
            scratch.others.leave_out_movers();
            taken = self.safe(&fresh, wish, self.world.interval, region, near, scratch);
        }
        let plan = match taken {
            Some(plan) => plan,
            None if old.end <= self.time => {
                // Who stands shut in can wait: those around make it act when they do.
                let stands = fresh.velocity.length_squared() < 1e-6;
                let length = if stands { PATIENT * self.world.interval } else { self.world.interval };
                let mut plan = Plan { end: self.time + f64::from(length), ..fresh };
                plan.brake();
                plan
            }
            None => return None,
        };
        mind.cause = cause;
        let leaves = self.leaves(&mind);
        let struck_by = self.struck(&plan);
        mind.is_struck = struck_by != NONE;
        Some(Decision { plan, mind, leaves, struck_by })
    }

    fn feel(&self, walker: &Walker<V>, mind: &Mind<V>, near: &[u32], scratch: &Scratch<V>) -> Forces<V> {
        let (world, seen) = (self.world, &scratch.seen);
        let walls = world.walls(mind.cell);
        let around =
            Surroundings { seen, solids: &world.solids, near, walls, flow: self.flow, interests: &world.interests };
        forces(walker, &world.fields[mind.field as usize], &around)
    }

    /// What moves a member now.
    pub fn forces(&self, member: u32, scratch: &mut Scratch<V>) -> Forces<V> {
        let plan = self.cells.plan(member);
        let (position, velocity) = plan.at(self.time);
        let mut mind = self.minds[member as usize];
        self.update(&mut mind, &plan, position, velocity);
        let mut walker = self.walker(&mind, &plan, position, velocity);
        self.give_way(&mind, &mut walker);
        let at = self.cells.coordinates(position);
        mind.cell = self.cells.number(at);
        self.look_around((member, at), &walker, &mind, None, scratch);
        let near = self.world.near(mind.cell);
        let f = self.feel(&walker, &mind, near, scratch);
        Forces { taken: plan.acceleration, ..f }
    }

    /// Follows the route, filters the velocity, and notes whether the member gets on.
    fn update(&self, mind: &mut Mind<V>, plan: &Plan<V>, position: V, velocity: V) {
        mind.filter.observe(velocity, (self.time - plan.start) as f32);
        let spline = &self.world.splines[mind.route as usize];
        spline.follow(&mut mind.cursor, position, self.world.fields[mind.field as usize].look_ahead_m);
        mind.is_there = spline.is_there(mind.cursor, position);
        if mind.is_there && spline.at_end() == AtEnd::Again {
            mind.cursor = Cursor::default();
            mind.least_left = f32::INFINITY;
        }
        let left = spline.left(mind.cursor, position);
        if mind.is_there || mind.speed == 0.0 || left < mind.least_left - GETTING_ON {
            mind.least_left = left;
            mind.got_on = self.time;
            mind.is_stuck = false;
        } else if self.time - mind.got_on > PATIENCE_S {
            mind.is_stuck = true;
        }
    }

    /// Where a member wants to go.
    pub fn walker(&self, mind: &Mind<V>, plan: &Plan<V>, position: V, velocity: V) -> Walker<V> {
        let spline = &self.world.splines[mind.route as usize];
        let field = &self.world.fields[mind.field as usize];
        let (desired, distance) = (spline.ahead(mind.cursor, field.look_ahead_m) - position).unit_and_length();
        let mut speed = mind.speed;
        if spline.at_end() == AtEnd::Stay {
            // Comes to rest at the goal.
            let to_goal = if distance < field.look_ahead_m { (spline.goal() - position).length() } else { distance };
            speed = speed.min(to_goal / (2.0 * field.relaxation_s));
            // Who is there gives way to those who press past it.
            speed *= (to_goal / spline.arrival_radius()).min(1.0);
        }
        let centre = plan.position + plan.velocity * (self.time - plan.start) as f32;
        Walker {
            position,
            velocity,
            radius: plan.radius,
            limit: plan.limit,
            desired,
            speed,
            left: spline.left(mind.cursor, position),
            retreats: false,
            off_centre: position - centre,
        }
    }

    /// Makes a member step back that does not get on, and has to before others can.
    fn give_way(&self, mind: &Mind<V>, walker: &mut Walker<V>) {
        let waited = self.time - mind.got_on;
        if waited < LEAST_PATIENT_S || mind.is_there {
            return;
        }
        let walls = self.world.walls(self.cells.number(self.cells.coordinates(walker.position)));
        let between = between_walls(&self.world.solids, walls, walker.position, walker.desired.right());
        let half = between.filter(|b| b.at_hand).map(|b| if b.place < 0.0 { Half::Left } else { Half::Right });
        let held = Held { position: walker.position, ahead: walker.desired, waited, half };
        if let Some(way) = held.retreat(self.flow) {
            *walker = Walker { desired: way, speed: SLOWLY * mind.speed, retreats: true, ..*walker };
        }
    }

    /// Finds those who are felt around a member in a cell; for one who takes a plan also everybody who is registered
    /// near, and in the scheme that asks for it whom it meets first.
    fn look_around(
        &self,
        (member, at): (u32, [i32; 3]),
        me: &Walker<V>,
        mind: &Mind<V>,
        aim: Option<(Tracer<'_>, &mut Meeting<V>)>,
        scratch: &mut Scratch<V>,
    ) {
        scratch.seen.clear();
        let field = &self.world.fields[mind.field as usize];
        let heed = Heed {
            perception: field.perception_m,
            felt: felt_within(me, field),
            horizon: minded_within(field),
            room: field.comfort_m + ROUNDING,
        };
        let look = Look { cells: self.cells, at, time: self.time, member, me, heed };
        let Scratch { room, seen, rows, .. } = &mut *scratch;
        match aim {
            None => look.around(room, seen, None),
            Some((Tracer::Occupancy(_), _)) => look.around(room, seen, Some(rows)),
            Some((Tracer::Registration, meeting)) => {
                look.around(room, seen, Some(rows));
                meeting.look(self.cells, rows);
            }
        }
        for mover in &self.world.movers {
            let plan = mover.plan(self.time, 1.0);
            let offset = plan.position - me.position;
            let distance = offset.length();
            let radii = me.radius + mover.radius;
            if distance - mover.radius < 2.0 * self.cells.side() {
                scratch.seen.push(Seen { offset, velocity: plan.velocity, distance, radii, yields: false });
            }
        }
    }

    /// When a bound touches an obstacle, if that is before `first`.
    #[inline]
    pub fn first_obstacle(&self, bound: &Bound<V>, near: &[u32], mut first: (Cause, f32)) -> (Cause, f32) {
        for &s in near {
            let contact = bound.first_contact_with(&self.world.solids[s as usize], self.time, first.1);
            if contact < first.1 {
                first = (Cause::Obstacle(self.world.owners[s as usize]), contact);
            }
        }
        for mover in &self.world.movers {
            let plan = mover.plan(self.time, 1.0);
            let still = Bound { limit: 0.0, ..Bound::from(&plan) };
            let contact = bound.first_contact(&still, self.time, first.1);
            // Beyond the next point of its way nothing is known: it is looked at anew there.
            let known = (plan.end - self.time) as f32;
            let (cause, time) =
                if contact <= known { (Cause::Obstacle(mover.obstacle), contact) } else { (Cause::Region, known) };
            if time < first.1 {
                first = (cause, time);
            }
        }
        first
    }

    /// Those whose plans a plan of a length has to be compared with.
    fn look_at_plans(&self, fresh: &Plan<V>, length: f32, scratch: &mut Scratch<V>) {
        scratch.others.clear();
        let reach = Reach::new(self.cells, HURRY * self.world.speed, fresh, length);
        reach.find(scratch.rows.all(), &mut scratch.others);
        for mover in &self.world.movers {
            let plan = mover.plan(self.time, length + 2.0 * self.world.speed / fresh.limit);
            let way = plan.velocity.length() * (plan.end - plan.start) as f32;
            let free = (plan.position - fresh.position).length() - plan.radius - way;
            if free < reach.mine {
                scratch.others.push(&plan);
            }
        }
        scratch.others.prepare(fresh.position, self.time);
    }

    /// A plan near the one that is wished for, for which the rule holds.
    fn safe(
        &self,
        fresh: &Plan<V>,
        wish: V,
        length: f32,
        region: (V, V),
        near: &[u32],
        scratch: &Scratch<V>,
    ) -> Option<Plan<V>> {
        let shortest = self.world.interval;
        let (mut a, mut length) = (wish, length);
        for attempt in 0..TRIES {
            let candidate = self.candidate(fresh, a, length);
            if !candidate.stays_within(region.0, region.1) {
                if length <= shortest {
                    break;
                }
                length = (0.5 * length).max(shortest);
                continue;
            }
            match self.worst(&candidate, near, scratch) {
                None => return Some(candidate.plan),
                Some(worst) => {
                    // Slides along what is in the way.
                    a = candidate.plan.acceleration + worst.away * (worst.lack * BEYOND / lever(&candidate));
                    if attempt > 0 {
                        length = (SHORTER * length).max(shortest);
                    }
                }
            }
        }
        let stop = fresh.velocity * -shortest.recip();
        for share in [0.5, 1.0] {
            let candidate = self.candidate(fresh, stop * share, shortest);
            let is_safe = candidate.stays_within(region.0, region.1) && self.worst(&candidate, near, scratch).is_none();
            if is_safe {
                return Some(candidate.plan);
            }
        }
        None
    }

    /// A plan within the limits of acceleration and speed.
    #[inline]
    fn candidate(&self, fresh: &Plan<V>, a: V, length: f32) -> Candidate<V> {
        let a = a.at_most(fresh.limit);
        let fastest = HURRY * self.world.speed;
        let a = ((fresh.velocity + a * length).at_most(fastest) - fresh.velocity) * length.recip();
        Candidate::new(Plan { end: self.time + f64::from(length), acceleration: a.at_most(fresh.limit), ..*fresh })
    }

    /// The largest lack of a plan.
    fn worst(&self, candidate: &Candidate<V>, near: &[u32], scratch: &Scratch<V>) -> Option<Lack<V>> {
        let solids = near.iter().filter_map(|&s| lack_of_solid(candidate, &self.world.solids[s as usize]));
        scratch.others.worst(candidate).into_iter().chain(solids).reduce(|a, b| if b.lack > a.lack { b } else { a })
    }

    /// True for one who is to leave the crowd, as it is at the end of its route.
    pub fn leaves(&self, mind: &Mind<V>) -> bool {
        mind.is_there && self.world.splines[mind.route as usize].at_end() == AtEnd::Leave
    }

    /// Moving obstacle in the place of one at the start of a plan.
    pub fn struck(&self, plan: &Plan<V>) -> u32 {
        let hits = |m: &&super::world::Mover<V>| {
            let apart = (m.plan(self.time, 1.0).position - plan.position).length();
            apart < m.radius + plan.radius - 1e-3
        };
        self.world.movers.iter().find(hits).map_or(NONE, |m| m.obstacle)
    }
}

/// Sum of the terms.
pub(crate) fn total<V: Space>(f: &Forces<V>) -> V {
    f.driving + f.interaction + f.decelerating + f.damping + f.turning + f.safety
}
