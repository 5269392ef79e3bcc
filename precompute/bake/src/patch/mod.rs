//! Motion patches: building blocks found from motion, with embedded motion (Lee, Choi and Lee 2006, sections 4 and 6).

mod block;
mod bounds;
mod config;
mod scenes;
mod tile;
mod track;

pub use block::spans;
pub use config::{PatchConfig, SourceEnvironment, TileConfig};
pub use scenes::{SourceScenes, embed, scenes};
pub use tile::{Freedom, PrunedTile, TileCell, TileGraph, prune};

use crate::environment::{Environment, UnitObject, UnitSet};
use crate::{cluster::PoseGroups, stages::stage_error};
use bounds::FrameExtents;
use serde::{Deserialize, Serialize};
use throng_core::patch::{CellRecord, EdgeRecord, LinkRecord, NONE, PairRecord, Placement};
use throng_motion::{ClipSet, Progress, Result};
use track::PatchTrack;

/// A motion patch, as the bundle stores it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RawPatch {
    /// Unique name: the units', joined by `+`, and a number if several arrangements of them occur.
    pub name: String,
    /// Units by name, placed in the patch's frame; the first one at the identity.
    pub units: Vec<(String, Placement)>,
    /// [`throng_core::patch::KIND_BLOCK`] or [`throng_core::patch::KIND_TILE`].
    pub kind: u32,
    /// Edges of a tile, in pairs: edge 2i and 2i + 1 are opposite.
    pub edges: Vec<EdgeRecord>,
    /// Cells; `first_link` and `num_links` are set.
    pub cells: Vec<CellRecord>,
    /// Links, sorted by the cell they begin in; tags index [`RawPatches::link_tags`].
    pub links: Vec<LinkRecord>,
    /// Interactions of two people across its edges, ascending; `patch` is not set.
    pub pairs: Vec<PairRecord>,
    /// Lowest and highest corner of the bounds of all bodies, in the patch's frame (m).
    pub bounds: [[f32; 3]; 2],
}

/// All patches of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RawPatches {
    /// The patches.
    pub patches: Vec<RawPatch>,
    /// Tags of links, by `tag - 1`.
    pub link_tags: Vec<String>,
    /// The unit objects, as TOML.
    pub units: String,
    /// Reports of the patches.
    pub report: Vec<PatchReport>,
}

/// Report of one patch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
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
    /// Freedom of a tile's characters to turn.
    #[serde(default)]
    pub freedom: Freedom,
    /// Links removed because an entry could not be left in every direction (Lee, Choi and Lee 2006, section 6, first
    /// condition).
    pub pruned_directions: usize,
    /// Links removed because they were outside the largest strongly connected component of the torus (second one).
    pub pruned_component: usize,
    /// Interactions of two people.
    #[serde(default)]
    pub pairs: Vec<PairReport>,
}

/// Report of an interaction of two people.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PairReport {
    /// Clips of the two.
    pub clips: [String; 2],
    /// Tag of the interaction; empty if untagged.
    pub tag: String,
    /// Reason why it was left out.
    pub refused: Option<String>,
    /// Number of the tile's edges across which it is possible.
    pub edges: usize,
}

/// Environment in which a clip was captured, with the units of each frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CaptureSetting {
    /// The environment.
    pub environment: Environment,
    /// For each frame the units it belongs to, as ascending indices into `environment.units` (num_frames).
    pub units_of: Vec<Vec<u32>>,
}

/// Inputs shared by all patches of a build.
struct PatchInputs<'a> {
    clips: &'a ClipSet,
    tracks: &'a [PatchTrack],
    /// Names of all tags.
    tags: &'a [String],
    settings: &'a [Option<CaptureSetting>],
    units: &'a UnitSet,
    config: &'a PatchConfig,
    /// Mean height of the hips above the support, by pose group (m).
    hips: &'a [f32],
    bounds: &'a FrameExtents,
}

/// Makes the patches of a clip set.
///
/// - `settings`: of each clip; `None` on level ground (clips.clips.len()).
/// - returns tiles in the order of the config, then building blocks in the order of the motion.
///
/// # Errors
/// [`throng_motion::error::BuildError::Key`] for a setting out of its limits or a tile with missing unit or clips;
/// [`throng_motion::error::BuildError::Stage`]
/// for a tile that cannot be made, with the unmet condition, and for too many tags.
///
/// # Source
/// Lee, Choi and Lee 2006, sections 4 and 6.
pub fn build(
    clips: &ClipSet,
    groups: &PoseGroups,
    settings: &[Option<CaptureSetting>],
    config: &PatchConfig,
    units: &UnitSet,
    progress: &dyn Progress,
) -> Result<RawPatches> {
    config.check()?;
    let (tracks, tags) = PatchTrack::new_all(clips, groups)?;
    let bounds = FrameExtents::new(clips);
    let mut out = RawPatches { link_tags: tags, ..RawPatches::default() };
    let hips = hips_heights(clips, groups);
    let (tracks, hips, tags) = (tracks.as_slice(), hips.as_slice(), out.link_tags.as_slice());
    let given = PatchInputs { clips, tracks, tags, settings, units, config, hips, bounds: &bounds };
    let mut tiles = Vec::new();
    progress.begin("patch", config.tiles.len() as u64, "tiles");
    for (i, tile) in config.tiles.iter().enumerate() {
        progress.check()?;
        tiles.push(tile::build(&given, tile).map_err(|e| e.within_key(&format!("patches.tiles[{i}]")))?);
        progress.advance(1);
    }
    progress.end();
    tiles.extend(block::build(&given, progress)?);
    (out.patches, out.report) = tiles.into_iter().unzip();
    out.number_duplicates();
    out.keep_used_tags();
    let why = |e| stage_error("patch", format!("the units cannot be written as TOML: {e}"), "Correct the unit file");
    out.units = toml::to_string(units).map_err(why)?;
    Ok(out)
}

impl RawPatches {
    /// Numbers patches of equal units from the second on.
    fn number_duplicates(&mut self) {
        let mut uses = std::collections::BTreeMap::<String, usize>::new();
        for (patch, report) in self.patches.iter_mut().zip(&mut self.report) {
            let n = uses.entry(patch.name.clone()).and_modify(|n| *n += 1).or_insert(1);
            if *n > 1 {
                patch.name = format!("{} {n}", patch.name);
            }
            report.name.clone_from(&patch.name);
        }
    }

    /// Removes unused tags.
    fn keep_used_tags(&mut self) {
        let mut number = vec![0u16; self.link_tags.len() + 1];
        for link in self.patches.iter().flat_map(|p| &p.links) {
            number[usize::from(link.tag & !LinkRecord::FOR_TWO)] = 1;
        }
        number[0] = 0;
        number.iter_mut().filter(|n| **n > 0).zip(1..).for_each(|(n, used)| *n = used);
        let mut tags = number[1..].iter();
        self.link_tags.retain(|_| tags.next().is_some_and(|&n| n > 0));
        for link in self.patches.iter_mut().flat_map(|p| &mut p.links) {
            let for_two = link.tag & LinkRecord::FOR_TWO;
            link.tag = number[usize::from(link.tag & !LinkRecord::FOR_TWO)] | for_two;
        }
    }
}

/// True for a panel of level ground that is tiled in two directions: motion over it may be placed anywhere.
fn is_ground(unit: &UnitObject) -> bool {
    unit.floor && unit.tile.as_ref().is_some_and(|t| t.steps.len() == 2 && t.steps.iter().all(|s| s[1] == 0.0))
}

/// A cell inside of a patch; a character may rest in it if a link for one leads from it to itself.
///
/// - `links`: sorted by the cell that they begin in.
fn inner_cell(number: u32, placement: Placement, group: u32, links: &[LinkRecord]) -> CellRecord {
    let first = links.partition_point(|l| l.from < number);
    let own = &links[first..links.partition_point(|l| l.from <= number)];
    let is_rest = own.iter().any(|l| l.to == number && !l.is_for_two());
    let flags = if is_rest { CellRecord::IS_REST } else { 0 };
    let (first_link, num_links) = (first as u32, own.len() as u32);
    CellRecord { placement, group, edge: NONE, twin: NONE, flags, first_link, num_links, reserved: [0; 2] }
}

/// Mean height of the hips above the support, by pose group (m).
fn hips_heights(clips: &ClipSet, groups: &PoseGroups) -> Vec<f32> {
    let mut sums = vec![(0.0f64, 0u32); groups.num_groups()];
    for (clip, start) in clips.clips.iter().zip(clips.frame_starts()) {
        for (f, root) in clip.root_positions.iter().enumerate() {
            if let Some(group) = groups.group_of(throng_motion::clip::FrameId(start + f as u32)) {
                let sum = &mut sums[group as usize];
                *sum = (sum.0 + f64::from(root.y - clip.support.get(f).copied().unwrap_or(0.0)), sum.1 + 1);
            }
        }
    }
    sums.iter().map(|&(sum, n)| (sum / f64::from(n.max(1))) as f32).collect()
}
