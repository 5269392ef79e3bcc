//! Figures measured of a scene, and of each of its groups.

use super::{meter::GateFlow, watch::PartnerFigures};
use crate::touch::TouchFigures;
use serde::Serialize;

/// Figures of some characters. Keys that do not apply to them are left out. All parts make one object,
/// so that keys differ; scenes name them in `that.figure`. They are filled in `watch.rs`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct SceneFigures {
    /// Number of characters with policies, paths or worlds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub characters: Option<usize>,
    /// Number of agents that started.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub agents: Option<usize>,
    /// Engine that decided when agents act.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engine: Option<String>,
    /// Simulated time (s).
    pub simulated_s: f64,
    /// Steps of all characters per second of wall time on one thread: choices, control, poses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps_per_second: Option<f64>,
    /// Pairs of characters, or of a character and an agent, that overlapped at any time: discs around their roots, or
    /// capsules of trunk and head. Opponents are not counted, nor discs in worlds of several floors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub character_overlaps: Option<usize>,
    /// The deepest of these overlaps (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deepest_overlap_m: Option<f64>,
    /// Figures of characters with policies.
    #[serde(flatten)]
    pub blows: Option<BlowFigures>,
    /// Figures of opponents.
    #[serde(flatten)]
    pub touch: Option<TouchFigures>,
    /// Figures of characters in worlds that act together.
    #[serde(flatten)]
    pub partners: Option<PartnerFigures>,
    /// Figures of characters in worlds.
    #[serde(flatten)]
    pub world: Option<InhabitedFigures>,
    /// Figures of characters on random paths.
    #[serde(flatten)]
    pub paths: Option<FollowedPathFigures>,
    /// Figures of agents.
    #[serde(flatten)]
    pub crowd: Option<AgentFigures>,
    /// Figures of characters with policies on the way to goals, in a scene without agents; agents have these keys, too, and then
    /// count them with their own.
    #[serde(flatten)]
    pub travel: Option<TravelFigures>,
    /// Agents and characters with goals that ever stayed within half a metre for 10 s on their way, or did not come half a metre nearer to their goal in
    /// 20 s, and characters in worlds that stayed for 30 s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stuck: Option<usize>,
    /// Mean speed of planted heels and toes (m/s).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub foot_slip_mean_mps: Option<f64>,
    /// 95th percentile of the speed of planted heels and toes (m/s).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub foot_slip_p95_mps: Option<f64>,
    /// Hash of the state at the end, in hexadecimal, of all groups together: the same for the same scene on any number of threads.
    /// `bench crowd` hashes the engine of the agents alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state_hash: Option<String>,
}

/// Figures of characters with policies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BlowFigures {
    /// Blows that landed, a simulated minute and character.
    pub hits_per_minute: f64,
    /// Share of the blows thrown that landed.
    pub landed_fraction: f64,
    /// Share of the blows thrown that arms caught.
    pub blocked_fraction: f64,
    /// Blows thrown.
    pub thrown: u32,
    /// Deepest overlap of the cores of two opponents (m).
    pub max_penetration_m: f64,
    /// Share of the time in which pairs overlapped by more than a few centimetres.
    pub deep_fraction: f64,
    /// Distance over ground from the opponent or target, mean over time and characters (m).
    pub distance_mean_m: f64,
    /// The greatest such distance after the first 5 s; none where the run is no longer (m).
    pub distance_max_m: Option<f64>,
}

/// Figures of characters with policies on the way to goals.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct TravelFigures {
    /// Mean speed towards the goal, along the planned path, of characters that have not arrived (m/s).
    pub progress_mps: f64,
    /// Characters that at the end have stayed within half a metre for 10 s on their way, or not come half a metre nearer to their
    /// goal in 20 s.
    pub stuck_at_end: usize,
    /// Characters that reached their goal.
    pub arrived: usize,
    /// Share of those with a goal that reached it.
    pub reached: f64,
    /// Share of the time on their way in which they stood.
    pub stopped_share: f64,
}

/// Figures of characters in worlds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct InhabitedFigures {
    /// Times at which a character entered a unit by more than a few centimetres.
    pub environment_penetrations: u64,
    /// Deepest penetration of a unit (m).
    pub deepest_penetration_m: f64,
    /// Goals that were reached, a simulated minute and character.
    pub fulfilled_per_minute: f64,
    /// Distance over ground and up, a simulated minute and character, on average (m).
    pub travelled_m_per_minute: f64,
    /// Change of the path's direction from one half metre to the next, a metre over ground (deg).
    pub turned_deg_per_m: f64,
    /// Share of the time that was spent waiting for others.
    pub waiting_fraction: f64,
}

/// Figures of characters on random paths.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FollowedPathFigures {
    /// Mean speed of the paths (m/s).
    pub speed_mean_mps: f64,
    /// Greatest speed of a character (m/s).
    pub speed_max_mps: f64,
    /// Fastest change of a knee's angle (rad/s).
    pub knee_rate_max_radps: f64,
    /// Farthest that an ankle or toe joint was below the ground (m).
    pub below_ground_max_m: f64,
}

/// Figures of hands that take and put down things.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ThingFigures {
    /// Things that were taken.
    pub things_taken: u32,
    /// Things that were put down.
    pub things_put: u32,
    /// Times that an agent gave up, as it could not reach a thing or the place to put it.
    pub things_out_of_reach: u32,
    /// Distance of palms from things as they grip them, and from the places to put them down, 95th percentile, rounded up to
    /// 10 mm (m).
    pub hand_off_p95_m: f32,
    /// Largest distance of palms from things; 0.32 for anything farther (m).
    pub hand_off_max_m: f32,
}

/// Figures of agents. Keys about time and events are of all of them together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct AgentFigures {
    /// Wall time of the engine, and of bodies that follow agents, for one simulated second (s).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_s_per_simulated_s: Option<f64>,
    /// Time to make the crowd: its layout, paths and memory (s).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub setup_s: Option<f64>,
    /// Least, median and largest `us_per_agent_second` of all repeats (us).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub us_range: Option<[f64; 3]>,
    /// Wall time of the engine for one present agent and simulated second; in `bench crowd` the running time of the engine's
    /// thread, where the system reports it, so that other load counts little (us).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub us_per_agent_second: Option<f64>,
    /// Events of one agent in one simulated second; in the fixed engine, its steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub events_per_agent_second: Option<f64>,
    /// Events at which the bound of one agent entered or left cells; only the engine `occupancy` has such events.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crossings_per_agent_second: Option<f64>,
    /// Decisions of one agent in one simulated second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decisions_per_agent_second: Option<f64>,
    /// Pairs that overlapped by more than 1 mm, for one agent and frame at 30 Hz.
    pub overlap_over_1mm_fraction: f64,
    /// Pairs that overlapped by more than 1 cm, for one agent and frame at 30 Hz.
    pub overlap_over_1cm_fraction: f64,
    /// Deepest overlap of a pair, or of an agent and an obstacle (m).
    pub max_overlap_m: f64,
    /// Mean speed towards the goal, along the planned path, of agents that have not arrived (m/s).
    pub progress_mps: f64,
    /// Mean speed towards the goal in each ten seconds in which agents were on their way (m/s).
    pub progress_by_10s_mps: Vec<f64>,
    /// Agents that at the end have stayed within half a metre for 10 s on their way, or not come half a metre nearer to their
    /// goal in 20 s.
    pub stuck_at_end: usize,
    /// Mean desired speed, for comparison (m/s).
    pub desired_mps: f64,
    /// Agents that reached their goal.
    pub arrived: usize,
    /// Share of the agents that reached their goal.
    pub reached: f64,
    /// Share of the time on their way in which agents stood.
    pub stopped_share: f64,
    /// Agents that know of a happening, if the scene has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub informed: Option<usize>,
    /// Figures of hands, if the scene has things.
    #[serde(flatten)]
    pub things: Option<ThingFigures>,
    /// Order of lanes in the last quarter of the time that groups met: 0 as mixed as by chance, 1 all agents in lanes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lane_order: Option<f64>,
    /// Flow through the scene's gate.
    #[serde(flatten)]
    pub flow: Option<GateFlow>,
    /// Largest distance over ground of hips from the centre of their disc (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hips_off_max_m: Option<f64>,
}
