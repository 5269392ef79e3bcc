//! Scenes in worlds of patches: people who live there, run and measured.

mod config;
mod overlap;

pub use config::{PictureConfig, SharedWish, WishConfig, WorldScene};
pub use overlap::{OverlapMeter, TRUNK_RADIUS_M};
