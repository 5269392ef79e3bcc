//! A copy of a crowd that goes on by itself, beside the run that is shown.

use super::CrowdRun;
use super::simulation::{CrowdSimulation, RunInput};
use crate::bundle::OpenBundle;
use glam::Vec3;
use throng_core::Result;
use throng_core::characters::Characters;

/// The characters at one step, which continue without later inputs to the run.
#[derive(Clone, Debug)]
pub struct CrowdFork(CrowdSimulation);

impl CrowdRun {
    /// A copy of the characters at the step shown.
    pub fn fork(&self) -> CrowdFork {
        CrowdFork(self.simulation.clone())
    }
}

impl CrowdFork {
    /// The characters as they would be.
    pub fn characters(&self) -> &Characters {
        &self.0.characters
    }

    /// Moves the target of a character, or all targets (m).
    pub fn send(&mut self, character: Option<usize>, to: Vec3) {
        if let Some(RunInput::Target { character, to }) = (RunInput::Target { character, to }).limited() {
            self.0.move_target(character, to);
        }
    }

    /// One step forward.
    ///
    /// # Errors
    /// [`throng_core::Error`] where a step cannot be taken.
    pub fn step(&mut self, bundle: &OpenBundle) -> Result<()> {
        self.0.step(bundle).map(|_| ())
    }
}
