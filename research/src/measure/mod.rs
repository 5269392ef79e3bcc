//! Experiments on bundles and worlds. One file answers one question.

mod blend;
mod matching;
mod world;

pub use blend::{BlendFigures, blend};
pub use matching::{MatchingConfig, MatchingFigures, matching};
pub use world::{EditFigures, PlannedPathFigures, WorldFigures, world};
