//! Scenes in worlds of patches: people who live there, run and measured.

mod config;
mod life;

pub use crate::run::{TRUNK_RADIUS_M, TrunkMeter as OverlapMeter};
pub use config::{PictureConfig, SharedWish, WishConfig, WorldScene};
pub use life::{Life, trunks};
