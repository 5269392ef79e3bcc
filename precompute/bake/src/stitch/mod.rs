//! Worlds: patches fitted into an environment and joined where they overlap, without obstructed motion and dead ends
//! (Lee, Choi and Lee 2006, section 5).

mod clearance;
mod config;
mod connect;
mod edit;
mod inferred;
mod library;
mod place;
mod report;
mod sets;
mod source;

pub use config::StitchConfig;
pub use edit::editor::Editor;
pub use edit::explain::{InstanceItem, RemovalExplanation, UnitCollision};
pub use inferred::SavedFiles;
pub use library::Library;
pub use report::{RemovalReason, StitchReport};
pub use source::{StitchKit, WorldSource, check_replaced, save, stitch_source};

use crate::environment::Environment;
use throng_core::patch::PatchTables;
use throng_motion::{error::Result, progress::Progress};
use throng_world::WorldData;

/// Stitches a world: fits the patches of a bundle into an environment, joins them where they overlap, and removes
/// motion that units obstruct or that is outside the largest strongly connected component.
///
/// # Errors
/// [`throng_motion::error::BuildError::Config`] if a setting is out of its limits.
/// [`throng_motion::error::BuildError::Stage`] names overlapping units, units that
/// no block fits, units that no character can reach or leave, and environments in which no motion continues.
///
/// # Source
/// Lee, Choi and Lee (2006), section 5. Differs: joints also leave and enter tiles in the middle of their motion, and
/// joints and obstacles are found once for all pairs in the same relative placement.
pub fn stitch(
    patches: &PatchTables,
    library: &Library<'_>,
    environment: &Environment,
    config: &StitchConfig,
    progress: &dyn Progress,
) -> Result<(WorldData, StitchReport)> {
    Ok(Editor::new(patches, *library, environment.clone(), config, progress)?.into_world())
}
