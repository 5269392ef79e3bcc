//! Bakes motion capture into Throng tables. [`pipeline`] lists the stages in order.

pub mod cache;
pub mod clip;
pub mod error;
pub mod features;
pub mod files;
pub mod graph;
pub mod import;
pub mod picture;
pub mod progress;
pub mod raw;

pub use clip::{Clip, ClipSet};
pub use error::{BuildError, ImportError, Warnings};
