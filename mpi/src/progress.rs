//! Progress of all processes, printed by the first one on standard error.

use serde::{Deserialize, Serialize};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::{thread::JoinHandle, time::Duration};
use throng_precompute::progress::{BuildStatus, Progress};

/// Time between two samples of a rank's status.
const SAMPLE_PERIOD: Duration = Duration::from_secs(1);
/// Number of samples between two lines.
const SAMPLES_PER_LINE: u32 = 5;

/// Status of a rank within its stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RankStatus {
    /// The stage.
    pub stage: String,
    /// Share of the stage that is done (0 to 1); none if it is not known.
    pub share: Option<f64>,
    /// Remaining time of the stage (s); none if it is not known.
    pub left_s: Option<f64>,
}

/// Statuses of all ranks, shared apart from the messages of their work.
pub trait RankStatuses: Send + Sync {
    /// Posts the status of a rank.
    fn post_status(&self, rank: usize, of_rank: RankStatus);
    /// Last known statuses of all ranks, by rank.
    fn last_known(&self) -> Vec<Option<RankStatus>>;
}

/// Statuses of ranks that are threads.
#[derive(Default)]
pub struct LocalRankStatuses(Mutex<Vec<Option<RankStatus>>>);

impl RankStatuses for LocalRankStatuses {
    fn post_status(&self, rank: usize, of_rank: RankStatus) {
        let mut statuses = lock(&self.0);
        if statuses.len() <= rank {
            statuses.resize(rank + 1, None);
        }
        statuses[rank] = Some(of_rank);
    }

    fn last_known(&self) -> Vec<Option<RankStatus>> {
        lock(&self.0).clone()
    }
}

/// Posts the status of its rank every second. On the first rank it prints its own status and that of the slowest rank every
/// few seconds; as JSON lines, also the stages that it enters.
pub struct ProgressLines {
    status: Arc<Mutex<BuildStatus>>,
    prints_json: bool,
    /// Ends the thread when it is dropped.
    stop_sender: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl ProgressLines {
    /// Begins to post and print, as JSON lines if `json`.
    pub fn new(json: bool, rank: usize, statuses: &Arc<dyn RankStatuses>) -> Self {
        let status = Arc::<Mutex<BuildStatus>>::default();
        let (watched, statuses) = (status.clone(), statuses.clone());
        let (stop_sender, ended) = channel();
        let thread = std::thread::spawn(move || {
            let mut num_samples = 0;
            while ended.recv_timeout(SAMPLE_PERIOD) == Err(RecvTimeoutError::Timeout) {
                let status = lock(&watched).clone();
                let Some(far) = status.progress_text() else { continue };
                let (stage, share, left_s) = (status.stage().into(), status.share(), status.left_s());
                statuses.post_status(rank, RankStatus { stage, share, left_s });
                num_samples += 1;
                if rank == 0 && num_samples % SAMPLES_PER_LINE == 0 {
                    print_status(&status, &far, &statuses.last_known(), json);
                }
            }
        });
        Self { status, prints_json: json && rank == 0, stop_sender: Some(stop_sender), thread: Some(thread) }
    }
}

impl Drop for ProgressLines {
    fn drop(&mut self) {
        drop(self.stop_sender.take());
        // A failed thread prints nothing more.
        _ = self.thread.take().map(JoinHandle::join);
    }
}

fn print_status(status: &BuildStatus, far: &str, statuses: &[Option<RankStatus>], json: bool) {
    let slowest_rank = slowest_rank(statuses);
    if json {
        let slowest_rank = slowest_rank.map(
            |(rank, p)| serde_json::json!({ "rank": rank, "stage": p.stage, "share": p.share, "left_s": p.left_s }),
        );
        let line = serde_json::json!({ "stage": status.stage(), "share": status.share(), "far": far, "slowest": slowest_rank });
        eprintln!("{line}");
        return;
    }
    let slowest_rank = slowest_rank.map(|(rank, p)| {
        let (share, left_s) = (p.share.unwrap_or(0.0), p.left_s.unwrap_or(0.0));
        format!("; slowest is rank {rank}: {} {:.0} %, about {left_s:.0} s left", p.stage, (100.0 * share).floor())
    });
    eprintln!("{}: {far}{}", status.stage(), slowest_rank.unwrap_or_default());
}

/// The rank with the most remaining time, if there are several.
fn slowest_rank(statuses: &[Option<RankStatus>]) -> Option<(usize, &RankStatus)> {
    let known = statuses.iter().enumerate().filter_map(|(rank, p)| Some((rank, p.as_ref()?)));
    let left = |p: &RankStatus| p.left_s.unwrap_or(0.0);
    let working = known.filter(|(_, p)| left(p) > 0.0);
    working.max_by(|a, b| left(a.1).total_cmp(&left(b.1))).filter(|_| statuses.len() > 1)
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Progress for ProgressLines {
    fn begin(&self, stage: &'static str, total: u64, unit: &'static str) {
        lock(&self.status).begin(stage, total, unit);
    }

    fn advance(&self, done: u64) {
        lock(&self.status).advance(done);
    }

    fn end(&self) {
        lock(&self.status).end();
    }

    fn enter_stage(&self, stage: &'static str) {
        lock(&self.status).enter_stage(stage);
        if self.prints_json {
            eprintln!("{}", serde_json::json!({ "stage": stage }));
        }
    }

    fn stage_kept(&self, stage: &'static str) {
        lock(&self.status).keep(stage);
        if self.prints_json {
            eprintln!("{}", serde_json::json!({ "kept": stage }));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rank_with_most_left_is_the_slowest() {
        let of_rank =
            |share: f64, left_s: f64| RankStatus { stage: "graph".into(), share: Some(share), left_s: Some(left_s) };
        let statuses = LocalRankStatuses::default();
        assert_eq!(slowest_rank(&statuses.last_known()), None);
        statuses.post_status(2, of_rank(0.5, 8.0));
        statuses.post_status(0, of_rank(1.0, 0.0));
        assert_eq!(
            slowest_rank(&statuses.last_known()).map(|(rank, _)| rank),
            Some(2),
            "one of which nothing is known is no reason"
        );
        statuses.post_status(1, of_rank(0.2, 9.0));
        assert_eq!(slowest_rank(&statuses.last_known()), Some((1, &of_rank(0.2, 9.0))));
        for rank in 0..3 {
            statuses.post_status(rank, of_rank(1.0, 0.0));
        }
        assert_eq!(slowest_rank(&statuses.last_known()), None, "all are done");
        assert_eq!(slowest_rank(&[Some(of_rank(0.5, 3.0))]), None, "alone, nobody is the slowest");
    }

    #[test]
    fn ranks_note_where_they_are() {
        let statuses: Arc<dyn RankStatuses> = Arc::new(LocalRankStatuses::default());
        let lines = ProgressLines::new(true, 1, &statuses);
        lines.begin("graph", 10, "frames");
        lines.advance(5);
        while statuses.last_known().is_empty() {
            std::thread::yield_now();
        }
        let of_rank = statuses.last_known()[1].clone().expect("rank 1");
        assert_eq!((&*of_rank.stage, of_rank.share), ("graph", Some(0.5)));
        assert!(of_rank.left_s.is_some_and(|s| s > 0.0));
    }
}
