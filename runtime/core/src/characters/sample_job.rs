//! Poses straight from the database, without characters.

use super::motion_set::MotionSet;
use crate::body::{FrameCursor, LanePose, Mat3x4, sample_pose, shared, to_model, write_matrices};
use crate::skeleton::NUM_JOINTS;
use throng_base::Result;
use throng_base::error::{check_index, check_length, check_range};
use throng_base::simd::{LANES, LaneWork, Lanes, dispatch};

/// Samples frames between rows and applies the hierarchy, in one pass over a batch.
///
/// Allocates nothing; split by range to run on several threads.
///
/// ```no_run
/// use throng_core::characters::{MotionSet, SampleJob};
/// use throng_core::{Bundle, Mat3x4, NUM_JOINTS};
///
/// let motion_set = MotionSet::new(&Bundle::open("people.throng")?);
/// let mut matrices = [Mat3x4::default(); NUM_JOINTS];
/// SampleJob { motion_set: &motion_set, frames: &[0], ratios: &[0.5], matrices: &mut matrices }.run()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SampleJob<'a> {
    /// The database.
    pub motion_set: &'a MotionSet,
    /// Row of each pose (< number of rows).
    pub frames: &'a [u32],
    /// Ratio to the next row, which must be of the same clip for the pose to make sense (0 to 1). (frames.len())
    pub ratios: &'a [f32],
    /// Output: joints in model space, above the planar root (frames.len() * NUM_JOINTS).
    pub matrices: &'a mut [Mat3x4],
}

impl SampleJob<'_> {
    /// # Errors
    /// [`throng_base::Error`] where the output has another length or a frame does not exist.
    pub fn validate(&self) -> Result<()> {
        check_length("matrices", self.matrices.len(), self.frames.len() * NUM_JOINTS)?;
        check_length("ratios", self.ratios.len(), self.frames.len())?;
        self.ratios.iter().try_for_each(|&ratio| check_range("ratio", ratio, 0.0..=1.0, "between 0 and 1"))?;
        let num_frames = self.motion_set.num_frames();
        self.frames.iter().try_for_each(|&frame| check_index("frame", None, frame as usize, num_frames))
    }

    /// # Errors
    /// As [`Self::validate`].
    pub fn run(self) -> Result<()> {
        self.validate()?;
        dispatch(self);
        Ok(())
    }
}

impl LaneWork for SampleJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let set = self.motion_set;
        let batches = self.frames.chunks(LANES).zip(self.ratios.chunks(LANES));
        for ((frames, ratios), out) in batches.zip(self.matrices.chunks_mut(LANES * NUM_JOINTS)) {
            let spots = std::array::from_fn(|l| {
                let l = l.min(frames.len() - 1);
                set.frame_position(frames[l], ratios[l], false)
            });
            let cursor: FrameCursor<'_, F> = FrameCursor::at_positions(&spots, &set.frames, &set.rotation_code);
            let [.., height] = cursor.root();
            let mut pose = LanePose::unposed(F::splat(0.0));
            sample_pose(&cursor, height, &mut pose);
            write_matrices(&to_model(shared(&set.skeleton), &pose), out);
        }
    }
}
