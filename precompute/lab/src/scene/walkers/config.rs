//! Scene files of walkers: how many there are, what their bodies come from, and how they move.

use crate::scene::file::{Fault, SceneFile, check_count, check_numbers, fault, one, same};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use throng_motion::error::BuildError;

/// A scene of walkers on random curved paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WalkersScene {
    /// The scene's name; the file's stem where absent.
    #[serde(default)]
    pub name: String,
    /// Bundle, relative to the scene file's folder.
    pub bundle: PathBuf,
    /// Config that the bundle is built from where it is not there.
    #[serde(default)]
    pub config: Option<PathBuf>,
    /// Blend spaces of the bundle; characters take them in turn.
    pub spaces: Vec<String>,
    /// Number of characters.
    pub characters: usize,
    /// Seed of bodies and paths.
    #[serde(default = "one")]
    pub seed: u64,
    /// How the characters move.
    #[serde(default)]
    pub paths: PathsConfig,
    /// Value of the first style axis by speed, as (speed, value) that ascend by speed; between them it changes
    /// linearly. Speeds are those of the database skeleton: a smaller body runs sooner. 0 everywhere where empty.
    /// (m/s)
    #[serde(default)]
    pub style_by_speed: Vec<[f32; 2]>,
    /// What the bodies are like.
    #[serde(default)]
    pub bodies: BodiesConfig,
    /// Hills of this height; 0 is level ground (m, 0 to 10).
    #[serde(default)]
    pub hills_m: f32,
    /// Styles that the picture shows on one path.
    #[serde(default)]
    pub shown: Vec<ShownStyle>,
}

/// How walkers move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PathsConfig {
    /// Speeds that are drawn (m/s, 0 to 20).
    pub speeds: [f32; 2],
    /// Share of the draws that stand still (0 to 1).
    pub standing: f32,
    /// How long a speed and a turning rate are kept (s, 0.1 to 1000).
    pub seconds: [f32; 2],
    /// How fast the speed changes at most (m/s^2, > 0).
    pub acceleration: f32,
    /// Fastest turn (rad/s, >= 0).
    pub max_gyration: f32,
    /// How far curves press outwards at most, which bounds turns at speed (m/s^2, > 0).
    pub sideways: f32,
    /// Side of the square that they stay on (m, 4 to 10000).
    pub area_m: f32,
}

impl Default for PathsConfig {
    fn default() -> Self {
        Self {
            speeds: [0.0, 5.0],
            standing: 0.15,
            seconds: [1.5, 5.0],
            acceleration: 2.5,
            max_gyration: 1.6,
            sideways: 3.0,
            area_m: 60.0,
        }
    }
}

/// What bodies are like beside the database skeleton.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BodiesConfig {
    /// Sizes: smallest, largest (0.3 to 3).
    pub sizes: [f32; 2],
    /// Length of legs over that of the trunk, as a factor: least, most (0.5 to 2).
    pub legs: [f32; 2],
    /// Number of different bodies (1 to 10000).
    pub kinds: usize,
}

impl Default for BodiesConfig {
    fn default() -> Self {
        Self { sizes: [0.7, 1.15], legs: [0.92, 1.08], kinds: 24 }
    }
}

/// A style that the picture shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShownStyle {
    /// What it is called.
    pub name: String,
    /// Its blend space.
    pub space: String,
    /// Value of the first style axis.
    #[serde(default)]
    pub style: f32,
    /// How fast the path is walked (m/s, 0.1 to 20).
    pub speed: f32,
}

impl WalkersScene {
    /// True for the text of a scene of walkers.
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

    /// Checks numbers; `path` is for messages alone.
    ///
    /// # Errors
    /// [`BuildError::Config`] with file and key.
    pub fn check(&self, path: &Path) -> Result<(), BuildError> {
        self.check_file(path)
    }

    /// Value of the first style axis at a speed, scaled to the database skeleton (m/s).
    pub fn style(&self, speed: f32) -> f32 {
        let knots = &self.style_by_speed;
        let above = knots.partition_point(|k| k[0] <= speed);
        match (above.checked_sub(1).map(|i| knots[i]), knots.get(above)) {
            (Some(low), Some(high)) => low[1] + (speed - low[0]) / (high[0] - low[0]) * (high[1] - low[1]),
            (Some(end), None) => end[1],
            (None, Some(end)) => end[1],
            (None, None) => 0.0,
        }
    }
}

impl SceneFile for WalkersScene {
    fn of(scene: &throng_runtime::simulation::Scene) -> Option<Self> {
        let g = scene.groups.iter().find(|g| g.paths.is_some())?;
        let p = g.paths.clone()?;
        Some(Self {
            name: scene.name.clone(),
            bundle: g.bundle.clone().or(scene.bundle.clone())?,
            config: g.config.clone().or(scene.config.clone()),
            spaces: g.spaces.clone(),
            characters: g.count,
            seed: scene.seed,
            paths: PathsConfig {
                speeds: p.speeds,
                standing: p.standing,
                seconds: p.seconds,
                acceleration: p.acceleration,
                max_gyration: p.max_gyration,
                sideways: p.sideways,
                area_m: p.area_m,
            },
            style_by_speed: g.style_by_speed.clone(),
            bodies: same(&g.bodies())?,
            hills_m: scene.environment.hills_m,
            shown: scene.picture.shown.iter().filter_map(same).collect(),
        })
    }

    fn find_fault(&self) -> Result<(), Fault> {
        if self.spaces.is_empty() {
            return fault("spaces", "expected at least one blend space, found none");
        }
        check_count("characters", self.characters)?;
        let (p, b) = (&self.paths, &self.bodies);
        let ranges = [
            ("paths.speeds", p.speeds, 0.0, 20.0),
            ("paths.seconds", p.seconds, 0.1, 1000.0),
            ("bodies.sizes", b.sizes, 0.3, 3.0),
            ("bodies.legs", b.legs, 0.5, 2.0),
        ];
        for (key, [from, to], low, high) in ranges {
            if !(low <= from && from <= to && to <= high) {
                return fault(
                    key,
                    format!("expected two numbers that ascend from {low} to {high}, found {from}, {to}"),
                );
            }
        }
        check_numbers(&[
            ("paths.standing", p.standing, 0.0, 1.0),
            ("paths.acceleration", p.acceleration, 0.01, 1000.0),
            ("paths.max_gyration", p.max_gyration, 0.0, 20.0),
            ("paths.sideways", p.sideways, 0.01, 1000.0),
            ("paths.area_m", p.area_m, 4.0, 10_000.0),
            ("bodies.kinds", b.kinds as f32, 1.0, 10_000.0),
            ("hills_m", self.hills_m, 0.0, 10.0),
        ])?;
        if !self.style_by_speed.windows(2).all(|w| w[0][0] < w[1][0])
            || !self.style_by_speed.iter().flatten().all(|v| v.abs() < 1e3)
        {
            return fault("style_by_speed", "expected (speed, value) that ascend by speed");
        }
        for (i, s) in self.shown.iter().enumerate() {
            if !(0.1..=20.0).contains(&s.speed) {
                return fault(&format!("shown[{i}].speed"), format!("expected 0.1 to 20, found {}", s.speed));
            }
            if !(-1e3..=1e3).contains(&s.style) {
                return fault(&format!("shown[{i}].style"), format!("expected -1000 to 1000, found {}", s.style));
            }
        }
        Ok(())
    }
}
