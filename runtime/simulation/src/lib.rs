//! Scenes: groups of all kinds of motion on one clock.
//!
//! [`Scene`] is what a file says, [`CompiledScene`] the same with its bundles and worlds open, and [`Simulation`] what
//! runs: characters with policies, sparring pairs, blended walkers, inhabitants of stitched worlds, and agents with or
//! without bodies, together. [`Pedestrians`] are agents with bodies on their own, without a scene.

pub mod agents;
pub mod boxing;
mod casts;
mod compile;
pub mod inhabited;
mod kind;
mod paths;
mod pedestrians;
pub mod scenario;
pub mod scene;
mod simulation;
pub mod sparring;
pub mod wander;

pub use casts::GroupCast;
pub use compile::{CompiledScene, OpenWorld};
pub use kind::{Kind, Tick};
pub use pedestrians::Pedestrians;
pub use scene::{Motion, Scene};
pub use simulation::{Event, Group, Happened, Simulation, Thing};
