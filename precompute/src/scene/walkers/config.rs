//! Scene files of walkers: how many there are, what their bodies come from, and how they move.

use crate::error::BuildError;
use crate::scene::file::{Fault, SceneFile, check_count, check_numbers, fault, has_key, one};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

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
    /// [Unit: m/s]
    #[serde(default)]
    pub style_by_speed: Vec<[f32; 2]>,
    /// What the bodies are like.
    #[serde(default)]
    pub bodies: BodiesConfig,
    /// Hills of this height; 0 is level ground. [Unit: m] [Limit: 0 to 10]
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
    /// Speeds that are drawn. [Unit: m/s] [Limit: 0 to 20]
    pub speeds: [f32; 2],
    /// Share of the draws that stand still. [Limit: 0 to 1]
    pub standing: f32,
    /// How long a speed and a turning rate are kept. [Unit: s] [Limit: 0.1 to 1000]
    pub seconds: [f32; 2],
    /// How fast the speed changes at most. [Unit: m/s^2] [Limit: > 0]
    pub acceleration: f32,
    /// Fastest turn. [Unit: rad/s] [Limit: >= 0]
    pub max_gyration: f32,
    /// How far curves press outwards at most, which bounds turns at speed. [Unit: m/s^2] [Limit: > 0]
    pub sideways: f32,
    /// Side of the square that they stay on. [Unit: m] [Limit: 4 to 10000]
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
    /// Sizes: smallest, largest. [Limit: 0.3 to 3]
    pub sizes: [f32; 2],
    /// Length of legs over that of the trunk, as a factor: least, most. [Limit: 0.5 to 2]
    pub legs: [f32; 2],
    /// Number of different bodies. [Limit: 1 to 10000]
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
    /// How fast the path is walked. [Unit: m/s] [Limit: 0.1 to 20]
    pub speed: f32,
}

impl WalkersScene {
    /// True for the text of a scene of walkers.
    pub fn is_one(path: &Path) -> bool {
        has_key(path, "spaces")
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

    /// Value of the first style axis at a speed, scaled to the database skeleton. [Unit: m/s]
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
    fn name_mut(&mut self) -> &mut String {
        &mut self.name
    }

    fn paths_mut(&mut self) -> Vec<&mut PathBuf> {
        std::iter::once(&mut self.bundle).chain(&mut self.config).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "bundle = \"a.throng\"\nspaces = [\"ahead\"]\ncharacters = 3\n";

    fn load(text: &str) -> Result<WalkersScene, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("parade.toml");
        std::fs::write(&path, text).unwrap();
        WalkersScene::load(&path).map_err(|e| e.to_string())
    }

    #[test]
    fn a_scene_needs_a_bundle_spaces_and_characters() {
        let scene = load(SCENE).unwrap();
        assert_eq!((scene.name.as_str(), scene.characters), ("parade", 3));
        assert!(load("spaces = [\"a\"]\ncharacters = 3\n").unwrap_err().contains("`bundle`"));
        assert!(load("bundle = \"a\"\nspaces = []\ncharacters = 3\n").unwrap_err().contains("`spaces`"));
    }

    #[test]
    fn faults_name_the_key_and_what_was_expected() {
        for (text, parts) in [
            ("[paths]\nspeeds = [3.0, 1.0]\n", ["`paths.speeds`", "3, 1"]),
            ("[bodies]\nkinds = 0\n", ["`bodies.kinds`", "found 0"]),
            ("hills_m = -1.0\n", ["`hills_m`", "found -1"]),
            ("style_by_speed = [[2.0, 0.0], [1.0, 1.0]]\n", ["`style_by_speed`", "ascend"]),
            ("colour = 1\n", ["parade.toml:4", "colour"]),
        ] {
            let message = load(&format!("{SCENE}{text}")).unwrap_err();
            assert!(parts.iter().all(|p| message.contains(p)), "{message}");
        }
    }

    #[test]
    fn styles_change_linearly_between_the_speeds_that_are_given() {
        let scene = load(&format!("{SCENE}style_by_speed = [[2.0, 0.0], [3.0, 1.0], [5.0, 2.0]]\n")).unwrap();
        let style = |speed| scene.style(speed);
        assert_eq!([style(0.0), style(2.0), style(2.5), style(4.0), style(9.0)], [0.0, 0.0, 0.5, 1.5, 2.0]);
    }
}
