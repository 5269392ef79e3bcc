//! Opens bundles, answers policy queries, poses characters.
//!
//! A bundle (`*.throng`) is opened as [`Bundle`]; [`characters::PolicyCharacters`] and [`walkers::Walkers`] are
//! [`CharacterGroup`]s that move and pose people. [`policy`] answers single queries without characters.

pub mod blend;
pub mod body;
pub mod bundle;
pub mod character_group;
pub mod characters;
pub mod contacts;
pub mod format;
pub mod graph;
pub mod hits;
pub mod patch;
mod placement;
mod plain_body;
pub mod planar;
pub mod policy;
pub mod reserve;
mod roster;
pub mod skeleton;
pub mod stops;
pub mod walkers;

pub use body::{BodyVolume, JointCapsule, LocalTransform, Mat3x4};
pub use bundle::Bundle;
pub use character_group::{AdoptReport, CharacterGroup, OrderStatus, PosedBodies, PosedBody};
pub use contacts::Contacts;
pub use format::FormatError;
pub use hits::HitRecord;
pub use plain_body::PlainBody;
pub use planar::Planar;
pub use roster::Roster;
pub use skeleton::{Joint, NUM_JOINTS, Skeleton};
#[cfg(feature = "rayon")]
pub use throng_base::Rayon;
pub use throng_base::{self as base, Error, Executor, Id, Inline, Result, glam, simd};
