//! Scene files of crowds: who is there, what stands in the way, and what happens.

use super::group::GroupConfig;
use super::happening::HappeningConfig;
use super::obstacle::ObstacleConfig;
use crate::error::BuildError;
use crate::scene::file::{Fault, SceneFile, check_count, check_numbers, fault, has_key, one};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use throng_runtime::crowd::Field;

/// Farthest that a coordinate of a scene may be from the origin. [Unit: m]
const FARTHEST_M: f32 = 1e5;

/// A scene of a crowd that avoids each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrowdScene {
    /// The scene's name; the file's stem where absent.
    #[serde(default)]
    pub name: String,
    /// Where the crowd moves. Points have two numbers on the ground (x, z) and three in the air (x, y, z). [Unit: m]
    #[serde(default)]
    pub space: CrowdSpace,
    /// What finds out when somebody has to act.
    #[serde(default)]
    pub engine: Engine,
    /// How long it runs unless told otherwise. [Unit: s] [Limit: 0.1 to 100000]
    #[serde(default = "seconds")]
    pub seconds: f64,
    /// Seed of places and variety.
    #[serde(default = "one")]
    pub seed: u64,
    /// Another number of members stretches the whole layout, so that their density stays what it is.
    #[serde(default)]
    pub grows: bool,
    /// Who is there. [Size: >= 1]
    pub groups: Vec<GroupConfig>,
    /// What stands or moves in the way.
    #[serde(default)]
    pub obstacles: Vec<ObstacleConfig>,
    /// Leads members around obstacles that stand; otherwise they go straight and only give way.
    #[serde(default = "yes")]
    pub routes: bool,
    /// Parameters of the force field, for everybody; those left out are as they come.
    #[serde(default)]
    #[schemars(with = "serde_json::Value")]
    pub field: Field,
    /// What happens from outside.
    #[serde(default)]
    pub happenings: Vec<HappeningConfig>,
    /// A line whose flow is counted.
    #[serde(default)]
    pub gate: Option<GateConfig>,
    /// Measures how far members sort themselves by direction.
    #[serde(default)]
    pub lanes: Option<LanesConfig>,
    /// Bodies for the members; discs where absent.
    #[serde(default)]
    pub bodies: Option<CrowdBodiesConfig>,
}

fn seconds() -> f64 {
    15.0
}

fn yes() -> bool {
    true
}

/// Where a crowd moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CrowdSpace {
    /// Discs, on the ground.
    #[default]
    Ground,
    /// Balls, in the air.
    Air,
}

impl CrowdSpace {
    /// Numbers of a point.
    pub fn dimensions(self) -> usize {
        match self {
            Self::Ground => 2,
            Self::Air => 3,
        }
    }
}

/// What finds out when somebody has to act.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Engine {
    /// Bounds registered in cells: resetting and colliding events (Kim, Kim and Shin 2003, the later text).
    #[default]
    Events,
    /// Bounds listed in every cell that they occupy: six kinds of events and groups in contact (the earlier text).
    Occupancy,
    /// Everybody acts at every step: the baseline.
    Fixed,
}

impl Engine {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Events, Self::Occupancy, Self::Fixed];

    /// As scene files and reports call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Events => "events",
            Self::Occupancy => "occupancy",
            Self::Fixed => "fixed",
        }
    }

    /// The engine of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|e| e.name() == name)
    }
}

/// A line that members cross: through a door, for instance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GateConfig {
    /// One end. [Unit: m]
    pub from: [f32; 2],
    /// The other end. [Unit: m]
    pub to: [f32; 2],
}

/// How lanes are measured: a member's lane is what lies before and behind it in a band along the corridor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LanesConfig {
    /// Along the corridor.
    pub along: [f32; 2],
    /// Width of the band. [Unit: m] [Limit: 0.1 to 100]
    #[serde(default = "lane_width")]
    pub width_m: f32,
    /// How far it reaches before and behind. [Unit: m] [Limit: 0.1 to 1000]
    #[serde(default = "lane_reach")]
    pub reach_m: f32,
}

fn lane_width() -> f32 {
    1.0
}

fn lane_reach() -> f32 {
    5.0
}

/// Bodies that follow the members.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrowdBodiesConfig {
    /// Bundle with blend spaces, relative to the scene file's folder.
    pub bundle: PathBuf,
    /// Config that the bundle is built from where it is not there.
    #[serde(default)]
    pub config: Option<PathBuf>,
    /// Blend spaces of the bundle; members take them in turn. [Size: >= 1]
    pub spaces: Vec<String>,
}

impl CrowdScene {
    /// True for the text of a scene of a crowd.
    pub fn is_one(path: &Path) -> bool {
        has_key(path, "groups")
    }

    /// Reads a scene file; paths in it are taken from its folder.
    ///
    /// # Errors
    /// [`BuildError::Io`], or [`BuildError::Config`] with file, line and column, or file and key.
    pub fn load(path: &Path) -> Result<Self, BuildError> {
        Self::read(path)
    }

    /// Reads the text of a scene; `path` is for its name and messages.
    ///
    /// # Errors
    /// [`BuildError::Config`] as [`CrowdScene::load`].
    pub fn from_text(text: &str, path: &Path) -> Result<Self, BuildError> {
        Self::parse(text, path)
    }

    /// Checks numbers; `path` is for messages alone.
    ///
    /// # Errors
    /// [`BuildError::Config`] with file and key.
    pub fn check(&self, path: &Path) -> Result<(), BuildError> {
        self.check_file(path)
    }

    /// Number of members of all groups.
    pub fn num_members(&self) -> usize {
        self.groups.iter().map(|g| g.count).sum()
    }

    /// The scene with another number of members: every group keeps its share, and where the scene grows, lengths are
    /// stretched so that as many stand on a square (or cubic) metre as before.
    pub fn resized(&self, members: usize) -> Self {
        let (mut scene, before) = (self.clone(), self.num_members());
        let mut given = 0;
        let mut counted = 0;
        for group in &mut scene.groups {
            counted += group.count;
            let upto = (members as u128 * counted as u128 / before.max(1) as u128) as usize;
            group.count = upto - given;
            given = upto;
        }
        if self.grows {
            let stretch = (members as f64 / before.max(1) as f64).powf(1.0 / self.space.dimensions() as f64);
            scene.stretch(stretch as f32);
        }
        scene
    }

    /// Multiplies all lengths of the layout; those of members and what does not grow stay.
    fn stretch(&mut self, by: f32) {
        self.groups.iter_mut().for_each(|g| g.stretch(by));
        self.obstacles.iter_mut().filter(|o| o.grows).for_each(|o| o.stretch(by));
        self.happenings.iter_mut().for_each(|h| h.stretch(by));
    }

    fn check_parts(&self) -> Result<(), Fault> {
        let dimensions = self.space.dimensions();
        if self.groups.is_empty() {
            return fault("groups", "expected at least one group, found none");
        }
        for (i, group) in self.groups.iter().enumerate() {
            group.find_fault(&format!("groups[{i}]"), dimensions)?;
        }
        check_count("groups", self.num_members())?;
        for (i, obstacle) in self.obstacles.iter().enumerate() {
            obstacle.find_fault(&format!("obstacles[{i}]"), dimensions)?;
        }
        for (i, happening) in self.happenings.iter().enumerate() {
            happening.find_fault(&format!("happenings[{i}]"), dimensions)?;
        }
        Ok(())
    }

    fn check_measures(&self) -> Result<(), Fault> {
        let on_ground = self.space == CrowdSpace::Ground;
        if let Some(gate) = &self.gate {
            check_point("gate.from", &gate.from, 2)?;
            check_point("gate.to", &gate.to, 2)?;
            if gate.from == gate.to {
                return fault("gate", "expected two ends that differ");
            }
        }
        if let Some(lanes) = &self.lanes {
            check_numbers(&[
                ("lanes.width_m", lanes.width_m, 0.1, 100.0),
                ("lanes.reach_m", lanes.reach_m, 0.1, 1000.0),
            ])?;
            if !lanes.along.iter().all(|v| v.is_finite()) || lanes.along == [0.0; 2] {
                return fault("lanes.along", format!("expected a direction, found {:?}", lanes.along));
            }
            if self.groups.len() < 2 {
                return fault("lanes", "expected two groups that meet, found one");
            }
        }
        for (key, is_there) in
            [("gate", self.gate.is_some()), ("lanes", self.lanes.is_some()), ("bodies", self.bodies.is_some())]
        {
            if is_there && !on_ground {
                return fault(key, "expected none in the air: leave it out, or set `space = \"ground\"`");
            }
        }
        match &self.bodies {
            Some(b) if b.spaces.is_empty() => fault("bodies.spaces", "expected at least one blend space, found none"),
            _ => Ok(()),
        }
    }
}

impl SceneFile for CrowdScene {
    fn name_mut(&mut self) -> &mut String {
        &mut self.name
    }

    fn paths_mut(&mut self) -> Vec<&mut PathBuf> {
        self.bodies.iter_mut().flat_map(|b| std::iter::once(&mut b.bundle).chain(&mut b.config)).collect()
    }

    fn find_fault(&self) -> Result<(), Fault> {
        check_numbers(&[("seconds", self.seconds, 0.1, 1e5)])?;
        self.check_parts()?;
        self.check_measures()
    }
}

/// A point with as many numbers as the scene's space has.
pub(super) fn check_point(key: &str, point: &[f32], dimensions: usize) -> Result<(), Fault> {
    if point.len() != dimensions {
        let what = if dimensions == 2 { "2 numbers (x, z) on the ground" } else { "3 numbers (x, y, z) in the air" };
        return fault(key, format!("expected {what}, found {}", point.len()));
    }
    match point.iter().find(|v| v.is_nan() || v.abs() > FARTHEST_M) {
        Some(v) => fault(key, format!("expected -{FARTHEST_M} to {FARTHEST_M}, found {v}")),
        None => Ok(()),
    }
}

/// Two opposite corners, the lowest first.
pub(super) fn check_corners(key: &str, from: &[f32], to: &[f32], dimensions: usize) -> Result<(), Fault> {
    check_point(&format!("{key}.from"), from, dimensions)?;
    check_point(&format!("{key}.to"), to, dimensions)?;
    if from.iter().zip(to).any(|(a, b)| a >= b) {
        return fault(key, format!("expected the lowest corner, then the highest, found {from:?} and {to:?}"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUP: &str = "[[groups]]\ncount = 10\nplace = { block = { from = [0.0, 0.0], to = [5.0, 5.0] } }\n\
                         goal = { shift = { by = [9.0, 0.0] } }\n";

    fn load(text: &str) -> Result<CrowdScene, String> {
        CrowdScene::from_text(text, Path::new("square.toml")).map_err(|e| e.to_string())
    }

    #[test]
    fn a_scene_needs_groups_and_has_defaults() {
        let scene = load(GROUP).unwrap();
        assert_eq!((scene.name.as_str(), scene.num_members(), scene.engine), ("square", 10, Engine::Events));
        assert!(load("seconds = 3.0\n").unwrap_err().contains("`groups`"));
    }

    #[test]
    fn faults_name_the_key_and_what_was_expected() {
        for (text, parts) in [
            ("seconds = 0.0\n".to_owned() + GROUP, ["`seconds`", "found 0"]),
            ("space = \"air\"\n".to_owned() + GROUP, ["`groups[0].place.block.from`", "3 numbers"]),
            ("engine = \"magic\"\n".to_owned() + GROUP, ["square.toml:1:10", "occupancy"]),
            (GROUP.replace("count = 10", "count = 0"), ["`groups[0].count`", "found 0"]),
            (GROUP.replace("to = [5.0", "to = [-5.0"), ["`groups[0].place.block`", "lowest corner"]),
            (GROUP.to_owned() + "radius_m = [0.5, 0.2]\n", ["`groups[0].radius_m`", "0.5, 0.2"]),
            (GROUP.to_owned() + "[field]\nrelaxation_s = 0.5\nmagic = 1.0\n", ["unknown field `magic`", "square.toml"]),
            (
                GROUP.to_owned() + "[[obstacles]]\nwall = { points = [[1.0, 2.0]] }\n",
                ["`obstacles[0].wall.points`", "at least 2"],
            ),
            (GROUP.to_owned() + "[lanes]\nalong = [1.0, 0.0]\n", ["`lanes`", "two groups"]),
            (
                GROUP.to_owned() + "[[happenings]]\ntime_s = -1.0\ngoal = { stay = {} }\n",
                ["`happenings[0].time_s`", "found -1"],
            ),
            ("colour = 1\n".to_owned() + GROUP, ["square.toml:1", "colour"]),
        ] {
            let message = load(&text).unwrap_err();
            assert!(parts.iter().all(|p| message.contains(p)), "{parts:?}: {message}");
        }
    }

    #[test]
    fn more_members_keep_their_shares_and_their_density() {
        let mut scene = load(&format!("grows = true\n{GROUP}{}", GROUP.replace("10", "30"))).unwrap();
        let big = scene.resized(4000);
        assert_eq!([big.groups[0].count, big.groups[1].count], [1000, 3000]);
        let crate::scene::crowd::PlaceConfig::Block { to, .. } = &big.groups[0].place else { panic!("a block") };
        assert!((to[0] - 50.0).abs() < 1e-3, "10 times as long: {to:?}");
        scene.grows = false;
        assert_eq!(scene.resized(4000).groups[1].place, scene.groups[1].place);
        assert_eq!(scene.resized(7).num_members(), 7);
    }
}
