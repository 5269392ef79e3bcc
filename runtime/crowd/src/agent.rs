//! Agents of a crowd.

use glam::Vec3;
use throng_base::thresholds::{AGENT_RADIUS_M, WALK_SPEED_MPS};

/// Agent as it enters the crowd.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agent<V = Vec3> {
    /// Centre (m).
    pub position: V,
    /// Velocity at the start (m/s, no longer than the largest speed).
    pub velocity: V,
    /// Radius of the disc or ball that no other agent enters (m, > 0).
    pub radius: f32,
    /// Largest acceleration, A in Kim, Kim and Shin (2003b), eq. 1: how fast it can speed up, turn and brake (m/s2, > 0).
    pub acceleration: f32,
    /// Desired speed, v_des in Kim, Kim and Shin (2003b), eq. 17 (m/s, >= 0).
    pub speed: f32,
    /// Number of its route in [`crate::CrowdSetup::routes`]. Without one it stays where it is until it has an order.
    pub route: Option<usize>,
    /// Number of its force field in [`crate::CrowdSetup::fields`].
    pub field: usize,
}

impl<V: Default> Default for Agent<V> {
    /// A pedestrian of average size at the origin, at rest.
    fn default() -> Self {
        Self::standing_at(V::default())
    }
}

impl<V: Default> Agent<V> {
    /// A pedestrian of average size, at rest: [`AGENT_RADIUS_M`], [`WALK_SPEED_MPS`], 5 m/s2.
    pub fn standing_at(position: V) -> Self {
        let (radius, speed) = (AGENT_RADIUS_M, WALK_SPEED_MPS);
        Self { position, velocity: V::default(), radius, acceleration: 5.0, speed, route: None, field: 0 }
    }
}

impl<V> Agent<V> {
    /// Converts it to another space.
    pub fn map<W>(self, f: impl Fn(V) -> W) -> Agent<W> {
        let Self { position, velocity, radius, acceleration, speed, route, field } = self;
        Agent { position: f(position), velocity: f(velocity), radius, acceleration, speed, route, field }
    }
}
