//! What the documents of the viewer show of scene files, each a kind of motion.

mod config;
pub mod crowd;
mod file;
mod play;
mod snapshot;
pub mod walkers;
pub mod world;

pub use config::{DragPoint, Scene, SceneGoal, SceneKind, TargetConfig};
pub use play::{Cast, Play};
pub use snapshot::PlaySnapshot;
