//! Unit objects: what environments are put together from.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The unit objects of a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnitSet {
    /// The units; names are unique.
    pub units: Vec<Unit>,
}

/// A unit object: its shape cannot change (Lee, Choi and Lee 2006, section 4).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Unit {
    /// Its name.
    pub name: String,
    /// Its geometry, in its own frame: metres, Y up.
    #[serde(default)]
    pub shapes: Vec<Shape>,
    /// A pose whose hips lie in this box belongs to the unit; the bounding box of the shapes, up to 1.2 m above them,
    /// where absent.
    #[serde(default)]
    pub region: Option<Region>,
    /// Turning it by a full turn over this many changes nothing.
    #[serde(default = "one")]
    pub symmetry: u32,
    /// How copies of it join, where its motion is to be tilable.
    #[serde(default)]
    pub tile: Option<TileEdges>,
    /// True for what is walked on rather than around: bodies may touch it with their feet anywhere.
    #[serde(default)]
    pub floor: bool,
}

fn one() -> u32 {
    1
}

/// A box along the axes of its frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Lowest corner: x, y, z (m).
    pub min: [f32; 3],
    /// Highest corner: x, y, z (m).
    pub max: [f32; 3],
}

/// A piece of geometry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// A box, turned about the vertical and then tilted about its own x axis.
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
        /// (m)
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
    /// From the unit to its neighbour across each pair of edges: x, y, z; the opposite steps are implied. Ground
    /// panels have two, `[[w, 0, 0], [0, 0, d]]`; stairs and slides one, which rises (m).
    pub steps: Vec<[f32; 3]>,
    /// Width of the edges across the direction of each step (m).
    pub widths: Vec<f32>,
    /// Half-way between opposite edges, in the unit's frame: x, y, z (m).
    #[serde(default)]
    pub centre: [f32; 3],
}
