//! Progress of builds: a bar on a terminal, elsewhere a line every few seconds; and what is kept where one is interrupted.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use throng_precompute::progress::Progress;

/// Time between lines where standard error is no terminal.
const EVERY: Duration = Duration::from_secs(5);
/// What a shell says of a program that was interrupted.
const INTERRUPTED: i32 = 130;

/// Tells how far a build is, on standard error.
pub struct Bar {
    bar: Mutex<Option<ProgressBar>>,
    now: Arc<Mutex<Now>>,
    is_terminal: bool,
}

/// Where a build is.
#[derive(Debug, Default)]
struct Now {
    stage: &'static str,
    unit: &'static str,
    done: u64,
    /// 0 where it is not known.
    total: u64,
    since: Option<Instant>,
    /// Stages whose outputs are kept.
    kept: Vec<&'static str>,
    /// The build has ended.
    is_over: bool,
}

impl Drop for Bar {
    fn drop(&mut self) {
        lock(&self.now).is_over = true;
    }
}

impl Default for Bar {
    fn default() -> Self {
        let (now, is_terminal) = (Arc::<Mutex<Now>>::default(), std::io::stderr().is_terminal());
        if !is_terminal {
            let watched = Arc::downgrade(&now);
            std::thread::spawn(move || {
                loop {
                    std::thread::sleep(EVERY);
                    let Some(now) = watched.upgrade() else { return };
                    if let Some(line) = lock(&now).line() {
                        eprintln!("{line}");
                    }
                }
            });
        }
        Self { bar: Mutex::default(), now, is_terminal }
    }
}

impl Bar {
    /// Says on Ctrl+C what is kept and how to go on, and ends the program.
    ///
    /// - `cache`: the folder of the cache; none where nothing is kept.
    pub fn on_interrupt(cache: Option<PathBuf>) -> Self {
        let bar = Self::default();
        let now = Arc::clone(&bar.now);
        // Where it cannot be caught, the program ends without a word, as without this.
        _ = ctrlc::set_handler(move || {
            let now = lock(&now);
            if !now.is_over {
                eprintln!("\n{}", now.farewell(cache.as_deref()));
            }
            std::process::exit(INTERRUPTED);
        });
        bar
    }

    fn with(&self, f: impl FnOnce(&mut Option<ProgressBar>)) {
        f(&mut lock(&self.bar));
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Now {
    /// Where the build is, such as `graph: 43 % of 3584 frames, 12 s left`.
    fn line(&self) -> Option<String> {
        let spent = self.since?.elapsed();
        Some(told(self.stage, (self.done, self.total, self.unit), spent))
    }

    fn farewell(&self, cache: Option<&std::path::Path>) -> String {
        let stage = if self.stage.is_empty() { String::new() } else { format!(" in stage {}", self.stage) };
        let kept = match cache {
            None => "Nothing is kept, as the cache is off: the same command begins anew.".into(),
            Some(folder) => {
                let kept = if self.kept.is_empty() { String::new() } else { format!(" ({})", self.kept.join(", ")) };
                let folder = folder.display();
                format!(
                    "{folder} keeps the stages that were done{kept} and files that were read: the same command goes on there."
                )
            }
        };
        format!("interrupted{stage}; no bundle was written. {kept}")
    }
}

fn told(stage: &str, (done, total, unit): (u64, u64, &str), spent: Duration) -> String {
    let spent_s = spent.as_secs_f64();
    match (done.min(total), total) {
        (_, 0) if done > 0 => format!("{stage}: {done} {unit}, for {spent_s:.0} s"),
        (_, 0) => format!("{stage}: for {spent_s:.0} s"),
        (0, _) => format!("{stage}: 0 % of {total} {unit}, for {spent_s:.0} s"),
        (done, total) => {
            let left_s = spent_s * (total - done) as f64 / done as f64;
            format!("{stage}: {} % of {total} {unit}, about {left_s:.0} s left", 100 * done / total)
        }
    }
}

impl Progress for Bar {
    fn begin(&self, stage: &'static str, total: u64, unit: &'static str) {
        {
            let mut now = lock(&self.now);
            let kept = std::mem::take(&mut now.kept);
            *now = Now { stage, unit, total, since: Some(Instant::now()), kept, ..Now::default() };
        }
        if !self.is_terminal {
            return;
        }
        let template = if total > 0 {
            format!("{{prefix:>10}} [{{bar:30}}] {{pos}}/{{len}} {unit}, {{per_sec}}, {{eta}} left")
        } else {
            format!("{{prefix:>10}} {{spinner}} {{pos}} {unit}, {{per_sec}}, {{elapsed}}")
        };
        let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = if total > 0 { ProgressBar::new(total) } else { ProgressBar::no_length() };
        self.with(|b| *b = Some(bar.with_style(style.progress_chars("=> ")).with_prefix(stage)));
    }

    fn advance(&self, done: u64) {
        lock(&self.now).done += done;
        self.with(|b| b.iter().for_each(|b| b.inc(done)));
    }

    fn end(&self) {
        lock(&self.now).since = None;
        self.with(|b| b.take().iter().for_each(ProgressBar::finish_and_clear));
    }

    fn comes_to(&self, stage: &'static str) {
        let mut now = lock(&self.now);
        let kept = std::mem::take(&mut now.kept);
        *now = Now { stage, kept, since: Some(Instant::now()), ..Now::default() };
    }

    fn kept(&self, stage: &'static str) {
        lock(&self.now).kept.push(stage);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_say_stage_share_and_time_left() {
        let line = |done, total, s| told("graph", (done, total, "frames"), Duration::from_secs(s));
        assert_eq!(line(25, 100, 10), "graph: 25 % of 100 frames, about 30 s left");
        assert_eq!(line(0, 100, 10), "graph: 0 % of 100 frames, for 10 s");
        assert_eq!(line(7, 0, 10), "graph: 7 frames, for 10 s");
        assert_eq!(line(0, 0, 10), "graph: for 10 s");
        assert_eq!(line(120, 100, 10), "graph: 100 % of 100 frames, about 0 s left");
    }

    #[test]
    fn who_interrupts_is_told_what_is_kept() {
        let bar = Bar::default();
        assert_eq!(lock(&bar.now).line(), None);
        bar.comes_to("motion");
        bar.kept("motion");
        bar.begin("graph", 10, "frames");
        bar.advance(5);
        assert!(lock(&bar.now).line().is_some_and(|l| l.starts_with("graph: 50 % of 10 frames")));
        let told = lock(&bar.now).farewell(Some("cache".as_ref()));
        assert!(told.contains("in stage graph") && told.contains("cache keeps") && told.contains("(motion)"), "{told}");
        assert!(lock(&bar.now).farewell(None).contains("begins anew"));
    }
}
