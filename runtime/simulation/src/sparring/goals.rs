//! Behaviours and what they are about, as characters take them.

use super::config::within;
use glam::Vec3;
use throng_base::Result;
use throng_base::error::{self, check_index};
use throng_core::characters::{Goal, MAX_GOALS, MotionSet};

const _: () = assert!(MAX_GOALS == 4, "the message names it");

/// Checks that behaviours exist: their policies and weights.
pub(super) fn check(motion_set: &MotionSet, goals: impl ExactSizeIterator<Item = (usize, f32)>) -> Result<()> {
    let n = goals.len();
    error::check("the number of goals", None, n as f64, (1..=MAX_GOALS).contains(&n), "1 to 4")?;
    for (policy, weight) in goals {
        check_index("policy", None, policy, motion_set.num_policies())?;
        within("weight", weight, -1e6, 1e6, "a finite number below 1e6")?;
    }
    Ok(())
}

/// The goals of one step, on the stack.
pub(super) struct Goals<'a> {
    slots: [Goal<'a>; MAX_GOALS],
    len: usize,
}

impl<'a> Goals<'a> {
    /// Of policies, weights and targets (at most MAX_GOALS).
    pub fn new(of: impl Iterator<Item = (usize, f32, &'a [Vec3])>) -> Self {
        let mut goals = Self { slots: [Goal { policy: 0, weight: 0.0, targets: &[] }; MAX_GOALS], len: 0 };
        for (slot, (policy, weight, targets)) in goals.slots.iter_mut().zip(of) {
            *slot = Goal { policy, weight, targets };
            goals.len += 1;
        }
        goals
    }

    pub fn get(&self) -> &[Goal<'a>] {
        &self.slots[..self.len]
    }
}
