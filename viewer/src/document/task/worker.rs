//! Plans on its own thread, so that the window keeps drawing.

use super::{PlannedMotion, StagedTask};
use crate::document::background::Background;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use throng_planner::planner::Planners;
use throng_planner::task::{RunOptions, Task};
use throng_precompute::plans::{self, TaskSources};

/// Input of a plan.
pub(super) struct PlanningJob {
    pub sources: Arc<TaskSources>,
    pub task: Task,
    /// Number of motions.
    pub number: u64,
    /// In place of the task's.
    pub seed: Option<u64>,
    /// Results of the last plans, extended by this one.
    pub planners: Arc<Planners>,
}

/// The timed scene and the motions for it, or a message why there are none.
pub(super) type PlanningResult = Result<(Arc<StagedTask>, Vec<PlannedMotion>), String>;

/// A plan under way.
#[derive(Debug)]
pub struct Planning {
    made: Background<PlanningResult>,
    shared: Arc<PlanningShared>,
    /// Revision of the scene that is planned for.
    revision: u64,
    /// Number of things to do.
    total: usize,
}

#[derive(Debug, Default)]
struct PlanningShared {
    is_cancelled: AtomicBool,
    /// Things done or tried of the motion that is made now, and motions made before it.
    tried: AtomicUsize,
    motions: AtomicUsize,
}

impl Planning {
    pub(super) fn begin(job: PlanningJob, revision: u64, total: usize) -> Self {
        let shared = Arc::new(PlanningShared::default());
        let shared_state = Arc::clone(&shared);
        let made = Background::start(move || job.carry_out(&shared_state), || {});
        Self { made, shared, revision, total }
    }

    /// Stops the plan at its next node.
    pub fn cancel(&self) {
        self.shared.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Things done or tried of all that is to be done, and number of the motion that is made, from 1.
    pub fn progress(&self) -> ([usize; 2], usize) {
        let tried = self.shared.tried.load(Ordering::Relaxed).min(self.total);
        ([tried, self.total], self.shared.motions.load(Ordering::Relaxed) + 1)
    }

    /// The revision that was planned for, and the result, once there is one.
    pub(super) fn poll(&self, waits: bool) -> Option<(u64, PlanningResult)> {
        Some((self.revision, self.made.poll(waits, || Err("planning failed unexpectedly".into()))?))
    }
}

impl PlanningJob {
    fn carry_out(self, shared: &PlanningShared) -> PlanningResult {
        let Self { sources, task, number, seed, planners } = self;
        let staged = Arc::new(StagedTask::walk_walkers(&sources, task, seed)?);
        let tell = |tried: usize| {
            // From one on for each motion.
            if tried < shared.tried.swap(tried, Ordering::Relaxed) {
                shared.motions.fetch_add(1, Ordering::Relaxed);
            }
        };
        let cancel = Some(&shared.is_cancelled);
        let watch = RunOptions { seed, cancel, on_progress: Some(&tell), keeps_trees: true, planners: Some(&planners) };
        let StagedTask { task, clips, .. } = &*staged;
        let found = plans::variants(task, clips, number, &watch).map_err(|e| e.to_string())?;
        let distances = plans::plan_report(task, &found).map_or_else(Vec::new, |r| r.variants);
        let motions = found.into_iter().enumerate().filter_map(|(i, one)| {
            let one = [one];
            let report = plans::plan_report(task, &one)?;
            let [(seed, outcome)] = one;
            Some(PlannedMotion { seed, outcome, report, distance_rad: distances.get(i).map(|v| v.distance_rad) })
        });
        let motions: Vec<PlannedMotion> = motions.collect();
        Ok((staged, motions))
    }
}
