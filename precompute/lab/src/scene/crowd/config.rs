//! Scene files of crowds: who is there, what stands in the way, and what happens.

use super::group::GroupConfig;
use super::happening::HappeningConfig;
use super::obstacle::ObstacleConfig;
use crate::scene::file::{Fault, SceneFile, check_count, check_numbers, fault, one, same};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use throng_motion::error::BuildError;
use throng_runtime::crowd::Field;

/// Farthest that a coordinate of a scene may be from the origin (m).
const FARTHEST_M: f32 = 1e5;

/// A scene of a crowd that avoids each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrowdScene {
    /// The scene's name; the file's stem where absent.
    #[serde(default)]
    pub name: String,
    /// Where the crowd moves. Points have two numbers on the ground (x, z) and three in the air (x, y, z) (m).
    #[serde(default)]
    pub space: CrowdSpace,
    /// What finds out when somebody has to act.
    #[serde(default)]
    pub engine: Engine,
    /// How long it runs unless told otherwise (s, 0.1 to 100000).
    #[serde(default = "seconds")]
    pub seconds: f64,
    /// Seed of places and variety.
    #[serde(default = "one")]
    pub seed: u64,
    /// Another number of agents stretches the whole layout, so that their density stays what it is.
    #[serde(default)]
    pub grows: bool,
    /// Who is there (>= 1).
    pub groups: Vec<GroupConfig>,
    /// What stands or moves in the way.
    #[serde(default)]
    pub obstacles: Vec<ObstacleConfig>,
    /// Leads agents around obstacles that stand; otherwise they go straight and only give way.
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
    /// Measures how far agents sort themselves by direction.
    #[serde(default)]
    pub lanes: Option<LanesConfig>,
    /// Bodies for the agents; discs where absent.
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
    /// Bounds registered in cells: resetting and colliding events (Kim, Kim and Shin 2003a, the later text).
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

/// A line that agents cross: through a door, for instance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GateConfig {
    /// One end (m).
    pub from: [f32; 2],
    /// The other end (m).
    pub to: [f32; 2],
}

/// How lanes are measured: an agent's lane is what lies before and behind it in a band along the corridor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LanesConfig {
    /// Along the corridor.
    pub along: [f32; 2],
    /// Width of the band (m, 0.1 to 100).
    #[serde(default = "lane_width")]
    pub width_m: f32,
    /// How far it reaches before and behind (m, 0.1 to 1000).
    #[serde(default = "lane_reach")]
    pub reach_m: f32,
}

fn lane_width() -> f32 {
    1.0
}

fn lane_reach() -> f32 {
    5.0
}

/// Bodies that follow the agents.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrowdBodiesConfig {
    /// Bundle with blend spaces, relative to the scene file's folder.
    pub bundle: PathBuf,
    /// Config that the bundle is built from where it is not there.
    #[serde(default)]
    pub config: Option<PathBuf>,
    /// Blend spaces of the bundle; agents take them in turn (>= 1).
    pub spaces: Vec<String>,
}

impl CrowdScene {
    /// True for the text of a scene of a crowd.
    pub fn is_one(path: &Path) -> bool {
        Self::is_one_of(path)
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

    /// Number of agents of all groups.
    pub fn num_agents(&self) -> usize {
        self.groups.iter().map(|g| g.count).sum()
    }

    /// The scene with another number of agents: every group keeps its share, and where the scene grows, lengths are
    /// stretched so that as many stand on a square (or cubic) metre as before.
    pub fn resized(&self, agents: usize) -> Self {
        let (mut scene, before) = (self.clone(), self.num_agents());
        let mut given = 0;
        let mut counted = 0;
        for group in &mut scene.groups {
            counted += group.count;
            let upto = (agents as u128 * counted as u128 / before.max(1) as u128) as usize;
            group.count = upto - given;
            given = upto;
        }
        if self.grows {
            let stretch = (agents as f64 / before.max(1) as f64).powf(1.0 / self.space.dimensions() as f64);
            scene.stretch(stretch as f32);
        }
        scene
    }

    /// Multiplies all lengths of the layout; those of agents and what does not grow stay.
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
        check_count("groups", self.num_agents())?;
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
    fn of(scene: &throng_runtime::simulation::Scene) -> Option<Self> {
        let of_agents = || scene.groups.iter().filter(|g| g.is_of_agents());
        let group = |g: &throng_runtime::simulation::scene::GroupConfig| {
            Some(GroupConfig {
                name: g.name.clone(),
                count: g.count,
                place: same(g.place.as_ref()?)?,
                goal: same(g.goal.as_ref()?)?,
                via: g.via.clone(),
                arrival_m: g.arrival_m,
                at_end: match g.at_end {
                    throng_runtime::simulation::scene::AtEndConfig::Stay => super::AtEndConfig::Stay,
                    throng_runtime::simulation::scene::AtEndConfig::Leave => super::AtEndConfig::Leave,
                    throng_runtime::simulation::scene::AtEndConfig::Again => super::AtEndConfig::Again,
                },
                radius_m: g.radius_m,
                speed_mps: g.speed_mps,
                acceleration_mps2: g.acceleration_mps2,
            })
        };
        let bodies = of_agents().find(|g| !g.spaces.is_empty());
        of_agents().next()?;
        Some(Self {
            name: scene.name.clone(),
            space: if scene.environment.space.dimensions() == 3 { CrowdSpace::Air } else { CrowdSpace::Ground },
            engine: Engine::named(throng_runtime::simulation::scene::engine::name(scene.agents.engine))?,
            seconds: scene.seconds,
            seed: scene.seed,
            grows: scene.measure.grows,
            groups: of_agents().filter_map(group).collect(),
            obstacles: scene.environment.obstacles.iter().filter_map(same).collect(),
            routes: scene.agents.routes,
            field: scene.agents.field,
            happenings: scene.happenings.iter().filter_map(same).collect(),
            gate: None,
            lanes: None,
            bodies: bodies.and_then(|g| {
                let (bundle, config) =
                    (g.bundle.clone().or(scene.bundle.clone())?, g.config.clone().or(scene.config.clone()));
                Some(CrowdBodiesConfig { bundle, config, spaces: g.spaces.clone() })
            }),
        })
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
