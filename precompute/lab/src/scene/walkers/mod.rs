//! Scenes of walkers: characters of many sizes on paths of their own, whose bodies come from blend spaces.

mod config;
mod group;
mod path;

pub use config::{BodiesConfig, PathsConfig, ShownStyle, WalkersScene};
pub use group::{Walk, body_of};
pub(super) use group::{blend_fault, named_space};
pub use path::Wander;
