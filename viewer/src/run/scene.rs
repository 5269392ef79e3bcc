//! A scene: groups moved by whatever moves them, played, stopped, and rewound over its last minute.
//!
//! Bodies are not recorded. The state of every second is; a step in between is found again by repeating the steps after
//! the state before it, which gives the same bodies to the last bit.

use super::STEP_HZ;
use super::reel::Head;
use glam::Vec3;
use std::collections::VecDeque;
use std::fmt;
use std::time::Instant;
use throng_runtime::simulation::{CompiledScene, Event, Simulation};
use throng_runtime::{Inline, Rayon, Result, Run as Threads};

/// Steps between two states.
const STATE_EVERY: u32 = 60;
/// Steps that can be gone back: one minute.
const RECORDED_STEPS: u32 = 3600;
/// Memory that states may take (bytes).
const MAX_BYTES: usize = 512 << 20;
/// About what the state of a character takes (bytes).
const CHARACTER_BYTES: usize = 16 << 10;
/// Steps between two points of a trail.
const TRAIL_EVERY: u32 = 6;
/// Characters from which on a step is split over threads.
const PARALLEL_FROM: usize = 200;

/// State of a scene at a step.
#[derive(Clone)]
struct Keyframe {
    step: u32,
    state: Simulation,
}

/// A scene that runs, with the record of its last minute.
pub struct SceneRun {
    simulation: Simulation,
    /// Which of the recorded steps is shown.
    pub head: Head,
    /// Ascending; the first is that of the first recorded step.
    keyframes: VecDeque<Keyframe>,
    /// Events of the recorded steps, with their steps.
    events: VecDeque<(u32, Event)>,
    /// Places of all characters at every [`TRAIL_EVERY`]th step; `None` for one that has left (m).
    trails: VecDeque<(u32, Vec<Option<Vec3>>)>,
    /// Wall time of the last new step (s).
    step_s: f64,
}

impl fmt::Debug for SceneRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SceneRun").field("time_s", &self.simulation.time_s()).field("head", &self.head).finish()
    }
}

impl SceneRun {
    /// All characters where they start.
    ///
    /// # Errors
    /// [`throng_runtime::Error`] for starts or goals that are impossible.
    pub fn new(scene: &CompiledScene) -> Result<Self> {
        let simulation = Simulation::new(scene)?;
        let first = Keyframe { step: 0, state: simulation.clone() };
        let mut run = Self {
            simulation,
            head: Head::default(),
            keyframes: VecDeque::from([first]),
            events: VecDeque::new(),
            trails: VecDeque::new(),
            step_s: 0.0,
        };
        run.keep_trail(0);
        Ok(run)
    }

    /// The scene at the step shown.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Wall time of the last new step (s).
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Number of characters that are there.
    pub fn num_present(&self) -> usize {
        self.simulation.roots().flatten().count()
    }

    /// One step forward: a recorded one, or a new one.
    ///
    /// # Errors
    /// [`throng_runtime::Error`] where the step cannot be taken.
    pub fn step(&mut self) -> Result<()> {
        let step = self.head.now() + 1;
        let begin = Instant::now();
        self.advance_to(step)?;
        if !self.head.on() {
            self.step_s = begin.elapsed().as_secs_f64();
            self.record(step);
        }
        Ok(())
    }

    /// Shows a recorded step, the nearest one there is.
    ///
    /// # Errors
    /// [`throng_runtime::Error`] where a step cannot be repeated.
    pub fn seek(&mut self, step: u32) -> Result<()> {
        let shown = self.head.now();
        self.head.seek(step);
        let step = self.head.now();
        let after = self.keyframes.partition_point(|k| k.step <= step);
        let before = &self.keyframes[after.saturating_sub(1)];
        let mut at = shown;
        if step < shown || before.step > shown {
            self.simulation.clone_from(&before.state);
            at = before.step;
        }
        (at + 1..=step).try_for_each(|step| self.advance_to(step))
    }

    /// Events of the recorded steps up to the one shown, the latest first.
    pub fn events(&self) -> impl Iterator<Item = &Event> {
        let now = self.head.now();
        self.events.iter().rev().skip_while(move |e| e.0 > now).map(|e| &e.1)
    }

    /// Where a character has been during the last `seconds`, now and then, and now (m).
    pub fn trail(&self, who: usize, seconds: f32) -> impl Iterator<Item = Vec3> {
        let now = self.head.now();
        let from = now.saturating_sub((seconds * STEP_HZ) as u32);
        let recorded = self.trails.iter().filter(move |t| (from..now).contains(&t.0));
        recorded.filter_map(move |t| *t.1.get(who)?).chain(self.place(who))
    }

    /// Where a character is: the middle of an agent in the air, else on the ground that it stands on; `None` if it has left
    /// (m).
    pub fn place(&self, who: usize) -> Option<Vec3> {
        if let Some(disc) = self.simulation.disc(who) {
            return Some(disc.centre);
        }
        let root = self.simulation.root(who)?.translation();
        let Some(pose) = self.simulation.pose(who) else { return Some(root) };
        use throng_runtime::Joint::{LeftFoot, RightFoot};
        let ankle = [LeftFoot, RightFoot].map(|j| pose[j.index()].translation().y);
        Some(root.with_y(ankle[0].min(ankle[1])))
    }

    fn advance_to(&mut self, step: u32) -> Result<()> {
        let is_large = self.simulation.num_characters() >= PARALLEL_FROM;
        let threads: &dyn Threads = if is_large { &Rayon } else { &Inline };
        self.simulation.step_to(f64::from(step) / f64::from(STEP_HZ), threads)
    }

    /// Records a new step, which is shown.
    fn record(&mut self, step: u32) {
        self.events.extend(self.simulation.events().iter().map(|&e| (step, e)));
        self.keep_trail(step);
        if step.is_multiple_of(STATE_EVERY) {
            self.keyframes.push_back(Keyframe { step, state: self.simulation.clone() });
        }
        let mut first = *self.head.recorded().start();
        let bytes = self.keyframes.len() * self.simulation.num_characters() * CHARACTER_BYTES;
        let is_full = step - first > RECORDED_STEPS + STATE_EVERY || bytes > MAX_BYTES;
        if let Some(second) = self.keyframes.get(1).map(|k| k.step).filter(|_| is_full) {
            self.keyframes.pop_front();
            while self.events.pop_front_if(|e| e.0 <= second).is_some() {}
            while self.trails.pop_front_if(|t| t.0 < second).is_some() {}
            first = second;
        }
        self.head.record(first..=step, step);
    }

    fn keep_trail(&mut self, step: u32) {
        if step.is_multiple_of(TRAIL_EVERY) {
            let places = (0..self.simulation.num_characters()).map(|who| self.place(who)).collect();
            self.trails.push_back((step, places));
        }
    }
}
