//! How far the build of a missing bundle is.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use throng_precompute::progress::Progress;

/// How far a build is: written by the thread that builds, read by the window.
#[derive(Clone, Debug, Default)]
pub struct BuildNotice(Arc<Mutex<Option<BuildStage>>>);

#[derive(Clone, Copy, Debug)]
struct BuildStage {
    name: &'static str,
    done: u64,
    /// 0 where it is not known.
    total: u64,
}

impl BuildNotice {
    /// What is built, such as `building its bundle: policy, 40 %`; none while nothing is.
    pub fn text(&self) -> Option<String> {
        let stage = (*self.stage())?;
        let name = stage.name;
        Some(match stage.total {
            0 => format!("building its bundle: {name}"),
            total => format!("building its bundle: {name}, {} %", 100 * stage.done.min(total) / total),
        })
    }

    fn stage(&self) -> MutexGuard<'_, Option<BuildStage>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress for BuildNotice {
    fn begin(&self, stage: &'static str, total: u64, _unit: &'static str) {
        *self.stage() = Some(BuildStage { name: stage, done: 0, total });
    }

    fn advance(&self, done: u64) {
        if let Some(stage) = &mut *self.stage() {
            stage.done += done;
        }
    }

    fn end(&self) {
        *self.stage() = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stage_of_a_build_is_named_with_its_share() {
        let notice = BuildNotice::default();
        assert_eq!(notice.text(), None);
        notice.begin("policy", 8, "sweeps");
        notice.advance(2);
        notice.advance(1);
        assert_eq!(notice.text().unwrap(), "building its bundle: policy, 37 %");
        notice.begin("graph", 0, "frames");
        assert_eq!(notice.text().unwrap(), "building its bundle: graph");
        notice.end();
        assert_eq!(notice.text(), None);
    }
}
