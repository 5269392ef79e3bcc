//! Unit objects, the parts of environments.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The unit objects of a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnitSet {
    /// Units, with unique names.
    pub units: Vec<UnitObject>,
}

/// A unit object, of fixed shape (Lee, Choi and Lee 2006, section 4).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnitObject {
    /// Its name.
    pub name: String,
    /// Geometry in the unit's own frame: metres, Y up.
    #[serde(default)]
    pub shapes: Vec<UnitShape>,
    /// Region of hips: a pose with hips in this box belongs to the unit. If absent, the bounding box of the shapes, up
    /// to 1.2 m above them.
    pub region: Option<UnitRegion>,
    /// Order of rotational symmetry about the vertical: a full turn over this number changes nothing.
    #[serde(default = "default_symmetry")]
    pub symmetry: u32,
    /// Joining edges of copies, for a unit with tilable motion.
    pub tile: Option<TileEdges>,
    /// True for floors: bodies walk on the unit and may touch it with their feet anywhere.
    #[serde(default)]
    pub floor: bool,
}

fn default_symmetry() -> u32 {
    1
}

/// An axis-aligned box in the frame of its unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnitRegion {
    /// Lowest corner: x, y, z (m).
    pub min: [f32; 3],
    /// Highest corner: x, y, z (m).
    pub max: [f32; 3],
}

/// A piece of geometry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum UnitShape {
    /// Box turned about the vertical, then tilted about its own x axis.
    Box {
        /// Centre: x, y, z (m).
        at: [f32; 3],
        /// Edge lengths: x, y, z (m).
        size: [f32; 3],
        /// Angle about the vertical (deg).
        #[serde(default)]
        heading_deg: f32,
        /// Angle about the box's own x axis: positive lowers its far (+z) end (deg).
        #[serde(default)]
        pitch_deg: f32,
    },
    /// A round bar between two points.
    Bar {
        /// One end: x, y, z (m).
        from: [f32; 3],
        /// The other end (m).
        to: [f32; 3],
        /// Radius (m).
        radius: f32,
    },
    /// Triangles of a glTF file (`.glb` or `.gltf`), relative to the unit file's folder.
    Mesh {
        /// The file.
        file: PathBuf,
    },
}

/// The two opposite edges of each direction in which a unit is tiled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TileEdges {
    /// Offset to the neighbour across each pair of edges: x, y, z; the opposite offsets are implied. Ground panels have
    /// two, `[[w, 0, 0], [0, 0, d]]`; stairs and slides one, which rises (m).
    pub steps: Vec<[f32; 3]>,
    /// Width of the edges, perpendicular to each step (m).
    pub widths: Vec<f32>,
    /// Midpoint between opposite edges, in the unit's frame: x, y, z (m).
    #[serde(default)]
    pub centre: [f32; 3],
}
