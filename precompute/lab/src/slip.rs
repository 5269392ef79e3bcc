//! Foot slip: how fast planted feet move.

use crate::histogram::Histogram;
use glam::{Vec3, Vec3Swizzles};
use throng_core::characters::{Characters, DetailLevel};
use throng_core::{Contacts, Joint};
use throng_motion::annotate::contacts::FOOT_PARTS;
use throng_simulation::Simulation;

/// Histogram of the speeds of planted feet, up to 4 m/s, in bins of 1 mm/s.
type SpeedHistogram = Histogram<1000, 4000>;

/// The bottom of the heel and the ball of the left and of the right foot, in the world (m).
pub type Soles = [[Vec3; 2]; 2];

/// Feet of one character, in the world (m).
#[derive(Clone, Copy, Debug)]
pub enum Feet {
    /// Joints: left foot and toe, right foot and toe; each counts on its own.
    Joints([Vec3; 4]),
    /// Rolling soles: heel and ball each count over the ground while they are planted.
    Soles(Soles),
}

impl Feet {
    /// Feet from their joints.
    ///
    /// - `at`: position of a joint in the world (m).
    pub fn joints(at: impl Fn(Joint) -> Vec3) -> Self {
        Self::Joints(FOOT_PARTS.map(|(joint, _)| at(joint)))
    }
}

/// Measures from step to step how fast planted feet move.
#[derive(Clone, Debug)]
pub struct SlipMeter {
    /// Feet and contacts of each character at the last step.
    before: Vec<Option<(Feet, Contacts)>>,
    speeds: SpeedHistogram,
}

impl SlipMeter {
    /// A meter for a number of characters.
    pub fn new(num_characters: usize) -> Self {
        Self { before: vec![None; num_characters], speeds: SpeedHistogram::default() }
    }

    /// Observes one character after a step of `dt_s`; feet count that were planted before and still are.
    pub fn observe(&mut self, character: usize, dt_s: f32, contacts: Contacts, feet: Feet) {
        let Some((before, were)) = self.before[character].replace((feet, contacts)) else { return };
        let is_planted = |part: Contacts| dt_s > 0.0 && contacts.any(part) && were.any(part);
        for k in (0..FOOT_PARTS.len()).filter(|&k| is_planted(FOOT_PARTS[k].1)) {
            let moved_m = match (before, feet) {
                (Feet::Joints(was), Feet::Joints(now)) => (now[k] - was[k]).length(),
                (Feet::Soles(was), Feet::Soles(now)) => (now[k / 2][k % 2] - was[k / 2][k % 2]).xz().length(),
                _ => continue,
            };
            self.speeds.add(moved_m / dt_s);
        }
    }

    /// Observes all characters with policies after a step, except those whose feet are not locked at their level of detail.
    pub fn observe_characters(&mut self, characters: &Characters, dt_s: f32) {
        for c in 0..self.before.len() {
            if characters.level(c) != DetailLevel::Full {
                self.before[c] = None;
                continue;
            }
            let (root, pose) = (characters.root(c), characters.pose(c));
            let (turn, by) = (root.rotation(), root.translation());
            let feet = Feet::joints(|j| turn * pose[j.index()].translation() + by);
            self.observe(c, dt_s, characters.contacts(c), feet);
        }
    }

    /// Observes characters of a simulation after a step, except those without bodies.
    pub fn observe_simulation(&mut self, sim: &Simulation, characters: impl Iterator<Item = usize>, dt_s: f32) {
        for c in characters {
            let (Some(root), Some(pose)) = (sim.root(c), sim.pose(c)) else { continue };
            let (turn, by) = (root.rotation(), root.translation());
            let joints = || Feet::joints(|j| turn * pose[j.index()].translation() + by);
            self.observe(c, dt_s, sim.contacts(c), sim.soles(c).map_or_else(joints, Feet::Soles));
        }
    }

    /// Forgets the last step, as the next one does not follow it.
    pub fn forget_step(&mut self) {
        self.before.fill(None);
    }

    /// Clears the measurements, but keeps the last step.
    pub fn clear(&mut self) {
        self.speeds = SpeedHistogram::default();
    }

    /// True if the last step had feet.
    pub fn has_seen_feet(&self) -> bool {
        self.before.iter().any(Option::is_some)
    }

    /// Number of measured planted parts.
    pub fn samples(&self) -> u64 {
        self.speeds.num
    }

    /// Mean speed (m/s).
    pub fn mean_mps(&self) -> f64 {
        self.speeds.mean()
    }

    /// 95th percentile of the speed (m/s).
    pub fn p95_mps(&self) -> f64 {
        self.speeds.middle_quantile(0.95)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slip of a left foot whose heel and ball move so fast; the right one is always in the air.
    fn slip(heel: Vec3, ball: Vec3, contacts: Contacts) -> SlipMeter {
        let mut meter = SlipMeter::new(1);
        for step in 0..3 {
            let at = |v: Vec3| v * (0.1 * step as f32);
            meter.observe(0, 0.1, contacts, Feet::Soles([[at(heel), at(ball)], [at(Vec3::X * 9.0); 2]]));
        }
        meter
    }

    #[test]
    fn each_end_of_a_foot_counts_while_it_is_planted() {
        let sliding = slip(Vec3::X * 0.2, Vec3::Z * 0.3, Contacts::LEFT);
        assert_eq!(sliding.samples(), 4);
        assert!((sliding.mean_mps() - 0.25).abs() < 1e-6 && (sliding.p95_mps() - 0.3).abs() < 1e-3);
        assert!(slip(Vec3::X, Vec3::ZERO, Contacts::LEFT_TOE).p95_mps() < 1e-3, "it turns over its ball");
        assert!(slip(Vec3::ZERO, Vec3::Y, Contacts::LEFT).p95_mps() < 1e-3, "what rises does not slip");
        assert_eq!(slip(Vec3::X, Vec3::X, Contacts::RIGHT_HEEL).samples(), 2);
        assert_eq!(slip(Vec3::X, Vec3::X, Contacts::NONE).samples(), 0);
    }

    #[test]
    fn steps_that_are_no_neighbours_do_not_count() {
        let mut meter = slip(Vec3::X, Vec3::X, Contacts::LEFT);
        meter.forget_step();
        meter.observe(0, 0.1, Contacts::LEFT, Feet::Soles(Soles::default()));
        assert_eq!(meter.samples(), 4);
    }
}
