//! A recorded run of a crowd: played, stopped, stepped, and rewound over its last minute.
//!
//! Poses are not recorded. A keyframe every second and every input since are; a step in between is found again by
//! repeating the steps from the keyframe before it, which give the same poses to the last bit.

pub mod agents;
mod blend;
mod blending;
mod cast;
mod config;
mod figures;
mod marks;
mod recording;
mod reel;
mod scene;
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
pub use scene::SceneRun;
pub use simulation::Input;
pub use walkers::{WalkMoment, WalkRun};
pub use why::{BehaviourScore, Candidate, Why};
pub use world::{Moment, WorldRun};

use crate::bundle::OpenBundle;
use glam::{Vec2, Vec3};
use recording::Recording;
use simulation::Simulation;
use throng_precompute::BuildError;
use throng_precompute::scene::{Cast as SceneCast, Play, Scene};
use throng_runtime::characters::{Characters, CharactersError};

/// A run of a crowd or a scene, with the record of its last minute.
#[derive(Clone, Debug)]
pub struct Run {
    simulation: Simulation,
    /// The scene that is run, if it is one.
    scene: Option<Box<Scene>>,
    recording: Recording,
    /// Which of the recorded steps is shown.
    pub head: Head,
    last: StepFigures,
}

impl Run {
    /// Puts the characters at their starts and takes the first choices.
    ///
    /// # Errors
    /// A message where the bundle has no behaviour or its tables do not fit together.
    pub fn new(bundle: &OpenBundle, config: RunConfig, weights: &[f32]) -> Result<Self, String> {
        let behaviours = bundle.tables().policies().len();
        if behaviours == 0 {
            return Err("This bundle has no behaviour to run: build it from a config with `behaviours`.".into());
        }
        // The first behaviour alone, until others are asked for.
        let mut weights = if weights.is_empty() { vec![1.0] } else { weights.to_vec() };
        weights.resize(behaviours.min(throng_runtime::characters::MAX_GOALS), 0.0);
        let simulation = Simulation::new(bundle, config.limited(), weights).map_err(|e| e.to_string())?;
        Self::begin(bundle, simulation, None)
    }

    /// Puts the characters of a scene at their starts and takes the first choices.
    ///
    /// # Errors
    /// A message where the bundle lacks what the scene needs, with the way out.
    pub fn of_scene(bundle: &OpenBundle, scene: &Scene) -> Result<Self, String> {
        let simulation = Simulation::of_scene(bundle, scene).map_err(|e: BuildError| e.to_string())?;
        Self::begin(bundle, simulation, Some(Box::new(scene.clone())))
    }

    fn begin(bundle: &OpenBundle, simulation: Simulation, scene: Option<Box<Scene>>) -> Result<Self, String> {
        let recording = Recording::new(simulation.keyframe());
        let last = StepFigures::default();
        let mut run = Self { simulation, scene, recording, head: Head::default(), last };
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

    /// Place of a target of a scene at rest; none if there is no such target (m).
    pub fn home(&self, character: usize) -> Option<Vec3> {
        match &self.play_of_scene()?.cast {
            SceneCast::Pairs(_) => None,
            SceneCast::Targets(practice) => practice.targets().get(character).map(|t| t.home),
        }
    }

    /// Radius of the targets of a scene (m).
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
    pub fn characters(&self) -> &Characters {
        self.simulation.cast.characters()
    }

    /// Target of every character (m, number of characters).
    pub fn targets(&self) -> &[Vec3] {
        &self.simulation.around.targets
    }

    /// What is weighed against each other.
    pub fn goals(&self) -> &[RunGoal] {
        &self.simulation.goals
    }

    /// Coming blow of every character of a pair: x, seconds, z; empty without opponents.
    pub fn threats(&self) -> &[Vec3] {
        &self.simulation.around.threats
    }

    /// What every goal counts (number of goals).
    pub fn weights(&self) -> &[f32] {
        &self.simulation.around.weights
    }

    /// Number of the step shown, from 0.
    pub fn now(&self) -> u32 {
        self.simulation.around.step - 1
    }

    /// Time that is shown (s).
    pub fn time_s(&self) -> f32 {
        self.now() as f32 / STEP_HZ
    }

    /// What was measured of the step shown, as far as it is recorded.
    pub fn figures(&self) -> StepFigures {
        self.recording.figures(self.now()).unwrap_or(self.last)
    }

    /// What was measured of every recorded step up to the one shown: step and figures.
    pub fn history(&self) -> impl Iterator<Item = (u32, &StepFigures)> {
        let now = self.now();
        self.recording.history().take_while(move |h| h.0 <= now)
    }

    /// Where a character has been during the last `seconds`, every [`TRAIL_EVERY`] steps, and now (m).
    pub fn trail(&self, character: usize, seconds: f32) -> impl Iterator<Item = Vec2> {
        let now = self.now();
        let from = now.saturating_sub((seconds * STEP_HZ) as u32);
        let root = self.characters().root(character);
        self.recording.trail(character, from, now).chain([Vec2::new(root.x, root.z)])
    }

    /// Memory that the record takes (bytes).
    pub fn recording_bytes(&self) -> usize {
        self.recording.num_bytes()
    }

    /// One step forward: the next recorded one, or a new one at the end of the record.
    ///
    /// # Errors
    /// [`CharactersError`] where a step cannot be taken.
    pub fn step(&mut self, bundle: &OpenBundle) -> Result<(), CharactersError> {
        let s = &mut self.simulation;
        self.recording.before(s);
        for input in self.recording.inputs(s.around.step) {
            s.take(bundle, input)?;
        }
        let figures = s.step(bundle)?;
        self.recording.after(s, figures);
        self.last = figures;
        self.show_now();
        Ok(())
    }

    /// Shows a recorded step, the nearest one there is.
    ///
    /// # Errors
    /// [`throng_runtime::Error`] where a step cannot be repeated.
    pub fn seek(&mut self, bundle: &OpenBundle, step: u32) -> throng_runtime::Result<()> {
        self.head.seek(step);
        let step = self.head.now();
        let keyframe = self.recording.keyframe_before(step);
        if step < self.simulation.around.step.saturating_sub(1) || keyframe.step() > self.simulation.around.step {
            self.simulation.restore(bundle, keyframe)?;
        }
        while self.simulation.around.step <= step {
            self.step(bundle)?;
        }
        Ok(())
    }

    fn show_now(&mut self) {
        self.head.record(self.recording.range(), self.now());
    }

    /// Takes an input before the next step. What was recorded after the step shown is dropped: it did not
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
        self.show_now();
    }

    /// Why a character plays what it plays; none before its first choice and where the segment was not chosen.
    pub fn why(&self, bundle: &OpenBundle, character: usize) -> Option<Why> {
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
