//! Runs stages: times them, tells their progress, keeps and finds their outputs.

use crate::cache::{Cache, Key};
use crate::share::is_so_for_all;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::cell::{OnceCell, RefCell};
use std::ops::Deref;
use std::time::Instant;
use throng_base::Comm;
use throng_motion::clip::ClipSet;
use throng_motion::error::{BuildError, Warnings};
use throng_motion::progress::Progress;

/// Files of one performer: of one source skeleton.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Performer {
    /// Height of the body, estimated from the lengths of its segments (m).
    pub height_m: f32,
    /// Names of the clips.
    pub clips: Vec<String>,
}

/// Everything the motion stages leave behind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// The clips, annotated.
    pub clips: ClipSet,
    /// Files that were skipped, and why.
    pub skipped: Vec<String>,
    /// Whose motion it is.
    pub performers: Vec<Performer>,
    /// Files that an earlier build had read.
    pub files_kept: usize,
    /// Files whose clips an earlier build had made.
    pub clips_kept: usize,
    /// What is odd but tolerable.
    pub warnings: Warnings,
}

/// How long stages took and which came from the cache.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timing {
    /// Stages that ran, in order, and their time (s).
    pub stage_s: Vec<(&'static str, f64)>,
    /// Outputs that were read from the cache.
    pub cached: Vec<&'static str>,
    /// Time since the build began (s).
    pub seconds_total: f64,
}

/// What a stage made, and the key of everything it depends on.
#[derive(Clone, Debug)]
pub struct Output<T> {
    /// Of the stage's config and its inputs.
    pub key: Key,
    /// What it made.
    pub value: T,
}

impl<T> Deref for Output<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

/// A build under way.
pub struct Stages<'a> {
    cache: &'a Cache,
    progress: &'a dyn Progress,
    comm: &'a dyn Comm,
    begin: Instant,
    timing: RefCell<Timing>,
    warnings: RefCell<Warnings>,
}

impl<'a> Stages<'a> {
    /// Begins a build.
    ///
    /// - `comm`: processes that build together. They have one cache, into which the first one writes the outputs of stages.
    pub fn new(cache: &'a Cache, progress: &'a dyn Progress, comm: &'a dyn Comm) -> Self {
        Self { cache, progress, comm, begin: Instant::now(), timing: RefCell::default(), warnings: RefCell::default() }
    }

    /// Runs a stage; its time is what the stages that run within it leave of it.
    ///
    /// # Errors
    /// The stage's own; [`BuildError::Stopped`].
    pub fn run<T>(
        &self,
        stage: &'static str,
        work: impl FnOnce(&dyn Progress) -> Result<T, BuildError>,
    ) -> Result<T, BuildError> {
        let spent = || self.timing.borrow().stage_s.iter().map(|(_, s)| s).sum::<f64>();
        let (begin, before) = (Instant::now(), spent());
        self.progress.check()?;
        self.progress.comes_to(stage);
        let out = work(self.progress);
        let within = spent() - before;
        self.timing.borrow_mut().stage_s.push((stage, begin.elapsed().as_secs_f64() - within));
        out
    }

    /// The output of a stage, from the cache if the same config and inputs have made it before.
    ///
    /// - `inputs`: keys of all that it is made of, besides `config`.
    ///
    /// # Errors
    /// The stage's own.
    pub fn stage<T: Serialize + DeserializeOwned>(
        &self,
        name: &'static str,
        inputs: &[Key],
        config: &impl Serialize,
        work: impl FnOnce(&dyn Progress) -> Result<T, BuildError>,
    ) -> Result<Output<T>, BuildError> {
        self.several(name, inputs, config, || self.run(name, work))
    }

    /// As [`Stages::stage`], for the output of several stages, which `work` runs.
    ///
    /// # Errors
    /// Those of `work`.
    pub fn several<T: Serialize + DeserializeOwned>(
        &self,
        name: &'static str,
        inputs: &[Key],
        config: &impl Serialize,
        work: impl FnOnce() -> Result<T, BuildError>,
    ) -> Result<Output<T>, BuildError> {
        let key = Key::of(name, inputs, config)?;
        let kept = self.cache.load(name, key);
        if let (true, Some(value)) = (is_so_for_all(self.comm, kept.is_some())?, kept) {
            self.timing.borrow_mut().cached.push(name);
            self.progress.kept(name);
            return Ok(Output { key, value });
        }
        let value = work()?;
        if self.comm.rank() == 0 && self.cache.store(name, key, &value, &mut self.warnings.borrow_mut()) {
            self.progress.kept(name);
        }
        Ok(Output { key, value })
    }

    /// A stage that runs when its output is first asked for, and whose output is made faster than a cache reads it.
    ///
    /// # Errors
    /// [`BuildError::Format`] for a config that cannot be encoded.
    pub fn on_demand<T, W: Fn() -> Result<T, BuildError>>(
        &self,
        name: &'static str,
        inputs: &[Key],
        config: &impl Serialize,
        work: W,
    ) -> Result<OnDemand<'_, T, W>, BuildError> {
        Ok(OnDemand { stages: self, key: Key::of(name, inputs, config)?, name, work, made: OnceCell::new() })
    }

    /// Processes that build together.
    pub fn comm(&self) -> &'a dyn Comm {
        self.comm
    }

    /// The cache, for what is kept file by file.
    pub fn cache(&self) -> &'a Cache {
        self.cache
    }

    /// Ends the build: its times, and what is odd about the build itself.
    pub fn finish(self) -> (Timing, Warnings) {
        if let Some(fault) = self.cache.fault() {
            self.warnings.borrow_mut().push(format!("not all is cached, and more will be made again: {fault}"));
        }
        let timing = self.timing.into_inner();
        (Timing { seconds_total: self.begin.elapsed().as_secs_f64(), ..timing }, self.warnings.into_inner())
    }
}

/// An output that is made once, when it is first asked for.
pub struct OnDemand<'a, T, W> {
    /// Of the stage's config and its inputs.
    pub key: Key,
    stages: &'a Stages<'a>,
    name: &'static str,
    work: W,
    made: OnceCell<T>,
}

impl<T, W: Fn() -> Result<T, BuildError>> OnDemand<'_, T, W> {
    /// The output.
    ///
    /// # Errors
    /// The stage's own.
    pub fn get(&self) -> Result<&T, BuildError> {
        match self.made.get() {
            Some(made) => Ok(made),
            None => {
                let made = self.stages.run(self.name, |_| (self.work)())?;
                Ok(self.made.get_or_init(|| made))
            }
        }
    }
}
