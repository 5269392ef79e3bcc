//! Scenes: groups of all kinds of motion on one clock.
//!
//! [`Scene`] is what a file says, [`CompiledScene`] the same with its bundles and worlds open, and [`Simulation`] what
//! runs: characters with policies, sparring pairs, blended walkers, inhabitants of stitched worlds, and agents with or
//! without bodies, together. [`Pedestrians`] are agents with bodies on their own, without a scene.

pub mod agents;
pub mod boxing;
mod character_groups;
mod compile;
mod expectations;
pub mod inhabitant_group;
mod motion_kind;
mod order;
mod paths;
mod pedestrians;
pub mod scenario;
pub mod scene;
mod simulation;
pub mod sparring;
mod statistics;
pub mod travellers;
pub mod wander;

pub use character_groups::AnyCharacterGroup;
pub use compile::{CompiledScene, OpenWorld};
pub use expectations::ExpectationWatch;
pub use motion_kind::{GroupStep, MotionKind};
pub use order::Order;
pub use pedestrians::Pedestrians;
pub use scene::{GroupMotion, Scene};
pub use simulation::{CharacterEvent, SceneGroup, SceneThing, Simulation, SimulationEvent};
pub use statistics::SceneStatistics;
