//! A scene of a crowd that acts at its own events: played, stopped, and rewound as far as it is recorded.
//!
//! What was seen is recorded, not the state of the engine: what was seen can be shown again, and continues at its end.

mod bodies;
mod happened;
mod moment;
mod rates;
mod sim;

pub use bodies::SeenBodies;
pub use happened::{EventLog, Happened, What, With};
pub use moment::{Cast, CrowdMoment, Details, FORCE_TERMS, Figures, SeenAgent};
pub use rates::{Rates, WINDOW_S};

use super::STEP_HZ;
use super::reel::Reel;
use crate::bundle::OpenBundle;
use glam::{Vec2, Vec3};
use sim::{In, Sim};
use std::fmt;
use std::sync::Arc;
use std::time::Instant;
use throng_precompute::BuildError;
use throng_precompute::scene::crowd::{CrowdScene, CrowdSpace};
use throng_runtime::crowd::Event;
use throng_runtime::{Contacts, Mat3x4, NUM_JOINTS, Planar};

/// Steps between two points of a trail.
const TRAIL_EVERY: u32 = 6;
/// Time that a piece of a step should take; after each, a frame may end (s).
const PIECE_S: f64 = 0.003;
/// A step is cut into so many pieces at most.
const MOST_PIECES: f64 = 256.0;
/// What an agent's step may take before one was measured (s).
const GUESSED_S: f64 = 1e-6;

/// The record of a scene of a crowd.
pub struct CrowdRun {
    sim: Box<dyn Sim>,
    cast: Cast,
    /// All of them at the recorded steps.
    pub reel: Reel<CrowdMoment>,
    log: EventLog,
    /// Agent whose events and forces are recorded.
    watched: Option<usize>,
    /// Time of the first step (s).
    start_s: f64,
    /// Steps taken since.
    steps: u64,
    /// How far the engine is, perhaps within a step (s).
    time_s: f64,
    /// Steps that were asked for one by one and have not been shown.
    wanted: u32,
    /// What the step that is under way has taken so far, and what the last one took (s).
    spent_s: [f64; 2],
}

impl fmt::Debug for CrowdRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CrowdRun").field("agents", &self.cast.groups.len()).field("time_s", &self.time_s).finish()
    }
}

impl CrowdRun {
    /// All agents at their starts, or in a saved state; bodies restart there.
    ///
    /// - `kept`: what [`CrowdRun::snapshot`] gave for the same scene.
    /// - `bundle`: that of the bodies; agents are discs or balls without one.
    ///
    /// # Errors
    /// [`BuildError`] for an impossible start, a goal without a way, bytes that were kept of another scene, or a blend
    /// space that the bundle does not have.
    pub fn new(scene: &CrowdScene, kept: Option<&[u8]>, bundle: Option<Arc<OpenBundle>>) -> Result<Self, BuildError> {
        let mut sim: Box<dyn Sim> = match scene.space {
            CrowdSpace::Ground => Box::new(In::<Vec2>::new(scene, kept)?.with_bodies(scene, bundle)?),
            CrowdSpace::Air => Box::new(In::<Vec3>::new(scene, kept)?),
        };
        let (cast, start_s) = (sim.cast(scene), sim.now());
        let (first, n) = (sim.see(None, true, 0.0)?, cast.groups.len());
        let mut log = EventLog::default();
        log.mark(start_s, first.figures.present);
        let body = NUM_JOINTS * size_of::<Mat3x4>() + size_of::<(u32, Planar, Contacts)>();
        let each = size_of::<Option<SeenAgent>>() + if first.bodies.is_some() { body } else { 0 };
        let reel = Reel::new(n * each, first);
        let spent_s = [0.0, GUESSED_S * n as f64];
        Ok(Self { sim, cast, reel, log, watched: None, start_s, steps: 0, time_s: start_s, wanted: 0, spent_s })
    }

    /// What does not change.
    pub fn cast(&self) -> &Cast {
        &self.cast
    }

    /// All of them at the step shown.
    pub fn moment(&self) -> &CrowdMoment {
        self.reel.moment()
    }

    /// What has happened; that of later than the step shown, too.
    pub fn log(&self) -> &EventLog {
        &self.log
    }

    /// Wall time of the engine for the last step (s).
    pub fn step_s(&self) -> f64 {
        self.spent_s[1]
    }

    /// True where a frame without a play head that moves still has work to do.
    pub fn is_busy(&self) -> bool {
        self.wanted > 0 || self.is_mid_step()
    }

    fn is_mid_step(&self) -> bool {
        self.time_s > self.start_s + self.steps as f64 / f64::from(STEP_HZ)
    }

    /// Asks for steps, which [`CrowdRun::advance`] takes.
    pub fn want(&mut self, steps: u32) {
        self.wanted += steps;
    }

    /// Takes back steps that were asked for.
    pub fn want_no_more(&mut self) {
        self.wanted = 0;
    }

    /// Keeps events and forces of another agent from now on.
    pub fn watch(&mut self, agent: Option<usize>) {
        let agent = agent.filter(|&m| m < self.cast.groups.len());
        if agent == self.watched {
            return;
        }
        self.watched = agent;
        self.log.watch(agent);
        if self.reel.head.is_live() && !self.is_mid_step() {
            let mut moment = self.reel.moment().clone();
            moment.details = agent.and_then(|m| self.sim.details(m));
            self.reel.replace(moment);
        }
    }

    /// Moves time on by wall time, until a deadline where there is one; returns the steps that were shown.
    ///
    /// # Errors
    /// [`BuildError`] where the engine does not get on.
    pub fn advance(&mut self, wall_s: f32, deadline: Option<Instant>) -> Result<u32, BuildError> {
        self.reel.head.owe(wall_s);
        let (begin, mut shown) = (Instant::now(), 0);
        while self.is_mid_step() || self.wanted > 0 || self.reel.head.is_due(shown, begin) {
            if !self.go_on(deadline)? {
                self.reel.head.let_go();
                break;
            }
            self.wanted = self.wanted.saturating_sub(1);
            shown += 1;
            if deadline.is_some_and(|d| Instant::now() >= d) {
                self.reel.head.let_go();
                break;
            }
        }
        Ok(shown)
    }

    /// One step forward: a recorded one, or a new one; false where the deadline comes before its end.
    fn go_on(&mut self, deadline: Option<Instant>) -> Result<bool, BuildError> {
        if self.reel.head.on() {
            return Ok(true);
        }
        let hz = f64::from(STEP_HZ);
        let end_s = self.start_s + (self.steps + 1) as f64 / hz;
        let pieces = (self.spent_s[1] / PIECE_S).ceil().clamp(1.0, MOST_PIECES);
        let mut told = Vec::new();
        while self.time_s < end_s {
            let piece_s = if deadline.is_some() { 1.0 / (hz * pieces) } else { 1.0 / hz };
            let until_s = if self.time_s + 1.001 * piece_s < end_s { self.time_s + piece_s } else { end_s };
            let begin = Instant::now();
            let done = self.sim.advance(until_s, &mut |e| told.push(*e));
            self.spent_s[0] += begin.elapsed().as_secs_f64();
            self.take_down(&told);
            told.clear();
            done?;
            self.time_s = until_s;
            if until_s < end_s && deadline.is_some_and(|d| Instant::now() >= d) {
                return Ok(false);
            }
        }
        self.steps += 1;
        self.spent_s = [0.0, self.spent_s[0]];
        // Overlaps and progress are measured as often as the benches do.
        let moment = self.sim.see(self.watched, self.steps.is_multiple_of(2), 1.0 / STEP_HZ)?;
        self.log.mark(end_s, moment.figures.present);
        self.reel.push(moment);
        Ok(true)
    }

    /// Writes events into the log, with where they happened.
    fn take_down(&mut self, told: &[Event]) {
        for event in told {
            let Some((what, with)) = What::of(&event.kind) else { continue };
            let agent = event.agent.index();
            let last = |m: usize| self.reel.last().agents.get(m).copied().flatten().map(|s| s.at);
            let place = |m: usize| self.sim.place(m, event.time).or_else(|| last(m));
            let other_at = if let With::Agent(other) = with { place(other) } else { None };
            let at = place(agent).unwrap_or_default();
            self.log.add(Happened { time_s: event.time, agent, what, with, at, other_at });
        }
    }

    /// Corners of an agent's way, from where it was sent to its goal (m, agent < number of agents).
    pub fn way(&self, agent: usize) -> Vec<Vec3> {
        self.sim.way(agent)
    }

    /// Where an agent has been during the last `seconds`, now and then (m).
    pub fn trail(&self, agent: usize, seconds: f32) -> impl Iterator<Item = Vec3> {
        let at = move |m: &CrowdMoment| Some(m.agents.get(agent)?.as_ref()?.at);
        self.reel.before(seconds, TRAIL_EVERY).filter_map(at)
    }

    /// The state of the engine, for [`CrowdRun::new`]; where a step is under way, as it is within it.
    pub fn snapshot(&self) -> Vec<u8> {
        self.sim.snapshot()
    }

    /// A number that differs where the motion of anybody differs.
    pub fn state_hash(&self) -> u64 {
        self.sim.state_hash()
    }
}

#[cfg(test)]
mod tests;
