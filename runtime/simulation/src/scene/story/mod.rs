//! What people of a scene live by: places, values, relations, events, rules and state graphs (Kim, Kim and Shin 2003a,
//! section 3, and 2003b, section 3).

mod check;

use super::PlaceConfig;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub(super) use check::stretch_actions;

/// A store, a picture, a guidepost, a region of interest, a queue: somewhere that people come to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SiteConfig {
    /// Its name, once in the scene.
    pub name: String,
    /// What it is, for predicates (`place.kind`): "store", "picture", any word.
    #[serde(default = "place")]
    pub kind: String,
    /// Its middle (m).
    pub at: Vec<f32>,
    /// How near to its middle one is at the place: `enters` and `leaves` happen there (m, 0.05 to 1000).
    #[serde(default = "site_radius")]
    pub radius_m: f32,
    /// Who enters reads the boards: the global one and those of the cells there.
    #[serde(default)]
    pub guidepost: bool,
    /// Each agent enters it once; later it takes no notice.
    #[serde(default)]
    pub once: bool,
    /// Where those who read its arrow go: the name of another place.
    #[serde(default)]
    pub arrow: Option<String>,
    /// Where people stand, sit or look here, each a place for one.
    #[serde(default)]
    pub slots: Vec<SlotConfig>,
    /// Slots in a row along a line, the first one first.
    #[serde(default)]
    pub queue: Option<QueueConfig>,
}

fn place() -> String {
    "place".into()
}

fn site_radius() -> f32 {
    2.0
}

/// A place for one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SlotConfig {
    /// Where (m).
    pub at: Vec<f32>,
    /// What who stands there faces (m); the middle of the place where absent.
    #[serde(default)]
    pub facing: Option<Vec<f32>>,
}

/// Slots along a line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct QueueConfig {
    /// The line, from its head (m, >= 2).
    pub points: Vec<Vec<f32>>,
    /// Between two who stand in it (m, 0.3 to 10).
    #[serde(default = "queue_spacing")]
    pub spacing_m: f32,
}

fn queue_spacing() -> f32 {
    0.8
}

/// A thing that people of a scene take, carry and put down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ThingConfig {
    /// Its name, once in the scene.
    pub name: String,
    /// Where its middle lies at the start: x, y up, z (m).
    pub at: [f32; 3],
    /// Its lengths along x, y and z, for pictures (m, 0.01 to 2).
    #[serde(default = "thing_size")]
    pub size_m: [f32; 3],
    /// How it is carried.
    #[serde(default)]
    pub carried: Carried,
}

/// How a thing is carried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Carried {
    /// In a hand that swings as one walks: a bag, a stick.
    Hanging,
    /// Before the belly, upright: a cup, a tray.
    #[default]
    Level,
}

fn thing_size() -> [f32; 3] {
    [0.08, 0.1, 0.08]
}

/// A door: a wall that opens and closes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DoorConfig {
    /// Its name, once in the scene.
    pub name: String,
    /// One end (m).
    pub from: Vec<f32>,
    /// The other end (m).
    pub to: Vec<f32>,
    /// Half its thickness (m, 0 to 10).
    #[serde(default)]
    pub radius_m: f32,
    /// Open at the start.
    #[serde(default)]
    pub open: bool,
}

/// What agents feel, as a number that changes with time: v' = rate + (rest - v) ln 2 / half-life, within its limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ValueConfig {
    /// Least and most at the start.
    pub start: [f32; 2],
    /// How fast it grows (1/s).
    pub rate_per_s: f32,
    /// Where it goes by itself; needs `half_life_s`.
    pub rest: Option<f32>,
    /// Time in which half of the way to rest is gone (s, 0.01 to 1e6).
    pub half_life_s: f32,
    /// Least and greatest.
    pub limits: [f32; 2],
}

impl Default for ValueConfig {
    fn default() -> Self {
        Self { start: [0.0; 2], rate_per_s: 0.0, rest: None, half_life_s: 60.0, limits: [0.0, 1.0] }
    }
}

/// What some feel for others, or for a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RelationConfig {
    /// A group, or one agent of it as `"group:3"`.
    pub of: String,
    /// A group, one agent of it, or a place.
    pub to: String,
    /// Of the pairs, those that it is true of, drawn by chance; of both sides alike (0 to 1).
    #[serde(default = "whole")]
    pub share: f32,
    /// From -1 (enemies) to 1 (close friends).
    #[serde(default)]
    pub friendship: Option<f32>,
    /// From -1 (keeps away) to 1 (drawn to it).
    #[serde(default)]
    pub curiosity: Option<f32>,
}

fn whole() -> f32 {
    1.0
}

/// Something that happens, and what is told of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct EventConfig {
    /// Its name, once in the scene: what rules and graphs wait for.
    pub name: String,
    /// When it happens (s).
    pub at_s: Option<f64>,
    /// When it happens, drawn evenly between two times (s).
    pub between_s: Option<[f64; 2]>,
    /// It happens again and again, by chance, with this mean time between (s, 0.01 to 1e6).
    pub every_s: Option<f64>,
    /// It happens again and again, after exactly this time (s, 0.01 to 1e6).
    pub period_s: Option<f64>,
    /// When it happens: each time that this becomes true, of what is there for all (`time`, `count`, `free`, `held`, `open`,
    /// `board`); looked at whenever something happens to anybody.
    pub when: Option<String>,
    /// To whom it happens: a predicate. Nobody, where `nobody = true`; all where absent.
    pub who: Option<String>,
    /// It happens to nobody: only boards show it.
    pub nobody: bool,
    /// Doors that open with it.
    pub opens: Vec<String>,
    /// Doors that close with it, once nobody stands in them.
    pub closes: Vec<String>,
    /// Who knows of it tells those it meets.
    pub told_on: bool,
    /// It is on the global board from then on.
    pub posted: bool,
    /// How long it is told and posted (s); for ever where absent.
    pub fresh_s: Option<f64>,
}

/// To an event, those of a group react with a behaviour (E, M, B).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RuleConfig {
    /// What explanations call it; its number where absent.
    #[serde(default)]
    pub name: String,
    /// The event: its name; `starts`, `meets`, `enters`, `leaves`, `crosses`, `arrives`, `stuck`, `done`, `full` or
    /// `timer`; or a value that passes a threshold, such as `"fatigue > 0.7"`.
    pub on: String,
    /// Groups that it is for; all where empty.
    #[serde(default)]
    pub who: Vec<String>,
    /// Predicate; true where absent.
    #[serde(default)]
    pub when: Option<String>,
    /// How likely it is followed (0 to 1).
    #[serde(default = "whole")]
    pub probability: f32,
    /// What is done: name of a behaviour, or actions.
    #[serde(rename = "do")]
    pub does: DoConfig,
    /// It interrupts behaviours of rules with the same or a lower priority.
    #[serde(default)]
    pub priority: i8,
    /// Least time between two of one agent (s, 0 to 1e6).
    #[serde(default)]
    pub pause_s: f32,
}

/// What is done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum DoConfig {
    /// A behaviour of `[behaviours]`.
    Named(String),
    /// One after the other.
    Actions(Vec<ActionConfig>),
}

/// An action: a table whose one word says what is done, and the others how: `{ go = "exit", speed = 1.5 }`.
pub type ActionConfig = BTreeMap<String, WordConfig>;

/// What is said of an action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum WordConfig {
    /// Yes or no.
    Flag(bool),
    /// A number.
    Number(f64),
    /// A name, or an expression.
    Text(String),
    /// A point (m).
    Point(Vec<f32>),
    /// Points (m).
    Points(Vec<Vec<f32>>),
}

/// A state-transition graph.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GraphConfig {
    /// Social graphs are made of spatial ones, and these of primitive ones.
    pub level: LevelConfig,
    /// The state in which it begins.
    pub start: String,
    /// Its states by name.
    pub states: BTreeMap<String, StateConfig>,
    /// Ways from state to state (at most 64 from one state).
    #[serde(default)]
    pub edges: Vec<EdgeConfig>,
}

/// Levels of graphs, the highest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LevelConfig {
    /// What one is about: to go shopping.
    Social,
    /// Where one goes or stays.
    Spatial,
    /// Single motions.
    Primitive,
}

/// A state: a graph of a level below, or a behaviour.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct StateConfig {
    /// A graph of a lower level, which begins anew.
    pub graph: Option<String>,
    /// What is done: name of a behaviour, or actions. Before a graph, only what takes no time.
    #[serde(rename = "do")]
    pub does: Option<DoConfig>,
}

/// A way from one state to another, or back to the same: then nothing changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct EdgeConfig {
    /// From this state; from any of the graph where absent.
    #[serde(default)]
    pub from: Option<String>,
    /// To this state.
    pub to: String,
    /// The event, as in rules; `done` where absent.
    #[serde(default = "done")]
    pub on: String,
    /// Predicate; true where absent.
    #[serde(default)]
    pub when: Option<String>,
    /// How likely it is taken. Edges without one share what the others leave (0 to 1).
    #[serde(default)]
    pub probability: Option<f32>,
}

fn done() -> String {
    "done".into()
}

/// Who enters while time runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SourceConfig {
    /// Of the group, how many are there at the start; the others enter one by one.
    #[serde(default)]
    pub start: usize,
    /// How many enter, by chance (Poisson), as (from time, per second), in order of time (s, 1/s).
    pub rates: Vec<[f64; 2]>,
    /// Where they enter; `place` of the group where absent.
    #[serde(default)]
    pub place: Option<PlaceConfig>,
}

/// When the scene ends.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct EndConfig {
    /// When all of these groups have left.
    pub left: Vec<String>,
    /// When all who are there know of this event.
    pub known: Option<String>,
    /// When this event happens to anybody.
    pub event: Option<String>,
}

/// What lengths of a scene file are in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum UnitsConfig {
    /// Metres.
    #[default]
    M,
    /// Inches (0.0254 m).
    In,
}
