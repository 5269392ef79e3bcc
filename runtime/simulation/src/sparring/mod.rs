//! Sparring: pairs of characters that strike at each other, and boxers that strike at targets (Lee and Lee 2004, section 6).
//!
//! [`Sparring`] takes each character's head as the other's target, tests at effective hits which blows land, and
//! pushes what is struck. [`TargetPractice`] gives every character a [`StruckTarget`] of its own instead. Both are a
//! [`throng_core::CharacterGroup`] of [`throng_core::characters::PolicyCharacters`], with the same orders.

mod body;
mod bout;
mod config;
mod landing;
mod pair;
mod practice;
mod snapshot;
mod stagger;
mod tally;
mod target;
#[cfg(test)]
mod tests;

pub use body::{BodyShape, NUM_CAPSULES, NUM_CORE, SparringBody, StruckPart, WorldPose};
pub use bout::{Sparring, SparringFigures};
pub use config::{NO_THREAT_S, SeparationConfig, SparringConfig, StaggerConfig};
pub use landing::BlowLanding;
pub use practice::{PracticeConfig, PracticeFigures, TargetHit, TargetPractice};
pub use tally::BlowTally;
pub use target::{StruckTarget, TargetConfig};
pub use throng_core::body::TouchConfig;
