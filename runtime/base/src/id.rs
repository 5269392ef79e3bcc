//! Ids of agents and characters.

use serde::{Deserialize, Serialize};

/// Names one agent or character. Nobody else of the same cast ever has the same id; a snapshot keeps it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Id {
    /// Place in the tables (< capacity). Free again once its owner has left.
    pub index: u32,
    /// How many had this place before.
    pub generation: u32,
}

impl Id {
    /// The first one to have a place.
    pub fn first(index: usize) -> Self {
        Self { index: index as u32, generation: 0 }
    }

    /// Place in the tables (< capacity).
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
