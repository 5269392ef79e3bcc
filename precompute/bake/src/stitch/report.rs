//! Report of stitching a world.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Reason why a cell or a link of an instance is removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RemovalReason {
    /// Across this edge of a tile there is no other tile.
    NoNeighbour,
    /// A body would collide with a unit.
    Obstacle,
    /// No motion continues from there for ever.
    DeadEnd,
    /// Not reached from the rest of the world.
    OutsideComponent,
}

impl RemovalReason {
    /// All reasons, in order.
    pub const ALL: [Self; 4] = [Self::NoNeighbour, Self::Obstacle, Self::DeadEnd, Self::OutsideComponent];

    /// Name in worlds and reports.
    pub fn name(self) -> &'static str {
        ["no_neighbour", "obstacle", "dead_end", "outside_component"][self as usize]
    }
}

/// Report of stitching a world.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct StitchReport {
    /// Number of fitted patches.
    pub instances: usize,
    /// Number of instances of each patch, by name.
    pub patches: BTreeMap<String, usize>,
    /// Number of remaining cells.
    pub cells: u64,
    /// Number of remaining links and joints.
    pub transitions: u64,
    /// Duration of all remaining links (h).
    pub motion_hours: f64,
    /// Removed cells and links, by reason.
    pub disabled: BTreeMap<String, u64>,
    /// Kinds of pairs of patches that have joints.
    pub tables: usize,
    /// Joints of all of them.
    pub joints: usize,
    /// Time taken (s).
    pub seconds: f64,
    /// Peak memory of the program so far; 0 if the system does not report it (bytes).
    pub peak_bytes: u64,
    /// Length of the world's sections (bytes).
    pub world_bytes: u64,
}
