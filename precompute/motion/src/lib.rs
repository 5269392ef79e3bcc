//! From files to clips: import, retarget, resample, annotate.

pub mod annotate;
pub mod clip;
pub mod error;
pub mod export;
pub mod files;
pub mod import;
pub mod memory;
pub mod mirror;
pub mod pod;
pub mod progress;
pub mod raw;
pub mod resample;
pub mod retarget;
pub mod side;
mod smpl;
pub mod stance;
pub mod wearer;

pub use clip::{
    Clip, ClipHit, ClipSet, ClipTag, Exclusion, ExclusionReason, FrameId, FrameRange, joint_transforms, runs_where,
};
pub use error::{BuildError, ImportError, Result, Warnings, check_ranges};
pub use progress::{Progress, Silent, StopRequested};
