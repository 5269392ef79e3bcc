//! Scenes: characters on a bundle with something to do, from a file, run and measured.

mod config;
pub mod crowd;
mod file;
mod play;
mod run;
mod snapshot;
pub mod walkers;
pub mod world;

pub use config::{DragPoint, Scene, SceneGoal, SceneKind, TargetConfig};
pub use play::{Cast, Play};
pub use run::{RunConfig, SceneEvent, SceneFrame, SceneRecord, SceneReport, run};
pub use snapshot::PlaySnapshot;
