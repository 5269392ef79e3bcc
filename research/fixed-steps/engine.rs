//! Fixed steps of time, undone where discs overlap: the baseline of Kim, Kim and Shin (2003b), section 4.
//!
//! It shares cells, plans, decisions and counts with the engine of events, which are nobody else's: so it is compiled as
//! `events::fixed` of `throng-crowd`, with the feature `fixed-steps`.

use crate::events::decide::{Decider, Decision, total};
use crate::events::engine::Engine;
use crate::senses::SensingState;
use crate::space::plan::MotionPlan;
use crate::{CrowdConfig, CrowdError, NONE, Scheme, Space};
use serde::{Deserialize, Serialize};

/// An overlap that is not let be (m).
const TOO_DEEP: f32 = 1e-3;
/// How often all agents are checked again after velocities were taken away.
const PASSES: usize = 4;

/// The scheme's memory.
#[derive(Clone, Debug)]
pub(crate) struct Fixed<V> {
    /// Memory that is kept between steps.
    pub steps: Steps,
    /// The motion of each agent in this step.
    decisions: Vec<Decision<V>>,
    /// The place of each agent at its end, by number.
    ends: Vec<V>,
}

/// What is remembered between steps.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Steps {
    /// Shortest step (s).
    shortest_s: f64,
    /// Shortest steps in one that was never halved.
    whole: u64,
    /// Shortest steps that were made.
    done: u64,
}

impl<V: Space> Fixed<V> {
    /// At time 0; none for the schemes of events.
    pub fn new(config: &CrowdConfig, capacity: usize) -> Option<Self> {
        if !matches!(config.scheme, Scheme::Fixed | Scheme::Pairs) {
            return None;
        }
        let whole = 1 << config.halvings;
        let steps = Steps { shortest_s: f64::from(config.step_s) / whole as f64, whole, done: 0 };
        Some(Self { steps, decisions: Vec::with_capacity(capacity), ends: vec![V::default(); capacity] })
    }
}

impl Steps {
    /// True where steps are the same as those of another one, and what was done ends after the present.
    pub fn fits(&self, other: &Self, now: f64) -> bool {
        let end = self.done as f64 * self.shortest_s;
        let step = self.shortest_s * self.whole as f64;
        (self.shortest_s, self.whole) == (other.shortest_s, other.whole) && (now..=now + step).contains(&end)
    }

    /// Shortest steps until the next time at which a step may end: halves begin in the middle and at the ends of a step.
    fn longest(&self) -> u64 {
        if self.done.is_multiple_of(self.whole) { self.whole } else { 1 << self.done.trailing_zeros() }
    }
}

impl<V: Space> Engine<V> {
    pub(crate) fn run_steps(&mut self, fixed: &mut Fixed<V>, until_s: f64) -> Result<bool, CrowdError> {
        loop {
            let time = fixed.steps.done as f64 * fixed.steps.shortest_s;
            // What is sensed within the last step, which is final now.
            while let Some((sensed, entry)) = self.queue.first(time.min(until_s)) {
                if self.is_full() {
                    return Ok(false);
                }
                if (entry as usize) < self.states.len() {
                    self.queue.remove(entry);
                    continue;
                }
                self.now = sensed;
                self.process_sense(entry);
            }
            if time > until_s || self.is_full() {
                return Ok(time > until_s && !self.is_full());
            }
            self.refresh_grid_until(time);
            self.now = time;
            self.step(fixed);
        }
    }

    fn step(&mut self, fixed: &mut Fixed<V>) {
        let mut length = fixed.steps.longest();
        let shortest_s = fixed.steps.shortest_s;
        let seconds = |length: u64| (length as f64 * shortest_s) as f32;
        let most = seconds(length);
        fixed.decisions.clear();
        for agent in 0..self.states.len() as u32 {
            if self.states[agent as usize].cell != NONE {
                let decision = self.desired_motion(agent, most);
                fixed.decisions.push(decision);
            }
        }
        for decision in &fixed.decisions {
            let agent = decision.plan.index;
            if self.apply(agent, decision) {
                self.free.push(agent);
            }
        }
        while self.overlap(fixed, seconds(length)) {
            self.counts.undone += 1;
            if length == 1 {
                self.stop(fixed, seconds(length));
                break;
            }
            length /= 2;
        }
        fixed.steps.done += length;
        let end = fixed.steps.done as f64 * fixed.steps.shortest_s;
        for decision in &fixed.decisions {
            let agent = decision.plan.index;
            let cell = self.states[agent as usize].cell;
            if cell != NONE {
                let plan = MotionPlan { end, ..self.cells.plan(agent) };
                self.cells.set(cell, cell, &plan);
            }
        }
        self.counts.steps += 1;
        self.look_about_all();
    }

    /// What an agent does if nothing but the forces moves it (Kim, Kim and Shin 2003b, eq. 14), no faster than any other scheme lets it.
    fn desired_motion(&mut self, agent: u32, step: f32) -> Decision<V> {
        let Self { scenery, cells, states, grid, turns, external_obstacles, relationships, scratch, .. } = self;
        let decider =
            Decider { scenery, cells, states, grid, turns, external_obstacles, relationships, time: self.now };
        let desired = decider.desired_motion(agent, None, scratch);
        let fresh = desired.fresh;
        let fastest = scenery.fastest;
        let wanted = total(&desired.forces).at_most(fresh.limit);
        let end = (fresh.velocity + wanted * step).at_most(fastest);
        let acceleration = ((end - fresh.velocity) * step.recip()).at_most(fresh.limit);
        let plan = MotionPlan { end: self.now + f64::from(step), acceleration, ..fresh };
        let mut state = desired.state;
        let struck_by = decider.striking_obstacle(&plan);
        state.is_struck = struck_by != NONE;
        Decision { leaves: decider.leaves(&state), plan, state, struck_by }
    }

    /// True where agents overlap at the end of a step, more than at its start.
    fn overlap(&self, fixed: &mut Fixed<V>, step: f32) -> bool {
        self.note_ends(fixed, step);
        fixed.decisions.iter().any(|d| self.deepest(fixed, d.plan.index, d.plan.index + 1).is_some())
    }

    /// Notes the places at the end of a step.
    fn note_ends(&self, fixed: &mut Fixed<V>, step: f32) {
        for d in &fixed.decisions {
            let agent = d.plan.index;
            if self.states[agent as usize].cell != NONE {
                fixed.ends[agent as usize] = self.cells.plan(agent).motion_after(step).0;
            }
        }
    }

    /// Unit vector to what an agent overlaps most at the end of a step, and which agent that is; of those with numbers from
    /// `from` on.
    fn deepest(&self, fixed: &Fixed<V>, agent: u32, from: u32) -> Option<(V, u32)> {
        if self.states[agent as usize].cell == NONE {
            return None;
        }
        let (me, end) = (self.cells.plan(agent), fixed.ends[agent as usize]);
        let mut deepest = TOO_DEEP;
        let mut found = None;
        self.cells.for_each_cell_around(self.cells.coordinates(me.position), |cell| {
            self.cells.for_each_in_cell(cell, |other| {
                if other.index < from || other.index == agent {
                    return;
                }
                let near = me.radius + other.radius - deepest;
                let apart = (fixed.ends[other.index as usize] - end).length_squared();
                if apart < near * near && near > 0.0 {
                    let (toward, before) = (other.position - me.position).unit_and_length();
                    if apart.sqrt() < before {
                        deepest = me.radius + other.radius - apart.sqrt();
                        found = Some((toward, other.index));
                    }
                }
            });
        });
        for &s in self.scenery.solids_near(self.states[agent as usize].cell) {
            let solid = &self.scenery.solids[s as usize];
            let (distance, (away, before)) =
                (solid.direction_and_distance(end).1, solid.direction_and_distance(me.position));
            if me.radius - distance > deepest && distance < before {
                deepest = me.radius - distance;
                found = Some((-away, NONE));
            }
        }
        found
    }

    /// Takes away velocity and acceleration with which agents run into something in the shortest step.
    fn stop(&mut self, fixed: &mut Fixed<V>, step: f32) {
        for _ in 0..PASSES {
            let mut is_free = true;
            for n in 0..fixed.decisions.len() {
                let agent = fixed.decisions[n].plan.index;
                let Some((toward, other)) = self.deepest(fixed, agent, 0) else { continue };
                is_free = false;
                for (m, toward) in [(agent, toward), (other, -toward)].into_iter().filter(|(m, _)| *m != NONE) {
                    let mut plan = self.cells.plan(m);
                    plan.velocity += toward * -plan.velocity.dot(toward).max(0.0);
                    plan.acceleration += toward * -plan.acceleration.dot(toward).max(0.0);
                    let cell = self.states[m as usize].cell;
                    self.cells.set(cell, cell, &plan);
                    fixed.ends[m as usize] = plan.motion_after(step).0;
                }
            }
            if is_free {
                return;
            }
        }
        let left = fixed.decisions.iter().filter(|d| self.deepest(fixed, d.plan.index, 0).is_some()).count();
        self.counts.overlaps += left as u64;
    }

    /// Looks for everybody, as after a step of everybody.
    fn look_about_all(&mut self) {
        for agent in 0..self.states.len() as u32 {
            if self.sensors.states[agent as usize] != SensingState::default() {
                self.sense_neighbours(agent);
            }
        }
    }
}
