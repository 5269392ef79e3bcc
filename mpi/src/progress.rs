//! Progress of all processes, told by the first one on standard error.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use throng_precompute::progress::{Progress, Status};

/// Time between lines.
const EVERY: Duration = Duration::from_secs(5);

/// Tells every few seconds where the first process is, and as JSON lines also to what stages it comes.
pub struct Lines {
    status: Arc<Mutex<Status>>,
    json: bool,
}

impl Lines {
    /// Begins to tell; as JSON lines, if that is wanted.
    pub fn new(json: bool) -> Self {
        let status = Arc::<Mutex<Status>>::default();
        let watched = Arc::downgrade(&status);
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(EVERY);
                let Some(status) = watched.upgrade() else { return };
                let status = lock(&status);
                match status.far() {
                    Some(far) if json => {
                        eprintln!(
                            "{}",
                            serde_json::json!({ "stage": status.stage(), "share": status.share(), "far": far })
                        );
                    }
                    Some(far) => eprintln!("{}: {far}", status.stage()),
                    None => (),
                }
            }
        });
        Self { status, json }
    }
}

fn lock(status: &Mutex<Status>) -> MutexGuard<'_, Status> {
    status.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Progress for Lines {
    fn begin(&self, stage: &'static str, total: u64, unit: &'static str) {
        lock(&self.status).begin(stage, total, unit);
    }

    fn advance(&self, done: u64) {
        lock(&self.status).advance(done);
    }

    fn end(&self) {
        lock(&self.status).end();
    }

    fn comes_to(&self, stage: &'static str) {
        lock(&self.status).comes_to(stage);
        if self.json {
            eprintln!("{}", serde_json::json!({ "stage": stage }));
        }
    }

    fn kept(&self, stage: &'static str) {
        lock(&self.status).keep(stage);
        if self.json {
            eprintln!("{}", serde_json::json!({ "kept": stage }));
        }
    }
}
