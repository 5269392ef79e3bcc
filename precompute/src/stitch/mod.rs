//! Worlds: patches fitted into an environment, joined where they overlap, without what is in the way and without
//! dead ends (004 section 5).

mod allow;
mod assemble;
mod bits;
mod bodies;
mod component;
mod config;
mod crossing;
mod editor;
mod field;
mod fit;
mod history;
mod joined;
mod lay;
mod library;
mod make;
mod mask;
mod near;
mod numbers;
mod outcome;
mod paths;
mod plan;
mod prepare;
mod reach;
mod relation;
mod relay;
mod remains;
mod report;
mod resettle;
mod rows;
mod same;
mod seen;
mod settled;
mod situation;
mod solids;
mod source;
mod swept;
mod table;
mod why;

pub use config::StitchConfig;
pub use editor::Editor;
pub use library::Library;
pub use report::{Reason, StitchReport};
pub use source::{Kit, WorldSource, save, stitch_source};
pub use why::{Collision, Item, Why};

use crate::environment::Environment;
use crate::error::BuildError;
use crate::progress::Progress;
use throng_runtime::patch::Patches;
use throng_runtime::world::WorldData;

/// Stitches a world: fits the patches of a bundle into an environment, joins them where they overlap, and takes out
/// what units are in the way of and what does not belong to the largest strongly connected component.
///
/// # Errors
/// [`BuildError::Config`] where a setting is out of its limits. [`BuildError::Stage`] names units that stand in each
/// other, that no block fits, that no character can get to or away from, and says where no motion goes on at all.
///
/// # Source
/// 004, section 5. Differs: joints also leave and enter tiles in the middle of their motion, and joints and obstacles
/// are found once for all pairs that stand to each other in the same way.
pub fn stitch(
    patches: &Patches<'_>,
    library: &Library<'_>,
    environment: &Environment,
    config: &StitchConfig,
    progress: &dyn Progress,
) -> Result<(WorldData, StitchReport), BuildError> {
    Ok(Editor::new(*patches, *library, environment.clone(), config, progress)?.into_world())
}
