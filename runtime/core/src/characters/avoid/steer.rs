//! Steering: the direction that turns least from the target and does not run into others soon.

use super::AvoidConfig;
use crate::{reserve::PathReservations, stops::BODY_RADIUS_M};
use glam::Vec2;
use throng_base::maths;
use throng_geometry::{Bounds2d, Capsule2d, distance_to_segment};

/// Directions that are weighed, to the left of the target (rad): both sides, less and less towards it.
const TURNS: [f32; 13] = [0.0, -0.2, 0.2, -0.4, 0.4, -0.65, 0.65, -0.95, 0.95, -1.3, 1.3, -1.8, 1.8];
/// Directions that are tried, best first.
pub const NUM_DIRECTIONS: usize = 4;
/// Cost of an immediate collision, as a turn (rad).
const COLLISION: f32 = 3.0;
/// Advantage of a turn to the right, so that two that meet pass on the same side (rad).
const RIGHT: f32 = 0.05;
/// Distance to the target below which a character does not turn aside (m).
const NEAR_M: f32 = 0.3;
/// Most others that are weighed; paths are tested against all.
const OTHERS: usize = 32;

/// The character that chooses, and its target.
pub struct SteeringQuery<'a> {
    pub number: usize,
    /// Position of the character (m).
    pub place: Vec2,
    /// Target (m).
    pub target: Vec2,
    /// Speed of a walking character (m/s).
    pub speed_mps: f32,
    /// Time since its choice (s).
    pub ago_s: f32,
    /// Ground of all others.
    pub book: &'a PathReservations,
    pub config: &'a AvoidConfig,
}

/// Another, as seen from the chooser.
#[derive(Clone, Copy, Default)]
struct NearbyCharacter {
    number: u32,
    place: Vec2,
    velocity: Vec2,
    reach_m: f32,
}

/// [`TURNS`], with the sine and cosine of each.
pub type Turns = [(f32, Vec2); TURNS.len()];

/// All candidate directions.
pub fn candidate_turns() -> Turns {
    TURNS.map(|turn| (turn, Vec2::new(maths::sin(turn), maths::cos(turn))))
}

impl SteeringQuery<'_> {
    /// Turns from the target to try, best first (rad); the first is 0 where nothing is in front.
    pub fn ranked_directions(&self, turns: &Turns) -> [f32; NUM_DIRECTIONS] {
        let offset = self.target - self.place;
        let distance = offset.length();
        let mut costs = turns.map(|(turn, _)| (turn.abs() + if turn > 0.0 { RIGHT } else { 0.0 }, turn));
        if distance > NEAR_M && self.config.horizon_s > 0.0 {
            let others = &mut [NearbyCharacter::default(); OTHERS];
            let num = self.gather_nearby(others);
            let horizon = self.config.horizon_s.min(distance / self.speed_mps);
            for ((cost, _), (_, Vec2 { x: sin, y: cos })) in costs.iter_mut().zip(turns) {
                // The left of the direction is towards +X where +Z is ahead.
                let ahead = Vec2::new(offset.x * cos + offset.y * sin, offset.y * cos - offset.x * sin) / distance;
                let velocity = ahead * self.speed_mps;
                let soonest = others[..num].iter().map(|o| time_to(o, velocity)).fold(f32::INFINITY, f32::min);
                let soonest = soonest.min(self.walls_ahead(velocity));
                if soonest < horizon {
                    *cost += COLLISION * (1.0 - soonest / self.config.horizon_s);
                }
            }
        }
        // Stable, so that equal costs keep their order.
        costs.sort_by(|a, b| a.0.total_cmp(&b.0));
        std::array::from_fn(|i| costs[i].1)
    }

    /// Others within reach of the horizon, by number; the nearest where there are many.
    fn gather_nearby(&self, out: &mut [NearbyCharacter; OTHERS]) -> usize {
        let reach = 2.0 * BODY_RADIUS_M + self.config.room_m + self.speed_mps * self.config.horizon_s;
        let mut num = 0;
        let mut add = |number: u32, now: Vec2, velocity: Vec2, radius_m: f32| {
            // A character that stands beside the target does not block the way to it.
            let most = if velocity == Vec2::ZERO { 0.95 * now.distance(self.target) } else { f32::INFINITY };
            let reach_m = (BODY_RADIUS_M + radius_m + self.config.room_m).min(most);
            let o = NearbyCharacter { number, place: now - self.place, velocity, reach_m };
            let key = |o: &NearbyCharacter| (o.place.length_squared(), o.number);
            if num < OTHERS {
                out[num] = o;
                num += 1;
            } else if let Some(farthest) =
                out.iter_mut().max_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal))
                && key(&o) < key(farthest)
            {
                *farthest = o;
            }
        };
        let around = Bounds2d::around_disc(self.place, reach);
        let own = self.book.path(self.number);
        self.book.for_each_near(self.number, &around, |other| {
            let mut moving = self.book.path(other);
            if moving.is_on_other_floors(&own) {
                return true;
            }
            moving.elapsed_s -= self.ago_s;
            add(other as u32, moving.position_now(), self.book.velocity(other), BODY_RADIUS_M);
            true
        });
        self.book.external_obstacles.visit_bodies_near(&around, |number, other| {
            add(u32::MAX - number as u32, other.place, other.velocity, other.radius_m);
            true
        });
        num
    }

    /// Time until a wall is hit (s), sampled at a few points ahead.
    fn walls_ahead(&self, velocity: Vec2) -> f32 {
        const PLACES: usize = 4;
        let heights_m = self.book.path(self.number).heights_m;
        let is_near = |place: Vec2| {
            let gap = |w: &Capsule2d| distance_to_segment(place, [w.from, w.to]) - w.radius_m;
            let around = Bounds2d::around_disc(place, BODY_RADIUS_M);
            self.book.meets_wall(&around, heights_m, |w| gap(w) < BODY_RADIUS_M)
        };
        if self.book.walls().next().is_none() {
            return f32::INFINITY;
        }
        let times = (1..=PLACES).map(|k| self.config.horizon_s * k as f32 / (2 * PLACES) as f32);
        let meets = |t: &f32| is_near(self.place + velocity * *t);
        times.into_iter().find(meets).unwrap_or(f32::INFINITY)
    }
}

/// Time until two that keep their velocities collide; infinite where they do not (s).
fn time_to(other: &NearbyCharacter, velocity: Vec2) -> f32 {
    let (place, velocity) = (other.place, other.velocity - velocity);
    let gap = place.length_squared() - other.reach_m * other.reach_m;
    let approach = -place.dot(velocity);
    if approach <= 0.0 {
        return f32::INFINITY;
    }
    if gap <= 0.0 {
        // Nearer than one would like already, and getting nearer.
        return 0.0;
    }
    let speed = velocity.length_squared();
    let root = approach * approach - speed * gap;
    if root < 0.0 { f32::INFINITY } else { (approach - root.sqrt()) / speed }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_to_collisions_are_those_of_hand_solved_cases() {
        let other =
            NearbyCharacter { number: 0, place: Vec2::new(0.0, 4.0), velocity: Vec2::new(0.0, -1.0), reach_m: 1.0 };
        assert!((time_to(&other, Vec2::new(0.0, 2.0)) - 1.0).abs() < 1e-6);
        assert_eq!(time_to(&other, Vec2::new(0.0, -2.0)), f32::INFINITY);
        assert_eq!(time_to(&other, Vec2::new(3.0, 0.0)), f32::INFINITY);
    }
}
