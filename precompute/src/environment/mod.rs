//! What characters move in: unit objects with a shape, and environments that place them (004 section 4).

mod unit;

pub use unit::{Region, Shape, TileEdges, Unit, UnitSet};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use throng_runtime::patch::Placement;

/// A unit object and where it stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacedUnit {
    /// Number of the unit in its [`UnitSet`].
    pub unit: usize,
    /// Its frame in the world.
    pub placement: Placement,
}

/// An environment: the list (u1, T1), ..., (um, Tm) of 004 section 4. The ground y = 0 is there beside it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Environment {
    /// Its name, for messages.
    pub name: String,
    /// What stands where.
    pub units: Vec<PlacedUnit>,
}

/// An environment as a file has it; world files use the same keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EnvironmentFile {
    /// Its name; the file's stem where absent.
    pub name: String,
    /// File of unit objects, relative to this file's folder.
    pub units: PathBuf,
    /// Groups of units that are placed together, by name.
    pub prefabs: std::collections::BTreeMap<String, Vec<Place>>,
    /// What stands where.
    pub place: Vec<Place>,
}

/// A unit or prefab, placed once or in a regular pattern.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Name of a unit or a prefab.
    pub unit: String,
    /// Where its origin stands: x, y, z. [Unit: m]
    pub at: [f32; 3],
    /// Angle about the vertical, counted from +Z to +X. [Unit: deg]
    #[serde(default)]
    pub heading_deg: f32,
    /// How many, along `step[0]`, `step[1]` and `step[2]` of the file that holds it.
    #[serde(default = "once")]
    pub repeat: [u32; 3],
    /// From one to the next, for each number of `repeat`: x, y, z. [Unit: m]
    #[serde(default)]
    pub step: [[f32; 3]; 3],
}

fn once() -> [u32; 3] {
    [1; 3]
}
