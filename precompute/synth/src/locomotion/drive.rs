//! Steady movement over the ground.

use crate::side::{forward, leftward};
use glam::DVec2;

/// A constant velocity in the body's frame, and a constant turning rate: the path is a circular arc, a straight line or
/// a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drive {
    /// Speed to the left (m/s).
    pub left: f64,
    /// Speed ahead (m/s).
    pub ahead: f64,
    /// Turning rate, positive to the left (rad/s).
    pub gyration: f64,
}

impl Drive {
    /// Speed along the path (m/s).
    pub fn speed(&self) -> f64 {
        self.left.hypot(self.ahead)
    }

    /// Heading of the body at `t` seconds; 0 at time 0 (rad).
    pub fn heading_at(&self, t: f64) -> f64 {
        self.gyration * t
    }

    /// Position on the ground (x, z) at `t` seconds; the origin at time 0 (m).
    pub fn position_at(&self, t: f64) -> DVec2 {
        // The chord of an arc has the arc's mean direction.
        let half = 0.5 * self.gyration * t;
        let chord = if half.abs() < 1e-9 { t } else { t * half.sin() / half };
        (leftward(half) * self.left + forward(half) * self.ahead) * chord
    }

    /// Ground position of a point given in the body's frame at `t` seconds (m).
    pub fn point_at(&self, t: f64, left: f64, ahead: f64) -> DVec2 {
        let heading = self.heading_at(t);
        self.position_at(t) + leftward(heading) * left + forward(heading) * ahead
    }

    /// A ground point in the body's frame at `t` seconds: to the left, ahead (m).
    pub fn to_body_frame(self, t: f64, point: DVec2) -> DVec2 {
        let (heading, from) = (self.heading_at(t), point - self.position_at(t));
        DVec2::new(from.dot(leftward(heading)), from.dot(forward(heading)))
    }

    /// Acceleration towards the centre of the arc: to the left, ahead (m/s^2).
    pub fn centripetal_acceleration(&self) -> DVec2 {
        DVec2::new(self.ahead, -self.left) * self.gyration
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_place_is_the_integral_of_the_velocity(
            left in -1.0f64..1.0, ahead in -1.0f64..5.0, gyration in -1.5f64..1.5, t in -3.0f64..3.0,
        ) {
            let drive = Drive { left, ahead, gyration };
            const STEPS: i32 = 2000;
            let dt = t / f64::from(STEPS);
            let sum: DVec2 = (0..STEPS).map(|k| {
                let heading = drive.heading_at((f64::from(k) + 0.5) * dt);
                (leftward(heading) * left + forward(heading) * ahead) * dt
            }).sum();
            prop_assert!((drive.position_at(t) - sum).length() < 1e-5);
        }

        #[test]
        fn what_is_placed_is_seen_there(left in -1.0f64..1.0, ahead in -1.0f64..1.0, t in -3.0f64..3.0) {
            let drive = Drive { left: 0.3, ahead: 1.2, gyration: 0.8 };
            let seen = drive.to_body_frame(t, drive.point_at(t, left, ahead));
            prop_assert!((seen - DVec2::new(left, ahead)).length() < 1e-12);
        }

        #[test]
        fn the_pull_is_the_second_derivative(left in -1.0f64..1.0, ahead in -1.0f64..4.0, gyration in -1.0f64..1.0) {
            let drive = Drive { left, ahead, gyration };
            const H: f64 = 1e-3;
            let bend = (drive.position_at(H) + drive.position_at(-H)) / (H * H);
            prop_assert!((bend - drive.centripetal_acceleration()).length() < 1e-5);
        }
    }
}
