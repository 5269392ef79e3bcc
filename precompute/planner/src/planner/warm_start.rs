//! Planners kept from run to run of a task, so that a plan continues where the last one like it ended.

use super::LimbPlanner;
use crate::linkage::Limb;
use crate::problem::Problem;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

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
