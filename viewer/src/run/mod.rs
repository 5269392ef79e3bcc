//! A recorded run of a crowd: played, stopped, stepped, and rewound over its last minute.
//!
//! Poses are not recorded. A keyframe every second and every input since are; a step in between is found again by
//! repeating the steps from the keyframe before it, which give the same poses to the last bit.

mod blend;
mod blending;
mod cast;
mod config;
mod figures;
mod marks;
pub mod members;
mod recording;
mod reel;
mod simulation;
mod walkers;
mod why;
mod world;

pub use blend::{BlendMoment, BlendRun};
pub use blending::{Beside, Blending, LEGS, SIZES};
pub use cast::{About, RunGoal};
pub use config::{MAX_CHARACTERS, MAX_TARGET_M, RunConfig, STEP_HZ, TargetMode};
pub use figures::{BoutFigures, Slip, StepFigures};
pub use marks::{Mark, Met};
pub use recording::{RECORDED_STEPS, TRAIL_EVERY};
pub use reel::{Head, Reel};
pub use simulation::Input;
pub use walkers::{WalkMoment, WalkRun};
pub use why::{BehaviourScore, Candidate, Why};
pub use world::{Moment, WorldRun};

use crate::document::Bundle;
use glam::{Vec2, Vec3};
use recording::Recording;
use simulation::Simulation;
use std::ops::RangeInclusive;
use std::time::{Duration, Instant};
use throng_precompute::BuildError;
use throng_precompute::scene::{Cast as SceneCast, Play, Scene};
use throng_runtime::troupe::{Troupe, TroupeError};

/// Longest time that one call of [`Run::advance`] spends on steps, at least one step apart.
const BUDGET: Duration = Duration::from_millis(50);

/// A run of a crowd or a scene, with the record of its last minute.
#[derive(Clone, Debug)]
pub struct Run {
    simulation: Simulation,
    /// The scene that is run, if it is one.
    scene: Option<Box<Scene>>,
    recording: Recording,
    playing: bool,
    speed: f32,
    /// Simulated time that has passed but has not been stepped. [Unit: s]
    owed_s: f32,
    last: StepFigures,
}

impl Run {
    /// Puts the characters at their starts and takes the first choices.
    ///
    /// # Errors
    /// A message where the bundle has no behaviour or its tables do not fit together.
    pub fn new(bundle: &Bundle, config: RunConfig, weights: &[f32]) -> Result<Self, String> {
        let behaviours = bundle.tables().num_policies();
        if behaviours == 0 {
            return Err("This bundle has no behaviour to run: build it from a config with `behaviours`.".into());
        }
        // The first behaviour alone, until others are asked for.
        let mut weights = if weights.is_empty() { vec![1.0] } else { weights.to_vec() };
        weights.resize(behaviours.min(throng_runtime::troupe::MAX_GOALS), 0.0);
        let simulation = Simulation::new(bundle, config.limited(), weights).map_err(|e| e.to_string())?;
        Self::begin(bundle, simulation, None)
    }

    /// Puts the characters of a scene at their starts and takes the first choices.
    ///
    /// # Errors
    /// A message where the bundle lacks what the scene needs, with the way out.
    pub fn of_scene(bundle: &Bundle, scene: &Scene) -> Result<Self, String> {
        let simulation = Simulation::of_scene(bundle, scene).map_err(|e: BuildError| e.to_string())?;
        Self::begin(bundle, simulation, Some(Box::new(scene.clone())))
    }

    fn begin(bundle: &Bundle, simulation: Simulation, scene: Option<Box<Scene>>) -> Result<Self, String> {
        let recording = Recording::new(simulation.keyframe());
        let last = StepFigures::default();
        let mut run = Self { simulation, scene, recording, playing: false, speed: 1.0, owed_s: 0.0, last };
        run.step(bundle).map_err(|e| e.to_string())?;
        Ok(run)
    }

    /// The scene that is run; none of a crowd.
    pub fn scene(&self) -> Option<&Scene> {
        self.scene.as_deref()
    }

    /// The scene as it stands; none of a crowd.
    pub fn play_of_scene(&self) -> Option<&Play> {
        self.simulation.cast.play()
    }

    /// Where a target of a scene hangs when nobody has struck it; none where there is no such target. [Unit: m]
    pub fn home(&self, character: usize) -> Option<Vec3> {
        match &self.play_of_scene()?.cast {
            SceneCast::Pairs(_) => None,
            SceneCast::Targets(practice) => practice.targets().get(character).map(|t| t.home),
        }
    }

    /// Radius of the targets of a scene. [Unit: m]
    pub fn target_radius_m(&self) -> Option<f32> {
        match &self.play_of_scene()?.cast {
            SceneCast::Pairs(_) => None,
            SceneCast::Targets(practice) => Some(practice.config().target.radius_m),
        }
    }

    /// True where targets can be moved: not where each is an opponent's head.
    pub fn has_movable_targets(&self) -> bool {
        self.play_of_scene().is_none_or(|p| !p.homes.is_empty())
    }

    /// Blows of the last `seconds`.
    pub fn marks(&self, seconds: f32) -> impl Iterator<Item = &Mark> {
        let now = self.now();
        self.recording.marks((now + 1).saturating_sub((seconds * STEP_HZ) as u32), now)
    }

    /// What it is made of.
    pub fn config(&self) -> &RunConfig {
        &self.simulation.config
    }

    /// The characters as they are now.
    pub fn troupe(&self) -> &Troupe {
        self.simulation.cast.troupe()
    }

    /// Target of every character. [Unit: m] [Size: number of characters]
    pub fn targets(&self) -> &[Vec3] {
        &self.simulation.around.targets
    }

    /// What is weighed against each other.
    pub fn goals(&self) -> &[RunGoal] {
        &self.simulation.goals
    }

    /// Coming blow of every character of a pair: x, seconds, z; empty where nobody has an opponent.
    pub fn threats(&self) -> &[Vec3] {
        &self.simulation.around.threats
    }

    /// What every goal counts. [Size: number of goals]
    pub fn weights(&self) -> &[f32] {
        &self.simulation.around.weights
    }

    /// Number of the step that is shown, from 0.
    pub fn now(&self) -> u32 {
        self.simulation.around.step - 1
    }

    /// Time that is shown. [Unit: s]
    pub fn time_s(&self) -> f32 {
        self.now() as f32 / STEP_HZ
    }

    /// Steps that can be shown.
    pub fn recorded(&self) -> RangeInclusive<u32> {
        self.recording.range()
    }

    /// True where the step that is shown is the last one so far.
    pub fn is_live(&self) -> bool {
        self.now() == *self.recorded().end()
    }

    /// True where time moves on.
    pub fn is_playing(&self) -> bool {
        self.playing
    }

    /// How many simulated seconds pass in one.
    pub fn speed(&self) -> f32 {
        self.speed
    }

    /// Lets time move on, or stops it.
    pub fn play(&mut self, playing: bool) {
        self.playing = playing;
        self.owed_s = 0.0;
    }

    /// Sets how many simulated seconds pass in one. [Limit: 0.05 to 8, clamped]
    pub fn set_speed(&mut self, speed: f32) {
        self.speed = if speed.is_finite() { speed.clamp(0.05, 8.0) } else { 1.0 };
    }

    /// What was measured of the step that is shown, as far as it is recorded.
    pub fn figures(&self) -> StepFigures {
        self.recording.figures(self.now()).unwrap_or(self.last)
    }

    /// What was measured of every recorded step up to the one that is shown: step and figures.
    pub fn history(&self) -> impl Iterator<Item = (u32, &StepFigures)> {
        let now = self.now();
        self.recording.history().take_while(move |h| h.0 <= now)
    }

    /// Where a character has been during the last `seconds`, every [`TRAIL_EVERY`] steps, and now. [Unit: m]
    pub fn trail(&self, character: usize, seconds: f32) -> impl Iterator<Item = Vec2> {
        let now = self.now();
        let from = now.saturating_sub((seconds * STEP_HZ) as u32);
        let root = self.troupe().root(character);
        self.recording.trail(character, from, now).chain([Vec2::new(root.x, root.z)])
    }

    /// Memory that the record takes. [Unit: bytes]
    pub fn recording_bytes(&self) -> usize {
        self.recording.num_bytes()
    }

    /// Moves time on by wall time, as far as the time budget allows; what does not fit is dropped, so that a slow
    /// machine shows slow motion.
    ///
    /// # Errors
    /// [`TroupeError`] where a step cannot be taken.
    pub fn advance(&mut self, bundle: &Bundle, wall_s: f32) -> Result<u32, TroupeError> {
        if !self.playing {
            return Ok(0);
        }
        self.owed_s += wall_s.clamp(0.0, 0.25) * self.speed;
        let begin = Instant::now();
        let mut steps = 0;
        while self.owed_s >= 1.0 / STEP_HZ {
            if steps > 0 && begin.elapsed() > BUDGET {
                self.owed_s = 0.0;
                break;
            }
            self.owed_s -= 1.0 / STEP_HZ;
            self.step(bundle)?;
            steps += 1;
        }
        Ok(steps)
    }

    /// One step on: the next recorded one, or a new one at the end of the record.
    ///
    /// # Errors
    /// [`TroupeError`] where a step cannot be taken.
    pub fn step(&mut self, bundle: &Bundle) -> Result<(), TroupeError> {
        let s = &mut self.simulation;
        self.recording.before(s);
        for input in self.recording.inputs(s.around.step) {
            s.take(bundle, input)?;
        }
        let figures = s.step(bundle)?;
        self.recording.after(s, figures);
        self.last = figures;
        Ok(())
    }

    /// Shows a recorded step, the nearest one there is.
    ///
    /// # Errors
    /// [`TroupeError`] where a step cannot be repeated.
    pub fn seek(&mut self, bundle: &Bundle, step: u32) -> Result<(), TroupeError> {
        let step = step.clamp(*self.recorded().start(), *self.recorded().end());
        let keyframe = self.recording.keyframe_before(step);
        if step < self.simulation.around.step.saturating_sub(1) || keyframe.step() > self.simulation.around.step {
            self.simulation.restore(keyframe)?;
        }
        while self.simulation.around.step <= step {
            self.step(bundle)?;
        }
        self.owed_s = 0.0;
        Ok(())
    }

    /// Takes an input before the next step. What was recorded after the step that is shown is dropped: it did not
    /// know of the input. A target is kept within [`MAX_TARGET_M`]; one that is nowhere is not taken.
    pub fn input(&mut self, input: Input) {
        let Some(input) = input.limited() else { return };
        let next = self.simulation.around.step;
        // The target is shown where it is dragged to at once, even while time stands still.
        match &input {
            // An opponent's head is not to be moved.
            Input::Target { .. } if !self.has_movable_targets() => return,
            Input::Target { character, to } if self.simulation.move_target(*character, *to).is_err() => return,
            Input::Weights(weights) => self.simulation.around.weights.clone_from(weights),
            Input::Target { .. } | Input::Play { .. } => {}
        }
        self.recording.branch(next, input);
    }

    /// Why a character plays what it plays; none before its first choice and where the segment was not chosen.
    pub fn why(&self, bundle: &Bundle, character: usize) -> Option<Why> {
        why::explain(bundle, self, character)
    }

    /// What a character's last choice was about, and at which step it was.
    fn last_choice(&self, character: usize, about: About) -> (Vec3, u32) {
        let a = &self.simulation.around;
        let target = match about {
            About::Target => a.choice_targets[character],
            About::Threat => a.choice_threats[character],
        };
        (target, a.choice_steps[character])
    }

    /// Weights at a step, from the inputs before it.
    fn weights_at(&self, step: u32) -> &[f32] {
        self.recording.weights_at(step)
    }
}

#[cfg(test)]
mod tests;
