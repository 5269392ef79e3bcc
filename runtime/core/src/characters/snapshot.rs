//! Saves the state of characters and restores it.

use super::block::{Block, LAID};
use super::room::clear_beyond;
use super::scheduled_clip::is_stretch;
use super::{Characters, CharactersError, MotionSet};
use crate::pose::{Mat3x4, get};
use serde::{Deserialize, Serialize};
use throng_base::simd::LANES;

/// State of characters at one instant: all that their next steps depend on, without poses.
/// (about 520 bytes a character)
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
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
            blocks: self.saved_blocks(),
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
        if got != expected || snapshot.blocks.len() != got.div_ceil(LANES) {
            return Err(CharactersError::Length { what: "snapshot", got, expected });
        }
        for (what, got, expected) in
            [("frames", snapshot.num_frames, self.num_frames), ("segments", snapshot.num_segments, self.num_segments)]
        {
            if got != expected {
                return Err(CharactersError::OtherBundle { what, expected, got });
            }
        }
        self.blocks[..snapshot.blocks.len()].copy_from_slice(&snapshot.blocks);
        self.num_choosers = snapshot.num_choosers;
        Ok(())
    }

    /// Goes back to bytes that may be anybody's: characters that are laid on scheduled clips, as many as there are room
    /// for. Poses are there after the next step. False where they are no such characters; nothing has changed then.
    pub fn restore_laid(&mut self, motion_set: &MotionSet, snapshot: &CharactersSnapshot) -> bool {
        let n = snapshot.num_characters;
        let room = self.matrices.len() / crate::NUM_JOINTS;
        if n > room || snapshot.blocks.len() != n.div_ceil(LANES) {
            return false;
        }
        if !(0..n).all(|c| is_laid(motion_set, &snapshot.blocks[c / LANES], c % LANES)) {
            return false;
        }
        self.blocks.fill(Block::ZERO);
        self.blocks[..snapshot.blocks.len()].copy_from_slice(&snapshot.blocks);
        clear_beyond(&mut self.blocks, n);
        self.matrices.fill(Mat3x4::default());
        (self.num_characters, self.num_choosers) = (n, 0);
        true
    }
}

/// True where one is laid on a stretch of a clip, somewhere.
fn is_laid(motion_set: &MotionSet, b: &Block, lane: usize) -> bool {
    let near = |v: f32| v.abs() < 1e7;
    let places = [get(&b.clip_to_world, lane), get(&b.root, lane), get(&b.drift, lane)];
    b.segment[lane] == LAID
        && is_stretch(motion_set, b.first[lane], b.length[lane])
        && places.iter().all(|v| v.to_array().into_iter().all(near))
        && [b.time[lane], b.lift[lane], b.turn[lane], b.drift_from[lane]].into_iter().all(near)
        && b.bend[lane] == 0.0
}
