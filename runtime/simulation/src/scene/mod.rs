//! Scene files: characters, their motion, environment and events. One format for all kinds of motion.

mod check;
mod environment;
mod expect;
mod goal;
mod group;
mod happening;
mod level;
mod measure;
mod obstacle;
mod place;
mod story;

pub(crate) use check::check_point;
pub use environment::{AgentsConfig, EnvironmentConfig, SpaceConfig, engine};
pub use expect::{ExpectConfig, ExpectedQuantity, ExpectedStatistic};
pub use goal::{AtEndConfig, GoalConfig};
pub use group::{
    ANY_PARTNER, BodiesConfig, DragPoint, GroupConfig, GroupMotion, InhabitantGoalConfig, PathsConfig,
    StruckTargetConfig, WeightedBehaviour, WeightedGoal,
};
pub use happening::{HappeningConfig, NearConfig};
pub use level::SceneLevelConfig;
pub use measure::{GateConfig, LanesConfig, PictureConfig, PictureStyle, SceneMeasureConfig};
pub(crate) use obstacle::to_point;
pub use obstacle::{BoxConfig, DiscConfig, MoverConfig, ObstacleConfig, PathPoint, PolygonConfig, WallConfig};
pub use place::PlaceConfig;
pub use story::{
    ActionConfig, CarryStyle, DoorConfig, EdgeConfig, EndConfig, EventConfig, LevelConfig, LineChoice, QueueConfig,
    RelationConfig, RuleConfig, ServiceConfig, SiteConfig, SlotConfig, SourceConfig, StateConfig, StateGraphConfig,
    StoryBehaviour, ThingConfig, TimeDistribution, ValueConfig, WordConfig,
};

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use throng_base::{Error, Result, error::ensure, maths, text::TomlSource};

/// Contents of a scene file. Lengths are in metres, times in seconds. A new field changes the hash of the setup: `content` prints
/// all but names and paths.
///
/// ```no_run
/// let mut scene = throng_simulation::Scene::load("street.toml")?;
/// scene.seed = 7;
/// scene.check()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Name of the scene; the file's stem where absent.
    #[serde(default)]
    pub name: String,
    /// Seed of places, paths and choices.
    #[serde(default = "one")]
    pub seed: u64,
    /// Duration of a run, unless another one is given (s, 0.001 to 100000).
    #[serde(default = "seconds")]
    pub seconds: f64,
    /// Bundle of the groups that name none of their own, relative to this file's folder.
    pub bundle: Option<PathBuf>,
    /// Config that the bundle is built from where it is missing.
    pub config: Option<PathBuf>,
    /// Environment: space, obstacles, doors, ground and world.
    #[serde(default)]
    pub environment: EnvironmentConfig,
    /// Level, whose borders are walls and whose places are places of the scene.
    pub level: Option<SceneLevelConfig>,
    /// Settings of agents: how they avoid each other, and what they sense.
    #[serde(default)]
    pub agents: AgentsConfig,
    /// Groups of characters and agents (>= 1).
    pub groups: Vec<GroupConfig>,
    /// Happenings, which are events with one rule each: agents that know of one go to its goal.
    #[serde(default)]
    pub happenings: Vec<HappeningConfig>,
    /// Places to which agents come: stores, pictures, guideposts, queues.
    #[serde(default)]
    pub places: Vec<SiteConfig>,
    /// Services: tills, and lines before them.
    #[serde(default)]
    pub services: Vec<ServiceConfig>,
    /// Things that agents take, carry and put down.
    #[serde(default)]
    pub things: Vec<ThingConfig>,
    /// Values that agents feel, by name.
    #[serde(default)]
    pub values: BTreeMap<String, ValueConfig>,
    /// Relations of agents to each other and to places; of several that apply, the last counts.
    #[serde(default)]
    pub relations: Vec<RelationConfig>,
    /// Events that happen in the scene.
    #[serde(default)]
    pub events: Vec<EventConfig>,
    /// Behaviours, which are lists of actions, by name.
    #[serde(default)]
    pub behaviours: BTreeMap<String, Vec<ActionConfig>>,
    /// Rules by which agents react to events; of several that fit, the first is followed.
    #[serde(default)]
    pub rules: Vec<RuleConfig>,
    /// State-transition graphs, by name.
    #[serde(default)]
    pub graphs: BTreeMap<String, StateGraphConfig>,
    /// Conditions that a run has to meet, for `throng check SCENE --run`.
    #[serde(default)]
    pub expect: Vec<ExpectConfig>,
    /// Conditions of which any ends the scene early.
    #[serde(default)]
    pub end: EndConfig,
    /// Measurements beside the standard ones.
    #[serde(default)]
    pub measure: SceneMeasureConfig,
    /// Contents of the picture.
    #[serde(default)]
    pub picture: PictureConfig,
    /// Source text that it was read from.
    #[serde(skip)]
    pub(crate) source: TomlSource,
}

const HELP: &str = "`throng schema --of scene` lists all keys, and data/scenes/ has examples.";

throng_base::key_defaults! {
    one: u64 = 1;
    seconds: f64 = 15.0;
}

impl Scene {
    /// Reads a scene file. Paths in it start from its folder.
    ///
    /// # Errors
    /// [`Error::Io`], or [`Error::Text`] with line and column of what is wrong.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::from_source(TomlSource::read(path, "a scene")?, false)
    }

    /// Reads a scene that a stranger sent: all files that it names lie in its folder or below, and nothing is built for it.
    ///
    /// # Errors
    /// As [`Scene::load`], and [`Error::Format`] for a file that lies elsewhere, links followed.
    pub fn load_untrusted(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::from_source(TomlSource::read(path, "a scene")?, true)
    }

    /// Leaves out what its bundles and worlds are made from, so that missing ones are an error and not built.
    pub fn forget_configs(&mut self) {
        (self.config, self.environment.world_config) = (None, None);
        self.groups.iter_mut().for_each(|g| (g.config, g.world_config) = (None, None));
    }

    /// Reads the text of a scene file; `path` gives its name, its folder and what messages call it.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        Self::from_source(TomlSource::new(text, path), false)
    }

    /// Reads the text of a scene that a stranger sent, as [`Scene::load_untrusted`].
    ///
    /// # Errors
    /// As [`Scene::load_untrusted`].
    pub fn parse_untrusted(text: &str, path: &Path) -> Result<Self> {
        Self::from_source(TomlSource::new(text, path), true)
    }

    /// Parses a scene that was serialized by the program: every key is there, and paths are relative to the folder of that run.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse_written(text: &str) -> Result<Self> {
        let source = TomlSource::new(text, Path::new("recorded scene"));
        let mut scene: Self = source.parse(HELP)?;
        scene.source = source;
        scene.check()?;
        Ok(scene)
    }

    fn from_source(source: TomlSource, is_untrusted: bool) -> Result<Self> {
        check::other_files(&source)?;
        let mut scene: Self = source.parse(HELP)?;
        let path = source.path();
        if scene.name.is_empty() {
            scene.name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        scene.paths_mut().for_each(|p| *p = folder.join(&*p));
        if is_untrusted {
            scene.forget_configs();
            scene.paths_mut().try_for_each(|p| refuse_outside(p, folder))?;
        }
        scene.source = source;
        check::refuse_foreign_keys(&scene)?;
        scene.add_level()?;
        scene.check()?;
        Ok(scene)
    }

    /// Checks all numbers.
    ///
    /// # Errors
    /// [`Error::Text`] with the key, what was expected, and its place in the file where it stands there.
    pub fn check(&self) -> Result<()> {
        check::check_scene(self).map_err(|(key, why)| self.fault(&key, why))
    }

    /// Error about a key, such as `groups[0].place`.
    pub fn fault(&self, key: &str, why: impl std::fmt::Display) -> Error {
        self.source.error_at_key(key, format!("key `{key}`: {why}"))
    }

    /// Error about a key, at a byte of its value's text.
    pub(crate) fn fault_within(&self, key: &str, byte: Option<usize>, why: impl std::fmt::Display) -> Error {
        let why = format!("key `{key}`: {why}");
        byte.map_or_else(
            || self.source.error_at_key(key, why.clone()),
            |byte| self.source.error_within_value(key, byte, why.clone()),
        )
    }

    /// True where agents have rules, events, graphs or sources beside goals.
    pub fn has_story(&self) -> bool {
        !self.happenings.is_empty()
            || !self.events.is_empty()
            || !self.rules.is_empty()
            || self.groups.iter().any(|g| g.graph.is_some() || g.source.is_some())
    }

    /// Number of all characters and agents.
    pub fn num_characters(&self) -> usize {
        self.groups.iter().map(|g| g.count).sum()
    }

    /// The bundle of a group, and the config that it is built from (group < number of groups).
    pub fn bundle_of(&self, group: usize) -> (Option<&Path>, Option<&Path>) {
        let g = &self.groups[group];
        let own = (g.bundle.as_deref(), g.config.as_deref());
        if own.0.is_some() { own } else { (self.bundle.as_deref(), self.config.as_deref()) }
    }

    /// The stitched world of a group, and the world file that it is stitched from (group < number of groups).
    pub fn world_of(&self, group: usize) -> (Option<&Path>, Option<&Path>) {
        let (g, e) = (&self.groups[group], &self.environment);
        let own = (g.world.as_deref(), g.world_config.as_deref());
        if own.0.is_some() { own } else { (e.world.as_deref(), e.world_config.as_deref()) }
    }

    /// Takes another bundle, in place of the scene's and of those of all groups; nothing builds it where it is missing.
    pub fn set_bundle(&mut self, bundle: &Path) {
        (self.bundle, self.config) = (Some(bundle.to_path_buf()), None);
        self.groups.iter_mut().for_each(|group| (group.bundle, group.config) = (None, None));
    }

    /// Copy of the scene with another number of characters: every group keeps its share, and where the scene grows, lengths
    /// are scaled so that the density stays the same.
    pub fn resized(&self, characters: usize) -> Self {
        let (mut scene, before) = (self.clone(), self.num_characters());
        let mut given = 0;
        let mut counted = 0;
        for group in &mut scene.groups {
            counted += group.count;
            let upto = (characters as u128 * counted as u128 / before.max(1) as u128) as usize;
            group.count = upto - given;
            given = upto;
        }
        if self.measure.grows {
            let stretch = characters as f64 / before.max(1) as f64;
            scene.stretch(maths::pow(stretch, 1.0 / self.environment.space.dimensions() as f64) as f32);
        }
        scene
    }

    /// Multiplies all lengths of the layout; sizes of agents and obstacles that do not grow stay.
    fn stretch(&mut self, by: f32) {
        self.groups.iter_mut().for_each(|g| g.stretch(by));
        self.environment.obstacles.iter_mut().filter(|o| o.grows).for_each(|o| o.stretch(by));
        self.happenings.iter_mut().for_each(|h| h.stretch(by));
        self.places.iter_mut().for_each(|p| p.stretch(by));
        self.things.iter_mut().for_each(|t| t.stretch(by));
        self.environment.doors.iter_mut().for_each(|d| d.stretch(by));
        self.stretch_story(by);
    }

    /// Multiplies the points of actions.
    fn stretch_story(&mut self, by: f32) {
        self.behaviours.values_mut().for_each(|b| story::stretch_actions(b, by));
        self.rules.iter_mut().for_each(|r| r.does.stretch(by));
        let states = self.graphs.values_mut().flat_map(|g| g.states.values_mut());
        states.filter_map(|s| s.does.as_mut()).for_each(|d| d.stretch(by));
    }

    /// Contents of the scene, independent of the paths of files, for hashing.
    pub(crate) fn content(&self) -> String {
        let mut scene = Self { source: TomlSource::default(), name: String::new(), expect: Vec::new(), ..self.clone() };
        scene.paths_mut().for_each(|p| *p = PathBuf::new());
        format!("{scene:?}")
    }

    fn paths_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let e = &mut self.environment;
        let level = self.level.as_mut().map(|l| &mut l.file);
        let own = [&mut self.bundle, &mut self.config, &mut e.world, &mut e.world_config];
        let groups = self.groups.iter_mut();
        let of_groups = groups.flat_map(|g| [&mut g.bundle, &mut g.config, &mut g.world, &mut g.world_config]);
        own.into_iter().chain(of_groups).flatten().chain(level)
    }
}

/// Refuses a file outside a folder, links followed. One that is not there may not be named from above or from the root.
fn refuse_outside(file: &Path, folder: &Path) -> Result<()> {
    let real = |p: &Path| if p.as_os_str().is_empty() { Path::new(".") } else { p }.canonicalize();
    let is_plain = |p: &Path| p.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    let inside = match (real(file), real(folder)) {
        (Ok(file), Ok(folder)) => file.starts_with(folder),
        _ => file.strip_prefix(folder).is_ok_and(is_plain),
    };
    let why =
        "lies outside of the folder of the scene, which is not trusted; put it beside the scene, or trust the scene";
    ensure(inside, || Error::Format { path: file.to_path_buf(), why: why.into() })
}

#[cfg(test)]
mod tests;
