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
use throng_motion::memory;
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
    /// Files that an earlier build had read. Of this build, as is the next: what is cached does not depend on it.
    #[serde(skip)]
    pub files_kept: usize,
    /// Files whose clips an earlier build had made.
    #[serde(skip)]
    pub clips_kept: usize,
    /// What is odd but tolerable.
    pub warnings: Warnings,
}

/// What a stage took in one process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Spent {
    /// Time (s).
    pub wall_s: f64,
    /// Of this, time in which it waited for others, moving messages included (s).
    pub waited_s: f64,
    /// Time that processors ran its threads, waiting left out (s); none where the system does not tell, or where ranks are
    /// threads of one process.
    pub ran_s: Option<f64>,
    /// Bytes that it sent to others.
    pub bytes_moved: u64,
    /// Most memory that the process had held when the stage ended; 0 where the system does not tell (bytes).
    pub peak_bytes: u64,
}

impl Spent {
    /// What was spent beyond `before`.
    fn since(self, before: Self) -> Self {
        Self {
            wall_s: self.wall_s - before.wall_s,
            waited_s: self.waited_s - before.waited_s,
            ran_s: self.ran_s.zip(before.ran_s).map(|(all, before)| all - before),
            bytes_moved: self.bytes_moved - before.bytes_moved,
            peak_bytes: self.peak_bytes,
        }
    }

    /// Both together.
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

/// What stages took and which came from the cache.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timing {
    /// Stages that ran, in order, and what they took.
    pub stages: Vec<(&'static str, Spent)>,
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

    /// What the build took so far.
    fn spent(&self) -> Spent {
        let (wall_s, traffic) = (self.begin.elapsed().as_secs_f64(), self.comm.traffic());
        Spent {
            wall_s,
            waited_s: traffic.waited_s,
            ran_s: self.comm.ran_s(),
            bytes_moved: traffic.bytes_moved,
            peak_bytes: memory::peak_bytes().unwrap_or(0),
        }
    }

    /// What the stages took that have ended.
    fn spent_in_stages(&self) -> Spent {
        let none = Spent { ran_s: Some(0.0), ..Spent::default() };
        self.timing.borrow().stages.iter().fold(none, |all, (_, spent)| all.plus(*spent))
    }

    /// Runs a stage; what it took is what the stages that run within it leave of it.
    ///
    /// # Errors
    /// The stage's own; [`BuildError::Stopped`].
    pub fn run<T>(
        &self,
        stage: &'static str,
        work: impl FnOnce(&dyn Progress) -> Result<T, BuildError>,
    ) -> Result<T, BuildError> {
        let (begin, before) = (self.spent(), self.spent_in_stages());
        self.progress.check()?;
        self.progress.comes_to(stage);
        let out = work(self.progress);
        let took = self.spent().since(begin).since(self.spent_in_stages().since(before));
        self.timing.borrow_mut().stages.push((stage, took));
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

    /// As [`Stages::several`], for an output that is not kept as a whole.
    ///
    /// # Errors
    /// Those of `work`.
    pub fn unkept<T>(
        &self,
        name: &'static str,
        inputs: &[Key],
        config: &impl Serialize,
        work: impl FnOnce() -> Result<T, BuildError>,
    ) -> Result<Output<T>, BuildError> {
        Ok(Output { key: Key::of(name, inputs, config)?, value: work()? })
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
