//! A build under way: its thread reports to it, the window shows it and may stop it.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use throng_precompute::progress::{BuildStatus, Progress};
use throng_precompute::run::{BuildContext, News};
use throng_precompute::{cache::Cache, verdict::Verdict};

/// Log of a build.
#[derive(Clone, Debug, Default)]
pub struct BuildLog {
    /// Present stage and progress; the last ones after the end.
    pub status: BuildStatus,
    /// Reports: what was built, what could not be, and warnings.
    pub news: Vec<News>,
    /// Trial of the built bundle by some characters; none if no behaviour has a target.
    pub verdict: Option<Verdict>,
}

/// End of a build.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BuildEnd {
    /// The requested document is open.
    Done,
    /// The user stopped the build: a message that says what is kept, and how to continue.
    Stopped(String),
    /// The build failed: a message with the reason and the way out.
    Failed(String),
}

/// A build that has ended.
#[derive(Clone, Debug)]
pub struct FinishedBuild {
    /// Files that were requested.
    pub paths: Vec<PathBuf>,
    /// Log of the build.
    pub log: BuildLog,
    /// End of the build.
    pub end: BuildEnd,
}

/// A build that is shown.
#[derive(Clone, Debug)]
pub enum ShownBuild {
    /// The build is under way; there may be nothing to build at all.
    UnderWay {
        /// Files that were requested.
        paths: Vec<PathBuf>,
        /// The build with its log.
        building: OngoingBuild,
    },
    /// The build has ended.
    Ended(Box<FinishedBuild>),
}

/// A build under way. Clones share one state.
#[derive(Clone, Debug, Default)]
pub struct OngoingBuild(Arc<BuildShared>);

#[derive(Debug, Default)]
struct BuildShared {
    log: Mutex<BuildLog>,
    is_stopped: AtomicBool,
}

impl OngoingBuild {
    /// Log so far.
    pub fn log(&self) -> MutexGuard<'_, BuildLog> {
        self.0.log.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets the build end before its next piece of work.
    pub fn stop(&self) {
        self.0.is_stopped.store(true, Ordering::Relaxed);
    }

    /// True where something is made; false where files are only read.
    pub fn has_begun(&self) -> bool {
        let log = self.log();
        !log.status.stage().is_empty() || !log.news.is_empty()
    }

    /// Runs work with the cache in the current folder, and reports to this build.
    pub fn run_with_cache<T>(&self, work: impl FnOnce(&BuildContext<'_>) -> T) -> T {
        let cache = Cache::in_folder(Cache::FOLDER);
        work(&BuildContext { cache: &cache, progress: self, report_news: &|news| self.log().news.push(news) })
    }

    /// The record of a build that has ended; none where nothing had to be made.
    ///
    /// - `fault`: why it could not be made.
    pub fn finished(&self, paths: &[PathBuf], fault: Option<&str>) -> Option<FinishedBuild> {
        if !self.has_begun() {
            return None;
        }
        let log = self.log().clone();
        let end = match fault {
            None => BuildEnd::Done,
            Some(_) if self.is_stopped() => {
                BuildEnd::Stopped(log.status.interruption_text(Some(Path::new(Cache::FOLDER)), "opening it again"))
            }
            Some(why) => BuildEnd::Failed(why.to_owned()),
        };
        Some(FinishedBuild { paths: paths.to_vec(), log, end })
    }
}

impl Progress for OngoingBuild {
    fn begin(&self, stage: &'static str, total: u64, unit: &'static str) {
        self.log().status.begin(stage, total, unit);
    }

    fn advance(&self, done: u64) {
        self.log().status.advance(done);
    }

    fn end(&self) {
        self.log().status.end();
    }

    fn enter_stage(&self, stage: &'static str) {
        self.log().status.enter_stage(stage);
    }

    fn stage_kept(&self, stage: &'static str) {
        self.log().status.keep(stage);
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
        let (building, paths) = (OngoingBuild::default(), [PathBuf::from("clips")]);
        assert!(building.check().is_ok() && building.finished(&paths, None).is_none());
        building.run_with_cache(|with| {
            with.progress.enter_stage("motion");
            with.progress.stage_kept("motion");
            with.progress.begin("graph", 10, "frames");
            (with.report_news)(News::Making("building clips".into()));
        });
        assert_eq!(building.finished(&paths, None).unwrap().end, BuildEnd::Done);
        assert_eq!(building.finished(&paths, Some("torn")).unwrap().end, BuildEnd::Failed("torn".into()));
        building.clone().stop();
        assert!(building.check().is_err());
        let built = building.finished(&paths, Some("torn")).unwrap();
        let BuildEnd::Stopped(log) = built.end else { panic!("{built:?}") };
        assert!(
            log.contains("in stage graph") && log.contains("(motion)") && log.contains("opening it again"),
            "{log}"
        );
        assert_eq!((built.log.news.len(), built.paths), (1, paths.to_vec()));
    }
}
