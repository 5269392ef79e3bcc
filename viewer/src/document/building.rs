//! A build under way: its thread tells of it, the window shows it and may stop it.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use throng_precompute::cache::Cache;
use throng_precompute::progress::{Progress, Status};
use throng_precompute::run::{Cached, News};
use throng_precompute::verdict::Verdict;

/// What was told of a build.
#[derive(Clone, Debug, Default)]
pub struct Told {
    /// Where it is, or was when it ended.
    pub status: Status,
    /// What is made, what could not be, and what is odd.
    pub news: Vec<News>,
    /// What characters do with what was made; none where they go to no target.
    pub verdict: Option<Verdict>,
}

/// How a build ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// What was asked for is open.
    Done,
    /// It was stopped: what is kept, and how to go on.
    Stopped(String),
    /// Why it could not be made, and the way out.
    Failed(String),
}

/// A build that has ended.
#[derive(Clone, Debug)]
pub struct Built {
    /// What was asked for.
    pub paths: Vec<PathBuf>,
    /// What was told of it.
    pub told: Told,
    /// How it ended.
    pub end: End,
}

/// A build that is shown.
#[derive(Clone, Debug)]
pub enum Build {
    /// It is under way, if anything has to be made at all.
    UnderWay {
        /// What was asked for.
        paths: Vec<PathBuf>,
        /// What is told of it.
        building: Building,
    },
    /// It has ended.
    Ended(Box<Built>),
}

/// A build under way. A clone is the same one.
#[derive(Clone, Debug, Default)]
pub struct Building(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    told: Mutex<Told>,
    is_stopped: AtomicBool,
}

impl Building {
    /// What was told so far.
    pub fn told(&self) -> MutexGuard<'_, Told> {
        self.0.told.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets it end at its next piece of work.
    pub fn stop(&self) {
        self.0.is_stopped.store(true, Ordering::Relaxed);
    }

    /// True where something is made; false where files are only read.
    pub fn has_begun(&self) -> bool {
        let told = self.told();
        !told.status.stage().is_empty() || !told.news.is_empty()
    }

    /// Works with the cache in the current folder, told here.
    pub fn with<T>(&self, work: impl FnOnce(&Cached<'_>) -> T) -> T {
        let cache = Cache::in_folder(Cache::FOLDER);
        work(&Cached { cache: &cache, progress: self, tell: &|news| self.told().news.push(news) })
    }

    /// The record of a build that has ended; none where nothing had to be made.
    ///
    /// - `fault`: why it could not be made.
    pub fn ended(&self, paths: &[PathBuf], fault: Option<&str>) -> Option<Built> {
        if !self.has_begun() {
            return None;
        }
        let told = self.told().clone();
        let end = match fault {
            None => End::Done,
            Some(_) if self.is_stopped() => {
                End::Stopped(told.status.farewell(Some(Path::new(Cache::FOLDER)), "opening it again"))
            }
            Some(why) => End::Failed(why.to_owned()),
        };
        Some(Built { paths: paths.to_vec(), told, end })
    }
}

impl Progress for Building {
    fn begin(&self, stage: &'static str, total: u64, unit: &'static str) {
        self.told().status.begin(stage, total, unit);
    }

    fn advance(&self, done: u64) {
        self.told().status.advance(done);
    }

    fn end(&self) {
        self.told().status.end();
    }

    fn comes_to(&self, stage: &'static str) {
        self.told().status.comes_to(stage);
    }

    fn kept(&self, stage: &'static str) {
        self.told().status.keep(stage);
    }

    fn is_stopped(&self) -> bool {
        self.0.is_stopped.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_that_is_stopped_says_what_is_kept_and_one_that_only_read_says_nothing() {
        let (building, paths) = (Building::default(), [PathBuf::from("clips")]);
        assert!(building.check().is_ok() && building.ended(&paths, None).is_none());
        building.with(|with| {
            with.progress.comes_to("motion");
            with.progress.kept("motion");
            with.progress.begin("graph", 10, "frames");
            (with.tell)(News::Making("building clips".into()));
        });
        assert_eq!(building.ended(&paths, None).unwrap().end, End::Done);
        assert_eq!(building.ended(&paths, Some("torn")).unwrap().end, End::Failed("torn".into()));
        building.clone().stop();
        assert!(building.check().is_err());
        let built = building.ended(&paths, Some("torn")).unwrap();
        let End::Stopped(told) = built.end else { panic!("{built:?}") };
        assert!(
            told.contains("in stage graph") && told.contains("(motion)") && told.contains("opening it again"),
            "{told}"
        );
        assert_eq!((built.told.news.len(), built.paths), (1, paths.to_vec()));
    }
}
