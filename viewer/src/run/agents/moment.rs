//! What is seen of a crowd: all agents at a step, and details of the selected one.

use super::bodies::SeenBodies;
use glam::Vec3;
use throng_precompute::scene::crowd::SeenObstacle;
use throng_runtime::Skeleton;

/// Terms of the force field, with the equation of Kim, Kim and Shin 2003a that says what they are.
pub const FORCE_TERMS: [(&str, &str); 6] = [
    ("driving", "Toward the desired velocity along the route (eq. 17)"),
    ("interaction", "Attraction and repulsion (eq. 17)"),
    ("decelerating", "Slows down toward obstacles ahead (eq. 19)"),
    ("damping", "Against approach (eq. 20)"),
    ("turning", "Sideways (eq. 22)"),
    ("safety", "To the centre of the bound (eq. 23)"),
];

/// What is seen of an agent, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenAgent {
    /// Its centre; y is 0 on the ground (m).
    pub at: Vec3,
    /// How it moves (m/s).
    pub velocity: Vec3,
    /// Centre of its time-varying bound (m).
    pub bound: Vec3,
    /// Radius of its time-varying bound (m).
    pub bound_radius: f32,
    /// It knows of something that happened from outside.
    pub knows: bool,
}

/// What was measured of all agents.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Agents that have not left.
    pub present: usize,
    /// Pairs that overlap by more than 1 mm now.
    pub overlaps: u64,
    /// Deepest overlap so far; zero or less if no agents have touched (m).
    pub deepest_m: f64,
    /// Mean speed toward the goal so far, along the planned way, of agents that had not arrived (m/s).
    pub progress_mps: f64,
    /// Agents that have reached their goal.
    pub arrived: usize,
    /// Agents that stayed within half a metre for 10 s on their way.
    pub stuck: usize,
}

/// More of one agent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Details {
    /// Whose.
    pub agent: usize,
    /// Terms of the force field, in the order of [`FORCE_TERMS`] (m/s2).
    pub forces: [Vec3; 6],
    /// The acceleration that was taken after the safety rule (m/s2).
    pub taken: Vec3,
    /// Its largest acceleration (m/s2).
    pub limit: f32,
    /// Its desired speed (m/s).
    pub speed: f32,
    /// Where it wants to go; zero at its goal.
    pub desired: Vec3,
    /// Way that is left (m).
    pub way_left: f32,
    /// Its last event, and its next one if nothing comes between (s).
    pub events: [f64; 2],
    /// Both ends of the way that its centre takes if it brakes (m).
    pub stop: [Vec3; 2],
    /// Lowest corner of the cell that it is registered in (m).
    pub cell: Vec3,
    /// Side of cells (m).
    pub cell_side: f32,
}

/// All of them at one step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrowdMoment {
    /// When (s).
    pub time_s: f64,
    /// All agents; `None` for one that has left (number of agents).
    pub agents: Vec<Option<SeenAgent>>,
    /// What was measured so far.
    pub figures: Figures,
    /// More of the one that was looked at then.
    pub details: Option<Details>,
    /// Bodies of the agents present; none if agents are discs or balls.
    pub bodies: Option<SeenBodies>,
}

/// What does not change while a scene runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cast {
    /// True in the air.
    pub in_the_air: bool,
    /// Names of groups.
    pub names: Vec<String>,
    /// Of each agent: its group.
    pub groups: Vec<usize>,
    /// Of each agent (m).
    pub radii: Vec<f32>,
    /// Of each agent: its desired speed at the start (m/s).
    pub speeds: Vec<f32>,
    /// Skeletons of bodies, which agents take in turn; empty where agents are discs or balls.
    pub skeletons: Vec<Skeleton>,
    /// What stands or moves in the way.
    pub obstacles: Vec<SeenObstacle>,
    /// A box around starts and goals (m).
    pub extents: [Vec3; 2],
    /// Bounds are registered in cells and have regions.
    pub has_regions: bool,
}
