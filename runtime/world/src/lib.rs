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
use std::sync::Arc;
use throng_base::Hash128;
use throng_core::format::{BundleWriter, FileStorage, FormatError, SectionLayout, Table};

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

/// Defines the tables of a world, in the order of the file, and what is done to each of them.
macro_rules! world_tables {
    ($($(#[$doc:meta])* $name:ident: $record:ty = $tag:ident;)*) => {
        /// The rows of a world, of a file or in memory. Clones share them.
        #[derive(Clone, Debug, PartialEq)]
        pub struct WorldTables { $($(#[$doc])* pub $name: Table<$record>,)* }

        /// A world in memory, as the stitcher makes it and the editor changes it.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct WorldData {
            $($(#[$doc])* pub $name: Vec<$record>,)*
            /// Name, provenance, figures.
            pub meta: WorldMeta,
        }

        impl WorldTables {
            fn of_file(storage: &Arc<FileStorage>, layout: &SectionLayout) -> Result<Self, FormatError> {
                Ok(Self { $($name: Table::of_file(storage, &layout.section::<$record>(tags::$tag)?)),* })
            }

            fn hash_rows(&self, hash: &mut Hash128) {
                $(hash.add_bytes(bytemuck::cast_slice(&self.$name));)*
            }
        }

        impl WorldData {
            /// A copy of the rows, to read the world through.
            pub fn tables(&self) -> WorldTables {
                WorldTables { $($name: (&self.$name).into()),* }
            }

            fn add_sections(&self, file: &mut BundleWriter<'_>) {
                $(file.section(tags::$tag, &self.$name);)*
            }
        }
    };
}

world_tables! {
    /// Placed units; a unit's number is a resource that characters hold.
    units: UnitRecord = UNITS;
    /// The patches.
    instances: InstanceRecord = INSTANCES;
    /// Instance across each edge of each tile, [`throng_core::patch::NONE`] where there is none.
    neighbours: u32 = NEIGHBOURS;
    /// Bits of enabled cells.
    cell_words: u64 = CELLS;
    /// Bits of enabled links.
    link_words: u64 = LINKS;
    /// Overlaps of instances.
    adjacencies: AdjacencyRecord = ADJACENCIES;
    /// Joints of pairs of patches.
    tables: JointTableRecord = TABLES;
    /// Joints of all tables.
    joints: JointRecord = JOINTS;
    /// For each table, the numbers of its joints within it, sorted by (b, a, a_offset) (joints.len()).
    joints_by_b: u32 = JOINTS_BY_B;
    /// Bits of joints that may be taken, two each.
    joint_words: u64 = JOINT_BITS;
    /// Units that are held in each instance.
    resources: u32 = RESOURCES;
}

/// True where bit `index` is set in the words that begin at `first`.
pub fn is_set(words: &[u64], first: u32, index: u32) -> bool {
    words[first as usize + index as usize / 64] >> (index % 64) & 1 == 1
}
