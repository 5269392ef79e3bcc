//! Saves the state of characters and restores it.

use super::block::Block;
use super::{Characters, CharactersError};

/// State of characters at one instant: all that their next steps depend on, without poses.
/// (about 520 bytes a character)
#[derive(Clone, Debug, Default)]
pub struct CharactersSnapshot {
    blocks: Vec<Block>,
    num_characters: usize,
    num_choosers: usize,
    num_frames: usize,
    num_segments: usize,
}

impl CharactersSnapshot {
    /// Memory that it takes (bytes).
    pub fn num_bytes(&self) -> usize {
        size_of_val(self.blocks.as_slice())
    }
}

impl Characters {
    /// Saves the state.
    pub fn snapshot(&self) -> CharactersSnapshot {
        CharactersSnapshot {
            blocks: self.blocks.clone(),
            num_characters: self.num_characters,
            num_choosers: self.num_choosers,
            num_frames: self.num_frames,
            num_segments: self.num_segments,
        }
    }

    /// Goes back to a snapshot. Steps from there repeat those of the saved characters bit by bit where motion set,
    /// config and goals are the same; poses are there after the first of them.
    ///
    /// # Errors
    /// [`CharactersError::Length`] where the snapshot is of another number of characters, [`CharactersError::OtherBundle`] where
    /// it is of characters on another bundle; nothing has changed then.
    pub fn restore(&mut self, snapshot: &CharactersSnapshot) -> Result<(), CharactersError> {
        let (got, expected) = (snapshot.num_characters, self.num_characters);
        if got != expected {
            return Err(CharactersError::Length { what: "snapshot", got, expected });
        }
        for (what, got, expected) in
            [("frames", snapshot.num_frames, self.num_frames), ("segments", snapshot.num_segments, self.num_segments)]
        {
            if got != expected {
                return Err(CharactersError::OtherBundle { what, expected, got });
            }
        }
        self.blocks.clone_from(&snapshot.blocks);
        self.num_choosers = snapshot.num_choosers;
        Ok(())
    }
}
