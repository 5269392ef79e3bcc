//! Random curved paths that never jump.

use crate::scene::PathsConfig;
use glam::Vec2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};
use std::f32::consts::PI;
use throng_base::maths;
use throng_core::{planar::wrap_angle, walkers::Control};

/// Largest angular acceleration (rad/s^2).
const TURNING_ACCELERATION: f32 = 4.0;

/// A random path: speed and turning rate are drawn anew from time to time and approached at bounded rates.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct RandomPath {
    rng: Pcg64Mcg,
    /// Position relative to the centre of the square (m).
    position: Vec2,
    heading: f32,
    pub speed: f32,
    gyration: f32,
    /// Speed and turning rate that are approached.
    aim: [f32; 2],
    /// Time until they are drawn anew (s).
    left_s: f32,
}

impl RandomPath {
    /// Path that begins with a stand at a random place of the square.
    pub fn new(config: &PathsConfig, seed: u64, who: u64) -> Self {
        let mut rng = Pcg64Mcg::seed_from_u64(seed ^ who.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        let half = 0.5 * config.area_m;
        let position = Vec2::new(rng.random_range(-half..half), rng.random_range(-half..half));
        let heading = rng.random_range(-PI..PI);
        Self { rng, position, heading, speed: 0.0, gyration: 0.0, aim: [0.0; 2], left_s: 0.0 }
    }

    /// Advances the path by `dt_s`. The style is left at 0.
    pub fn step(&mut self, config: &PathsConfig, dt_s: f32) -> Control {
        self.left_s -= dt_s;
        if self.left_s <= 0.0 {
            self.draw_aim(config);
        }
        let home =
            self.position + Vec2::new(maths::sin(self.heading), maths::cos(self.heading)) * (1.0 + 2.0 * self.speed);
        let [speed, mut gyration] = self.aim;
        if home.abs().max_element() > 0.5 * config.area_m {
            // Back towards the middle.
            let off = wrap_angle(maths::atan2(-self.position.x, -self.position.y) - self.heading);
            gyration = off.clamp(-1.0, 1.0) * config.max_gyration;
        }
        let bound = config.max_gyration.min(config.sideways / self.speed.max(0.1));
        self.speed += (speed - self.speed).clamp(-config.acceleration * dt_s, config.acceleration * dt_s);
        let change = TURNING_ACCELERATION * dt_s;
        self.gyration += (gyration.clamp(-bound, bound) - self.gyration).clamp(-change, change);
        self.heading = wrap_angle(self.heading + self.gyration * dt_s);
        let velocity = Vec2::new(maths::sin(self.heading), maths::cos(self.heading)) * self.speed;
        self.position += velocity * dt_s;
        Control {
            position: Some(self.position + Vec2::from(config.centre)),
            velocity,
            heading: Some(self.heading),
            turning_rate: Some(self.gyration),
            ..Control::default()
        }
    }

    /// False for a state that no path can have.
    pub fn is_valid(&self) -> bool {
        let Self { rng: _, position, heading, speed, gyration, aim, left_s } = self;
        let all = [position.x, position.y, *heading, *speed, *gyration, aim[0], aim[1], *left_s];
        all.iter().all(|v| v.abs() < 1e5)
    }

    fn draw_aim(&mut self, config: &PathsConfig) {
        let draw = |rng: &mut Pcg64Mcg, [low, high]: [f32; 2]| low + (high - low) * rng.random_range(0.0..1.0f32);
        self.left_s = draw(&mut self.rng, config.seconds);
        let stands = self.rng.random_range(0.0..1.0f32) < config.standing;
        let speed = draw(&mut self.rng, config.speeds);
        let turn = draw(&mut self.rng, [-1.0, 1.0]);
        // Mostly nearly straight, now and then a sharp turn.
        let gyration = turn * turn.abs() * config.max_gyration;
        self.aim = if stands { [0.0; 2] } else { [speed, gyration] };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(control: &Control) -> Vec2 {
        control.position.expect("a place")
    }

    #[test]
    fn wanderers_keep_to_their_square_and_to_their_bounds() {
        let config = PathsConfig { area_m: 40.0, ..PathsConfig::default() };
        let dt = 1.0 / 60.0;
        let (mut fastest, mut stood) = (0.0f32, false);
        for who in 0..20 {
            let mut w = RandomPath::new(&config, 7, who);
            let mut last = w.step(&config, dt);
            for _ in 0..6000 {
                let now = w.step(&config, dt);
                assert!(at(&now).abs().max_element() < 26.0, "{now:?}");
                assert!((now.velocity - last.velocity).length() < (config.acceleration + 9.0) * dt);
                assert!(((at(&now) - at(&last)) / dt - now.velocity).length() < 1e-2);
                fastest = fastest.max(now.velocity.length());
                stood |= now.velocity == Vec2::ZERO;
                last = now;
            }
        }
        assert!(fastest > 4.5 && fastest < 5.01 && stood, "{fastest}");
    }
}
