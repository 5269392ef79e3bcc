//! Progress bars with stage, rate and time left, on a terminal only.

use indicatif::{ProgressBar, ProgressStyle};
use std::sync::Mutex;
use throng_precompute::progress::Progress;

/// A bar on standard error; nothing where that is no terminal.
#[derive(Default)]
pub struct Bar {
    bar: Mutex<Option<ProgressBar>>,
}

impl Bar {
    fn with(&self, f: impl FnOnce(&mut Option<ProgressBar>)) {
        if let Ok(mut bar) = self.bar.lock() {
            f(&mut bar);
        }
    }
}

impl Progress for Bar {
    fn begin(&self, stage: &'static str, total: u64, unit: &'static str) {
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
        self.with(|b| b.iter().for_each(|b| b.inc(done)));
    }

    fn end(&self) {
        self.with(|b| b.take().iter().for_each(ProgressBar::finish_and_clear));
    }
}
