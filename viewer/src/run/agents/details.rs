//! Motion of an agent: its forces, its bound and its route.

use glam::Vec3;
use throng_crowd::{Crowd, Id};
use throng_simulation::{AnyCharacterGroup, Simulation};

/// Terms of the force field, with their equations in Kim, Kim and Shin 2003b, and colours on dark and on light ground.
pub const FORCE_TERMS: [(&str, &str, [u32; 2]); 6] = [
    ("driving", "Toward the desired velocity along the route (eq. 17)", [0x5fd068, 0x1d7a2a]),
    ("interaction", "Attraction and repulsion (eq. 17)", [0x59b4ff, 0x1763b0]),
    ("decelerating", "Slows down toward obstacles ahead (eq. 19)", [0xd98cff, 0x8a2fb8]),
    ("damping", "Against approach (eq. 20)", [0xff8a5c, 0xb8480f]),
    ("turning", "Sideways (eq. 22)", [0xffd84d, 0x8a6a00]),
    ("safety", "To the centre of the bound (eq. 23)", [0x4fe0d0, 0x0a7d72]),
];

/// More of one agent, in the world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AgentDetails {
    /// Velocity of the agent (m/s).
    pub velocity: Vec3,
    /// Radius of its body (m).
    pub radius: f32,
    /// Radius of its time-varying bound (m).
    pub bound_radius: f32,
    /// Terms of the force field, in the order of [`FORCE_TERMS`] (m/s2).
    pub forces: [Vec3; 6],
    /// The acceleration after the safety rule (m/s2).
    pub taken: Vec3,
    /// Largest acceleration of the agent (m/s2).
    pub limit: f32,
    /// Desired speed of the agent (m/s).
    pub speed: f32,
    /// Desired velocity; zero at its goal.
    pub desired: Vec3,
    /// Length of the route that is left (m).
    pub route_left: f32,
    /// Last event, and the next one if no other comes between (s).
    pub events: [f64; 2],
    /// Both ends of the path of the agent's centre when braking (m).
    pub stop: [Vec3; 2],
    /// Lowest corner of the agent's cell (m).
    pub cell: Vec3,
    /// Side of cells (m).
    pub cell_side: f32,
}

/// The engine of an agent, and its name there; none for other characters.
fn engine(simulation: &Simulation, who: usize) -> Option<(&Crowd, Id)> {
    match simulation.locate(who) {
        (AnyCharacterGroup::Ground(agents), member) => Some((agents.crowd(), agents.id(member)?)),
        (AnyCharacterGroup::Air(agents), member) => Some((agents.crowd(), agents.id(member)?)),
        _ => None,
    }
}

/// Centre and radius of the time-varying bound of an agent; none for other characters and after it has left (m).
pub fn agent_bound(simulation: &Simulation, who: usize) -> Option<(Vec3, f32)> {
    let (crowd, id) = engine(simulation, who)?;
    crowd.bound(id, crowd.time_s())
}

/// Details of an agent; none for other characters and after it has left.
pub fn agent_details(simulation: &Simulation, who: usize) -> Option<AgentDetails> {
    let (crowd, id) = engine(simulation, who)?;
    let (agent, f) = (crowd.agent(id)?, crowd.forces(id)?);
    let events = [crowd.last_event(id)?, crowd.next_event(id)?];
    let (from, to) = crowd.stop_region(id)?;
    // The agent was registered at the position of its last event.
    let (side, then) = (crowd.cell_side(), crowd.position(id, events[0])?);
    Some(AgentDetails {
        velocity: crowd.velocity(id, crowd.time_s())?,
        radius: agent.radius,
        bound_radius: crowd.bound(id, crowd.time_s())?.1,
        forces: [f.driving, f.interaction, f.decelerating, f.damping, f.turning, f.safety],
        taken: f.taken,
        limit: agent.acceleration,
        speed: agent.speed,
        desired: crowd.desired_direction(id)?,
        route_left: crowd.distance_left(id)?,
        events,
        stop: [from, to],
        cell: (then / side).floor() * side,
        cell_side: side,
    })
}
