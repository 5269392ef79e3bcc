//! Planners from run to run of a task, so that a plan goes on where the last one like it ended.

use super::Planner;
use crate::linkage::Limb;
use crate::problem::Problem;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// A limb, and from when to when it is planned (bits of seconds).
type Key = (Limb, [u64; 2]);

/// Planners with their trees: those of the last run, which plans begin with, and those of this one.
///
/// A run that begins without a last one is the same as without any of it.
#[derive(Debug, Default)]
pub struct Planners {
    last: Mutex<BTreeMap<Key, Planner>>,
    now: Mutex<BTreeMap<Key, Planner>>,
}

impl Planners {
    /// For the next run; what it did not come to is still that of the run before.
    #[must_use]
    pub fn next(&self) -> Self {
        let all = |of: &Mutex<BTreeMap<Key, Planner>>| std::mem::take(&mut *locked(of));
        let mut last = all(&self.last);
        last.extend(all(&self.now));
        Self { last: Mutex::new(last), now: Mutex::default() }
    }

    /// That of the last run, if there is one that nobody took.
    pub(crate) fn take(&self, problem: &Problem) -> Option<Planner> {
        locked(&self.last).remove(&key(problem))
    }

    /// Keeps one for the next run.
    pub(crate) fn keep(&self, problem: &Problem, planner: &Planner) {
        locked(&self.now).insert(key(problem), planner.clone());
    }
}

fn key(problem: &Problem) -> Key {
    (problem.chain.linkage.limb, [problem.init.time_s, problem.goal.time_s].map(f64::to_bits))
}

fn locked<T>(of: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
