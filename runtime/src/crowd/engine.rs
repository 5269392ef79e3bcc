//! The crowd and its loop of events.

use super::cells::Cells;
use super::decide::{Cause, Decider, Decision, Mind, Scratch};
use super::filter::Filter;
use super::flow::{Flow, LOOK_S};
use super::plan::Plan;
use super::queue::Calendar;
use super::safety::{Candidate, MARGIN, Other, lack, lack_of_solid, room};
use super::spline::Spline;
use super::tracing::{Registration, Trace, Tracing};
use super::watchdog::Watchdog;
use super::world::{HURRY, World, check_member};
use super::{AtEnd, Counts, CrowdError, Event, EventKind, Id, Member, NONE, Route, Setup, Space};

/// Members of a crowd that fits the processor's caches.
const FEW: usize = 1 << 15;

/// Members that act at their own events.
///
/// Everybody has one next event. Between two of them a member keeps its acceleration, so that its position at any time
/// is known exactly; at its event it looks at those who are registered near, asks the force field what it wishes, and
/// takes the nearest plan it can find for which the rule of safety holds. Its next event is when its new bound touches
/// another bound, an obstacle or the side of its region (001 section 2.1), though not before the smallest interval is
/// over.
///
/// Nobody ever overlaps anybody: see the rule in `safety.rs`, which does not depend on forces or intervals.
#[derive(Clone, Debug)]
pub struct Crowd<V> {
    pub(super) world: World<V>,
    pub(super) cells: Cells<V>,
    pub(super) minds: Vec<Mind<V>>,
    /// Route that was made for the members of a number alone, see [`Crowd::send_along`]; [`NONE`] where there is none.
    pub(super) own: Vec<u32>,
    pub(super) queue: Calendar,
    /// Numbers that are free, the next one last.
    pub(super) free: Vec<u32>,
    pub(super) flow: Flow<V>,
    /// Looks at the flow so far.
    pub(super) looks: u64,
    pub(super) now: f64,
    pub(super) counts: Counts,
    pub(super) trace: Trace<V>,
    pub(super) scratch: Scratch<V>,
    pub(super) watchdog: Watchdog,
    #[cfg(feature = "rayon")]
    pub(super) windows: super::window::Windows<V>,
}

impl<V: Space> Crowd<V> {
    /// Puts everybody where they start. All memory that [`Crowd::advance`] needs is taken here.
    ///
    /// # Errors
    /// [`CrowdError`] for settings out of their range, members or stop regions that overlap, one in an obstacle, a
    /// subgoal in an obstacle.
    pub fn new(setup: Setup<V>) -> Result<Self, CrowdError> {
        let (world, cells, flow) = World::new(&setup)?;
        let capacity = setup.config.capacity.max(setup.members.len());
        let mut crowd = Self {
            watchdog: Watchdog::new(capacity, world.interval, setup.config.scheme.most_events()),
            scratch: Scratch::new(&cells, capacity, world.movers.len()),
            trace: Trace::new(&setup.config, &cells, capacity),
            world,
            cells,
            minds: vec![Mind { cell: NONE, ..Mind::default() }; capacity],
            own: vec![NONE; capacity],
            queue: Calendar::new(capacity),
            free: (0..capacity as u32).rev().collect(),
            flow,
            looks: 0,
            now: 0.0,
            #[cfg(feature = "rayon")]
            windows: super::window::Windows::default(),
            counts: Counts::default(),
        };
        for member in &setup.members {
            crowd.enter(*member)?;
        }
        Ok(crowd)
    }

    /// Lets time pass until `until_s`; everything that happens is told to `on_event` in its order. Allocates nothing.
    ///
    /// # Errors
    /// [`CrowdError::Past`], and [`CrowdError::Storm`] where the watchdog finds a pair with more events than it could
    /// have.
    pub fn advance(&mut self, until_s: f64, on_event: &mut impl FnMut(&Event)) -> Result<(), CrowdError> {
        self.check_time(until_s)?;
        // Taken out, so that it can be changed together with the rest.
        let mut trace = std::mem::take(&mut self.trace);
        let result = match &mut trace {
            Trace::Registration => self.by_registration(until_s, on_event),
            Trace::Occupancy(occupancy) => self.by_occupancy(occupancy, until_s, on_event),
            Trace::Fixed(fixed) => self.by_steps(fixed, until_s, on_event),
        };
        self.trace = trace;
        result?;
        self.now = until_s;
        Ok(())
    }

    fn by_registration(&mut self, until_s: f64, on_event: &mut impl FnMut(&Event)) -> Result<(), CrowdError> {
        while let Some((time, member)) = self.queue.first(until_s) {
            self.look_until(time);
            self.now = time;
            if self.minds.len() > FEW {
                self.fetch();
            }
            self.happen(member, on_event)?;
        }
        Ok(())
    }

    /// Has what the next events will look at fetched from memory, while there is something else to do.
    fn fetch(&self) {
        if let Some(next) = self.queue.later(1) {
            let at = self.cells.coordinates(self.cells.plan(next).position);
            self.cells.fetch(at);
        }
        if let Some(next) = self.queue.later(2) {
            std::hint::black_box((self.cells.plan(next).radius, self.minds[next as usize].cell));
        }
    }

    pub(super) fn check_time(&self, until_s: f64) -> Result<(), CrowdError> {
        let is_good = (self.now..=1e9).contains(&until_s);
        if is_good { Ok(()) } else { Err(CrowdError::Past { got: until_s, now: self.now }) }
    }

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
                    lack(&candidate, &Other::new(other, self.now)).map_or(1.0, |l| -l.lack)
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

    pub(super) fn check_id(&self, id: Id) -> Result<(), CrowdError> {
        let is_here = self.minds.get(id.index()).is_some_and(|m| m.cell != NONE && m.generation == id.generation);
        if is_here { Ok(()) } else { Err(CrowdError::Gone(id)) }
    }

    pub(super) fn id(&self, index: u32) -> Id {
        Id { index, generation: self.minds[index as usize].generation }
    }

    pub(super) fn take_out(&mut self, index: u32) {
        let mind = &mut self.minds[index as usize];
        self.cells.remove(mind.cell, index);
        self.queue.remove(index);
        mind.cell = NONE;
        mind.generation = mind.generation.wrapping_add(1);
    }

    /// When everybody is looked at next, whenever anybody asks for anything.
    pub(super) fn next_look(&self) -> f64 {
        self.looks as f64 * LOOK_S
    }

    /// Looks at everybody, as often as it is time to.
    pub(super) fn look_until(&mut self, time: f64) {
        if self.next_look() <= time {
            // Nobody acts between looks that are due together: the last one shows what all of them would.
            self.looks = (time / LOOK_S) as u64;
            let now = self.next_look();
            self.looks += 1;
            self.flow.clear();
            for (index, mind) in (0u32..).zip(&self.minds) {
                if mind.cell != NONE {
                    let plan = self.cells.plan(index);
                    let (position, velocity) = plan.at(now.max(plan.start));
                    self.flow.add(position, velocity, mind.intent);
                }
            }
        }
    }

    /// The next event of a member, and of whom its bound touches.
    pub(super) fn happen(&mut self, member: u32, on_event: &mut impl FnMut(&Event)) -> Result<(), CrowdError> {
        let cause = self.minds[member as usize].cause;
        let partner = self.partner(cause);
        self.watch(member, partner)?;
        on_event(&self.count(member, self.kind(cause)));
        let renewed = partner.filter(|&p| self.is_renewed_with(p, member, self.now));
        self.decide(member, &Registration, on_event);
        if let Some(renewed) = renewed.filter(|&p| self.minds[p as usize].cell != NONE) {
            self.decide(renewed, &Registration, on_event);
        }
        Ok(())
    }

    /// True for the partner of a member's colliding event who acts then too: one who has not acted since the member did,
    /// so that its bound is the one that is touched, nor within the smallest interval.
    pub(super) fn is_renewed_with(&self, partner: u32, member: u32, time: f64) -> bool {
        if self.minds[partner as usize].cell == NONE {
            return false;
        }
        let start = self.cells.plan(partner).start;
        start <= self.cells.plan(member).start && time - start >= f64::from(self.world.interval)
    }

    /// Lets a member take a new plan; false where it has to keep the one it has.
    pub(super) fn decide(&mut self, member: u32, tracing: &impl Tracing<V>, on_event: &mut impl FnMut(&Event)) -> bool {
        let Self { world, cells, minds, flow, scratch, .. } = self;
        let decider = Decider { world, cells, minds, flow, time: self.now };
        let Some(decision) = decider.decide(member, tracing, scratch) else { return false };
        self.queue.set(member, decision.plan.end);
        if self.take(member, &decision, on_event) {
            self.free.push(member);
        }
        true
    }

    /// Does what was decided. True where the member has left: its number is free then.
    pub(super) fn take(&mut self, member: u32, decision: &Decision<V>, on_event: &mut impl FnMut(&Event)) -> bool {
        self.counts.decisions += 1;
        let before = self.minds[member as usize];
        let mind = decision.mind;
        self.cells.set(before.cell, mind.cell, &decision.plan);
        self.minds[member as usize] = mind;
        if mind.is_there && !before.is_there {
            on_event(&self.count(member, EventKind::Arrived));
        }
        if mind.is_stuck && !before.is_stuck {
            on_event(&self.count(member, EventKind::Stuck));
        }
        if mind.is_struck && !before.is_struck {
            on_event(&self.count(member, EventKind::Struck { obstacle: decision.struck_by as usize }));
        }
        if decision.leaves {
            on_event(&self.count(member, EventKind::Left));
            self.take_out(member);
        }
        decision.leaves
    }

    pub(super) fn partner(&self, cause: Cause) -> Option<u32> {
        match cause {
            Cause::Member(other) => Some(other).filter(|&o| self.minds[o as usize].cell != NONE),
            _ => None,
        }
    }

    pub(super) fn kind(&self, cause: Cause) -> EventKind {
        match cause {
            Cause::Region => EventKind::Resetting,
            Cause::Member(other) => EventKind::Colliding { other: self.id(other) },
            Cause::Obstacle(obstacle) => EventKind::Meeting { obstacle: obstacle as usize },
        }
    }

    /// Counts an event that happens now.
    pub(super) fn count(&mut self, member: u32, kind: EventKind) -> Event {
        let counts = &mut self.counts;
        let count = match kind {
            EventKind::Resetting => &mut counts.resetting,
            EventKind::Colliding { .. } => &mut counts.colliding,
            EventKind::Meeting { .. } => &mut counts.meeting,
            EventKind::Entering => &mut counts.entering,
            EventKind::Leaving => &mut counts.leaving,
            EventKind::Contacting { .. } => &mut counts.contacting,
            EventKind::Separating { .. } => &mut counts.separating,
            EventKind::Arrived => &mut counts.arrived,
            EventKind::Left => &mut counts.left,
            EventKind::Struck { .. } => &mut counts.struck,
            EventKind::Stuck => &mut counts.stuck,
        };
        *count += 1;
        Event { time: self.now, member: self.id(member), kind }
    }

    /// Shows an event of a member to the watchdog.
    #[inline]
    pub(super) fn watch(&mut self, member: u32, partner: Option<u32>) -> Result<(), CrowdError> {
        let storm = match self.watchdog.note(member, partner.unwrap_or(NONE), self.now) {
            Ok(()) => return Ok(()),
            Err(storm) => storm,
        };
        let other = if storm.partner == NONE { member } else { storm.partner };
        Err(CrowdError::Storm {
            first: self.id(member),
            second: self.id(other),
            events: storm.events.into(),
            most: storm.most.into(),
            seconds: storm.seconds,
        })
    }

    /// Side of the cells that members are registered in. [Unit: m]
    pub fn cell_side(&self) -> f32 {
        self.cells.side()
    }

    /// See [`AtEnd`]: what a member of a route does at its end.
    pub fn at_end(&self, route: usize) -> Option<AtEnd> {
        self.world.splines.get(route).map(|s| s.at_end())
    }
}
