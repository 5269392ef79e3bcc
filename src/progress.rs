//! Progress of builds: a bar on a terminal, elsewhere a line every few seconds; and messages on interruption.

use crate::output;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::{io::IsTerminal, time::Duration};
use tempfile::TempDir;
use throng_precompute::progress::{BuildStatus, Progress};

/// Time between lines if standard error is no terminal.
const LINE_PERIOD: Duration = Duration::from_secs(5);
/// Exit code of a program that was interrupted, as shells have it.
const INTERRUPTED: i32 = 130;

/// Existing folders of [`ScratchFolder`].
static SCRATCH_FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A temporary folder that is removed when the command ends, also by Ctrl+C.
pub struct ScratchFolder(TempDir);

impl ScratchFolder {
    pub fn new() -> std::io::Result<Self> {
        let folder = tempfile::tempdir().map_err(|e| {
            let way_out = "set TMPDIR to a folder that is there and may be written";
            std::io::Error::new(e.kind(), format!("cannot make a folder for temporary files: {e}; {way_out}"))
        })?;
        lock(&SCRATCH_FOLDERS).push(folder.path().to_path_buf());
        Ok(Self(folder))
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }
}

impl Drop for ScratchFolder {
    fn drop(&mut self) {
        lock(&SCRATCH_FOLDERS).retain(|folder| folder != self.0.path());
    }
}

/// Flag that Ctrl+C sets for runs that then end by themselves.
static STOP_REQUESTED: OnceLock<AtomicBool> = OnceLock::new();

/// From now on, Ctrl+C does not end the program but sets the returned flag.
pub fn stop_on_interrupt() -> &'static AtomicBool {
    let stop = STOP_REQUESTED.get_or_init(AtomicBool::default);
    // Refused if a build has set its own handler, which honours the flag.
    _ = ctrlc::set_handler(move || stop.store(true, Ordering::Relaxed));
    stop
}

/// Shows the progress of a build on standard error.
pub struct BuildProgressBar {
    bar: Mutex<Option<ProgressBar>>,
    now: Arc<Mutex<BuildState>>,
    is_terminal: bool,
}

/// State of a build.
#[derive(Debug, Default)]
struct BuildState {
    status: BuildStatus,
    /// True if the build has ended.
    is_over: bool,
}

impl Drop for BuildProgressBar {
    fn drop(&mut self) {
        lock(&self.now).is_over = true;
    }
}

impl Default for BuildProgressBar {
    fn default() -> Self {
        let (now, is_terminal) = (Arc::<Mutex<BuildState>>::default(), std::io::stderr().is_terminal());
        if !is_terminal {
            let watched = Arc::downgrade(&now);
            std::thread::spawn(move || {
                loop {
                    std::thread::sleep(LINE_PERIOD);
                    // A handler of Ctrl+C holds the state for as long as the program runs.
                    let Some(now) = watched.upgrade() else { return };
                    let now = lock(&now);
                    if now.is_over {
                        return;
                    }
                    if let Some(line) = now.status.status_line() {
                        output::print_to_stderr(line);
                    }
                }
            });
        }
        Self { bar: Mutex::default(), now, is_terminal }
    }
}

impl BuildProgressBar {
    /// A bar that on Ctrl+C prints what is kept and how to go on, and ends the program.
    ///
    /// - `cache`: folder of the cache; none if nothing is kept.
    pub fn on_interrupt(cache: Option<PathBuf>) -> Self {
        let bar = Self::default();
        let now = Arc::clone(&bar.now);
        // If the signal cannot be caught, the program ends without a message.
        _ = ctrlc::set_handler(move || {
            if let Some(stop) = STOP_REQUESTED.get() {
                return stop.store(true, Ordering::Relaxed);
            }
            let now = lock(&now);
            if !now.is_over {
                let text = now.status.interruption_text(cache.as_deref(), "the same command");
                output::print_to_stderr(format_args!("\n{text}"));
            }
            lock(&SCRATCH_FOLDERS).iter().for_each(|folder| _ = std::fs::remove_dir_all(folder));
            std::process::exit(INTERRUPTED);
        });
        bar
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Progress for BuildProgressBar {
    fn begin(&self, stage: &'static str, total: u64, unit: &'static str) {
        lock(&self.now).status.begin(stage, total, unit);
        if !self.is_terminal {
            return;
        }
        let (bar, begin, end) = match total {
            0 => (ProgressBar::no_length(), "{spinner} {pos}", "{elapsed}"),
            _ => (ProgressBar::new(total), "[{bar:30}] {pos}/{len}", "{eta} left"),
        };
        let template = format!("{{prefix:>10}} {begin} {unit}, {{per_sec}}, {end}");
        let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
        *lock(&self.bar) = Some(bar.with_style(style.progress_chars("=> ")).with_prefix(stage));
    }

    fn advance(&self, done: u64) {
        lock(&self.now).status.advance(done);
        lock(&self.bar).iter().for_each(|bar| bar.inc(done));
    }

    fn end(&self) {
        lock(&self.now).status.end();
        lock(&self.bar).take().iter().for_each(ProgressBar::finish_and_clear);
    }

    fn enter_stage(&self, stage: &'static str) {
        lock(&self.now).status.enter_stage(stage);
    }

    fn stage_kept(&self, stage: &'static str) {
        lock(&self.now).status.keep(stage);
    }
}
