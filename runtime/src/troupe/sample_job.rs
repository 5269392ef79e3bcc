//! Poses straight from the database, without characters.

use super::TroupeError;
use super::hierarchy::{shared, to_model, write_matrices};
use super::repertoire::Repertoire;
use super::sample::{Cursor, sample};
use crate::lanes::{LANES, Lanes, Work, dispatch};
use crate::pose::Mat3x4;
use crate::skeleton::NUM_JOINTS;

/// Samples frames between rows and applies the hierarchy, in one pass over a batch.
///
/// Allocates nothing; split by range to run on several threads.
#[derive(Debug)]
pub struct SampleJob<'a> {
    /// The database.
    pub repertoire: &'a Repertoire<'a>,
    /// Row of each pose. [Limit: < number of rows]
    pub frames: &'a [u32],
    /// How far to the next row, which must be of the same clip for the pose to make sense. [Limit: 0 to 1]
    /// [Size: frames.len()]
    pub ratios: &'a [f32],
    /// Output: joints in model space, above the planar root. [Size: frames.len() * NUM_JOINTS]
    pub matrices: &'a mut [Mat3x4],
}

impl SampleJob<'_> {
    /// # Errors
    /// [`TroupeError`] where the output has another length or a frame does not exist.
    pub fn validate(&self) -> Result<(), TroupeError> {
        let (got, expected) = (self.matrices.len(), self.frames.len() * NUM_JOINTS);
        if got != expected {
            return Err(TroupeError::Length { what: "matrices", got, expected });
        }
        let (got, expected) = (self.ratios.len(), self.frames.len());
        if got != expected {
            return Err(TroupeError::Length { what: "ratios", got, expected });
        }
        if let Some(&got) = self.ratios.iter().find(|r| !(0.0..=1.0).contains(*r)) {
            return Err(TroupeError::Value { what: "ratio", got, expected: "between 0 and 1" });
        }
        let limit = self.repertoire.frames.len();
        match self.frames.iter().find(|f| **f as usize >= limit) {
            Some(&f) => Err(TroupeError::Index { what: "frame", got: f as usize, limit }),
            None => Ok(()),
        }
    }

    /// # Errors
    /// As [`Self::validate`].
    pub fn run(self) -> Result<(), TroupeError> {
        self.validate()?;
        dispatch(self);
        Ok(())
    }
}

impl Work for SampleJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let rows = self.repertoire.frames;
        let last = rows.len() - 1;
        let batches = self.frames.chunks(LANES).zip(self.ratios.chunks(LANES));
        for ((frames, ratios), out) in batches.zip(self.matrices.chunks_mut(LANES * NUM_JOINTS)) {
            let lane = |l: usize| l.min(frames.len() - 1);
            let at: [usize; LANES] = std::array::from_fn(|l| frames[lane(l)] as usize);
            let cursor = Cursor {
                rows: [at.map(|f| &rows[f]), at.map(|f| &rows[(f + 1).min(last)])],
                ratio: F::from_array(std::array::from_fn(|l| ratios[lane(l)])),
            };
            write_matrices(&to_model(shared(&self.repertoire.skeleton), &sample::<F>(&cursor)), frames.len(), out);
        }
    }
}
