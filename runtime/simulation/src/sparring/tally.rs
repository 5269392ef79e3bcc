//! Outcomes of blows.

use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// Numbers of blows by outcome; each thrown blow has landed, been blocked or missed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BlowTally {
    /// Blows that reached their effective hit.
    pub thrown: u32,
    /// Blows that met their target.
    pub landed: u32,
    /// Blows that were caught by the opponent's arms.
    pub blocked: u32,
    /// Blows that met nothing.
    pub missed: u32,
}

/// Outcome of one blow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BlowOutcome {
    Landed,
    Blocked,
    Missed,
}

impl BlowTally {
    /// Share of the thrown blows that landed; 0 where none was thrown.
    pub fn landed_fraction(&self) -> f32 {
        self.landed as f32 / self.thrown.max(1) as f32
    }

    /// True where each sum equals its parts, and as many blows again can be counted.
    pub(super) fn is_valid(all: &[Self]) -> bool {
        let parts = |t: &Self| u64::from(t.landed) + u64::from(t.blocked) + u64::from(t.missed);
        let thrown: u64 = all.iter().map(|t| u64::from(t.thrown)).sum();
        all.iter().all(|t| parts(t) == u64::from(t.thrown)) && thrown <= u64::from(u32::MAX / 2)
    }

    /// Counts one blow.
    pub(super) fn count_blow(&mut self, outcome: BlowOutcome) {
        self.thrown += 1;
        match outcome {
            BlowOutcome::Landed => self.landed += 1,
            BlowOutcome::Blocked => self.blocked += 1,
            BlowOutcome::Missed => self.missed += 1,
        }
    }
}

impl AddAssign for BlowTally {
    fn add_assign(&mut self, o: Self) {
        self.thrown += o.thrown;
        self.landed += o.landed;
        self.blocked += o.blocked;
        self.missed += o.missed;
    }
}
