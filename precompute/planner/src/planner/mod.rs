//! The planner: search, then smoothing, within a budget.

#[cfg(test)]
mod tests;

use crate::collide::Checker;
use crate::linkage::{LIMB_JOINTS, Limb, LimbPose};
use crate::problem::Problem;
use crate::rotation::angle_between;
use crate::search::{SearchConfig, SearchOutcome, SearchRequest, TimeGrid, TreeSearch};
use crate::smooth::{Roughness, RoundingWindow, SmoothConfig, Smoother, roughness};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Settings of a plan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanConfig {
    /// The search.
    pub search: SearchConfig,
    /// Smoothing after the search.
    pub smooth: SmoothConfig,
}

/// Limits of the effort for a plan, and the random seed.
#[derive(Clone, Copy, Debug)]
pub struct Budget<'a> {
    /// Most samples of the search; with this limit alone results are the same on every machine.
    pub draws: u32,
    /// Most time (s); whatever is found first is smoothed only while there is some left.
    pub seconds: Option<f64>,
    /// Stops as soon as it is true; a plan already found is kept.
    pub cancel: Option<&'a AtomicBool>,
    /// Random seed: the same seed gives the same plan.
    pub seed: u64,
    /// Frames a second of the result (Hz, > 0): the clip's.
    pub rate_hz: f64,
    /// True begins with the trees of the last plan, where it had the same start or goal: things have moved a little since. The
    /// result then depends on that plan, too.
    pub warm: bool,
}

impl Default for Budget<'_> {
    fn default() -> Self {
        Self { draws: 20_000, seconds: None, cancel: None, seed: 1, rate_hz: 30.0, warm: false }
    }
}

/// Reason why there is no plan.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The budget was spent.
    #[error("no way found with {draws} samples; the nearest that both ends came was {nearest_m:.3} m; give more time")]
    Spent {
        /// Samples drawn.
        draws: u32,
        /// Distance between the tree of the start and that of the goal (m).
        nearest_m: f64,
    },
    /// The plan was cancelled.
    #[error("cancelled after {draws} samples")]
    Cancelled {
        /// Samples drawn.
        draws: u32,
    },
    /// The frame rate is invalid.
    #[error("expected a rate of 1 to 1000 frames a second; give the clip's")]
    Rate,
}

/// Random generator of a seed.
pub fn seeded_rng(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// Result of a plan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanOutcome {
    /// `None` where there is a motion.
    pub why: Option<PlanError>,
    /// Nodes of both trees.
    pub nodes: usize,
    /// Collision samples.
    pub checks: u64,
    /// Time until the first path (s).
    pub first_solution_s: f64,
    /// Time with smoothing (s).
    pub total_s: f64,
    /// Share of the easing of ends at rest that could be had (0 to 1).
    pub eased: f64,
    /// Frames over which start and goal were blended.
    pub blended: [usize; 2],
    /// Roughness before and after smoothing.
    pub roughness: [Roughness; 2],
}

impl PlanOutcome {
    /// True where there is a motion.
    pub fn is_solved(&self) -> bool {
        self.why.is_none()
    }
}

/// Plans motions of limbs.
///
/// Buffers are kept from plan to plan: nothing is allocated after the first one of its size.
#[derive(Clone, Debug, Default)]
pub struct LimbPlanner {
    checker: Checker,
    search: TreeSearch,
    spare_path: Vec<crate::problem::LimbState>,
    frames: Vec<LimbPose>,
    spare: Vec<LimbPose>,
    windows: Vec<RoundingWindow>,
    /// Time grid of the last plan.
    grid: Option<TimeGrid>,
}

impl LimbPlanner {
    /// A planner without a plan.
    pub fn new() -> Self {
        Self::default()
    }

    /// Plans a motion from the start to the goal, which [`LimbPlanner::motion`] then returns.
    pub fn plan(&mut self, problem: &Problem, config: &PlanConfig, budget: &Budget<'_>) -> PlanOutcome {
        let began = Instant::now();
        let checks = self.checker.checks;
        self.grid = None;
        self.frames.clear();
        let mut outcome = PlanOutcome::default();
        if !(1.0..=1000.0).contains(&budget.rate_hz) {
            return PlanOutcome { why: Some(PlanError::Rate), ..outcome };
        }
        let is_cancelled = || budget.cancel.is_some_and(|c| c.load(Ordering::Relaxed));
        let is_late = || budget.seconds.is_some_and(|s| began.elapsed().as_secs_f64() > s);
        let keep_on = || match (is_cancelled(), is_late()) {
            (true, _) => Some(SearchOutcome::Cancelled),
            (_, true) => Some(SearchOutcome::NoPath),
            _ => None,
        };
        let grid = TimeGrid::new(problem.init.time_s, problem.goal.time_s, budget.rate_hz);
        let mut rng = seeded_rng(budget.seed);
        let search = &mut self.search;
        let quest = SearchRequest { problem, config: &config.search, grid, draws: budget.draws, warm: budget.warm };
        let found = search.run(quest, &mut self.checker, &mut rng, keep_on);
        outcome.nodes = search.num_nodes();
        outcome.first_solution_s = began.elapsed().as_secs_f64();
        let (draws, nearest_m) = (search.draws, search.nearest_m);
        match found {
            SearchOutcome::Path => {
                self.grid = Some(grid);
                self.smooth(problem, config, grid, &mut rng, &mut outcome, || keep_on().is_none());
            }
            SearchOutcome::NoPath => outcome.why = Some(PlanError::Spent { draws, nearest_m }),
            SearchOutcome::Cancelled => outcome.why = Some(PlanError::Cancelled { draws }),
        }
        outcome.checks = self.checker.checks - checks;
        outcome.total_s = began.elapsed().as_secs_f64();
        outcome
    }

    fn smooth(
        &mut self,
        problem: &Problem,
        config: &PlanConfig,
        grid: TimeGrid,
        rng: &mut Pcg64Mcg,
        outcome: &mut PlanOutcome,
        keep_on: impl Fn() -> bool,
    ) {
        let smooth = &config.smooth;
        let frames_in = |seconds: f64| (seconds.max(0.0) / grid.step_s()).round().min(grid.steps as f64) as usize;
        let (path, frames, spare) = (&mut self.search.path, &mut self.frames, &mut self.spare);
        let mut smoother = Smoother { problem, grid, checker: &mut self.checker };
        smoother.fill_frames(path, frames);
        outcome.roughness[0] = roughness(frames, grid.step_s());
        smoother.straighten_path(path, &mut self.spare_path, smooth.straighten, rng, &keep_on);
        smoother.fill_frames(path, frames);
        // Easing speeds up what lies between the ends; where corners cannot be rounded there, even time is smoother.
        for is_eased in [true, false] {
            if !keep_on() {
                break;
            }
            outcome.eased = if is_eased { smoother.ease_ends(path, frames) } else { 0.0 };
            if !is_eased {
                smoother.fill_frames(path, frames);
            }
            smoother.round_corners(frames, frames_in(smooth.round_s), spare, &mut self.windows);
            std::mem::swap(frames, spare);
            outcome.blended = smoother.blend_ends(frames, spare, frames_in(smooth.blend_s), outcome.eased > 0.0);
            // A straight path has no corners that easing could make worse.
            let is_straight = path.len() <= 2;
            let jerk_rms = roughness(frames, grid.step_s()).jerk_rms;
            if outcome.eased == 0.0 || is_straight || jerk_rms <= outcome.roughness[0].jerk_rms {
                break;
            }
        }
        outcome.roughness[1] = roughness(frames, grid.step_s());
    }

    /// The motion of the last plan that was solved.
    pub fn motion(&self) -> Option<LimbMotion<'_>> {
        let grid = self.grid?;
        Some(LimbMotion { start_s: grid.start_s, step_s: grid.step_s(), frames: &self.frames })
    }

    /// The search trees of the last plan, for inspection.
    pub fn search(&self) -> &TreeSearch {
        &self.search
    }
}

/// Poses of a limb, frame by frame; in between, joints turn evenly along shortest arcs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbMotion<'a> {
    /// Time of the first frame (s).
    pub start_s: f64,
    /// From frame to frame (s).
    pub step_s: f64,
    /// The poses.
    pub frames: &'a [LimbPose],
}

impl LimbMotion<'_> {
    /// Difference from another motion of the same frames: the mean angle between the poses of joints that turn differently in
    /// some frame; 0 for the same motion (rad).
    pub fn distance_rad(&self, other: &Self) -> f64 {
        let pairs = || self.frames.iter().zip(other.frames);
        let differs = |i: usize| pairs().any(|(a, b)| a.0[i] != b.0[i]);
        let joints: Vec<usize> = (0..LIMB_JOINTS).filter(|i| differs(*i)).collect();
        let sum: f64 = pairs().flat_map(|(a, b)| joints.iter().map(|i| angle_between(a.0[*i], b.0[*i]))).sum();
        sum / (joints.len() * pairs().count()).max(1) as f64
    }
}

/// A limb, and the times from and to which it is planned (bits of seconds).
type Key = (Limb, [u64; 2]);

/// Planners with their trees: those of the last run, with which plans begin, and those of this one.
///
/// Without a last run, results are the same as without kept planners.
#[derive(Debug, Default)]
pub struct Planners {
    last: Mutex<BTreeMap<Key, LimbPlanner>>,
    now: Mutex<BTreeMap<Key, LimbPlanner>>,
}

impl Planners {
    /// Planners for the next run; plans that this run did not get to keep those of the run before.
    #[must_use]
    pub fn for_next_run(&self) -> Self {
        let all = |of: &Mutex<BTreeMap<Key, LimbPlanner>>| std::mem::take(&mut *lock_despite_panic(of));
        let mut last = all(&self.last);
        last.extend(all(&self.now));
        Self { last: Mutex::new(last), now: Mutex::default() }
    }

    /// Takes the last run's planner of this problem, if there is one and nothing has taken it.
    pub(crate) fn take_planner(&self, problem: &Problem) -> Option<LimbPlanner> {
        lock_despite_panic(&self.last).remove(&planner_key(problem))
    }

    /// Keeps a planner for the next run.
    pub(crate) fn keep_planner(&self, problem: &Problem, planner: &LimbPlanner) {
        lock_despite_panic(&self.now).insert(planner_key(problem), planner.clone());
    }
}

fn planner_key(problem: &Problem) -> Key {
    (problem.chain.limb, [problem.init.time_s, problem.goal.time_s].map(f64::to_bits))
}

fn lock_despite_panic<T>(of: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
