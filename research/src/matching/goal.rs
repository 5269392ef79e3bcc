//! Where a character wants to go, as a trajectory to look for.

use super::features::AHEAD_S;
use glam::{Vec2, Vec3};

/// Time in which the way to the wanted speed, or to the wanted direction, halves (s).
const HALF_LIFE_S: f32 = 0.25;
/// Time before arrival from which on a character slows down (s).
const SLOW_S: f32 = 0.5;

/// What a character wants, in its own frame: +Z ahead, +X left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchGoal {
    /// Where to stand: x, z (m).
    pub place: Vec2,
    /// Where to look from there: x, z (m).
    pub look: Vec2,
    /// How fast to go at most (m/s, >= 0).
    pub speed_mps: f32,
    /// Where to strike, and in what time; none where nothing is in reach (m, s).
    pub hit: Option<(Vec3, f32)>,
}

impl MatchGoal {
    /// Root positions and facing directions at the moments that are compared.
    ///
    /// - `velocity`: of the root now: x, z (m/s).
    ///
    /// # Source
    /// D. Holden, "Spring-It-On: The Game Developer's Spring-Roll-Call", 2021: critically damped velocity and angle.
    pub fn trajectory(&self, velocity: Vec2) -> ([Vec2; 3], [Vec2; 3]) {
        let damping = 2.0 * std::f32::consts::LN_2 / HALF_LIFE_S;
        let distance = self.place.length();
        let slowed = self.speed_mps.min(distance / SLOW_S);
        let goal = self.place.normalize_or_zero() * slowed;
        let off = velocity - goal;
        let change = off * damping;
        let place = |t: f32| {
            let e = (-damping * t).exp();
            let spring = -change / (damping * damping) - (off + change * t) / damping;
            let at = e * spring + change / (damping * damping) + off / damping + goal * t;
            // Nobody wants to run past the place.
            let past = at.dot(self.place.normalize_or_zero()) - distance;
            if past > 0.0 { at - self.place.normalize_or_zero() * past } else { at }
        };
        let path = AHEAD_S.map(place);
        let mut facing = [Vec2::Y; 3];
        for (t, facing) in AHEAD_S.into_iter().zip(&mut facing) {
            let turned = 1.0 - (-damping * t).exp() * (1.0 + damping * t);
            let angle = self.look.x.atan2(self.look.y) * turned;
            *facing = Vec2::new(angle.sin(), angle.cos());
        }
        (path, facing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_up_to_speed_and_turns_towards_the_target() {
        let goal = MatchGoal { place: Vec2::new(0.0, 10.0), look: Vec2::new(10.0, 0.0), speed_mps: 1.5, hit: None };
        let (path, facing) = goal.trajectory(Vec2::ZERO);
        // As many steps of the spring's own law: the velocity's acceleration is critically damped.
        let damping = 2.0 * std::f64::consts::LN_2 / f64::from(HALF_LIFE_S);
        let (mut p, mut v, mut a, dt) = (0.0f64, 0.0f64, 0.0f64, 1e-5);
        for _ in 0..100_000 {
            p += v * dt;
            v += a * dt;
            a += (damping * damping * (1.5 - v) - 2.0 * damping * a) * dt;
        }
        assert!((f64::from(path[2].y) - p).abs() < 1e-3 && path[2].x == 0.0, "{path:?} {p}");
        assert!(facing[0].x < facing[1].x && facing[2].x > 0.9, "{facing:?}");
    }

    #[test]
    fn stops_where_it_wants_to_stand() {
        let goal = MatchGoal { place: Vec2::new(0.1, 0.0), look: Vec2::Y, speed_mps: 1.5, hit: None };
        let (path, _) = goal.trajectory(Vec2::new(1.5, 0.0));
        assert!(path.iter().all(|p| p.x <= 0.1 + 1e-6), "{path:?}");
        let still = MatchGoal { place: Vec2::ZERO, ..goal };
        assert_eq!(still.trajectory(Vec2::ZERO).0, [Vec2::ZERO; 3]);
    }
}
