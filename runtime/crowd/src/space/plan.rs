//! Plan of an agent until its next event: a parabola through space.

use crate::Space;
use serde::{Deserialize, Serialize};

/// Motion of one agent from the event at which it was planned to the one that ends it, as agents near it may rely on.
///
/// The acceleration is constant; where the agent brakes to rest, until it stands. All others keep out of the
/// [`MotionPlan::stop_region`] that it has until `end`, see [`crate::safety::rule`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct MotionPlan<V> {
    /// Event at which it was taken (s).
    pub start: f64,
    /// Latest time at which the agent acts (s).
    pub end: f64,
    /// Position at the start (m).
    pub position: V,
    /// Velocity at the start (m/s).
    pub velocity: V,
    /// Acceleration until it stands (m/s2).
    pub acceleration: V,
    /// Time from the start after which it stands (s).
    pub moving: f32,
    /// Radius of its disc or ball (m).
    pub radius: f32,
    /// Largest acceleration (m/s2).
    pub limit: f32,
    /// Number of its agent.
    pub index: u32,
}

impl<V: Space> MotionPlan<V> {
    /// Position and velocity, `after` seconds from the start.
    #[inline]
    pub fn motion_after(&self, after: f32) -> (V, V) {
        let dt = after.min(self.moving);
        let velocity = if after < self.moving { self.velocity + self.acceleration * dt } else { V::default() };
        (self.position + (self.velocity + self.acceleration * (0.5 * dt)) * dt, velocity)
    }

    /// Position and velocity at a time, not before the start.
    #[inline]
    pub fn motion_at(&self, time: f64) -> (V, V) {
        self.motion_after((time - self.start) as f32)
    }

    /// Brakes from here on with all its force.
    pub fn brake(&mut self) {
        let speed = self.velocity.length();
        self.moving = speed / self.limit;
        self.acceleration = if speed > 0.0 { self.velocity * -(self.limit / speed) } else { V::default() };
    }

    /// Ends of the way of its centre if it brakes with all its force, `after` seconds from the start: with the radius
    /// around it, the stop region.
    #[inline]
    pub fn stop_region(&self, after: f32) -> (V, V) {
        let (x, v) = self.motion_after(after);
        (x, stopping_point(x, v, self.limit))
    }
}

/// Point at which an agent that brakes with all its force comes to rest.
#[inline]
pub(crate) fn stopping_point<V: Space>(position: V, velocity: V, limit: f32) -> V {
    position + velocity * (velocity.length() * 0.5 / limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn braking_ends_where_the_stop_region_says() {
        let mut plan = MotionPlan {
            position: Vec2::new(1.0, 2.0),
            velocity: Vec2::new(1.2, -0.5),
            limit: 5.0,
            radius: 0.3,
            end: 1.0,
            ..MotionPlan::default()
        };
        let end = stopping_point(plan.position, plan.velocity, plan.limit);
        plan.brake();
        let (x, v) = plan.motion_after(2.0);
        assert!((x - end).length() < 1e-6 && v == Vec2::ZERO, "{x} {end}");
        for i in 0..20 {
            let (from, to) = plan.stop_region(i as f32 * 0.02);
            assert!((to - end).length() < 1e-5, "the end of the stop region stays, {to}");
            assert!((from - plan.position).length() <= (end - plan.position).length() + 1e-6);
        }
    }
}
