//! Behaviours and what they are about, as characters take them.

use super::config::within;
use glam::Vec3;
use throng_core::characters::{CharactersError, Goal, MAX_GOALS, MotionSet};

/// Numbers of goals that there may be, as [`MAX_GOALS`] sets them.
const EXPECTED: &str = "1 to 4";
const _: () = assert!(MAX_GOALS == 4, "the message names it");

/// Checks that behaviours exist: their policies and weights.
pub(super) fn check(
    motion_set: &MotionSet,
    goals: impl ExactSizeIterator<Item = (usize, f32)>,
) -> Result<(), CharactersError> {
    if goals.len() == 0 || goals.len() > MAX_GOALS {
        let got = goals.len() as f32;
        return Err(CharactersError::Value { what: "the number of goals", got, expected: EXPECTED });
    }
    let limit = motion_set.num_policies();
    for (policy, weight) in goals {
        if policy >= limit {
            return Err(CharactersError::Index { what: "policy", got: policy, limit });
        }
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
