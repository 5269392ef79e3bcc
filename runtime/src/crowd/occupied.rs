//! Events of the scheme of 000 (section 2.2 and 2.3).

use super::bound::Bound;
use super::decide::Cause;
use super::occupancy::Occupancy;
use super::plan::Plan;
use super::tracing::{Trace, Tracer};
use super::{Crowd, CrowdError, Event, EventKind, NONE, Space};

/// Gap between two that touch. [Unit: m]
pub(crate) const CONTACT: f32 = 0.02;
/// Relative speed of two that do not move relative to each other. [Unit: m/s]
pub(crate) const REST: f32 = 0.01;
/// Share of the smallest interval by which a contact of bounds may be found too early.
const EARLY: f32 = 0.1;

impl<V: Space> Crowd<V> {
    pub(super) fn by_occupancy(
        &mut self,
        o: &mut Occupancy,
        until_s: f64,
        on_event: &mut impl FnMut(&Event),
    ) -> Result<(), CrowdError> {
        while let Some((time, member)) = self.queue.first(until_s) {
            self.look_until(time);
            self.now = time;
            let plan = self.cells.plan(member);
            let occupant = o.occupants[member as usize];
            let cause = self.minds[member as usize].cause;
            self.watch(member, self.partner(cause))?;
            let crossing = plan.start + f64::from(occupant.crossing.after);
            if crossing <= plan.end.min(occupant.meeting.0) {
                self.cross(o, &plan, on_event);
            } else if occupant.meeting.0 < plan.end {
                self.meet(o, member, occupant.meeting.1, on_event);
            } else {
                let is_actual = self.is_actual(&plan, cause);
                self.act(o, member, if is_actual { cause } else { Cause::Region }, on_event);
            }
        }
        Ok(())
    }

    /// Takes one who has left the crowd out of the lists.
    pub(super) fn forget(&mut self, o: &mut Occupancy, member: u32, on_event: &mut impl FnMut(&Event)) {
        o.remove(&self.cells, member);
        while let Some(other) = o.contacts.nth(member, 0) {
            self.separate(o, member, other, on_event);
        }
    }

    /// A bound enters or leaves cells; whom it finds in those it enters it may meet.
    fn cross(&mut self, o: &mut Occupancy, plan: &Plan<V>, on_event: &mut impl FnMut(&Event)) {
        let entered = o.cross(&self.cells, plan);
        let kind = if entered.is_some() { EventKind::Entering } else { EventKind::Leaving };
        on_event(&self.count(plan.index, kind));
        if let Some((low, high)) = entered {
            self.look(o, plan, low, high);
        }
        self.wait(o, plan);
    }

    /// The first contact that was found after the last event.
    fn meet(&mut self, o: &mut Occupancy, member: u32, cause: Cause, on_event: &mut impl FnMut(&Event)) {
        let plan = self.cells.plan(member);
        if self.is_actual(&plan, cause) {
            self.act(o, member, cause, on_event);
        } else {
            // The other one's bound was made anew since.
            self.look_anew(o, &plan);
            self.wait(o, &plan);
        }
    }

    /// A resetting or colliding event, or one with an obstacle.
    fn act(&mut self, o: &mut Occupancy, member: u32, cause: Cause, on_event: &mut impl FnMut(&Event)) {
        let partner = self.partner(cause);
        on_event(&self.count(member, self.kind(cause)));
        // Who was made anew just now waits as long as everybody does.
        let waits = |p: &u32| self.now - o.occupants[*p as usize].asked < f64::from(self.world.interval);
        let renewed = partner.filter(|p| !waits(p));
        o.renewed = renewed.unwrap_or(NONE);
        self.reset(o, member, on_event);
        o.renewed = NONE;
        if let Some(renewed) = renewed {
            self.reset(o, renewed, on_event);
        }
        let Some(partner) = partner else { return };
        let are_there = [member, partner].iter().all(|&m| self.minds[m as usize].cell != NONE);
        if are_there && self.are_in_contact(member, partner) && o.contacts.join(member, partner) {
            on_event(&self.count(member, EventKind::Contacting { other: self.id(partner) }));
        }
    }

    /// Makes a bound anew with another plan, if there is one that is safe.
    fn reset(&mut self, o: &mut Occupancy, member: u32, on_event: &mut impl FnMut(&Event)) {
        let is_new = self.decide(member, Tracer::Occupancy(o), on_event);
        if self.minds[member as usize].cell == NONE {
            self.forget(o, member, on_event);
            return;
        }
        let plan = self.cells.plan(member);
        o.occupants[member as usize].asked = self.now;
        if is_new {
            o.list(&self.cells, &plan);
            let mut n = 0;
            while let Some(other) = o.contacts.nth(member, n) {
                if self.are_in_contact(member, other) {
                    n += 1;
                } else {
                    self.separate(o, member, other, on_event);
                }
            }
        } else {
            self.look_anew(o, &plan);
        }
        self.wait(o, &plan);
    }

    /// Two that were in contact move relative to each other. Where that splits a group, its parts look for each other.
    fn separate(&mut self, o: &mut Occupancy, member: u32, other: u32, on_event: &mut impl FnMut(&Event)) {
        o.contacts.part(member, other);
        on_event(&self.count(member, EventKind::Separating { other: self.id(other) }));
        let mut n = 0;
        while let Some(m) = o.contacts.changed(n) {
            let plan = self.cells.plan(m);
            self.look_anew(o, &plan);
            self.wait(o, &plan);
            n += 1;
        }
    }

    /// Sets the next events of everybody, as they were when a state was kept.
    pub(super) fn wait_for_all(&mut self) {
        let trace = std::mem::take(&mut self.trace);
        if let Trace::Occupancy(o) = &trace {
            for member in (0..self.minds.len() as u32).filter(|&m| o.occupants[m as usize].is_listed) {
                let plan = self.cells.plan(member);
                self.wait(o, &plan);
            }
        }
        self.trace = trace;
    }

    /// Sets the next event of a member: of what it knows, the first.
    fn wait(&mut self, o: &Occupancy, plan: &Plan<V>) {
        let occupant = &o.occupants[plan.index as usize];
        let crossing = plan.start + f64::from(occupant.crossing.after);
        self.queue.set(plan.index, plan.end.min(occupant.meeting.0).min(crossing).max(self.now));
    }

    /// Looks for the first contact in all cells that a bound occupies.
    fn look_anew(&self, o: &mut Occupancy, plan: &Plan<V>) {
        let occupant = &mut o.occupants[plan.index as usize];
        occupant.meeting = (f64::INFINITY, Cause::Region);
        let (low, high) = (occupant.low, occupant.high);
        self.look(o, plan, low, high);
    }

    /// Looks for contacts in some cells that are before the one that is known, and before the end of the plan.
    fn look(&self, o: &mut Occupancy, plan: &Plan<V>, low: [i32; 3], high: [i32; 3]) {
        let (bound, me) = (Bound::from(plan), plan.index);
        let Some(occupant) = o.occupants.get(me as usize) else { return };
        let earliest = occupant.asked.max(plan.start) + f64::from(self.world.interval);
        let mut meeting = occupant.meeting;
        let mut within = (meeting.0.min(plan.end) - self.now) as f32;
        let mut note = |contact: f32, cause: Cause| {
            let time = (self.now + f64::from(contact)).max(earliest);
            if time < meeting.0.min(plan.end) {
                meeting = (time, cause);
            }
        };
        o.each(&self.cells, low, high, |other| {
            if other != me && !o.contacts.are_together(me, other) {
                let contact = bound.first_contact(&Bound::from(&self.cells.plan(other)), self.now, within);
                if contact < within {
                    note(contact, Cause::Member(other));
                    within = contact;
                }
            }
        });
        let decider = self.decider(self.now);
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                for x in low[0]..=high[0] {
                    let near = self.world.near(self.cells.number([x, y, z]));
                    let first = decider.first_obstacle(&bound, near, (Cause::Region, within));
                    if first.1 < within {
                        note(first.1, first.0);
                        within = first.1;
                    }
                }
            }
        }
        o.occupants[me as usize].meeting = meeting;
    }

    /// True where a contact of bounds is there, and not only was expected.
    fn is_actual(&self, plan: &Plan<V>, cause: Cause) -> bool {
        let Some(other) = self.partner(cause) else { return !matches!(cause, Cause::Member(_)) };
        let within = EARLY * self.world.interval;
        let other = Bound::from(&self.cells.plan(other));
        Bound::from(plan).first_contact(&other, self.now, within) < within
    }

    /// True where two touch, and their plans move them alike as long as both are known.
    fn are_in_contact(&self, a: u32, b: u32) -> bool {
        let (a, b) = (self.cells.plan(a), self.cells.plan(b));
        let ((x, v), (y, w)) = (a.at(self.now), b.at(self.now));
        let end = a.end.min(b.end).max(self.now);
        let last = (a.at(end).1 - b.at(end).1).length();
        (x - y).length() <= a.radius + b.radius + CONTACT && (v - w).length().max(last) <= REST
    }
}
