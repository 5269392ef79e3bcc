//! A build under way: its thread reports to it, the window shows it and may stop it.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use throng_precompute::cache::Cache;
use throng_precompute::progress::{Progress, Status};
use throng_precompute::run::{Cached, News};
use throng_precompute::verdict::Verdict;

/// Log of a build.
#[derive(Clone, Debug, Default)]
pub struct Told {
    /// Present stage and progress; the last ones after the end.
    pub status: Status,
    /// Reports: what was built, what could not be, and warnings.
    pub news: Vec<News>,
    /// Trial of the built bundle by some characters; none if no behaviour has a target.
    pub verdict: Option<Verdict>,
}

/// End of a build.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// The requested document is open.
    Done,
    /// The user stopped the build: a message that says what is kept, and how to continue.
    Stopped(String),
    /// The build failed: a message with the reason and the way out.
    Failed(String),
}

/// A build that has ended.
#[derive(Clone, Debug)]
pub struct Built {
    /// Files that were requested.
    pub paths: Vec<PathBuf>,
    /// Log of the build.
    pub told: Told,
    /// End of the build.
    pub end: End,
}

/// A build that is shown.
#[derive(Clone, Debug)]
pub enum Build {
    /// The build is under way; there may be nothing to build at all.
    UnderWay {
        /// Files that were requested.
        paths: Vec<PathBuf>,
        /// The build with its log.
        building: Building,
    },
    /// The build has ended.
    Ended(Box<Built>),
}

/// A build under way. Clones share one state.
#[derive(Clone, Debug, Default)]
pub struct Building(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    told: Mutex<Told>,
    is_stopped: AtomicBool,
}

impl Building {
    /// Log so far.
    pub fn told(&self) -> MutexGuard<'_, Told> {
        self.0.told.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets the build end before its next piece of work.
    pub fn stop(&self) {
        self.0.is_stopped.store(true, Ordering::Relaxed);
    }

    /// True where something is made; false where files are only read.
    pub fn has_begun(&self) -> bool {
        let told = self.told();
        !told.status.stage().is_empty() || !told.news.is_empty()
    }

    /// Runs work with the cache in the current folder, and reports to this build.
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
