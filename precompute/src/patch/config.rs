//! How motion patches are built.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// How motion patches are built from clips and the environments they were captured in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PatchConfig {
    /// File of unit objects, relative to the config file's folder; no patches are built where absent.
    pub units: Option<PathBuf>,
    /// Which clips were captured where.
    pub environments: Vec<SourceEnvironment>,
    /// Numbers of units that building blocks consist of. [Limit: 1 to 4 each]
    pub block_units: Vec<usize>,
    /// Edge length of cells. [Unit: m] [Limit: 0.02 to 0.5]
    pub cell_m: f64,
    /// Heading range of cells. [Unit: deg] [Limit: 2 to 45]
    pub cell_deg: f64,
    /// Links play at least this many frames. [Limit: >= 1]
    pub min_link_frames: usize,
    /// Links from one frame play less than this many; longer sub-sequences are chains of links. [Limit: >=
    /// 2 * min_link_frames, so that no sub-sequence is lost]
    pub max_link_frames: usize,
    /// Which patches are tilable.
    pub tiles: Vec<TileConfig>,
}

impl Default for PatchConfig {
    fn default() -> Self {
        Self {
            units: None,
            environments: Vec::new(),
            block_units: vec![1, 2],
            cell_m: 0.1,
            cell_deg: 10.0,
            min_link_frames: 20,
            max_link_frames: 40,
            tiles: Vec::new(),
        }
    }
}

/// Clips and the environment they were captured in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SourceEnvironment {
    /// Environment file, relative to the config file's folder.
    pub file: PathBuf,
    /// Clips, by name or pattern with one `*`. Mirrored copies do not count: their surroundings are mirrored too.
    pub clips: Vec<String>,
}

/// A tilable patch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TileConfig {
    /// Unit object, which says where its edges are.
    pub unit: String,
    /// Clips whose motion is embedded, by name or pattern with one `*`; all those in no environment where empty.
    #[serde(default)]
    pub clips: Vec<String>,
    /// Entries and exits along an edge, evenly. [Limit: >= 1]
    #[serde(default = "slots")]
    pub slots: usize,
    /// Headings of entries on each side of straight ahead. [Limit: >= 0]
    #[serde(default = "headings")]
    pub headings: usize,
    /// Angle between headings of entries. [Unit: deg]
    #[serde(default = "heading_step")]
    pub heading_step_deg: f64,
    /// Pose groups at edges: the commonest ones. [Limit: >= 1]
    #[serde(default = "edge_groups")]
    pub edge_groups: usize,
    /// Headings at rest within the tile, evenly around. [Limit: >= 0]
    #[serde(default = "rest_headings")]
    pub rest_headings: usize,
    /// How far the end of a motion may be moved, a metre travelled. [Unit: m/m]
    #[serde(default = "edit_position")]
    pub edit_m_per_m: f64,
    /// How far the end of a motion may be turned, a metre travelled. [Unit: deg/m]
    #[serde(default = "edit_heading")]
    pub edit_deg_per_m: f64,
    /// Motions kept between an entry and an exit: the least edited ones. [Limit: >= 1]
    #[serde(default = "variety")]
    pub variety: usize,
    /// Roots stay this far from the edges but where they enter and leave. [Unit: m]
    #[serde(default = "margin")]
    pub margin_m: f64,
}

fn slots() -> usize {
    5
}

fn headings() -> usize {
    2
}

fn heading_step() -> f64 {
    15.0
}

fn edge_groups() -> usize {
    6
}

fn rest_headings() -> usize {
    8
}

fn edit_position() -> f64 {
    0.1
}

fn edit_heading() -> f64 {
    8.0
}

fn variety() -> usize {
    2
}

fn margin() -> f64 {
    0.3
}
