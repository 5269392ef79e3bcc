//! Long work without Python's lock, on a separate thread, so that an interrupt ends it.

use crate::error;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;
use throng_precompute::cache::Cache;
use throng_precompute::error::BuildError;
use throng_precompute::progress::Progress;
use throng_precompute::run::{BuildContext, News, ensure_scene};
use throng_runtime::simulation::Scene;
use throng_simulation::CompiledScene;

/// Time between two checks for an interrupt.
const CHECK_PERIOD: Duration = Duration::from_millis(50);

/// Flag that tells work to stop.
#[derive(Default)]
pub struct InterruptFlag(AtomicBool);

impl Progress for InterruptFlag {
    fn begin(&self, _: &'static str, _: u64, _: &'static str) {}
    fn advance(&self, _: u64) {}
    fn end(&self) {}
    fn is_stopped(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Runs work to its end, or until Python is interrupted.
pub fn run_interruptibly<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&InterruptFlag) -> Result<T, BuildError> + Send,
) -> PyResult<T> {
    let (signals, (done, waiting)) = (InterruptFlag::default(), channel::<()>());
    let waiting = Mutex::new(waiting);
    let mut interrupt = None;
    let outcome = std::thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let _done = done;
            work(&signals)
        });
        let wait = || waiting.lock().ok().map(|w| w.recv_timeout(CHECK_PERIOD));
        while let Some(Err(RecvTimeoutError::Timeout)) = py.detach(wait) {
            if let Err(e) = py.check_signals() {
                signals.0.store(true, Ordering::Relaxed);
                interrupt = Some(e);
            }
        }
        py.detach(|| worker.join())
    });
    match (outcome, interrupt) {
        (Err(panic), _) => std::panic::resume_unwind(panic),
        (Ok(_), Some(interrupt)) => Err(interrupt),
        (Ok(outcome), None) => outcome.map_err(error::build_error),
    }
}

/// Opens the cache in a folder; none without a folder.
pub fn open_cache(folder: Option<PathBuf>) -> Result<Cache, BuildError> {
    folder.map_or_else(|| Ok(Cache::disabled()), |folder| Cache::at_address(&folder, Cache::LIMIT_BYTES))
}

/// Opens a scene; its missing inputs are built first, with messages to Python's logger "throng".
pub fn open_scene(scene: &Scene, cache: Option<PathBuf>, signals: &InterruptFlag) -> Result<CompiledScene, BuildError> {
    let tell = |news: News| {
        Python::attach(|py| {
            let logger = py.import("logging").and_then(|l| l.call_method1("getLogger", ("throng",)));
            // A message that cannot be logged is dropped.
            _ = logger.and_then(|l| l.call_method1("info", (news.to_string(),)));
        });
    };
    ensure_scene(scene, &BuildContext { cache: &open_cache(cache)?, progress: signals, report_news: &tell })?;
    Ok(scene.open()?)
}
