//! Story of a scene: places, values, relations, events, rules and state graphs (Kim, Kim and Shin 2003a,
//! section 3, and 2003b, section 3).

mod check;
mod service;

use super::PlaceConfig;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub(super) use check::stretch_actions;
pub use service::{LineChoice, ServiceConfig, TimeDistribution};

/// Place to which agents come: a store, a picture, a guidepost, a region of interest, a queue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SiteConfig {
    /// Name, unique in the scene.
    pub name: String,
    /// Kind of place, for predicates (`place.kind`): "store", "picture", any word.
    #[serde(default = "place")]
    pub kind: String,
    /// Centre (m).
    pub at: Vec<f32>,
    /// Radius, at which `enters` and `leaves` happen (m, 0.05 to 1000).
    #[serde(default = "site_radius")]
    pub radius_m: f32,
    /// Whether agents that enter read the blackboards: the global one and those of the cells there.
    #[serde(default)]
    pub guidepost: bool,
    /// Whether each agent enters it only once.
    #[serde(default)]
    pub once: bool,
    /// Name of the place to which its arrow points.
    pub arrow: Option<String>,
    /// Slots, each a place where one agent stands, sits or looks.
    #[serde(default)]
    pub slots: Vec<SlotConfig>,
    /// Queue: slots in a row along a line, from its head.
    pub queue: Option<QueueConfig>,
}

throng_base::key_defaults! {
    place: String = "place".into();
    site_radius: f32 = 2.0;
    queue_spacing: f32 = 0.8;
    thing_size: [f32; 3] = [0.08, 0.1, 0.08];
    whole: f32 = 1.0;
    done: String = "done".into();
}

/// Slot: a place for one agent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SlotConfig {
    /// Position (m).
    pub at: Vec<f32>,
    /// Position that an agent there faces; the centre of the place where absent (m).
    pub facing: Option<Vec<f32>>,
}

/// Queue of slots along a line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct QueueConfig {
    /// Points of the line, from its head (m, >= 2).
    pub points: Vec<Vec<f32>>,
    /// Distance between neighbours (m, 0.3 to 10).
    #[serde(default = "queue_spacing")]
    pub spacing_m: f32,
}

/// Thing that agents take, carry and put down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ThingConfig {
    /// Name, unique in the scene.
    pub name: String,
    /// Centre at the start: x, y up, z (m).
    pub at: [f32; 3],
    /// Size along x, y and z, for pictures (m, 0.01 to 2).
    #[serde(default = "thing_size")]
    pub size_m: [f32; 3],
    /// Style in which it is carried.
    #[serde(default)]
    pub carried: CarryStyle,
}

/// Style in which a thing is carried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum CarryStyle {
    /// In a hand that swings while walking, such as a bag or a stick.
    Hanging,
    /// In front of the belly, upright, such as a cup or a tray.
    #[default]
    Level,
}

/// Door: a wall that opens and closes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DoorConfig {
    /// Name, unique in the scene.
    pub name: String,
    /// One end (m).
    pub from: Vec<f32>,
    /// The other end (m).
    pub to: Vec<f32>,
    /// Radius: half its thickness (m, 0 to 10).
    #[serde(default)]
    pub radius_m: f32,
    /// Whether it is open at the start.
    #[serde(default)]
    pub open: bool,
}

/// Value that agents feel, a number that changes with time: v' = rate + (rest - v) ln 2 / half-life, within its limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ValueConfig {
    /// Least and greatest value at the start.
    pub start: [f32; 2],
    /// Growth by itself (1/s).
    pub rate_per_s: f32,
    /// Value of rest, to which it returns by itself with `half_life_s`.
    pub rest: Option<f32>,
    /// Half-life of the distance from the value of rest (s, 0.01 to 1e6).
    pub half_life_s: f32,
    /// Least and greatest value.
    pub limits: [f32; 2],
}

impl Default for ValueConfig {
    fn default() -> Self {
        Self { start: [0.0; 2], rate_per_s: 0.0, rest: None, half_life_s: 60.0, limits: [0.0, 1.0] }
    }
}

/// Relation of some agents to others, or to a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RelationConfig {
    /// A group, or one agent of it as `"group:3"`.
    pub of: String,
    /// A group, one agent of it, or a place.
    pub to: String,
    /// Whether it holds from `of` to `to` alone; otherwise also the other way round, for the same pairs.
    #[serde(default)]
    pub one_sided: bool,
    /// Share of the pairs for which it holds, drawn at random, alike from both sides (0 to 1).
    #[serde(default = "whole")]
    pub share: f32,
    /// Friendship, from -1 (enemies) to 1 (close friends).
    pub friendship: Option<f32>,
    /// Curiosity, from -1 (keeps away) to 1 (drawn to it).
    pub curiosity: Option<f32>,
}

/// Event that happens in the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct EventConfig {
    /// Name, unique in the scene, for which rules and graphs wait.
    pub name: String,
    /// Time at which it happens (s).
    pub at_s: Option<f64>,
    /// Range of times from which the time of the event is drawn evenly (s).
    pub between_s: Option<[f64; 2]>,
    /// Mean time between random occurrences (s, 0.01 to 1e6).
    pub every_s: Option<f64>,
    /// Time between regular occurrences (s, 0.01 to 1e6).
    pub period_s: Option<f64>,
    /// Condition: the event happens each time that it becomes true. It has only words about no agent in particular (`time`, `count`,
    /// `free`, `held`, `open`, `blackboard`), and is evaluated whenever something happens to any agent.
    pub when: Option<String>,
    /// Predicate of the agents to which it happens; all where absent, none where `nobody = true`.
    pub who: Option<String>,
    /// Whether it happens to no agent, so that only blackboards show it.
    pub nobody: bool,
    /// Doors that open with it.
    pub opens: Vec<String>,
    /// Doors that close with it, as soon as no agent stands in them.
    pub closes: Vec<String>,
    /// Whether agents that know of it tell those that they meet.
    pub passed_on: bool,
    /// Whether it is on the global blackboard from then on.
    pub posted: bool,
    /// Time for which it is passed on and posted; unlimited where absent (s).
    pub fresh_s: Option<f64>,
}

/// Rule (E, M, B): agents of some groups react to an event with a behaviour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RuleConfig {
    /// Name in explanations; the number of the rule where absent.
    #[serde(default)]
    pub name: String,
    /// Trigger: the name of an event; `starts`, `meets`, `enters`, `leaves`, `crosses`, `arrives`, `stuck`, `done`, `full` or
    /// `timer`; or a value that passes a threshold, such as `"fatigue > 0.7"`.
    pub on: String,
    /// Groups that it is for; all where empty.
    #[serde(default)]
    pub who: Vec<String>,
    /// Predicate; true where absent.
    pub when: Option<String>,
    /// Probability of following it (0 to 1).
    #[serde(default = "whole")]
    pub probability: f32,
    /// Behaviour: a name, or actions.
    #[serde(rename = "do")]
    pub does: StoryBehaviour,
    /// Whether the other agent of the event (`other`) follows the rule at the same time, with this one as its `other`; nobody does where
    /// either is busy with a rule.
    #[serde(default)]
    pub both: bool,
    /// Priority: it interrupts behaviours of rules with the same or a lower one.
    #[serde(default)]
    pub priority: i8,
    /// Least time between two uses of the rule by one agent (s, 0 to 1e6).
    #[serde(default)]
    pub pause_s: f32,
}

/// Behaviour of a rule or state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum StoryBehaviour {
    /// Name of a behaviour of `[behaviours]`.
    Named(String),
    /// Actions, one after the other.
    Actions(Vec<ActionConfig>),
}

/// Action: a table in which one key names the action, and others are its arguments: `{ go = "exit", speed = 1.5 }`.
pub type ActionConfig = BTreeMap<String, WordConfig>;

/// Argument of an action.
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

/// State-transition graph.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct StateGraphConfig {
    /// Level: social graphs are made of spatial ones, and these of primitive ones.
    pub level: LevelConfig,
    /// Start state.
    pub start: String,
    /// Its states by name.
    pub states: BTreeMap<String, StateConfig>,
    /// Edges between states (at most 64 from one state).
    #[serde(default)]
    pub edges: Vec<EdgeConfig>,
}

/// Level of a graph, the highest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LevelConfig {
    /// Purpose, such as to go shopping.
    Social,
    /// Place to go to or to stay at.
    Spatial,
    /// Single motion.
    Primitive,
}

/// State: a graph of a lower level, or a behaviour.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct StateConfig {
    /// Name of a graph of a lower level, which begins anew.
    pub graph: Option<String>,
    /// Behaviour: a name, or actions. Before a graph, only actions that take no time.
    #[serde(rename = "do")]
    pub does: Option<StoryBehaviour>,
}

/// Edge from one state to another, or back to the same one, in which case nothing changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct EdgeConfig {
    /// State from which it leads; any state of the graph where absent.
    pub from: Option<String>,
    /// State to which it leads.
    pub to: String,
    /// Trigger, as in rules; `done` where absent.
    #[serde(default = "done")]
    pub on: String,
    /// Predicate; true where absent.
    pub when: Option<String>,
    /// Probability of taking it. Edges without one share what the others leave (0 to 1).
    pub probability: Option<f32>,
    /// Whether an agent takes it alone; else its companions in the same state take it, too, and each waits at the end of a behaviour until all
    /// have come to it.
    #[serde(default)]
    pub alone: bool,
}

/// Source of agents that enter while time runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SourceConfig {
    /// Number of the group's agents that are there at the start; the others enter one by one.
    #[serde(default)]
    pub start: usize,
    /// Rates of random entries (Poisson), as (from time, per second), in order of time (s, 1/s).
    pub rates: Vec<[f64; 2]>,
    /// Time after which the rates begin again, such as 86400 for each day (s, > 0).
    pub period_s: Option<f64>,
    /// Whether agents that have left enter again, as others: the source goes on for as long as fewer than `count` are there.
    #[serde(default)]
    pub reuse: bool,
    /// Place at which they enter; `place` of the group where absent.
    pub place: Option<PlaceConfig>,
}

/// Conditions of which any ends the scene early.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct EndConfig {
    /// Groups whose agents must all have left.
    pub left: Vec<String>,
    /// Event that all agents that are there must know of.
    pub known: Option<String>,
    /// Event that must have happened.
    pub event: Option<String>,
}
