//! Recordings of runs, to replay and explain them: the scene, its step rate, and a hash of each simulated second.

use super::report::{ObservedStep, config_error, play_scene};
use serde::{Deserialize, Serialize};
use std::path::Path;
use throng_core::base::file::{MAX_TEXT_BYTES, read_file};
use throng_core::base::limits::{SECONDS, STEP_HZ};
use throng_core::base::{Error, SnapshotKind};
use throng_motion::error::{Result, ensure};
use throng_simulation::{CompiledScene, Scene, Simulation};

const KIND: SnapshotKind = SnapshotKind { what: "recording", tag: *b"RCRD", version: 1, setup: 0 };

/// A recorded run that can be repeated exactly: steps depend only on the data here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunRecording {
    /// The scene, as the text of a scene file; its paths are relative to the folder of the run.
    pub scene: String,
    /// Name of the scene.
    pub name: String,
    /// Content hash of the scene, its bundles and worlds.
    pub setup: u128,
    /// Steps a simulated second (Hz).
    pub step_hz: f64,
    /// Hash of the state at the end of every simulated second, and at the end.
    pub hashes: Vec<u64>,
    /// How long it ran (s).
    pub seconds: f64,
}

impl RunRecording {
    /// A recording at the begin of a run.
    ///
    /// # Errors
    /// [`BuildError::Config`](throng_motion::error::BuildError::Config) for a scene that cannot be written, such as one with a seed above 2^63.
    pub fn new(compiled: &CompiledScene, step_hz: f64) -> Result<Self> {
        let scene = compiled.scene();
        let text = toml::to_string(scene)
            .map_err(|e| config_error(format!("scene \"{}\" cannot be recorded: {e}", scene.name)))?;
        let (name, setup) = (scene.name.clone(), compiled.hash());
        Ok(Self { scene: text, name, setup, step_hz, hashes: Vec::new(), seconds: 0.0 })
    }

    /// Observes a simulation after a step.
    pub fn observe(&mut self, sim: &Simulation, is_last: bool) {
        self.seconds = sim.time_s();
        if is_last || sim.time_s() >= (self.hashes.len() + 1) as f64 - 1e-9 {
            self.hashes.push(sim.hash());
        }
    }

    /// The bytes of the file, with a checksum.
    pub fn bytes(&self) -> Vec<u8> {
        let mut out = Vec::new();
        KIND.write(self, &mut out);
        out
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`BuildError::Config`](throng_motion::error::BuildError::Config) for a file that is damaged or no recording.
    pub fn load(path: &Path) -> Result<Self> {
        let bytes = read_file(path, "a recording", MAX_TEXT_BYTES).map_err(config_error)?;
        Self::parse(&bytes).map_err(|e| {
            let why = match e {
                Error::Snapshot { why, .. } => format!("expected a recording of `throng run --record`: {why}"),
                e => e.to_string(),
            };
            config_error(format!("{}: {why}", path.display()))
        })
    }

    /// Like [`RunRecording::load`], from bytes.
    ///
    /// # Errors
    /// [`Error`] without the name of the file.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let read: Self = KIND.read_all(bytes)?;
        SECONDS.check("seconds", None, read.seconds)?;
        STEP_HZ.check("step_hz", None, read.step_hz)?;
        Ok(read)
    }

    /// The scene that ran.
    ///
    /// # Errors
    /// As [`Scene::parse_written`].
    pub fn scene(&self) -> Result<Scene> {
        Scene::parse_written(&self.scene).map_err(config_error)
    }

    /// Repeats the run until a time, or to its end, bit by bit.
    ///
    /// # Errors
    /// As [`Simulation::new`]; [`BuildError::Config`](throng_motion::error::BuildError::Config) if bundles have changed, this version of Throng computes other states, or
    /// the time lies beyond the end.
    pub fn replay(&self, compiled: &CompiledScene, until_s: Option<f64>) -> Result<Simulation> {
        if let Some(until_s) = until_s.filter(|t| !(0.0..self.seconds + 0.01).contains(t)) {
            let end_s = self.seconds;
            let what = format!("expected a time of 0 to {end_s:.2} s, where the recording ends, found {until_s}");
            return Err(config_error(what));
        }
        self.replay_observed(compiled, until_s, |_, _| Ok(()))
    }

    /// Like [`RunRecording::replay`]; also calls `look` before the first step and after every step.
    pub(crate) fn replay_observed(
        &self,
        compiled: &CompiledScene,
        until_s: Option<f64>,
        mut observe: impl FnMut(&Simulation, ObservedStep) -> Result<()>,
    ) -> Result<Simulation> {
        let differs = |what: &str| {
            config_error(format!("the recording of \"{}\" cannot be replayed: {what}; record it again", self.name))
        };
        ensure(compiled.hash() == self.setup, || differs("its scene, a bundle or a world is another one now"))?;
        let until_s = until_s.unwrap_or(self.seconds).clamp(0.0, self.seconds);
        let mut sim = Simulation::new(compiled).map_err(config_error)?;
        let mut seen = 0;
        play_scene(&mut sim, self.seconds, self.step_hz, until_s, |sim, moment| {
            let time_s = sim.time_s();
            if moment.step > 0 && (time_s >= self.seconds || time_s >= (seen + 1) as f64 - 1e-9) {
                if self.hashes.get(seen) != Some(&sim.hash()) {
                    return Err(differs(&format!("it went on differently by {time_s:.1} s")));
                }
                seen += 1;
            }
            observe(sim, moment)
        })?;
        Ok(sim)
    }
}
