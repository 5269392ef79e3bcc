//! Scenes of walkers: characters of many sizes on paths of their own, whose bodies come from blend spaces.

mod config;
mod group;
mod path;
mod run;

pub use config::{BodiesConfig, PathsConfig, ShownStyle, WalkersScene};
pub use group::Walk;
pub use path::{Wander, curve};
pub use run::{StyleWalk, WalkersRecord, WalkersReport, run, walk_styles};
