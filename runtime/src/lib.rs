//! Opens Throng tables, answers queries and steps characters.
//!
//! A bundle (`*.throng`) is opened as [`Tables`]; a [`troupe::Repertoire`] takes the views a step needs; a
//! [`troupe::Troupe`] holds the characters. [`sparring::Sparring`] lets pairs of them box. [`policy`] answers single queries without characters.

pub mod blend;
pub mod contacts;
pub mod crowd;
pub mod format;
pub mod graph;
pub mod hits;
mod lanes;
pub mod patch;
pub mod planar;
pub mod policy;
pub mod pose;
mod prefetch;
pub mod simd;
pub mod skeleton;
pub mod sparring;
pub mod tables;
pub mod troupe;
pub mod world;

pub use contacts::Contacts;
pub use format::FormatError;
pub use hits::HitRecord;
pub use planar::Planar;
pub use pose::{LocalTransform, Mat3x4};
pub use skeleton::{Joint, NUM_JOINTS, Skeleton};
pub use tables::Tables;
