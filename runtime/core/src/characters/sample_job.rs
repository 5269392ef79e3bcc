//! Poses straight from the database, without characters.

use super::CharactersError;
use super::motion_set::MotionSet;
use crate::pose::{Cursor, Mat3x4, sample, shared, to_model, write_matrices};
use crate::skeleton::NUM_JOINTS;
use throng_base::simd::{LANES, Lanes, Work, dispatch};

/// Samples frames between rows and applies the hierarchy, in one pass over a batch.
///
/// Allocates nothing; split by range to run on several threads.
#[derive(Debug)]
pub struct SampleJob<'a> {
    /// The database.
    pub motion_set: &'a MotionSet,
    /// Row of each pose (< number of rows).
    pub frames: &'a [u32],
    /// How far to the next row, which must be of the same clip for the pose to make sense (0 to 1).
    /// (frames.len())
    pub ratios: &'a [f32],
    /// Output: joints in model space, above the planar root (frames.len() * NUM_JOINTS).
    pub matrices: &'a mut [Mat3x4],
}

impl SampleJob<'_> {
    /// # Errors
    /// [`CharactersError`] where the output has another length or a frame does not exist.
    pub fn validate(&self) -> Result<(), CharactersError> {
        let (got, expected) = (self.matrices.len(), self.frames.len() * NUM_JOINTS);
        if got != expected {
            return Err(CharactersError::Length { what: "matrices", got, expected });
        }
        let (got, expected) = (self.ratios.len(), self.frames.len());
        if got != expected {
            return Err(CharactersError::Length { what: "ratios", got, expected });
        }
        if let Some(&got) = self.ratios.iter().find(|r| !(0.0..=1.0).contains(*r)) {
            return Err(CharactersError::Value { what: "ratio", got, expected: "between 0 and 1" });
        }
        let limit = self.motion_set.frames.len();
        match self.frames.iter().find(|f| **f as usize >= limit) {
            Some(&f) => Err(CharactersError::Index { what: "frame", got: f as usize, limit }),
            None => Ok(()),
        }
    }

    /// # Errors
    /// As [`Self::validate`].
    pub fn run(self) -> Result<(), CharactersError> {
        self.validate()?;
        dispatch(self);
        Ok(())
    }
}

impl Work for SampleJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let rows = &*self.motion_set.frames;
        let last = rows.len() - 1;
        let batches = self.frames.chunks(LANES).zip(self.ratios.chunks(LANES));
        for ((frames, ratios), out) in batches.zip(self.matrices.chunks_mut(LANES * NUM_JOINTS)) {
            let lane = |l: usize| l.min(frames.len() - 1);
            let at: [usize; LANES] = std::array::from_fn(|l| frames[lane(l)] as usize);
            let cursor = Cursor {
                rows: [at.map(|f| &rows[f]), at.map(|f| &rows[(f + 1).min(last)])],
                ratio: F::from_array(std::array::from_fn(|l| ratios[lane(l)])),
            };
            write_matrices(&to_model(shared(&self.motion_set.skeleton), &sample::<F>(&cursor)), frames.len(), out);
        }
    }
}
