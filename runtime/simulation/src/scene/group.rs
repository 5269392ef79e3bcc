//! Groups of characters or agents: number, motion, starts and goals.

use super::goal::{AtEndConfig, GoalConfig, scale_points};
use super::{place::PlaceConfig, story::SourceConfig};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use throng_base::thresholds::{AGENT_RADIUS_M, WALK_SPEED_MPS};
use throng_core::stops::BODY_RADIUS_M;

/// Group of characters or agents that are moved alike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GroupConfig {
    /// Name in messages and pictures; the number of the group where absent.
    #[serde(default)]
    pub name: String,
    /// Source of the group's motion.
    pub motion: GroupMotion,
    /// Number of characters (1 to 1000000); even for sparring.
    pub count: usize,
    /// Bundle of this group, in place of the scene's.
    pub bundle: Option<PathBuf>,
    /// Config that this bundle is built from where it is missing.
    pub config: Option<PathBuf>,
    /// Start of the group. Needed by all that have a goal; a `grid` for sparring and struck targets; patches scatter by themselves.
    pub place: Option<PlaceConfig>,

    /// Goal of agents, of characters with policies, and of those in worlds: there a `point`, `place` or `area` where they stay, or
    /// `wander` between places.
    pub goal: Option<GoalConfig>,
    /// Subgoals that all pass before their goal, in order (m).
    #[serde(default)]
    pub via: Vec<Vec<f32>>,
    /// Distance from the goal at which they have arrived (m, 0.01 to 1000).
    #[serde(default = "arrival")]
    pub arrival_m: f32,
    /// Behaviour at the goal.
    #[serde(default)]
    pub at_end: AtEndConfig,
    /// Least and largest radius of agents (m, 0.01 to 100).
    #[serde(default = "radius")]
    pub radius_m: [f32; 2],
    /// Least and largest desired speed of agents (m/s, 0 to 100).
    #[serde(default = "speed")]
    pub speed_mps: [f32; 2],
    /// Least and largest limit of the acceleration of agents (m/s^2, 0.01 to 1000).
    #[serde(default = "acceleration")]
    pub acceleration_mps2: [f32; 2],

    /// Name of the social graph of agents, in place of a goal.
    pub graph: Option<String>,
    /// Least and largest size of small groups in which agents walk together (1 to 4).
    #[serde(default = "alone")]
    pub companions: [usize; 2],
    /// Entry of agents while time runs.
    pub source: Option<SourceConfig>,

    /// Blend spaces of the bundle, for `blend`; characters take them in turn (1 to 64).
    #[serde(default)]
    pub spaces: Vec<String>,
    /// Random curved paths in place of a goal, for `blend`; characters on them avoid nobody.
    pub paths: Option<PathsConfig>,
    /// Value of the first style axis by speed, for `blend`, as (speed, value) that ascend by speed; between them it
    /// changes linearly. Speeds are those of the database skeleton: a smaller body runs sooner. 0 where empty (m/s).
    #[serde(default)]
    pub style_by_speed: Vec<[f32; 2]>,
    /// Sizes and proportions of bodies, for `blend`. Where absent, sizes are 0.9 to 1.05 with a goal and 0.7 to 1.15 on paths.
    pub bodies: Option<BodiesConfig>,

    /// Behaviours that characters weigh against each other, for `policy` and `sparring`, each once (1 to 4); "approach" where a group
    /// with a goal names none.
    #[serde(default)]
    pub behaviours: Vec<WeightedBehaviour>,
    /// Manners of motion, such as `sad`, for `policy` and `sparring`; characters take them in turn and keep them. `normal` is that which
    /// nothing sets apart.
    #[serde(default)]
    pub manners: Vec<String>,
    /// Temperature of random choices among the best few actions, for `policy` and `sparring`; 0 takes the best (0 to 1000).
    #[serde(default)]
    pub temperature: f64,
    /// Least force of blows to head and trunk that make the struck character step away, for `sparring`, relative to the strongest of
    /// their kind; 0.95 by default, above 1 no blow does (0 to 10).
    pub stagger_force: Option<f64>,
    /// Target that each character strikes at, for `policy` without a goal.
    #[serde(default)]
    pub target: StruckTargetConfig,

    /// Stitched world in place of the environment's, for `patches`.
    pub world: Option<PathBuf>,
    /// World file (TOML) that this world is stitched from where it is missing or older, for `patches`.
    pub world_config: Option<PathBuf>,
    /// Goals that are drawn one after the other by their shares, for `patches`; roaming where empty.
    #[serde(default)]
    pub goals: Vec<WeightedGoal>,
}

/// Source of a group's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum GroupMotion {
    /// Policies of the bundle: each character goes to its `goal`, or without one strikes at a target of its own, which gives way to
    /// blows and returns.
    Policy,
    /// Blended examples: bodies follow agents to a goal, or random paths.
    Blend,
    /// Patches of a stitched world: characters pursue one goal after another.
    Patches,
    /// Policies of two: characters 2i and 2i + 1 strike at each other's heads.
    Sparring,
    /// Nothing: agents without bodies.
    None,
}

impl GroupMotion {
    /// Name in scene files and reports.
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

throng_base::key_defaults! {
    alone: [usize; 2] = [1; 2];
    pub(super) arrival: f32 = 0.5;
    pub(super) radius: [f32; 2] = [AGENT_RADIUS_M; 2];
    pub(super) speed: [f32; 2] = [WALK_SPEED_MPS; 2];
    pub(super) acceleration: [f32; 2] = [5.0; 2];
    full: f64 = 1.0;
}

/// Behaviour with its weight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct WeightedBehaviour {
    /// Name of a behaviour of the bundle.
    pub name: String,
    /// Weight of its values in the sum (-1e6 to 1e6).
    #[serde(default = "full")]
    pub weight: f64,
}

/// Target that can be struck.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct StruckTargetConfig {
    /// Height above ground (m, -10 to 10).
    pub height_m: f64,
    /// Radius (m, 0.01 to 1).
    pub radius_m: f64,
    /// Path on which a hand drags it: places relative to its start, in order of time, then from the first
    /// again. It stays in place where there are none.
    pub drag: Vec<DragPoint>,
}

impl Default for StruckTargetConfig {
    fn default() -> Self {
        Self { height_m: 1.5, radius_m: 0.12, drag: Vec::new() }
    }
}

/// Point on the path of a dragged target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DragPoint {
    /// Time at the point (s, > 0, ascending).
    pub time_s: f64,
    /// Displacement to the left (m).
    #[serde(default)]
    pub x_m: f64,
    /// Displacement ahead (m).
    #[serde(default)]
    pub z_m: f64,
    /// Displacement up (m).
    #[serde(default)]
    pub y_m: f64,
}

/// Settings of random curved paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct PathsConfig {
    /// Speeds that are drawn (m/s, 0 to 20).
    pub speeds: [f32; 2],
    /// Share of the draws that stand still (0 to 1).
    pub standing: f32,
    /// Time for which a speed and a turning rate are kept (s, 0.1 to 1000).
    pub seconds: [f32; 2],
    /// Largest acceleration (m/s^2, 0.01 to 1000).
    pub acceleration: f32,
    /// Largest turning rate (rad/s, 0 to 20).
    pub max_gyration: f32,
    /// Largest centripetal acceleration, which limits turns at speed (m/s^2, 0.01 to 1000).
    pub sideways: f32,
    /// Side of the square in which paths stay (m, 4 to 10000).
    pub area_m: f32,
    /// Middle of the square (m).
    pub centre: [f32; 2],
}

impl PathsConfig {
    /// Ground under the square: half its side (m), the spacing of its heights (m), and their number along a side.
    pub(crate) fn ground_grid(&self) -> (f32, f32, usize) {
        // So many heights take 64 MiB; on a wider ground they lie farther apart.
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

/// Sizes and proportions of bodies, relative to the database skeleton.
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

/// Goal with its share of draws.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct WeightedGoal {
    /// Share of draws, relative to the other goals' shares (> 0).
    #[serde(default = "full")]
    pub share: f64,
    /// Goal.
    pub goal: InhabitantGoalConfig,
}

impl WeightedGoal {
    /// Goal of all characters where the file names none.
    pub fn roaming() -> Self {
        Self { share: 1.0, goal: InhabitantGoalConfig::Roam { seconds: [20.0, 40.0] } }
    }
}

/// Goal of a character in a world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum InhabitantGoalConfig {
    /// Go to random places.
    Roam {
        /// Least and longest duration (s).
        seconds: [f64; 2],
    },
    /// Go to a place drawn at random within a box of the world; anywhere where it is absent.
    Visit {
        /// Lowest and highest x and z of the places: [x, z, x, z] (m).
        within: Option<[f64; 4]>,
    },
    /// Go to where something can be done that the motion is tagged with, and do it.
    Perform {
        /// The tag, as the bundle names it.
        tag: String,
        /// Least and longest duration (s).
        seconds: [f64; 2],
        /// Partner, where two do it together: `partner` for any character with the same goal, or the name of a group.
        /// The character roams until it has found a partner, and then both come together.
        with: Option<String>,
    },
}

/// Name that stands for any character with the same goal.
pub const ANY_PARTNER: &str = "partner";

impl InhabitantGoalConfig {
    /// Least and longest duration, where it is given (s).
    pub fn seconds(&self) -> Option<[f64; 2]> {
        match self {
            Self::Roam { seconds } | Self::Perform { seconds, .. } => Some(*seconds),
            Self::Visit { .. } => None,
        }
    }
}

impl GroupConfig {
    /// True for agents, with or without bodies, which avoid each other.
    pub fn is_of_agents(&self) -> bool {
        self.motion == GroupMotion::None || self.motion == GroupMotion::Blend && self.paths.is_none()
    }

    /// Places of the level at which its people start, and to which they go; none for a group that is not on all floors.
    pub fn level_places(&self) -> [Option<&[String]>; 2] {
        let starts = if let Some(PlaceConfig::Level { names }) = &self.place { Some(&names[..]) } else { None };
        let goals = if let Some(GoalConfig::Level { names }) = &self.goal { Some(&names[..]) } else { None };
        [starts, goals]
    }

    /// Largest radius of its characters on the ground (m).
    pub fn largest_radius_m(&self) -> f32 {
        if self.motion == GroupMotion::Policy { BODY_RADIUS_M } else { self.radius_m[1] }
    }

    /// Name of the group in messages and pictures.
    pub fn title(&self, number: usize) -> String {
        if self.name.is_empty() { format!("group {number}") } else { self.name.clone() }
    }

    /// Sizes and proportions of its bodies.
    pub fn bodies(&self) -> BodiesConfig {
        let sizes = if self.paths.is_none() { [0.9, 1.05] } else { BodiesConfig::default().sizes };
        self.bodies.clone().unwrap_or(BodiesConfig { sizes, ..BodiesConfig::default() })
    }

    /// Value of the first style axis at a speed, scaled to the database skeleton (m/s).
    pub fn style_at(&self, speed: f32) -> f32 {
        let knots = &self.style_by_speed;
        let above = knots.partition_point(|k| k[0] <= speed);
        match (above.checked_sub(1).map(|i| knots[i]), knots.get(above)) {
            (Some(low), Some(high)) => low[1] + (speed - low[0]) / (high[0] - low[0]) * (high[1] - low[1]),
            (Some([_, end]), None) | (None, Some(&[_, end])) => end,
            (None, None) => 0.0,
        }
    }

    pub(super) fn stretch(&mut self, by: f32) {
        let of_source = self.source.iter_mut().filter_map(|source| source.place.as_mut());
        self.place.iter_mut().chain(of_source).for_each(|place| place.stretch(by));
        self.goal.iter_mut().for_each(|goal| goal.stretch(by));
        self.via.iter_mut().for_each(|p| scale_points(&mut [p], by));
    }
}
