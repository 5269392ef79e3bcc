//! Scene files: who is there, on which bundle, and what they are to do.

use super::file::{Fault, SceneFile, check_count, check_numbers, fault, one};
use crate::error::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use throng_runtime::troupe::MAX_GOALS;

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
    /// Between neighbours' places: pairs, or characters with their targets. [Unit: m] [Limit: > 0]
    #[serde(default = "spacing")]
    pub spacing_m: f64,
    /// Between a character and its opponent or target at the start. [Unit: m] [Limit: > 0]
    #[serde(default = "distance")]
    pub distance_m: f64,
    /// Choose at random among the best few actions; 0 always takes the best. [Limit: >= 0]
    #[serde(default)]
    pub temperature: f64,
    /// What characters weigh against each other, every behaviour once. [Size: 1 to 4]
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
    /// Weight of its values in the sum. [Limit: -1e6 to 1e6]
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
    /// Height above ground. [Unit: m]
    pub height_m: f64,
    /// Radius. [Unit: m] [Limit: 0.01 to 1]
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
    /// When it is there. [Unit: s] [Limit: > 0, ascending]
    pub time_s: f64,
    /// To the left. [Unit: m]
    #[serde(default)]
    pub x_m: f64,
    /// Ahead. [Unit: m]
    #[serde(default)]
    pub z_m: f64,
    /// Up. [Unit: m]
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
    fn name_mut(&mut self) -> &mut String {
        &mut self.name
    }

    fn paths_mut(&mut self) -> Vec<&mut PathBuf> {
        std::iter::once(&mut self.bundle).chain(&mut self.config).collect()
    }

    fn find_fault(&self) -> Result<(), Fault> {
        self.check_cast()?;
        self.check_goals()?;
        self.check_target()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(text: &str) -> Result<Scene, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("duel.toml");
        std::fs::write(&path, text).unwrap();
        Scene::load(&path).map_err(|e| e.to_string().replace(&folder.path().display().to_string(), ""))
    }

    const HEAD: &str = "bundle = \"b.throng\"\nkind = \"pairs\"\n";
    const TARGETS: &str = "bundle = \"b.throng\"\nkind = \"targets\"\n";
    const GOAL: &str = "[[goals]]\nbehaviour = \"approach\"\n";

    #[test]
    fn paths_start_from_the_scene_s_folder_and_the_name_is_the_file_s() {
        let scene = load(&format!("{HEAD}characters = 2\n{GOAL}")).unwrap();
        assert_eq!(scene.name, "duel");
        assert!(scene.bundle.is_absolute() && scene.bundle.ends_with("b.throng"));
        assert_eq!(scene.goals[0].weight, 1.0);
    }

    #[test]
    fn bytes_that_are_no_text_are_named_by_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("duel.toml");
        std::fs::write(&path, b"name = \"a\"\n\xff\xfe").unwrap();
        let message = Scene::load(&path).unwrap_err().to_string();
        assert!(message.contains("duel.toml:2: expected a scene as TOML"), "{message}");
    }

    #[test]
    fn faults_name_the_place_and_what_was_expected() {
        for (text, parts) in [
            (format!("{HEAD}characters = 3\n{GOAL}"), ["`characters`", "even"]),
            (format!("{HEAD}characters = 2\ngoals = []\n"), ["`goals`", "1 to 4"]),
            (format!("{HEAD}charcters = 2\n{GOAL}"), ["duel.toml:3", "`characters`"]),
            (format!("{HEAD}characters = 2\ndistance_m = -1.0\n{GOAL}"), ["`distance_m`", "found -1"]),
            (
                format!("{TARGETS}characters = 2\n{GOAL}[target]\ndrag = [{{ time_s = 0.0 }}]\n"),
                ["`target.drag`", "ascend"],
            ),
            (format!("{HEAD}characters = 2\n{GOAL}[target]\nheight_m = 1.4\n"), ["`target`", "height_m: 1.4"]),
            (format!("{HEAD}characters = 2\n{GOAL}weight = nan\n"), ["`goals[0].weight`", "found NaN"]),
            (format!("{HEAD}characters = 2\n{GOAL}weight = 2e6\n"), ["`goals[0].weight`", "found 2000000"]),
            (format!("{HEAD}characters = 2\n{GOAL}{GOAL}"), ["`goals[1].behaviour`", "\"approach\""]),
            (format!("{HEAD}characters = \"two\"\n{GOAL}"), ["duel.toml:3:14", "data/scenes/"]),
        ] {
            let message = load(&text).unwrap_err();
            assert!(parts.iter().all(|p| message.contains(p)), "{message}");
        }
    }
}
