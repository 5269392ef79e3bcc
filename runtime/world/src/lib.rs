//! Worlds: patches stitched together over a target environment (Lee, Choi and Lee 2006, section 5).

mod check;
mod error;
mod file;
mod graph;
pub mod inhabitants;
#[cfg(test)]
#[path = "../tests/common/made_up.rs"]
mod made_up;
#[cfg(any(test, feature = "made-up"))]
#[path = "../tests/common/made_up_floor.rs"]
pub mod made_up_floor;
mod path_hierarchy;
pub mod plan;
mod pod;
mod queue;
mod records;
pub mod tags;

pub use error::WorldError;
pub use file::{RestPlace, WORLD_MAGIC, WORLD_VERSION, World};
pub use graph::{PathCosts, WorldGraph, WorldNode, WorldStep};
pub use records::{AdjacencyRecord, InstanceRecord, JointRecord, JointTableRecord, UnitRecord};

use serde::{Deserialize, Serialize};
use throng_core::format::Table;

/// Metadata of a world.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorldMeta {
    /// Name of the world.
    pub name: String,
    /// Program and version that wrote it.
    pub generator: String,
    /// Name of the bundle with the patches of the world.
    pub bundle: String,
    /// Content hash of that bundle.
    pub bundle_hash: u128,
    /// The file it was stitched from, as seen from the folder of this one; empty where there is none.
    pub source: String,
    /// Content hash of what it was stitched from: the environment, its meshes, the settings and the bundle.
    pub source_hash: u128,
    /// The environment it was stitched from, as TOML.
    pub environment: String,
    /// Links and cells taken out, by reason.
    pub disabled: Vec<(String, u64)>,
    /// Cells that are left.
    pub cells: u64,
    /// Transitions that are left: links and joints.
    pub transitions: u64,
    /// Length of all links that are left (h).
    pub motion_hours: f64,
}

/// The rows of a world, of a file or in memory. Clones share them.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldTables {
    /// Placed units; a unit's number is a resource that characters hold.
    pub units: Table<UnitRecord>,
    /// The patches.
    pub instances: Table<InstanceRecord>,
    /// Instance across each edge of each tile, [`throng_core::patch::NONE`] where there is none.
    pub neighbours: Table<u32>,
    /// Bits of enabled cells.
    pub cell_words: Table<u64>,
    /// Bits of enabled links.
    pub link_words: Table<u64>,
    /// Overlaps of instances.
    pub adjacencies: Table<AdjacencyRecord>,
    /// Joints of pairs of patches.
    pub tables: Table<JointTableRecord>,
    /// Joints of all tables.
    pub joints: Table<JointRecord>,
    /// For each table, the numbers of its joints within it, sorted by (b, a, a_offset) (joints.len()).
    pub joints_by_b: Table<u32>,
    /// Bits of joints that may be taken, two each.
    pub joint_words: Table<u64>,
    /// Units that are held in each instance.
    pub resources: Table<u32>,
}

/// A world in memory, as the stitcher makes it and the editor changes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldData {
    /// See [`WorldTables`] for these.
    pub units: Vec<UnitRecord>,
    /// The patches.
    pub instances: Vec<InstanceRecord>,
    /// Instance across each edge of each tile.
    pub neighbours: Vec<u32>,
    /// Bits of enabled cells.
    pub cell_words: Vec<u64>,
    /// Bits of enabled links.
    pub link_words: Vec<u64>,
    /// Overlaps of instances.
    pub adjacencies: Vec<AdjacencyRecord>,
    /// Joints of pairs of patches.
    pub tables: Vec<JointTableRecord>,
    /// Joints of all tables.
    pub joints: Vec<JointRecord>,
    /// Order of joints by their side b.
    pub joints_by_b: Vec<u32>,
    /// Bits of joints that may be taken.
    pub joint_words: Vec<u64>,
    /// Units that are held in each instance.
    pub resources: Vec<u32>,
    /// Name, provenance, figures.
    pub meta: WorldMeta,
}

impl WorldData {
    /// A copy of the rows, to read the world through.
    pub fn tables(&self) -> WorldTables {
        WorldTables {
            units: (&self.units).into(),
            instances: (&self.instances).into(),
            neighbours: (&self.neighbours).into(),
            cell_words: (&self.cell_words).into(),
            link_words: (&self.link_words).into(),
            adjacencies: (&self.adjacencies).into(),
            tables: (&self.tables).into(),
            joints: (&self.joints).into(),
            joints_by_b: (&self.joints_by_b).into(),
            joint_words: (&self.joint_words).into(),
            resources: (&self.resources).into(),
        }
    }
}

/// True where bit `index` is set in the words that begin at `first`.
pub fn is_set(words: &[u64], first: u32, index: u32) -> bool {
    words[first as usize + index as usize / 64] >> (index % 64) & 1 == 1
}
