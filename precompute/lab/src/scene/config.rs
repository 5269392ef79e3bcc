//! Scene files: who is there, on which bundle, and what they are to do.

use super::file::{Fault, SceneFile, check_count, check_numbers, fault, one};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use throng_motion::error::BuildError;
use throng_runtime::characters::MAX_GOALS;

/// A scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// The scene's name; the file's stem where absent.
    #[serde(default)]
    pub name: String,
    /// Bundle, relative to the scene file's folder.
    pub bundle: PathBuf,
    /// Config that the bundle is built from where it is not there, relative to the scene file's folder.
    #[serde(default)]
    pub config: Option<PathBuf>,
    /// Who is there.
    pub kind: SceneKind,
    /// Number of characters; even for pairs.
    pub characters: usize,
    /// Seed of places and choices.
    #[serde(default = "one")]
    pub seed: u64,
    /// Between neighbours' places: pairs, or characters with their targets (m, > 0).
    #[serde(default = "spacing")]
    pub spacing_m: f64,
    /// Between a character and its opponent or target at the start (m, > 0).
    #[serde(default = "distance")]
    pub distance_m: f64,
    /// Choose at random among the best few actions; 0 always takes the best (>= 0).
    #[serde(default)]
    pub temperature: f64,
    /// What characters weigh against each other, every behaviour once (1 to 4).
    pub goals: Vec<SceneGoal>,
    /// For `targets` alone: where the targets are, and how they move.
    #[serde(default)]
    pub target: TargetConfig,
}

fn spacing() -> f64 {
    4.0
}

fn distance() -> f64 {
    1.5
}

/// Who is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SceneKind {
    /// Every character has a target of its own that gives way to blows and returns.
    Targets,
    /// Characters 2i and 2i + 1 spar: each one's head is the other's target.
    Pairs,
}

/// A behaviour and what it counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneGoal {
    /// Name of a behaviour of the bundle.
    pub behaviour: String,
    /// Weight of its values in the sum (-1e6 to 1e6).
    #[serde(default = "weight")]
    pub weight: f64,
}

fn weight() -> f64 {
    1.0
}

/// Targets that can be struck.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TargetConfig {
    /// Height above ground (m).
    pub height_m: f64,
    /// Radius (m, 0.01 to 1).
    pub radius_m: f64,
    /// How a hand drags it over the ground, as if by somebody: places relative to where it stands at the start, in
    /// order of time, then from the first again. It stands still where there are none.
    pub drag: Vec<DragPoint>,
}

impl Default for TargetConfig {
    fn default() -> Self {
        Self { height_m: 1.5, radius_m: 0.12, drag: Vec::new() }
    }
}

/// A place on a target's way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DragPoint {
    /// When it is there (s, > 0, ascending).
    pub time_s: f64,
    /// To the left (m).
    #[serde(default)]
    pub x_m: f64,
    /// Ahead (m).
    #[serde(default)]
    pub z_m: f64,
    /// Up (m).
    #[serde(default)]
    pub y_m: f64,
}

impl Scene {
    /// Reads a scene file; paths in it are taken from its folder.
    ///
    /// # Errors
    /// [`BuildError::Io`], or [`BuildError::Config`] with file, line and column, or file and key.
    pub fn load(path: &Path) -> Result<Self, BuildError> {
        Self::read(path)
    }

    /// True for a file that is a scene by its name.
    pub fn is_scene(path: &Path) -> bool {
        path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"))
    }

    /// Checks numbers; `path` is for messages alone.
    ///
    /// # Errors
    /// [`BuildError::Config`] with file and key.
    pub fn check(&self, path: &Path) -> Result<(), BuildError> {
        self.check_file(path)
    }

    /// Who is there, and where.
    fn check_cast(&self) -> Result<(), Fault> {
        check_count("characters", self.characters)?;
        if self.kind == SceneKind::Pairs && !self.characters.is_multiple_of(2) {
            return fault("characters", format!("expected an even number for pairs, found {}", self.characters));
        }
        check_numbers(&[
            ("spacing_m", self.spacing_m, 0.5, 1e3),
            ("distance_m", self.distance_m, 0.1, 1e3),
            ("temperature", self.temperature, 0.0, 1e3),
            ("target.height_m", self.target.height_m, -10.0, 10.0),
            ("target.radius_m", self.target.radius_m, 0.01, 1.0),
        ])
    }

    /// What they want.
    fn check_goals(&self) -> Result<(), Fault> {
        if self.goals.is_empty() || self.goals.len() > MAX_GOALS {
            return fault("goals", format!("expected 1 to {MAX_GOALS} behaviours, found {}", self.goals.len()));
        }
        for (i, goal) in self.goals.iter().enumerate() {
            if !(-1e6..=1e6).contains(&goal.weight) {
                return fault(&format!("goals[{i}].weight"), format!("expected -1e6 to 1e6, found {}", goal.weight));
            }
            if let Some(first) = self.goals[..i].iter().position(|g| g.behaviour == goal.behaviour) {
                let name = &goal.behaviour;
                return fault(
                    &format!("goals[{i}].behaviour"),
                    format!("expected every behaviour once, found \"{name}\" as in `goals[{first}]`"),
                );
            }
        }
        Ok(())
    }

    /// What they strike.
    fn check_target(&self) -> Result<(), Fault> {
        if self.kind == SceneKind::Pairs && self.target != TargetConfig::default() {
            return fault(
                "target",
                format!("expected none in a scene of pairs, who strike each other's heads, found {:?}", self.target),
            );
        }
        let mut before = 0.0;
        for p in &self.target.drag {
            let moderate = [p.x_m, p.y_m, p.z_m].iter().all(|v| v.abs() < 1e3);
            if !(p.time_s > before && p.time_s < 1e5 && moderate) {
                return fault(
                    "target.drag",
                    format!("expected times that ascend from above 0, and places, found {p:?}"),
                );
            }
            before = p.time_s;
        }
        Ok(())
    }
}

impl SceneFile for Scene {
    fn of(scene: &throng_runtime::simulation::Scene) -> Option<Self> {
        use throng_runtime::simulation::Motion;
        use throng_runtime::simulation::scene::PlaceConfig;
        let is_one =
            |g: &&throng_runtime::simulation::scene::GroupConfig| matches!(g.motion, Motion::Policy | Motion::Sparring);
        let g = scene.groups.iter().find(is_one)?;
        let (spacing_m, distance_m) = match g.place {
            Some(PlaceConfig::Grid { spacing_m, distance_m, .. }) => (spacing_m, distance_m),
            _ => (spacing(), distance()),
        };
        let goal = |b: &throng_runtime::simulation::scene::BehaviourConfig| SceneGoal {
            behaviour: b.name.clone(),
            weight: b.weight,
        };
        Some(Self {
            name: scene.name.clone(),
            bundle: g.bundle.clone().or(scene.bundle.clone())?,
            config: g.config.clone().or(scene.config.clone()),
            kind: if g.motion == Motion::Sparring { SceneKind::Pairs } else { SceneKind::Targets },
            characters: g.count,
            seed: scene.seed,
            spacing_m,
            distance_m,
            temperature: g.temperature,
            goals: g.behaviours.iter().map(goal).collect(),
            target: super::file::same(&g.target)?,
        })
    }

    fn find_fault(&self) -> Result<(), Fault> {
        self.check_cast()?;
        self.check_goals()?;
        self.check_target()
    }
}
