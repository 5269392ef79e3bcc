//! Recorded runs of crowds, scenes, worlds and blends: played, stopped, stepped, and rewound over their last minute.
//!
//! Crowds and scenes record a state every second and every input; a step in between is reproduced by repeating the
//! steps from the state before it, bit for bit. Worlds and blends record poses.

pub mod agents;
mod blend;
mod blending;
mod blow_marks;
mod choice_reason;
mod choices;
mod config;
mod figures;
mod recording;
mod reel;
mod scene;
mod simulation;
mod world;

pub use blend::{BlendMoment, BlendRun};
pub use blending::{BlendCompanions, Blending, LEGS, SIZES};
pub use blow_marks::{BlowMark, BlowResult};
pub use choice_reason::{ActionCandidate, BehaviourScore, ChoiceReason, explain_choice};
pub use choices::{GoalSubject, PolicyChooser, RecordedChoice, RunGoal};
pub use config::{CrowdRunConfig, MAX_CHARACTERS, MAX_TARGET_M, STEP_HZ, TargetMode};
pub use figures::{BoutFigures, Slip, StepFigures};
pub use recording::{RECORDED_STEPS, TRAIL_EVERY};
pub use reel::{PlayHead, Reel};
pub use scene::SceneRun;
pub use simulation::{CrowdSimulation, RunInput};
pub use world::{InhabitantsMoment, WorldRun};

use crate::bundle::OpenBundle;
use glam::{Vec2, Vec3};
use recording::CrowdRecording;
use throng_core::Result;
use throng_core::characters::Characters;

/// A run of a crowd, with the record of its last minute.
#[derive(Clone, Debug)]
pub struct CrowdRun {
    /// The characters at the step shown.
    pub(crate) simulation: CrowdSimulation,
    recording: CrowdRecording,
    /// Which of the recorded steps is shown.
    pub head: PlayHead,
    last: StepFigures,
}

impl CrowdRun {
    /// Puts the characters at their starts and takes the first choices.
    ///
    /// # Errors
    /// A message where the bundle has no behaviour or its tables do not fit together.
    pub fn new(bundle: &OpenBundle, config: CrowdRunConfig, weights: &[f32]) -> Result<Self, String> {
        let behaviours = bundle.tables().policies().len();
        if behaviours == 0 {
            return Err("This bundle has no behaviour to run: build it from a config with `behaviours`.".into());
        }
        // Only the first behaviour counts, until others are requested.
        let mut weights = if weights.is_empty() { vec![1.0] } else { weights.to_vec() };
        weights.resize(behaviours.min(throng_core::characters::MAX_GOALS), 0.0);
        let simulation = CrowdSimulation::new(bundle, config.limited(), weights).map_err(|e| e.to_string())?;
        let (recording, last) = (CrowdRecording::new(simulation.keyframe()), StepFigures::default());
        let mut run = Self { simulation, recording, head: PlayHead::default(), last };
        run.step(bundle).map_err(|e| e.to_string())?;
        Ok(run)
    }

    /// Config of the run.
    pub fn config(&self) -> &CrowdRunConfig {
        &self.simulation.config
    }

    /// The characters as they are now.
    pub fn characters(&self) -> &Characters {
        &self.simulation.characters
    }

    /// Target of every character (m, number of characters).
    pub fn targets(&self) -> &[Vec3] {
        &self.simulation.around.targets
    }

    /// Weight of every goal (number of goals).
    pub fn weights(&self) -> &[f32] {
        &self.simulation.around.weights
    }

    /// Number of the step shown, from 0.
    pub fn shown_step(&self) -> u32 {
        self.simulation.around.step - 1
    }

    /// Figures of the shown step, as far as they are recorded.
    pub fn figures(&self) -> StepFigures {
        self.recording.figures(self.shown_step()).unwrap_or(self.last)
    }

    /// Steps and figures of the recording up to the shown step.
    pub fn history(&self) -> impl Iterator<Item = (u32, &StepFigures)> {
        let now = self.shown_step();
        self.recording.history().take_while(move |h| h.0 <= now)
    }

    /// Past positions of a character during the last `seconds`, every [`TRAIL_EVERY`] steps, and the present one (m).
    pub fn trail(&self, character: usize, seconds: f32) -> impl Iterator<Item = Vec2> {
        let now = self.shown_step();
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
    /// [`throng_core::Error`] where a step cannot be taken.
    pub fn step(&mut self, bundle: &OpenBundle) -> Result<()> {
        let s = &mut self.simulation;
        self.recording.keep_keyframe(s);
        for input in self.recording.inputs(s.around.step) {
            s.apply_input(bundle, input)?;
        }
        let figures = s.step(bundle)?;
        self.recording.keep_figures(s, figures);
        self.last = figures;
        self.show_now();
        Ok(())
    }

    /// Shows the nearest recorded step.
    ///
    /// # Errors
    /// [`throng_core::Error`] where a step cannot be repeated.
    pub fn seek(&mut self, bundle: &OpenBundle, step: u32) -> Result<()> {
        self.head.seek(step);
        let step = self.head.shown_step();
        let keyframe = self.recording.keyframe_before(step);
        if step < self.simulation.around.step.saturating_sub(1) || keyframe.around.step > self.simulation.around.step {
            self.simulation.restore(bundle, keyframe)?;
        }
        while self.simulation.around.step <= step {
            self.step(bundle)?;
        }
        Ok(())
    }

    fn show_now(&mut self) {
        self.head.record(self.recording.range(), self.shown_step());
    }

    /// Applies an input before the next step. The recording after the shown step is dropped, since it did not have the
    /// input. A target is kept within [`MAX_TARGET_M`]; a target that is not a number is ignored.
    pub fn input(&mut self, input: RunInput) {
        let Some(input) = input.limited() else { return };
        let next = self.simulation.around.step;
        // The target follows a drag at once, even while time stands still.
        match &input {
            RunInput::Target { character, to } => self.simulation.move_target(*character, *to),
            RunInput::Weights { weights, .. } => self.simulation.around.weights = weights.as_slice().into(),
            RunInput::Play { .. } | RunInput::Goal { .. } | RunInput::Event(_) => {}
        }
        self.recording.branch(next, input);
        self.show_now();
    }

    /// A character, and all that bears on its choices; none where it does not exist.
    pub fn chooser<'a>(&'a self, bundle: &'a OpenBundle, character: usize) -> Option<PolicyChooser<'a>> {
        let (s, config) = (&self.simulation, &self.simulation.config);
        Some(PolicyChooser {
            bundle,
            characters: &s.characters,
            number: character,
            goals: &s.goals,
            target: *s.around.targets.get(character)?,
            choice: s.around.choices.last(character),
            threat: None,
            single_load: config.single_load,
            temperature: config.temperature,
            now: self.shown_step(),
        })
    }
}

#[cfg(test)]
mod tests;
