//! What came of stitching a world.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Why a cell or a link of an instance is taken out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// It leads across an edge of a tile, or comes from there, where no other tile is.
    NoNeighbour,
    /// A body would be in a unit.
    Obstacle,
    /// From there no way leads on for ever.
    DeadEnd,
    /// It is not reached from the rest of the world.
    OutsideComponent,
}

impl Reason {
    /// All reasons, in order.
    pub const ALL: [Self; 4] = [Self::NoNeighbour, Self::Obstacle, Self::DeadEnd, Self::OutsideComponent];

    /// The name, as worlds and reports write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoNeighbour => "no_neighbour",
            Self::Obstacle => "obstacle",
            Self::DeadEnd => "dead_end",
            Self::OutsideComponent => "outside_component",
        }
    }
}

/// What came of stitching a world.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct StitchReport {
    /// Patches that were fitted.
    pub instances: usize,
    /// How often each patch was, by name.
    pub patches: BTreeMap<String, usize>,
    /// Cells that are left.
    pub cells: u64,
    /// Links and joints that are left.
    pub transitions: u64,
    /// Length of all links that are left (h).
    pub motion_hours: f64,
    /// Cells and links taken out, by reason.
    pub disabled: BTreeMap<String, u64>,
    /// Kinds of pairs of patches that have joints.
    pub tables: usize,
    /// Joints of all of them.
    pub joints: usize,
    /// Time it took (s).
    pub seconds: f64,
    /// Most memory that the program has held so far, where the system tells; 0 elsewhere (bytes).
    pub peak_bytes: u64,
    /// Length of the world's sections (bytes).
    pub world_bytes: u64,
}
