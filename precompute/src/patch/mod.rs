//! Motion patches: building blocks found from motion, and the motion embedded in them (004 sections 4 and 6).

mod config;

pub use config::{PatchConfig, SourceEnvironment, TileConfig};

use serde::{Deserialize, Serialize};
use throng_runtime::patch::{CellRecord, EdgeRecord, LinkRecord, Placement};

/// A motion patch, as the bundle stores it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Patch {
    /// Unique name: the units', joined by `+`, and a number where several arrangements of them occur.
    pub name: String,
    /// Units by name and where they stand in the patch's frame; the first one at the identity.
    pub units: Vec<(String, Placement)>,
    /// [`throng_runtime::patch::KIND_BLOCK`] or [`throng_runtime::patch::KIND_TILE`].
    pub kind: u32,
    /// Edges of a tile, in pairs: edge 2i and 2i + 1 are opposite.
    pub edges: Vec<EdgeRecord>,
    /// Cells; `first_link` and `num_links` are set.
    pub cells: Vec<CellRecord>,
    /// Links, sorted by the cell they begin in; tags count in [`Patches::link_tags`].
    pub links: Vec<LinkRecord>,
    /// Lowest and highest corner of all that bodies reach, in the patch's frame. [Unit: m]
    pub bounds: [[f32; 3]; 2],
}

/// All patches of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Patches {
    /// The patches.
    pub patches: Vec<Patch>,
    /// What links show, by `tag - 1`.
    pub link_tags: Vec<String>,
    /// The unit objects, as TOML.
    pub units: String,
    /// What was found, for reports.
    pub report: Vec<PatchReport>,
}

/// What was made of one patch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PatchReport {
    /// Its name.
    pub name: String,
    /// Runs of frames that were embedded.
    pub segments: usize,
    /// Frames that were embedded.
    pub frames: usize,
    /// Cells that are left.
    pub cells: usize,
    /// Links that are left.
    pub links: usize,
    /// Links taken out because an entry could not be left in every direction (004 section 6, first condition).
    pub pruned_directions: usize,
    /// Links taken out because they were outside the largest strongly connected component of the torus (second one).
    pub pruned_component: usize,
}
