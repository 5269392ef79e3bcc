//! Opens Throng tables, answers queries and steps characters.

pub mod contacts;
pub mod format;
mod lanes;
pub mod planar;
pub mod policy;
pub mod pose;
pub mod skeleton;
mod troupe;

pub use contacts::Contacts;
pub use format::FormatError;
pub use planar::Planar;
pub use skeleton::{Joint, NUM_JOINTS, Skeleton};
