//! What is seen of a crowd: everybody at a step, and more of the one that is looked at.

use super::bodies::SeenBodies;
use glam::Vec3;
use throng_precompute::scene::crowd::SeenObstacle;
use throng_runtime::Skeleton;

/// Terms of the force field, with the equation of Kim, Kim and Shin 2003 that says what they are.
pub const FORCE_TERMS: [(&str, &str); 6] = [
    ("driving", "Toward the desired velocity along the route (eq. 17)"),
    ("interaction", "Attraction and repulsion (eq. 17)"),
    ("decelerating", "Takes back the driving force toward what is near (eq. 19)"),
    ("damping", "Against approach (eq. 20)"),
    ("turning", "Sideways (eq. 22)"),
    ("safety", "To the centre of the bound (eq. 23)"),
];

/// What is seen of a member, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenMember {
    /// Its centre; y is 0 on the ground. [Unit: m]
    pub at: Vec3,
    /// How it moves. [Unit: m/s]
    pub velocity: Vec3,
    /// Centre of its time-varying bound. [Unit: m]
    pub bound: Vec3,
    /// Radius of its time-varying bound. [Unit: m]
    pub bound_radius: f32,
    /// It knows of something that happened from outside.
    pub knows: bool,
}

/// What was measured of everybody.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Members that have not left.
    pub present: usize,
    /// Pairs that overlap by more than 1 mm now.
    pub overlaps: u64,
    /// Deepest overlap so far; zero or less where nobody has touched another. [Unit: m]
    pub deepest_m: f64,
    /// Mean speed toward the goal so far, along the planned way, of those who were not there. [Unit: m/s]
    pub progress_mps: f64,
    /// Members that have reached their goal.
    pub arrived: usize,
    /// Members that stayed within half a metre for 10 s on their way.
    pub stuck: usize,
}

/// More of one member.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Details {
    /// Whose.
    pub member: usize,
    /// Terms of the force field, in the order of [`FORCE_TERMS`]. [Unit: m/s2]
    pub forces: [Vec3; 6],
    /// The acceleration that was taken after the safety rule. [Unit: m/s2]
    pub taken: Vec3,
    /// Its largest acceleration. [Unit: m/s2]
    pub limit: f32,
    /// Its desired speed. [Unit: m/s]
    pub speed: f32,
    /// Where it wants to go; zero at its goal.
    pub desired: Vec3,
    /// Way that is left. [Unit: m]
    pub way_left: f32,
    /// Its last event, and its next one if nothing comes between. [Unit: s]
    pub events: [f64; 2],
    /// Both ends of the way that its centre takes if it brakes. [Unit: m]
    pub stop: [Vec3; 2],
    /// Lowest corner of the cell that it is registered in. [Unit: m]
    pub cell: Vec3,
    /// Side of cells. [Unit: m]
    pub cell_side: f32,
}

/// Everybody at one step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrowdMoment {
    /// When. [Unit: s]
    pub time_s: f64,
    /// Everybody; `None` where one has left. [Size: number of members]
    pub members: Vec<Option<SeenMember>>,
    /// What was measured so far.
    pub figures: Figures,
    /// More of the one that was looked at then.
    pub details: Option<Details>,
    /// Bodies of those who are there; none where members are discs or balls.
    pub bodies: Option<SeenBodies>,
}

/// What does not change while a scene runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cast {
    /// True in the air.
    pub in_the_air: bool,
    /// Names of groups.
    pub names: Vec<String>,
    /// Of each member: its group.
    pub groups: Vec<usize>,
    /// Of each member. [Unit: m]
    pub radii: Vec<f32>,
    /// Of each member: its desired speed at the start. [Unit: m/s]
    pub speeds: Vec<f32>,
    /// Skeletons of bodies, which members take in turn; empty where members are discs or balls.
    pub skeletons: Vec<Skeleton>,
    /// What stands or moves in the way.
    pub obstacles: Vec<SeenObstacle>,
    /// A box around starts and goals. [Unit: m]
    pub extents: [Vec3; 2],
    /// Bounds are registered in cells and have regions.
    pub has_regions: bool,
}
