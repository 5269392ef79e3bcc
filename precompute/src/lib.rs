//! Bakes motion capture into Throng tables. [`pipeline`] lists the stages in order.

pub mod annotate;
pub mod clip;
pub mod error;
pub mod features;
pub mod graph;
pub mod import;
pub mod mirror;
pub mod progress;
pub mod raw;
pub mod resample;
pub mod retarget;

pub use clip::{Clip, ClipSet};
pub use error::{BuildError, ImportError, Warnings};
