//! The engine's part: looking for what an agent senses next, and letting it happen.

use super::engine::Engine;
use crate::senses::crossing::{first_change, is_near, leaves_cell};
use crate::senses::{Sense, SensedEvent, SensingState, swept_bounds};
use crate::{CrowdEventKind, Id, NONE, Space, error::Result, space::plan::MotionPlan};

impl<V: Space> Engine<V> {
    /// Sets the senses of an agent.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn set_sense(&mut self, id: Id, sense: Sense) -> Result<()> {
        self.check_id(id)?;
        let own = &mut self.sensors.states[id.index()];
        let channels = |s: &Sense| (s.sends, s.receives, s.once);
        if channels(&own.sense) != channels(&sense) {
            self.sensors.changes += 1;
            (own.changed, own.last) = ((self.now, self.sensors.changes), None);
        }
        own.sense = sense;
        self.sense_neighbours(id.index);
        Ok(())
    }

    /// Wakes an agent at a time, once; `None` lets it sleep.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`], and [`throng_base::Error::Value`] for a time in the past.
    pub fn set_timer(&mut self, id: Id, time_s: Option<f64>) -> Result<()> {
        self.check_id(id)?;
        let time = time_s.unwrap_or(f64::INFINITY);
        let expected = "not before the present, and at most 1e9";
        let good = time >= self.now && (time <= 1e9 || time_s.is_none());
        throng_base::error::check_value("time_s", Some(id), time, good, expected)?;
        self.sensors.states[id.index()].timer = time;
        self.queue_senses(id.index);
        Ok(())
    }

    /// Forgets what an agent that has left sensed.
    pub fn forget_senses(&mut self, agent: u32) {
        self.sensors.states[agent as usize] = SensingState::default();
        self.sensors.boxes.remove(agent as usize);
        self.queue_senses(agent);
    }

    /// Queues the next sensed event of an agent, and its timer: after the events of the engine at the same time.
    fn queue_senses(&mut self, agent: u32) {
        let num = self.states.len() as u32;
        let own = &self.sensors.states[agent as usize];
        for (number, time) in [(num + agent, own.next.map_or(f64::INFINITY, |n| n.0)), (2 * num + agent, own.timer)] {
            if time < 1e9 { self.queue.set(number, time) } else { self.queue.remove(number) }
        }
    }

    /// Finds the next sensed event of an agent with a new plan, or with new senses.
    pub fn sense_neighbours(&mut self, agent: u32) {
        let sense = self.sensors.states[agent as usize].sense;
        if sense == (Sense { arrivals: sense.arrivals, ..Sense::default() }) || self.states[agent as usize].cell == NONE
        {
            if self.sensors.states[agent as usize].next.take().is_some() {
                self.queue_senses(agent);
            }
            self.sensors.boxes.remove(agent as usize);
            return;
        }
        let plan = self.cells.plan(agent);
        let now = self.now.max(plan.start);
        let bounds = swept_bounds(&plan, now);
        let mut found: Option<(f64, u8, SensedEvent)> = None;
        let mut take = |time: f64, rank: u8, what: SensedEvent| {
            if found.is_none_or(|(t, r, w)| (time, rank, number(what)) < (t, r, number(w))) {
                found = Some((time, rank, what));
            }
        };
        let sensors = &self.sensors;
        if sense.zones {
            sensors.zones.visit_intersecting(&bounds, |z| {
                let zone = &sensors.senses.zones[z];
                let there = MotionPlan {
                    start: now,
                    end: plan.end,
                    position: zone.centre,
                    moving: f32::INFINITY,
                    ..MotionPlan::default()
                };
                let near = is_near(&plan, &there, zone.radius, now);
                if let Some(at) = first_change(&plan, &there, zone.radius, now, plan.end, near) {
                    let z = z as u32;
                    if near { take(at, 0, SensedEvent::WentFrom(z)) } else { take(at, 1, SensedEvent::CameTo(z)) }
                }
                true
            });
        }
        if sense.cells
            && sensors.senses.cell_m > 0.0
            && let Some(at) = leaves_cell(&plan, sensors, now)
        {
            let [from, to] = [now, at].map(|time| sensors.cell_at(plan.motion_at(time).0));
            take(at, 2, SensedEvent::Crossed { by: [0, 1].map(|i| (to[i] - from[i]) as i16) });
        }
        let meet_m = sensors.senses.meet_m;
        let mut partner_start = 0.0;
        if meet_m > 0.0 && (sense.sends | sense.receives) != 0 {
            self.sensors.boxes.set(agent as usize, bounds);
            let sensors = &self.sensors;
            sensors.boxes.visit_intersecting(&bounds.expanded_by(meet_m), |o| {
                let other = &sensors.states[o];
                let (any, at_once) = sense.channels(&other.sense);
                if o == agent as usize || any == 0 {
                    return true;
                }
                if let Some(at) = self.meeting_time(&plan, o as u32, now, at_once != 0) {
                    take(at, 3, SensedEvent::Met(o as u32));
                }
                true
            });
        } else {
            self.sensors.boxes.remove(agent as usize);
        }
        if let Some((_, _, SensedEvent::Met(other))) = found {
            partner_start = self.cells.plan(other).start;
        }
        let own = &mut self.sensors.states[agent as usize];
        own.next = found.map(|(time, _, what)| (time, what));
        own.partner_start = partner_start;
        self.queue_senses(agent);
    }

    /// Time at which an agent and another one meet, until one of them takes a new plan.
    fn meeting_time(&self, plan: &MotionPlan<V>, other: u32, now: f64, at_once: bool) -> Option<f64> {
        let meet_m = self.sensors.senses.meet_m;
        let theirs = self.cells.plan(other);
        let until = plan.end.min(theirs.end);
        let near = is_near(plan, &theirs, meet_m, now);
        if near && at_once {
            let (own, its) = (&self.sensors.states[plan.index as usize], &self.sensors.states[other as usize]);
            let is_new = own.changed.0 == now && own.last.is_none_or(|last| other > last);
            if is_new && (its.changed.0 != now || its.changed.1 < own.changed.1) {
                return Some(now);
            }
        }
        // Apart first, and then together again.
        let apart = if near { first_change(plan, &theirs, meet_m, now, until, true)? } else { now };
        first_change(plan, &theirs, meet_m, apart, until, false)
    }

    /// An entry of the queue that is no event of the engine: what an agent senses, or its timer.
    pub fn process_sense(&mut self, entry: u32) {
        let num = self.states.len() as u32;
        let agent = entry % num;
        if entry >= 2 * num {
            self.sensors.states[agent as usize].timer = f64::INFINITY;
            self.queue_senses(agent);
            self.report_event(agent, CrowdEventKind::Timer);
            return;
        }
        let own = self.sensors.states[agent as usize];
        let Some((time, what)) = own.next else { return self.queue.remove(entry) };
        match what {
            SensedEvent::Met(other) => {
                let theirs = self.sensors.states[other as usize];
                let is_there = self.states[other as usize].cell != NONE;
                let is_same = is_there && self.cells.plan(other).start == own.partner_start && {
                    let (mine, its) = (self.cells.plan(agent), self.cells.plan(other));
                    is_near(&mine, &its, self.sensors.senses.meet_m, time)
                };
                if is_same && own.sense.channels(&theirs.sense).0 != 0 {
                    if own.changed.0 == time {
                        self.sensors.states[agent as usize].last = Some(other);
                    }
                    let (first, second) = (agent.min(other), agent.max(other));
                    self.report_event(first, CrowdEventKind::Met { other: self.id(second) });
                    self.sense_neighbours(other);
                }
            }
            SensedEvent::CameTo(zone) => self.report_event(agent, CrowdEventKind::CameTo { zone: zone as usize }),
            SensedEvent::WentFrom(zone) => self.report_event(agent, CrowdEventKind::WentFrom { zone: zone as usize }),
            SensedEvent::Crossed { by } => {
                let to = self.sensors.cell_at(self.cells.plan(agent).motion_at(time).0);
                let from = [0, 1].map(|i: usize| to[i].wrapping_sub(i32::from(by[i])));
                self.report_event(agent, CrowdEventKind::Crossed { from, to });
            }
        }
        self.sense_neighbours(agent);
    }

    /// Restores state that is not saved, after a snapshot.
    pub fn relink_senses(&mut self) {
        self.sensors.boxes.clear();
        self.sensors.signals.clear();
        self.sensors.changes = self.sensors.states.iter().map(|own| own.changed.1).max().unwrap_or(0);
        for agent in 0..self.states.len() as u32 {
            let own = self.sensors.states[agent as usize];
            if self.states[agent as usize].cell == NONE {
                continue;
            }
            if (own.sense.sends | own.sense.receives) != 0 && self.sensors.senses.meet_m > 0.0 {
                let plan = self.cells.plan(agent);
                self.sensors.boxes.set(agent as usize, swept_bounds(&plan, plan.start));
            }
            self.queue_senses(agent);
        }
    }
}

/// Order of what is sensed at one time.
fn number(what: SensedEvent) -> i64 {
    match what {
        SensedEvent::Met(n) | SensedEvent::CameTo(n) | SensedEvent::WentFrom(n) => i64::from(n),
        SensedEvent::Crossed { .. } => 0,
    }
}
