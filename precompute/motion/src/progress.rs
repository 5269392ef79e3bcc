//! Reports of the progress of long work, and requests to stop it.

use std::path::Path;
use std::time::{Duration, Instant};

/// Error: the work was stopped by request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped before it was done")]
pub struct StopRequested;

/// Receives the progress of the stages. Calls may come from any thread.
pub trait Progress: Sync {
    /// A stage with `total` units of work begins (0 where that is unknown), counted in `unit`.
    fn begin(&self, stage: &'static str, total: u64, unit: &'static str);
    /// `done` more units are finished.
    fn advance(&self, done: u64);
    /// The stage is finished.
    fn end(&self);
    /// A build reaches a stage, which may report more of itself.
    fn enter_stage(&self, _stage: &'static str) {}
    /// The output of a stage is stored: a build that is started again continues behind it.
    fn stage_kept(&self, _stage: &'static str) {}
    /// True where the work is asked to stop.
    fn is_stopped(&self) -> bool {
        false
    }

    /// Fails if the work is asked to stop; called between two pieces of work.
    ///
    /// # Errors
    /// [`StopRequested`] where the work is to stop.
    fn check(&self) -> Result<(), StopRequested> {
        if self.is_stopped() { Err(StopRequested) } else { Ok(()) }
    }
}

/// Progress of a build: the last reports to its [`Progress`].
#[derive(Clone, Debug, Default)]
pub struct BuildStatus {
    stage: &'static str,
    unit: &'static str,
    done: u64,
    /// Total; 0 where it is not known.
    total: u64,
    /// Time at which the stage began; `None` between two stages.
    since: Option<Instant>,
    /// Stages whose outputs are stored.
    kept: Vec<&'static str>,
}

impl BuildStatus {
    /// Receives [`Progress::begin`].
    pub fn begin(&mut self, stage: &'static str, total: u64, unit: &'static str) {
        let kept = std::mem::take(&mut self.kept);
        *self = Self { stage, unit, total, since: Some(Instant::now()), kept, done: 0 };
    }

    /// Receives [`Progress::advance`].
    pub fn advance(&mut self, done: u64) {
        self.done += done;
    }

    /// Receives [`Progress::end`].
    pub fn end(&mut self) {
        self.since = None;
    }

    /// Receives [`Progress::enter_stage`].
    pub fn enter_stage(&mut self, stage: &'static str) {
        self.begin(stage, 0, "");
    }

    /// Receives [`Progress::stage_kept`].
    pub fn keep(&mut self, stage: &'static str) {
        self.kept.push(stage);
    }

    /// The stage that runs or ran last; empty before the first.
    pub fn stage(&self) -> &'static str {
        self.stage
    }

    /// Stages whose outputs are stored, in the order in which they were made or found.
    pub fn stages_kept(&self) -> &[&'static str] {
        &self.kept
    }

    /// Share of the stage that is done (0 to 1); `None` where its length is not known.
    pub fn share(&self) -> Option<f64> {
        (self.total > 0).then(|| self.done.min(self.total) as f64 / self.total as f64)
    }

    /// Time that the rest of the stage will take, if it goes on as it did; `None` where that is not known (s).
    pub fn left_s(&self) -> Option<f64> {
        let (share, spent) = (self.share().filter(|&s| s > 0.0)?, self.since?.elapsed());
        Some(left_s(spent, share))
    }

    /// Text about the part of the stage that is done and the time for the rest, such as `43 % of 3584 frames, about 12 s left`;
    /// `None` between two stages.
    pub fn progress_text(&self) -> Option<String> {
        Some(self.text_after(self.since?.elapsed()))
    }

    /// Text about the progress of the build, such as `graph: 43 % of 3584 frames, about 12 s left`; `None` between two stages.
    pub fn status_line(&self) -> Option<String> {
        Some(format!("{}: {}", self.stage, self.progress_text()?))
    }

    fn text_after(&self, spent: Duration) -> String {
        let (spent_s, total, unit) = (spent.as_secs_f64(), self.total, self.unit);
        match (self.done, self.share()) {
            (0, None) => format!("for {spent_s:.0} s"),
            (done, None) => format!("{done} {unit}, for {spent_s:.0} s"),
            (0, Some(_)) => format!("0 % of {total} {unit}, for {spent_s:.0} s"),
            (_, Some(share)) => {
                let left_s = left_s(spent, share);
                format!("{:.0} % of {total} {unit}, about {left_s:.0} s left", (100.0 * share).floor())
            }
        }
    }

    /// Text about the stored outputs of a build that was interrupted.
    ///
    /// - `cache`: the folder of the cache; `None` where nothing is stored.
    /// - `again`: the command that continues the build, such as `the same command`.
    pub fn interruption_text(&self, cache: Option<&Path>, again: &str) -> String {
        let stage = if self.stage.is_empty() { String::new() } else { format!(" in stage {}", self.stage) };
        let kept = match cache {
            None => format!("Nothing is kept, as the cache is off: {again} begins anew."),
            Some(folder) => {
                let kept = if self.kept.is_empty() { String::new() } else { format!(" ({})", self.kept.join(", ")) };
                let folder = folder.display();
                format!(
                    "{folder} keeps the stages that were done{kept} and files that were read: {again} goes on there."
                )
            }
        };
        format!("interrupted{stage}; no bundle was written. {kept}")
    }
}

fn left_s(spent: Duration, share: f64) -> f64 {
    spent.as_secs_f64() * (1.0 - share) / share
}

/// Progress that is not reported.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _: &'static str, _: u64, _: &'static str) {}
    fn advance(&self, _: u64) {}
    fn end(&self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_say_share_and_time_left() {
        let line = |done, total, s| {
            let status = BuildStatus { unit: "frames", done, total, ..BuildStatus::default() };
            status.text_after(Duration::from_secs(s))
        };
        assert_eq!(line(25, 100, 10), "25 % of 100 frames, about 30 s left");
        assert_eq!(line(0, 100, 10), "0 % of 100 frames, for 10 s");
        assert_eq!(line(7, 0, 10), "7 frames, for 10 s");
        assert_eq!(line(0, 0, 10), "for 10 s");
        assert_eq!(line(120, 100, 10), "100 % of 100 frames, about 0 s left");
    }

    #[test]
    fn who_interrupts_is_told_what_is_kept() {
        let mut status = BuildStatus::default();
        assert_eq!((status.status_line(), status.share()), (None, None));
        status.enter_stage("motion");
        status.keep("motion");
        status.begin("graph", 10, "frames");
        status.advance(5);
        assert!(status.status_line().is_some_and(|l| l.starts_with("graph: 50 % of 10 frames")));
        let told = status.interruption_text(Some("cache".as_ref()), "the same command");
        assert!(told.contains("in stage graph") && told.contains("cache keeps") && told.contains("(motion)"), "{told}");
        assert!(status.interruption_text(None, "the same command").contains("the same command begins anew"));
        status.end();
        assert_eq!(status.status_line(), None);
    }
}
