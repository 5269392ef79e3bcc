//! Groups: how many, what moves them, where they start and what they are after.

use super::goal::{AtEndConfig, GoalConfig, scale};
use super::place::PlaceConfig;
use super::story::SourceConfig;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Characters or agents who are moved alike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GroupConfig {
    /// What messages and pictures call it; its number where absent.
    #[serde(default)]
    pub name: String,
    /// What moves them.
    pub motion: Motion,
    /// How many (1 to 1000000); even for sparring.
    pub count: usize,
    /// Bundle of this group, in place of the scene's.
    #[serde(default)]
    pub bundle: Option<PathBuf>,
    /// Config that this bundle is built from where it is missing.
    #[serde(default)]
    pub config: Option<PathBuf>,
    /// Where they start. Needed by agents; a `grid` for policies and sparring; patches scatter by themselves.
    #[serde(default)]
    pub place: Option<PlaceConfig>,

    /// Of agents: where they go.
    #[serde(default)]
    pub goal: Option<GoalConfig>,
    /// Of agents: subgoals that all of them pass before, in order (m).
    #[serde(default)]
    pub via: Vec<Vec<f32>>,
    /// Of agents: how near to the goal is there (m, 0.01 to 1000).
    #[serde(default = "arrival")]
    pub arrival_m: f32,
    /// Of agents: what is done there.
    #[serde(default)]
    pub at_end: AtEndConfig,
    /// Of agents: radii, least and most (m, 0.01 to 100).
    #[serde(default = "radius")]
    pub radius_m: [f32; 2],
    /// Of agents: desired speeds, least and most (m/s, 0 to 100).
    #[serde(default = "speed")]
    pub speed_mps: [f32; 2],
    /// Of agents: largest accelerations, least and most (m/s^2, 0.01 to 1000).
    #[serde(default = "acceleration")]
    pub acceleration_mps2: [f32; 2],

    /// Of agents: the social graph by which they live, in place of a goal.
    #[serde(default)]
    pub graph: Option<String>,
    /// Of agents: walk in small groups of so many, least and most (1 to 4).
    #[serde(default = "alone")]
    pub companions: [usize; 2],
    /// Of agents: how they enter while time runs.
    #[serde(default)]
    pub source: Option<SourceConfig>,

    /// Of `blend`: blend spaces of the bundle; characters take them in turn (1 to 64).
    #[serde(default)]
    pub spaces: Vec<String>,
    /// Of `blend`: random curved paths in place of a goal; who is on one minds nobody.
    #[serde(default)]
    pub paths: Option<PathsConfig>,
    /// Of `blend`: value of the first style axis by speed, as (speed, value) that ascend by speed; between them it
    /// changes linearly. Speeds are those of the database skeleton: a smaller body runs sooner. 0 where empty (m/s).
    #[serde(default)]
    pub style_by_speed: Vec<[f32; 2]>,
    /// Of `blend`: what the bodies are like. Where absent, sizes are 0.9 to 1.05 with a goal and 0.7 to 1.15 on paths.
    #[serde(default)]
    pub bodies: Option<BodiesConfig>,

    /// Of `policy` and `sparring`: what characters weigh against each other, every behaviour once (1 to 4).
    #[serde(default)]
    pub behaviours: Vec<BehaviourConfig>,
    /// Of `policy` and `sparring`: choose at random among the best few actions; 0 always takes the best (0 to 1000).
    #[serde(default)]
    pub temperature: f64,
    /// Of `sparring`: force of blows to head and trunk, of the strongest of their kind, from which who is struck steps away with
    /// them; 0.95 by default, above 1 nobody does (0 to 10).
    #[serde(default)]
    pub stagger_force: Option<f64>,
    /// Of `policy`: the target of each.
    #[serde(default)]
    pub target: StruckTargetConfig,

    /// Of `patches`: stitched world in place of the environment's.
    #[serde(default)]
    pub world: Option<PathBuf>,
    /// Of `patches`: world file (TOML) that this world is stitched from where it is missing or older.
    #[serde(default)]
    pub world_config: Option<PathBuf>,
    /// Of `patches`: what they wish, one after the other, drawn by their shares; roaming where empty.
    #[serde(default)]
    pub wishes: Vec<WeightedWish>,
}

/// What moves a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// Policies of the bundle: each character is after a target of its own, which gives way to blows and returns.
    Policy,
    /// Blended examples: bodies follow agents to a goal, or random paths.
    Blend,
    /// Patches of a stitched world: characters wish one thing after another.
    Patches,
    /// Policies of two: characters 2i and 2i + 1 strike at each other's heads.
    Sparring,
    /// Nothing: agents without bodies.
    None,
}

impl Motion {
    /// As scene files and reports call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Policy => "policy",
            Self::Blend => "blend",
            Self::Patches => "patches",
            Self::Sparring => "sparring",
            Self::None => "none",
        }
    }
}

fn alone() -> [usize; 2] {
    [1; 2]
}

pub(super) fn arrival() -> f32 {
    0.5
}

pub(super) fn radius() -> [f32; 2] {
    [0.3; 2]
}

pub(super) fn speed() -> [f32; 2] {
    [1.3; 2]
}

pub(super) fn acceleration() -> [f32; 2] {
    [5.0; 2]
}

fn full() -> f64 {
    1.0
}

/// A behaviour and what it counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BehaviourConfig {
    /// Name of a behaviour of the bundle.
    pub name: String,
    /// Weight of its values in the sum (-1e6 to 1e6).
    #[serde(default = "full")]
    pub weight: f64,
}

/// A target that can be struck.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct StruckTargetConfig {
    /// Height above ground (m, -10 to 10).
    pub height_m: f64,
    /// Radius (m, 0.01 to 1).
    pub radius_m: f64,
    /// How a hand drags it: places relative to where it hangs at the start, in order of time, then from the first
    /// again. It stands still where there are none.
    pub drag: Vec<DragPoint>,
}

impl Default for StruckTargetConfig {
    fn default() -> Self {
        Self { height_m: 1.5, radius_m: 0.12, drag: Vec::new() }
    }
}

/// A place on the way of a dragged target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

/// Random curved paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct PathsConfig {
    /// Speeds that are drawn (m/s, 0 to 20).
    pub speeds: [f32; 2],
    /// Share of the draws that stand still (0 to 1).
    pub standing: f32,
    /// How long a speed and a turning rate are kept (s, 0.1 to 1000).
    pub seconds: [f32; 2],
    /// How fast the speed changes at most (m/s^2, 0.01 to 1000).
    pub acceleration: f32,
    /// Fastest turn (rad/s, 0 to 20).
    pub max_gyration: f32,
    /// How far curves press outwards at most, which bounds turns at speed (m/s^2, 0.01 to 1000).
    pub sideways: f32,
    /// Side of the square that they stay on (m, 4 to 10000).
    pub area_m: f32,
    /// Middle of the square (m).
    pub centre: [f32; 2],
}

impl PathsConfig {
    /// Half a side of the ground under the square, the distance of its heights (m), and their number along a side.
    pub(crate) fn ground(&self) -> (f32, f32, usize) {
        // As many take 64 MiB: those of a wider ground lie farther apart.
        const MOST_KNOTS: f32 = 4000.0;
        const LEAST_SPACING_M: f32 = 0.5;
        let half = 0.5 * self.area_m + 20.0;
        let spacing = (2.0 * half / MOST_KNOTS).max(LEAST_SPACING_M);
        (half, spacing, (2.0 * half / spacing).ceil() as usize + 1)
    }
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
            centre: [0.0; 2],
        }
    }
}

/// What bodies are like beside the database skeleton.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

/// A wish and how often it is drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct WeightedWish {
    /// How often it is drawn, against the others' shares (> 0).
    #[serde(default = "full")]
    pub share: f64,
    /// The wish.
    pub wish: WishConfig,
}

impl WeightedWish {
    /// What everybody wishes where the file says nothing.
    pub fn roaming() -> Self {
        Self { share: 1.0, wish: WishConfig::Roam { seconds: [20.0, 40.0] } }
    }
}

/// What a character in a world wishes to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WishConfig {
    /// Go wherever chance leads.
    Roam {
        /// For how long: at least, at most (s).
        seconds: [f64; 2],
    },
    /// Go to a place drawn at random within a box of the world; anywhere where it is absent.
    Visit {
        /// Lowest and highest x and z of the places: [x, z, x, z] (m).
        #[serde(default)]
        within: Option<[f64; 4]>,
    },
    /// Go to where something can be done that the motion is tagged with, and do it.
    Perform {
        /// The tag, as the bundle names it.
        tag: String,
        /// For how long: at least, at most (s).
        seconds: [f64; 2],
        /// Whom to do it with, where two do it together: `partner` for anybody who wishes it too, or the name of a group.
        /// One roams until somebody wishes the same, and then both come together.
        #[serde(default)]
        with: Option<String>,
    },
}

/// Whoever wishes the same.
pub const ANY_PARTNER: &str = "partner";

impl WishConfig {
    /// How long it takes, where that is given (s).
    pub fn seconds(&self) -> Option<[f64; 2]> {
        match self {
            Self::Roam { seconds } | Self::Perform { seconds, .. } => Some(*seconds),
            Self::Visit { .. } => None,
        }
    }
}

impl GroupConfig {
    /// True for agents, with or without bodies, who keep clear of each other.
    pub fn is_of_agents(&self) -> bool {
        self.motion == Motion::None || self.motion == Motion::Blend && self.paths.is_none()
    }

    /// Its name in messages and pictures.
    pub fn title(&self, number: usize) -> String {
        if self.name.is_empty() { format!("group {number}") } else { self.name.clone() }
    }

    /// What its bodies are like.
    pub fn bodies(&self) -> BodiesConfig {
        let sizes = if self.paths.is_none() { [0.9, 1.05] } else { BodiesConfig::default().sizes };
        self.bodies.clone().unwrap_or(BodiesConfig { sizes, ..BodiesConfig::default() })
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

    pub(super) fn stretch(&mut self, by: f32) {
        if let Some(place) = &mut self.place {
            place.stretch(by);
        }
        if let Some(goal) = &mut self.goal {
            goal.stretch(by);
        }
        self.via.iter_mut().for_each(|p| scale(&mut [p], by));
    }
}
