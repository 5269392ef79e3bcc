//! Worlds: patches stitched together over a target environment (004 section 5).

mod atlas;
mod check;
mod error;
mod file;
mod graph;
pub mod inhabitants;
#[cfg(test)]
mod made_up;
pub mod plan;
mod records;

pub use error::WorldError;
pub use file::{WORLD_MAGIC, WORLD_VERSION, WorldFile, tags};
pub use graph::{Node, Step, WorldGraph};
pub use records::{AdjacencyRecord, InstanceRecord, JointRecord, JointTableRecord, UnitRecord};

use serde::{Deserialize, Serialize};

/// Most bytes the meta data may ask for while they are decoded. [Unit: bytes]
const META_LIMIT: usize = 64 << 20;

/// What a world says of itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorldMeta {
    /// Its name.
    pub name: String,
    /// Program and version that wrote it.
    pub generator: String,
    /// Name of the bundle whose patches it consists of.
    pub bundle: String,
    /// What tells that bundle from others.
    pub fingerprint: u64,
    /// The environment it was stitched from, as TOML.
    pub environment: String,
    /// Links and cells taken out, by reason.
    pub disabled: Vec<(String, u64)>,
    /// Cells that are left.
    pub cells: u64,
    /// Transitions that are left: links and joints.
    pub transitions: u64,
    /// Length of all links that are left. [Unit: h]
    pub motion_hours: f64,
}

impl WorldMeta {
    /// The section's bytes.
    ///
    /// # Errors
    /// [`WorldError::Layout`] where it cannot be encoded.
    pub fn encode(&self) -> Result<Vec<u8>, WorldError> {
        bincode::serde::encode_to_vec(self, bincode::config::standard())
            .map_err(|e| WorldError::layout(format!("WMET cannot be written: {e}")))
    }

    /// Reads a section's bytes.
    ///
    /// # Errors
    /// [`WorldError::Layout`] where they are damaged, ask for too much memory, or are followed by others.
    pub fn decode(bytes: &[u8]) -> Result<Self, WorldError> {
        let config = bincode::config::standard().with_limit::<META_LIMIT>();
        match bincode::serde::decode_from_slice(bytes, config) {
            Ok((meta, used)) if used == bytes.len() => Ok(meta),
            Ok((_, used)) => Err(WorldError::layout(format!("WMET has {} bytes, expected {used}", bytes.len()))),
            Err(e) => Err(WorldError::layout(format!("WMET cannot be read: {e}"))),
        }
    }
}

/// View on a world, in a file or in memory.
#[derive(Clone, Copy, Debug)]
pub struct WorldView<'a> {
    /// What stands where; a unit's number is a resource that characters hold.
    pub units: &'a [UnitRecord],
    /// The patches.
    pub instances: &'a [InstanceRecord],
    /// Instance across each edge of each tile, [`crate::patch::NONE`] where there is none.
    pub neighbours: &'a [u32],
    /// Which cells are enabled.
    pub cell_words: &'a [u64],
    /// Which links are enabled.
    pub link_words: &'a [u64],
    /// Where instances overlap.
    pub adjacencies: &'a [AdjacencyRecord],
    /// Joints of pairs of patches.
    pub tables: &'a [JointTableRecord],
    /// Joints of all tables.
    pub joints: &'a [JointRecord],
    /// For each table, the numbers of its joints within it, sorted by (b, a, a_offset). [Size: joints.len()]
    pub joints_by_b: &'a [u32],
    /// Which joints may be taken, two bits each.
    pub joint_words: &'a [u64],
    /// Units that are held in each instance.
    pub resources: &'a [u32],
}

/// A world in memory, as the stitcher makes it and the editor changes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldData {
    /// See [`WorldView`] for these.
    pub units: Vec<UnitRecord>,
    /// The patches.
    pub instances: Vec<InstanceRecord>,
    /// Instance across each edge of each tile.
    pub neighbours: Vec<u32>,
    /// Which cells are enabled.
    pub cell_words: Vec<u64>,
    /// Which links are enabled.
    pub link_words: Vec<u64>,
    /// Where instances overlap.
    pub adjacencies: Vec<AdjacencyRecord>,
    /// Joints of pairs of patches.
    pub tables: Vec<JointTableRecord>,
    /// Joints of all tables.
    pub joints: Vec<JointRecord>,
    /// Order of joints by their side b.
    pub joints_by_b: Vec<u32>,
    /// Which joints may be taken.
    pub joint_words: Vec<u64>,
    /// Units that are held in each instance.
    pub resources: Vec<u32>,
    /// Name, provenance, figures.
    pub meta: WorldMeta,
}

impl WorldData {
    /// The view that everything reads worlds through.
    pub fn view(&self) -> WorldView<'_> {
        WorldView {
            units: &self.units,
            instances: &self.instances,
            neighbours: &self.neighbours,
            cell_words: &self.cell_words,
            link_words: &self.link_words,
            adjacencies: &self.adjacencies,
            tables: &self.tables,
            joints: &self.joints,
            joints_by_b: &self.joints_by_b,
            joint_words: &self.joint_words,
            resources: &self.resources,
        }
    }
}

/// True where bit `index` is set in the words that begin at `first`.
pub fn is_set(words: &[u64], first: u32, index: u32) -> bool {
    words[first as usize + index as usize / 64] >> (index % 64) & 1 == 1
}
