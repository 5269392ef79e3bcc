//! Bakes motion capture into Throng tables. [`pipeline`] lists the stages in order.

pub mod clip;
pub mod error;
pub mod graph;
pub mod policy;
pub mod progress;
pub mod raw;

pub use clip::{Clip, ClipSet};
pub use error::{BuildError, ImportError, Warnings};
