//! What people of a scene live by: places, values, relations, events, rules and state graphs (Kim, Kim and Shin 2003a,
//! section 3, and 2003b, section 3).

use super::PlaceConfig;
use super::check::{Fault, check_numbers, check_point, check_ranges, fault};
use super::goal::scale;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

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

impl ThingConfig {
    pub(super) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), Fault> {
        if dimensions != 2 {
            return fault(key, "expected none in the air: hands take things on the ground");
        }
        check_point(&format!("{key}.at"), &self.at, 3)?;
        check_numbers(&[(&format!("{key}.at[1]"), self.at[1], 0.0, 10.0)])?;
        let sizes: Vec<_> = (0..3).map(|k| (format!("{key}.size_m[{k}]"), self.size_m[k])).collect();
        sizes.iter().try_for_each(|(key, size)| check_numbers(&[(key, *size, 0.01, 2.0)]))
    }

    /// Heights and the thing itself stay, but where units are converted.
    pub(super) fn stretch(&mut self, by: f32, also_size: bool) {
        self.at[0] *= by;
        self.at[2] *= by;
        if also_size {
            self.at[1] *= by;
            if self.size_m != thing_size() {
                self.size_m = self.size_m.map(|length| length * by);
            }
        }
    }
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
    /// Ways from state to state.
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

/// Words of actions that are lengths, or lengths over time.
const LENGTHS: [&str; 4] = ["speed", "within_m", "distance_m", "spacing_m"];

/// Multiplies all lengths of actions that are given as numbers and points.
pub(super) fn stretch_actions(actions: &mut [ActionConfig], by: f32, also_words: bool) {
    for (word, said) in actions.iter_mut().flatten() {
        match said {
            WordConfig::Number(number) if also_words && LENGTHS.contains(&word.as_str()) => *number *= f64::from(by),
            WordConfig::Point(at) => {
                let height = at.get(1).copied().filter(|_| word == "on" && !also_words);
                scale(&mut [at], by);
                // Tables do not grow with the layout.
                at.iter_mut().skip(1).zip(height).for_each(|(y, height)| *y = height);
            }
            WordConfig::Points(all) => all.iter_mut().for_each(|p| scale(&mut [p], by)),
            _ => {}
        }
    }
}

impl DoConfig {
    pub(super) fn stretch(&mut self, by: f32, also_words: bool) {
        if let Self::Actions(actions) = self {
            stretch_actions(actions, by, also_words);
        }
    }
}

impl SiteConfig {
    /// Multiplies its lengths; those of slots and queues among each other stay where only the layout grows.
    pub(super) fn stretch(&mut self, by: f32, also_sizes: bool) {
        let before = self.at.clone();
        scale(&mut [&mut self.at], by);
        if also_sizes && self.radius_m != site_radius() {
            self.radius_m *= by;
        }
        let moved: Vec<f32> = self.at.iter().zip(&before).map(|(a, b)| a - b).collect();
        let points = self.slots.iter_mut().flat_map(|s| std::iter::once(&mut s.at).chain(&mut s.facing));
        for point in points.chain(self.queue.iter_mut().flat_map(|q| &mut q.points)) {
            match also_sizes {
                true => scale(&mut [point], by),
                false => point.iter_mut().zip(&moved).for_each(|(p, m)| *p += m),
            }
        }
        if let Some(queue) = self.queue.as_mut().filter(|q| also_sizes && q.spacing_m != queue_spacing()) {
            queue.spacing_m *= by;
        }
    }

    pub(super) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), Fault> {
        check_point(&format!("{key}.at"), &self.at, dimensions)?;
        check_numbers(&[(&format!("{key}.radius_m"), self.radius_m, 0.05, 1000.0)])?;
        for (i, slot) in self.slots.iter().enumerate() {
            check_point(&format!("{key}.slots[{i}].at"), &slot.at, dimensions)?;
            if let Some(facing) = &slot.facing {
                check_point(&format!("{key}.slots[{i}].facing"), facing, dimensions)?;
            }
        }
        if let Some(queue) = &self.queue {
            check_numbers(&[(&format!("{key}.queue.spacing_m"), queue.spacing_m, 0.3, 10.0)])?;
            if queue.points.len() < 2 {
                let found = queue.points.len();
                return fault(&format!("{key}.queue.points"), format!("expected at least 2 points, found {found}"));
            }
            for (i, point) in queue.points.iter().enumerate() {
                check_point(&format!("{key}.queue.points[{i}]"), point, dimensions)?;
            }
        }
        Ok(())
    }
}

impl DoorConfig {
    pub(super) fn stretch(&mut self, by: f32) {
        scale(&mut [&mut self.from, &mut self.to], by);
    }

    pub(super) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), Fault> {
        check_point(&format!("{key}.from"), &self.from, dimensions)?;
        check_point(&format!("{key}.to"), &self.to, dimensions)?;
        check_numbers(&[(&format!("{key}.radius_m"), self.radius_m, 0.0, 10.0)])
    }
}

impl ValueConfig {
    pub(super) fn find_fault(&self, key: &str) -> Result<(), Fault> {
        let [low, high] = self.limits;
        if !(low < high && low.abs() < 1e6 && high.abs() < 1e6) {
            return fault(
                &format!("{key}.limits"),
                format!("expected two numbers that ascend, found {low} and {high}"),
            );
        }
        check_ranges(&[(&format!("{key}.start"), self.start, low, high)])?;
        check_numbers(&[
            (&format!("{key}.rate_per_s"), self.rate_per_s, -1e6, 1e6),
            (&format!("{key}.rest"), self.rest.unwrap_or(low), low, high),
            (&format!("{key}.half_life_s"), self.half_life_s, 0.01, 1e6),
        ])
    }
}

impl EventConfig {
    pub(super) fn find_fault(&self, key: &str) -> Result<(), Fault> {
        let times = [("at_s", self.at_s, 0.0), ("every_s", self.every_s, 0.01), ("period_s", self.period_s, 0.01)];
        for (name, time, least) in times {
            check_numbers(&[(&format!("{key}.{name}"), time.unwrap_or(least), least, 1e6)])?;
        }
        if let Some([from, to]) = self.between_s
            && !(0.0 <= from && from <= to && to <= 1e6)
        {
            let why = format!("expected two times that ascend from 0, found {from} and {to}");
            return fault(&format!("{key}.between_s"), why);
        }
        check_numbers(&[(&format!("{key}.fresh_s"), self.fresh_s.unwrap_or(0.0), 0.0, 1e9)])
    }
}

impl RelationConfig {
    pub(super) fn find_fault(&self, key: &str) -> Result<(), Fault> {
        if self.friendship.is_none() && self.curiosity.is_none() {
            return fault(key, "expected `friendship` or `curiosity`, found neither");
        }
        check_numbers(&[
            (&format!("{key}.share"), self.share, 0.0, 1.0),
            (&format!("{key}.friendship"), self.friendship.unwrap_or(0.0), -1.0, 1.0),
            (&format!("{key}.curiosity"), self.curiosity.unwrap_or(0.0), -1.0, 1.0),
        ])
    }
}

impl SourceConfig {
    pub(super) fn find_fault(&self, key: &str, count: usize, dimensions: usize) -> Result<(), Fault> {
        if self.start > count {
            let why = format!("expected at most the `count` of the group, {count}, found {}", self.start);
            return fault(&format!("{key}.start"), why);
        }
        if self.rates.is_empty() || !self.rates.windows(2).all(|w| w[0][0] < w[1][0]) {
            return fault(&format!("{key}.rates"), "expected [from time, per second], in the order of time");
        }
        for (i, [from, rate]) in self.rates.iter().enumerate() {
            check_numbers(&[
                (&format!("{key}.rates[{i}][0]"), *from, 0.0, 1e6),
                (&format!("{key}.rates[{i}][1]"), *rate, 0.0, 1e4),
            ])?;
        }
        match &self.place {
            Some(place @ PlaceConfig::Block { .. }) => place.find_fault(&format!("{key}.place"), dimensions),
            Some(_) => fault(&format!("{key}.place"), "expected a `block`"),
            None => Ok(()),
        }
    }
}
