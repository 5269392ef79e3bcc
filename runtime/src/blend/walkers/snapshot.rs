//! Keeping what walkers remember, to go back to it.

use super::Walkers;
use super::block::Block;
use crate::blend::error::{BlendError, check_length};

/// What walkers remember at one instant: all that their next steps depend on, poses not among it.
#[derive(Clone, Debug, Default)]
pub struct WalkersSnapshot {
    blocks: Vec<Block>,
    num_characters: usize,
}

impl WalkersSnapshot {
    /// Memory that it takes. [Unit: bytes]
    pub fn num_bytes(&self) -> usize {
        size_of_val(self.blocks.as_slice())
    }
}

impl Walkers {
    /// Keeps what the walkers remember.
    pub fn snapshot(&self) -> WalkersSnapshot {
        WalkersSnapshot { blocks: self.blocks.clone(), num_characters: self.num_characters }
    }

    /// Goes back to a snapshot. Steps from there are those of the walkers that were kept, bit by bit, where space,
    /// bodies, config and controls are the same; poses are there after the first of them.
    ///
    /// # Errors
    /// [`BlendError::Length`] where the snapshot is of another number of characters; nothing has changed then.
    pub fn restore(&mut self, snapshot: &WalkersSnapshot) -> Result<(), BlendError> {
        check_length("snapshot", snapshot.num_characters, self.num_characters)?;
        self.blocks.clone_from(&snapshot.blocks);
        Ok(())
    }
}
