//! Scenes in worlds of patches: people who live there, run and measured.

mod config;
mod life;
mod overlap;
mod run;

pub use config::{PictureConfig, SharedWish, WishConfig, WorldScene};
pub use life::{Life, trunks};
pub use overlap::{OverlapMeter, TRUNK_RADIUS_M};
pub use run::{WorldRecord, WorldReport, run};
