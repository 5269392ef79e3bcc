//! Opens Throng tables, answers queries and steps characters.

pub mod contacts;
pub mod planar;
pub mod policy;
pub mod simd;
pub mod skeleton;

pub use contacts::Contacts;
pub use planar::Planar;
pub use skeleton::{Joint, NUM_JOINTS, Skeleton};
