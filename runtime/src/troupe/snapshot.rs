//! Keeping what a troupe remembers, to go back to it.

use super::block::Block;
use super::{Troupe, TroupeError};

/// What a troupe remembers at one instant: all that its next steps depend on, poses not among it.
/// [Size: about 520 bytes a character]
#[derive(Clone, Debug, Default)]
pub struct TroupeSnapshot {
    blocks: Vec<Block>,
    num_characters: usize,
    num_choosers: usize,
    num_frames: usize,
    num_segments: usize,
}

impl TroupeSnapshot {
    /// Memory that it takes. [Unit: bytes]
    pub fn num_bytes(&self) -> usize {
        size_of_val(self.blocks.as_slice())
    }
}

impl Troupe {
    /// Keeps what the troupe remembers.
    pub fn snapshot(&self) -> TroupeSnapshot {
        TroupeSnapshot {
            blocks: self.blocks.clone(),
            num_characters: self.num_characters,
            num_choosers: self.num_choosers,
            num_frames: self.num_frames,
            num_segments: self.num_segments,
        }
    }

    /// Goes back to a snapshot. Steps from there are those of the troupe that was kept, bit by bit, where repertoire,
    /// config and goals are the same; poses are there after the first of them.
    ///
    /// # Errors
    /// [`TroupeError::Length`] where the snapshot is of another number of characters, [`TroupeError::OtherBundle`] where
    /// it is of a troupe on another bundle; nothing has changed then.
    pub fn restore(&mut self, snapshot: &TroupeSnapshot) -> Result<(), TroupeError> {
        let (got, expected) = (snapshot.num_characters, self.num_characters);
        if got != expected {
            return Err(TroupeError::Length { what: "snapshot", got, expected });
        }
        for (what, got, expected) in
            [("frames", snapshot.num_frames, self.num_frames), ("segments", snapshot.num_segments, self.num_segments)]
        {
            if got != expected {
                return Err(TroupeError::OtherBundle { what, expected, got });
            }
        }
        self.blocks.clone_from(&snapshot.blocks);
        self.num_choosers = snapshot.num_choosers;
        Ok(())
    }
}
