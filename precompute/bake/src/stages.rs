//! Runs stages: measures their time, reports progress, stores and loads their outputs.

use crate::cache::{Cache, CacheKey};
use crate::share::all_ranks_agree;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::{cell::RefCell, ops::Deref, time::Instant};
use throng_base::Comm;
use throng_motion::{BuildError, ClipSet, Progress, Result, Warnings, memory};

/// A fault of a stage, and the way out.
pub(crate) fn stage_error(stage: &'static str, message: impl Into<String>, help: impl Into<String>) -> BuildError {
    BuildError::Stage { stage, message: message.into(), help: help.into() }
}

/// Files of one performer: those of one source skeleton.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SourcePerformer {
    /// Height of the body, estimated from the lengths of its segments (m).
    pub height_m: f32,
    /// Names of the clips.
    pub clips: Vec<String>,
}

/// Output of the motion stages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionOutput {
    /// The clips, annotated.
    pub clips: ClipSet,
    /// Skipped files, with the reason.
    pub skipped: Vec<String>,
    /// Performers: files grouped by source skeleton.
    pub performers: Vec<SourcePerformer>,
    /// Files imported by an earlier build. Not part of the cached value, like the next field.
    #[serde(skip)]
    pub files_kept: usize,
    /// Files with clips made by an earlier build.
    #[serde(skip)]
    pub clips_kept: usize,
    /// Warnings.
    pub warnings: Warnings,
}

/// Cost of a stage in one process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct StageCost {
    /// Time (s).
    pub wall_s: f64,
    /// Part of this time spent waiting for other processes, including messages (s).
    pub waited_s: f64,
    /// Processor time of its threads, without waiting (s); `None` if the system does not report it, or if ranks are
    /// threads of one process.
    pub ran_s: Option<f64>,
    /// Bytes sent to other processes.
    pub bytes_moved: u64,
    /// Peak memory of the process up to the end of the stage; 0 if the system does not report it (bytes).
    pub peak_bytes: u64,
}

impl StageCost {
    /// Cost beyond `before`.
    fn minus(self, before: Self) -> Self {
        Self {
            wall_s: self.wall_s - before.wall_s,
            waited_s: self.waited_s - before.waited_s,
            ran_s: self.ran_s.zip(before.ran_s).map(|(all, before)| all - before),
            bytes_moved: self.bytes_moved - before.bytes_moved,
            peak_bytes: self.peak_bytes,
        }
    }

    /// Sum of two costs.
    pub fn plus(self, other: Self) -> Self {
        Self {
            wall_s: self.wall_s + other.wall_s,
            waited_s: self.waited_s + other.waited_s,
            ran_s: self.ran_s.zip(other.ran_s).map(|(a, b)| a + b),
            bytes_moved: self.bytes_moved + other.bytes_moved,
            peak_bytes: self.peak_bytes.max(other.peak_bytes),
        }
    }
}

/// Costs of stages, and names of those read from the cache.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildTiming {
    /// Stages that ran, in order, with their costs.
    pub stages: Vec<(&'static str, StageCost)>,
    /// Outputs that were read from the cache.
    pub cached: Vec<&'static str>,
    /// Time since the build began (s).
    pub seconds_total: f64,
}

/// Output of a stage, with its key.
#[derive(Clone, Debug)]
pub struct StageOutput<T> {
    /// Key of the stage's config and its inputs.
    pub key: CacheKey,
    /// Value of the output.
    pub value: T,
}

impl<T> Deref for StageOutput<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

/// A running build.
pub struct Stages<'a> {
    /// The cache, for outputs stored file by file.
    pub(crate) cache: &'a Cache,
    progress: &'a dyn Progress,
    /// Processes that build together.
    pub(crate) comm: &'a dyn Comm,
    begin: Instant,
    timing: RefCell<BuildTiming>,
    warnings: RefCell<Warnings>,
}

impl<'a> Stages<'a> {
    /// Begins a build.
    ///
    /// - `comm`: processes that build together. They share one cache, into which the first one writes the outputs of
    ///   stages.
    pub fn new(cache: &'a Cache, progress: &'a dyn Progress, comm: &'a dyn Comm) -> Self {
        Self { cache, progress, comm, begin: Instant::now(), timing: RefCell::default(), warnings: RefCell::default() }
    }

    /// Cost of the build so far.
    fn spent(&self) -> StageCost {
        let (wall_s, traffic) = (self.begin.elapsed().as_secs_f64(), self.comm.traffic());
        let (ran_s, peak_bytes) = (self.comm.cpu_s(), memory::peak_bytes().unwrap_or(0));
        StageCost { wall_s, waited_s: traffic.waited_s, ran_s, bytes_moved: traffic.bytes_moved, peak_bytes }
    }

    /// Cost of the stages that have ended.
    fn spent_in_stages(&self) -> StageCost {
        let none = StageCost { ran_s: Some(0.0), ..StageCost::default() };
        self.timing.borrow().stages.iter().fold(none, |all, (_, spent)| all.plus(*spent))
    }

    /// Runs a stage; its cost excludes that of stages that run within it.
    ///
    /// # Errors
    /// Errors of the stage; [`throng_motion::error::BuildError::Stopped`].
    pub fn run<T>(&self, stage: &'static str, work: impl FnOnce(&dyn Progress) -> Result<T>) -> Result<T> {
        let (begin, before) = (self.spent(), self.spent_in_stages());
        self.progress.check()?;
        self.progress.enter_stage(stage);
        let out = work(self.progress);
        let took = self.spent().minus(begin).minus(self.spent_in_stages().minus(before));
        self.timing.borrow_mut().stages.push((stage, took));
        out
    }

    /// Output of a stage, from the cache if it was made before from equal config and inputs.
    ///
    /// - `inputs`: keys of all its inputs besides `config`.
    ///
    /// # Errors
    /// Errors of the stage.
    pub fn stage<T: Serialize + DeserializeOwned>(
        &self,
        name: &'static str,
        inputs: &[CacheKey],
        config: &impl Serialize,
        work: impl FnOnce(&dyn Progress) -> Result<T>,
    ) -> Result<StageOutput<T>> {
        self.run_group(name, inputs, config, || self.run(name, work))
    }

    /// Output of several stages, which `work` runs; see [`Stages::stage`].
    ///
    /// # Errors
    /// Errors of `work`.
    pub fn run_group<T: Serialize + DeserializeOwned>(
        &self,
        name: &'static str,
        inputs: &[CacheKey],
        config: &impl Serialize,
        work: impl FnOnce() -> Result<T>,
    ) -> Result<StageOutput<T>> {
        let key = CacheKey::for_stage(name, inputs, config)?;
        let kept = self.cache.load(name, key);
        if let (true, Some(value)) = (all_ranks_agree(self.comm, kept.is_some())?, kept) {
            self.timing.borrow_mut().cached.push(name);
            self.progress.stage_kept(name);
            return Ok(StageOutput { key, value });
        }
        let value = work()?;
        if self.comm.rank() == 0 && self.cache.store(name, key, &value, &mut self.warnings.borrow_mut()) {
            self.progress.stage_kept(name);
        }
        Ok(StageOutput { key, value })
    }

    /// Ends the build: returns its costs, and warnings about the build itself.
    pub fn finish(self) -> (BuildTiming, Warnings) {
        if let Some(fault) = self.cache.take_fault() {
            self.warnings.borrow_mut().push(format!("not all is cached, and more will be made again: {fault}"));
        }
        let timing = self.timing.into_inner();
        (BuildTiming { seconds_total: self.begin.elapsed().as_secs_f64(), ..timing }, self.warnings.into_inner())
    }
}
