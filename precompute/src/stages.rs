//! Runs stages: times them, tells their progress, keeps and finds their outputs.

use crate::cache::{Cache, Key};
use crate::clip::ClipSet;
use crate::error::{BuildError, Warnings};
use crate::progress::Progress;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::time::Instant;

/// Everything the motion stages leave behind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// The clips, annotated.
    pub clips: ClipSet,
    /// Files that were skipped, and why.
    pub skipped: Vec<String>,
    /// What is odd but tolerable.
    pub warnings: Warnings,
}

/// How long stages took and which came from the cache.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timing {
    /// Stages that ran, in order, and their time. [Unit: s]
    pub stage_s: Vec<(&'static str, f64)>,
    /// Outputs that were read from the cache.
    pub cached: Vec<&'static str>,
    /// Time since the build began. [Unit: s]
    pub seconds_total: f64,
}

/// A build under way.
pub struct Stages<'a> {
    cache: &'a Cache,
    progress: &'a dyn Progress,
    begin: Instant,
    timing: Timing,
    /// What is odd about the build itself.
    pub warnings: Warnings,
}

impl<'a> Stages<'a> {
    /// Begins a build.
    pub fn new(cache: &'a Cache, progress: &'a dyn Progress) -> Self {
        Self { cache, progress, begin: Instant::now(), timing: Timing::default(), warnings: Warnings::default() }
    }

    /// Runs one stage.
    ///
    /// # Errors
    /// The stage's own.
    pub fn run<T>(
        &mut self,
        stage: &'static str,
        work: impl FnOnce(&dyn Progress) -> Result<T, BuildError>,
    ) -> Result<T, BuildError> {
        let begin = Instant::now();
        let out = work(self.progress);
        self.timing.stage_s.push((stage, begin.elapsed().as_secs_f64()));
        out
    }

    /// The output kept under `key`, or that of `work`, which is then kept.
    ///
    /// # Errors
    /// Those of `work`.
    pub fn cached<T: Serialize + DeserializeOwned>(
        &mut self,
        name: &'static str,
        key: Key,
        work: impl FnOnce(&mut Self) -> Result<T, BuildError>,
    ) -> Result<T, BuildError> {
        if let Some(found) = self.cache.load(name, key) {
            self.timing.cached.push(name);
            return Ok(found);
        }
        let made = work(self)?;
        self.cache.store(name, key, &made, &mut self.warnings);
        Ok(made)
    }

    /// Ends the build.
    pub fn finish(mut self) -> Timing {
        self.timing.seconds_total = self.begin.elapsed().as_secs_f64();
        self.timing
    }
}
