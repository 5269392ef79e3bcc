//! The posing kernel, eight characters at a time: frames are sampled, the hierarchy is applied, legs reach, feet are
//! locked, and matrices come out.

mod foot_lock;
mod hierarchy;
mod lanes;
mod lanewise;
mod leg;
mod matrix;
mod placement;
mod sample;

pub use foot_lock::FootLockConfig;
pub(crate) use foot_lock::{FootLock, LockStep, PlantedParts, lock_foot};
pub(crate) use hierarchy::{ModelPose, PARENTS, shared, to_model, write_locals, write_matrices};
pub(crate) use lanes::{Lane, Lane3, RANGE_BLOCKS, RANGE_LEN, get_lane, load, planar_of_lane, set_lane, store};
pub(crate) use lanewise::{Lanewise, lanewise_fields};
pub(crate) use leg::{LegJoints, bent_middle, move_leg};
pub use matrix::{LocalTransform, Mat3x4};
pub(crate) use placement::PlacementLanes;
pub(crate) use sample::{FrameCursor, FramePosition, LanePose, WINDOW, sample_number, sample_pose};
