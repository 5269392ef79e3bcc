//! Events of the scheme of Kim, Kim and Shin (2003a, section 2.2 and 2.3).

use crate::events::occupancy::{Occupancy, each_cell};
use crate::safety::bound::{Bound, narrowest_cell};
use crate::{Agent, CrowdError, CrowdEventKind, NONE, Space, events::schemes::SchemeRef};
use crate::{error::check, events::decide::Cause, events::engine::Engine, space::plan::MotionPlan};

/// Gap between two that touch (m).
pub(crate) const CONTACT: f32 = 0.02;
/// Relative speed of two that do not move relative to each other (m/s).
pub(crate) const REST: f32 = 0.01;
/// Share of the smallest interval by which a contact of bounds may be found too early.
const EARLY: f32 = 0.1;

impl<V: Space> Engine<V> {
    pub(crate) fn run_occupancy(&mut self, o: &mut Occupancy, until_s: f64) -> Result<bool, CrowdError> {
        self.run_events(until_s, |engine, agent| {
            let plan = engine.cells.plan(agent);
            let occupant = o.occupants[agent as usize];
            let cause = engine.states[agent as usize].cause;
            engine.note_for_watchdog(agent, engine.partner(cause))?;
            let crossing = plan.start + f64::from(occupant.crossing.after);
            if crossing <= plan.end.min(occupant.meeting.0) {
                engine.cross(o, &plan);
            } else if occupant.meeting.0 < plan.end {
                engine.process_meeting(o, agent, occupant.meeting.1);
            } else {
                let is_actual = engine.is_actual(&plan, cause);
                engine.act(o, agent, if is_actual { cause } else { Cause::Region });
            }
            Ok(())
        })
    }

    /// A newcomer is within the limits of the scheme, if that runs.
    pub(crate) fn check_occupancy(&self, n: usize, agent: &Agent<V>) -> Result<(), CrowdError> {
        if self.occupancy.is_none() {
            return Ok(());
        }
        let longest = self.scenery.steering.blocked_intervals * self.scenery.interval;
        let good = narrowest_cell(agent.radius, agent.acceleration, longest) <= self.cells.side;
        let expected = "small enough that a bound is not wider than a cell after the smallest interval";
        Ok(check("agent.acceleration", n, agent.acceleration, good, expected)?)
    }

    /// Lists an agent that entered, if there are lists.
    pub(crate) fn list(&mut self, plan: &MotionPlan<V>) {
        if let Some(occupancy) = &mut self.occupancy {
            occupancy.list(&self.cells, plan);
        }
    }

    /// Takes an agent that left out of the lists, if there are lists.
    pub(crate) fn unlist(&mut self, agent: u32) {
        if let Some(mut occupancy) = self.occupancy.take() {
            self.forget(&mut occupancy, agent);
            self.occupancy = Some(occupancy);
        }
    }

    /// Takes an agent that has left the crowd out of the lists.
    fn forget(&mut self, o: &mut Occupancy, agent: u32) {
        o.remove(&self.cells, agent);
        while let Some(other) = o.contacts.nth(agent, 0) {
            self.separate(o, agent, other);
        }
    }

    /// A bound enters or leaves cells; in those it enters it may meet other bounds.
    fn cross(&mut self, o: &mut Occupancy, plan: &MotionPlan<V>) {
        let entered = o.cross(&self.cells, plan);
        let kind = if entered.is_some() { CrowdEventKind::Entering } else { CrowdEventKind::Leaving };
        self.report_event(plan.index, kind);
        if let Some((low, high)) = entered {
            self.visit_cells(o, plan, low, high);
        }
        self.wait(o, plan);
    }

    /// The first contact that was found after the last event.
    fn process_meeting(&mut self, o: &mut Occupancy, agent: u32, cause: Cause) {
        let plan = self.cells.plan(agent);
        if self.is_actual(&plan, cause) {
            self.act(o, agent, cause);
        } else {
            // The other bound was renewed since.
            self.find_first_contact(o, &plan);
            self.wait(o, &plan);
        }
    }

    /// A resetting or colliding event, or one with an obstacle.
    fn act(&mut self, o: &mut Occupancy, agent: u32, cause: Cause) {
        let partner = self.partner(cause);
        self.report_event(agent, self.kind(cause));
        // An agent that was renewed just now waits as long as the others.
        let waits = |p: &u32| self.now - o.occupants[*p as usize].asked < f64::from(self.scenery.interval);
        let renewed = partner.filter(|p| !waits(p));
        o.renewed = renewed;
        self.reset(o, agent);
        o.renewed = None;
        if let Some(renewed) = renewed {
            self.reset(o, renewed);
        }
        let Some(partner) = partner else { return };
        let are_there = [agent, partner].iter().all(|&m| self.states[m as usize].cell != NONE);
        if are_there && self.are_in_contact(agent, partner) && o.contacts.join(agent, partner) {
            self.report_event(agent, CrowdEventKind::Contacting { other: self.id(partner) });
        }
    }

    /// Renews a bound with another plan, if there is a safe one.
    fn reset(&mut self, o: &mut Occupancy, agent: u32) {
        let is_new = self.decide(agent, SchemeRef { lists: Some(o) });
        if self.states[agent as usize].cell == NONE {
            self.forget(o, agent);
            return;
        }
        let plan = self.cells.plan(agent);
        o.occupants[agent as usize].asked = self.now;
        if is_new {
            o.list(&self.cells, &plan);
            let mut n = 0;
            while let Some(other) = o.contacts.nth(agent, n) {
                if self.are_in_contact(agent, other) {
                    n += 1;
                } else {
                    self.separate(o, agent, other);
                }
            }
        } else {
            self.find_first_contact(o, &plan);
        }
        self.wait(o, &plan);
    }

    /// Two that were in contact move relative to each other. Where that splits a group, its parts look for each other.
    fn separate(&mut self, o: &mut Occupancy, agent: u32, other: u32) {
        o.contacts.part(agent, other);
        self.report_event(agent, CrowdEventKind::Separating { other: self.id(other) });
        let mut n = 0;
        while let Some(m) = o.contacts.changed(n) {
            let plan = self.cells.plan(m);
            self.find_first_contact(o, &plan);
            self.wait(o, &plan);
            n += 1;
        }
    }

    /// Sets the next events of all agents, as they were in a snapshot.
    pub(crate) fn wait_for_all(&mut self) {
        let Some(o) = self.occupancy.take() else { return };
        for agent in (0..self.states.len() as u32).filter(|&m| o.occupants[m as usize].is_listed) {
            self.wait(&o, &self.cells.plan(agent));
        }
        self.occupancy = Some(o);
    }

    /// Sets the next event of an agent: of what it knows, the first.
    fn wait(&mut self, o: &Occupancy, plan: &MotionPlan<V>) {
        let occupant = &o.occupants[plan.index as usize];
        let crossing = plan.start + f64::from(occupant.crossing.after);
        self.queue.set(plan.index, plan.end.min(occupant.meeting.0).min(crossing).max(self.now));
    }

    /// Finds the first contact in all cells that a bound occupies.
    fn find_first_contact(&self, o: &mut Occupancy, plan: &MotionPlan<V>) {
        let occupant = &mut o.occupants[plan.index as usize];
        occupant.meeting = (f64::INFINITY, Cause::Region);
        let (low, high) = (occupant.low, occupant.high);
        self.visit_cells(o, plan, low, high);
    }

    /// Looks for contacts in some cells that are before the one that is known, and before the end of the plan.
    fn visit_cells(&self, o: &mut Occupancy, plan: &MotionPlan<V>, low: [i32; 3], high: [i32; 3]) {
        let (bound, me) = (Bound::from(plan), plan.index);
        let Some(occupant) = o.occupants.get(me as usize) else { return };
        let earliest = occupant.asked.max(plan.start) + f64::from(self.scenery.interval);
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
                    note(contact, Cause::Agent(other));
                    within = contact;
                }
            }
        });
        let decider = self.decider(self.now);
        each_cell(low, high, |at| {
            let near = self.scenery.solids_near(self.cells.number(at));
            let first = decider.first_obstacle(&bound, near, (Cause::Region, within));
            if first.1 < within {
                note(first.1, first.0);
                within = first.1;
            }
        });
        o.occupants[me as usize].meeting = meeting;
    }

    /// True where a contact of bounds is there, and not only was expected.
    fn is_actual(&self, plan: &MotionPlan<V>, cause: Cause) -> bool {
        let Some(other) = self.partner(cause) else { return !matches!(cause, Cause::Agent(_)) };
        let within = EARLY * self.scenery.interval;
        let other = Bound::from(&self.cells.plan(other));
        Bound::from(plan).first_contact(&other, self.now, within) < within
    }

    /// True where two touch, and their plans move them alike as long as both are known.
    fn are_in_contact(&self, a: u32, b: u32) -> bool {
        let (a, b) = (self.cells.plan(a), self.cells.plan(b));
        let ((x, v), (y, w)) = (a.motion_at(self.now), b.motion_at(self.now));
        let end = a.end.min(b.end).max(self.now);
        let last = (a.motion_at(end).1 - b.motion_at(end).1).length();
        (x - y).length() <= a.radius + b.radius + CONTACT && (v - w).length().max(last) <= REST
    }
}
