//! Settings of motion patches.

use crate::environment::GeometryTouchConfig;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, de::value::MapDeserializer};
use std::path::PathBuf;
use throng_motion::error::{BuildError, Result, check_ranges, ensure};

/// Most entries, exits and rest spots of a tile.
const MOST_SPOTS: usize = 2_000_000;

/// Settings of the motion patches built from clips and the environments they were captured in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PatchConfig {
    /// File of unit objects, relative to the config file's folder; if absent, no patches are built.
    pub units: Option<PathBuf>,
    /// Environments with the clips captured in them.
    pub environments: Vec<SourceEnvironment>,
    /// Limits of contacts of a body with its surroundings.
    pub touch: GeometryTouchConfig,
    /// Numbers of units that building blocks consist of (1 to 4 each).
    pub block_units: Vec<usize>,
    /// Edge length of cells (m, 0.02 to 0.5).
    pub cell_m: f64,
    /// Heading range of cells (deg, 2 to 45).
    pub cell_deg: f64,
    /// Links play at least this many frames (>= 1).
    pub min_link_frames: usize,
    /// Links from one frame play less than this many; longer sub-sequences are chains of links (>=
    /// 2 * min_link_frames, so that no sub-sequence is lost).
    pub max_link_frames: usize,
    /// Tilable patches.
    pub tiles: Vec<TileConfig>,
}

impl Default for PatchConfig {
    fn default() -> Self {
        Self {
            units: None,
            environments: Vec::new(),
            touch: GeometryTouchConfig::default(),
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
    /// Clips, by name or pattern with one `*`. Mirrored copies are excluded: their surroundings are mirrored too.
    pub clips: Vec<String>,
}

/// A tilable patch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TileConfig {
    /// Unit object, which defines the edges.
    pub unit: String,
    /// Clips whose motion is embedded, by name or pattern with one `*`; if empty, all those in no environment.
    #[serde(default)]
    pub clips: Vec<String>,
    /// Pairs of clips captured together, as two name patterns with one `*` each, which stands for the same text.
    /// Interactions are ranges with the same tag in both at the same time, placed across an edge of the tile (level
    /// ground).
    #[serde(default)]
    pub pairs: Vec<[String; 2]>,
    /// Number of entries and exits along an edge, evenly spaced (>= 1).
    #[serde(default = "slots")]
    pub slots: usize,
    /// Number of headings of entries on each side of straight ahead (>= 0).
    #[serde(default = "headings")]
    pub headings: usize,
    /// Angle between headings of entries (deg).
    #[serde(default = "heading_step")]
    pub heading_step_deg: f64,
    /// Number of pose groups at edges, most frequent first (>= 1); up to four times as many if these make no tile.
    #[serde(default = "edge_groups")]
    pub edge_groups: usize,
    /// Number of headings at rest within the tile, evenly spaced (>= 0).
    #[serde(default = "rest_headings")]
    pub rest_headings: usize,
    /// Number of rest spots along each side of a square about the tile's centre (>= 1).
    #[serde(default = "rest_spots")]
    pub rest_spots: usize,
    /// Number of pose groups at rest, most frequent first (>= 1); grows with those at edges.
    #[serde(default = "rest_groups")]
    pub rest_groups: usize,
    /// Largest shift of the end of a motion, a metre travelled (m/m).
    #[serde(default = "edit_position")]
    pub edit_m_per_m: f64,
    /// Largest turn of the end of a motion, a metre travelled (deg/m).
    #[serde(default = "edit_heading")]
    pub edit_deg_per_m: f64,
    /// Number of motions kept between an entry and an exit, least edited first (>= 1).
    #[serde(default = "variety")]
    pub variety: usize,
    /// Least distance of roots from the edges, except at entries and exits (m).
    #[serde(default = "margin")]
    pub margin_m: f64,
}

throng_base::key_defaults! {
    slots: usize = 5;
    headings: usize = 2;
    heading_step: f64 = 15.0;
    edge_groups: usize = 6;
    rest_headings: usize = 8;
    rest_spots: usize = 3;
    rest_groups: usize = 2;
    edit_position: f64 = 0.1;
    edit_heading: f64 = 8.0;
    variety: usize = 1;
    margin: f64 = 0.3;
}

impl PatchConfig {
    /// # Errors
    /// [`BuildError::Key`] naming the first key out of its limits.
    pub(crate) fn check(&self) -> Result<()> {
        let (least, most) = (self.min_link_frames as f64, f64::from(u16::MAX));
        let ranges = [
            ("cell_m", self.cell_m, 0.02, 0.5),
            ("cell_deg", self.cell_deg, 2.0, 45.0),
            ("min_link_frames", least, 1.0, most),
            ("max_link_frames", self.max_link_frames as f64, 2.0 * least, most),
        ];
        let blocks = self.block_units.iter().map(|&k| ("block_units", k as f64, 1.0, 4.0));
        let tiles = || self.tiles.iter().enumerate();
        check_ranges(ranges.into_iter().chain(blocks))
            .and_then(|()| self.touch.check().map_err(|e| e.within_key("touch")))
            .and_then(|()| tiles().try_for_each(|(i, t)| t.check().map_err(|e| e.within_key(&format!("tiles[{i}]")))))
            .map_err(|e| e.within_key("patches"))
    }
}

impl TileConfig {
    /// A tile of a unit, with default settings.
    pub fn for_unit(unit: &str) -> Self {
        let keys = MapDeserializer::<_, serde::de::value::Error>::new([("unit", unit)].into_iter());
        Self::deserialize(keys).expect("every other key has a default")
    }

    fn check(&self) -> Result<()> {
        let limits = [
            ("slots", self.slots as f64, 1.0, 100.0),
            ("headings", self.headings as f64, 0.0, 20.0),
            ("heading_step_deg", self.heading_step_deg, 0.1, 90.0),
            ("edge_groups", self.edge_groups as f64, 1.0, 1000.0),
            ("rest_headings", self.rest_headings as f64, 0.0, 360.0),
            ("rest_spots", self.rest_spots as f64, 1.0, 100.0),
            ("rest_groups", self.rest_groups as f64, 1.0, 1000.0),
            ("edit_m_per_m", self.edit_m_per_m, 0.0, 1.0),
            ("edit_deg_per_m", self.edit_deg_per_m, 0.0, 90.0),
            ("variety", self.variety as f64, 1.0, 1000.0),
            ("margin_m", self.margin_m, 0.0, 10.0),
        ];
        for (i, pattern) in self.pairs.iter().enumerate().flat_map(|(i, p)| p.iter().map(move |p| (i, p))) {
            let why = || format!("expected patterns with one `*` each, found `{pattern}`. Correct the config.");
            ensure(pattern.matches('*').count() == 1, || BuildError::key(format!("pairs[{i}]"), why()))?;
        }
        check_ranges(limits)?;
        let entries = 8 * self.slots * (2 * self.headings + 1) * self.edge_groups;
        let rest = self.rest_spots.pow(2) * self.rest_headings * (self.rest_groups + self.edge_groups);
        if entries + rest > MOST_SPOTS {
            let found = entries + rest;
            let why = format!(
                "expected {MOST_SPOTS} entries, exits and places of rest at most, found up to {found}: ask for fewer \
                 `slots`, `headings`, `edge_groups`, `rest_spots`, `rest_headings` or `rest_groups`"
            );
            return Err(BuildError::key("", why));
        }
        Ok(())
    }
}

/// True if `name` matches `pattern`, in which one `*` may stand for any text.
pub(super) fn matches(pattern: &str, name: &str) -> bool {
    if pattern.contains('*') { star_text(pattern, name).is_some() } else { pattern == name }
}

/// Text that the `*` of a pattern stands for in a matching name.
pub(super) fn star_text<'n>(pattern: &str, name: &'n str) -> Option<&'n str> {
    let (first, last) = pattern.split_once('*')?;
    name.strip_prefix(first)?.strip_suffix(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_within_their_limits_and_bad_numbers_are_named() {
        assert!(PatchConfig { tiles: vec![TileConfig::for_unit("panel")], ..Default::default() }.check().is_ok());
        for (config, key) in [
            (PatchConfig { cell_m: 0.0, ..Default::default() }, "cell_m"),
            (PatchConfig { max_link_frames: 30, ..Default::default() }, "max_link_frames"),
            (PatchConfig { block_units: vec![1, 5], ..Default::default() }, "block_units"),
            (
                PatchConfig {
                    tiles: vec![TileConfig { slots: 0, ..TileConfig::for_unit("panel") }],
                    ..Default::default()
                },
                "tiles[0].slots",
            ),
        ] {
            assert!(config.check().unwrap_err().to_string().contains(&format!("patches.{key}:")));
        }
    }

    #[test]
    fn tiles_of_too_many_spots_are_refused() {
        let check = |tile| PatchConfig { tiles: vec![tile], ..Default::default() }.check();
        let panel = || TileConfig::for_unit("panel");
        assert!(check(TileConfig { slots: 20, headings: 4, edge_groups: 1000, ..panel() }).is_ok());
        for tile in [
            TileConfig { slots: 100, headings: 20, edge_groups: 1000, ..panel() },
            TileConfig { rest_spots: 100, rest_headings: 360, rest_groups: 1000, ..panel() },
        ] {
            let e = check(tile).unwrap_err().to_string();
            assert!(e.starts_with("patches.tiles[0]: expected 2000000 entries"), "{e}");
        }
    }

    #[test]
    fn settings_left_out_of_a_file_are_those_of_a_plain_tile() {
        assert_eq!(toml::from_str::<TileConfig>("unit = 'panel'").unwrap(), TileConfig::for_unit("panel"));
    }

    #[test]
    fn one_star_stands_for_any_text() {
        assert!(matches("walk_*", "walk_07~mirror") && matches("*~mirror", "walk_07~mirror") && matches("a", "a"));
        assert!(!matches("walk_*", "run_01") && !matches("aa*aa", "aaa") && !matches("a", "ab"));
    }
}
