//! Ids of agents and characters.

use serde::{Deserialize, Serialize};

/// Id of one agent or character: unique in its group for all time, and kept by snapshots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Id {
    /// Row in the tables (< capacity); free again once its owner has left.
    pub index: u32,
    /// Number of earlier owners of this row.
    pub generation: u32,
}

impl Id {
    /// Id of the first owner of a row.
    pub fn first(index: usize) -> Self {
        Self { index: index as u32, generation: 0 }
    }

    /// Row in the tables (< capacity).
    pub fn index(self) -> usize {
        self.index as usize
    }
}

impl std::fmt::Display for Id {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.generation {
            0 => write!(f, "{}", self.index),
            n => write!(f, "{} (of generation {n})", self.index),
        }
    }
}
