//! The crowd and its loop of events.

use super::ahead::Ahead;
use super::cells::Cells;
use super::decide::{Cause, Decider, Decision, Mind, Scratch};
use super::flow::{Flow, LOOK_S};
use super::queue::Calendar;
use super::tracing::{Trace, Tracer};
use super::watchdog::Watchdog;
use super::world::World;
use super::{AtEnd, Counts, CrowdError, Event, EventKind, Id, NONE, Setup, Space};

/// Most members of a crowd that is taken to fit the processor's caches; in tests, none does. With 8000 it costs 4 to 8 % to
/// fetch ahead, with 16 000 it saves 4 to 11 %, with 100 000 a quarter to a third.
const FEW: usize = if cfg!(test) { 0 } else { 12_000 };

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
    pub(super) ahead: Ahead,
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
            scratch: Scratch::new(capacity, world.movers.len()),
            trace: Trace::new(&setup.config, &cells, capacity),
            world,
            cells,
            minds: vec![Mind { cell: NONE, ..Mind::default() }; capacity],
            own: vec![NONE; capacity],
            queue: Calendar::new(capacity),
            ahead: Ahead::default(),
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
            if self.minds.len() - self.free.len() > FEW {
                self.look_ahead();
            }
            self.happen(member, on_event)?;
        }
        Ok(())
    }

    pub(super) fn check_time(&self, until_s: f64) -> Result<(), CrowdError> {
        let is_good = (self.now..=1e9).contains(&until_s);
        if is_good { Ok(()) } else { Err(CrowdError::Past { got: until_s, now: self.now }) }
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
        self.decide(member, Tracer::Registration, on_event);
        if let Some(renewed) = renewed.filter(|&p| self.minds[p as usize].cell != NONE) {
            self.decide(renewed, Tracer::Registration, on_event);
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
    pub(super) fn decide(&mut self, member: u32, tracer: Tracer<'_>, on_event: &mut impl FnMut(&Event)) -> bool {
        let Self { world, cells, minds, flow, scratch, .. } = self;
        let decider = Decider { world, cells, minds, flow, time: self.now };
        let Some(decision) = V::decide(&decider, member, tracer, scratch) else { return false };
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
        Err(CrowdError::Storm {
            first: self.id(member),
            second: Some(storm.partner).filter(|&p| p != NONE).map(|p| self.id(p)),
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
