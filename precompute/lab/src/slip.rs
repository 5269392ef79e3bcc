//! Foot slip: how fast planted feet move.

use crate::histogram::Histogram;
use glam::{Quat, Vec3, Vec3Swizzles};
use throng_core::characters::{Characters, DetailLevel};
use throng_core::{Contacts, Joint, Skeleton};
use throng_motion::{annotate::contacts::FOOT_PARTS, stance::FEET};
use throng_simulation::Simulation;

/// Histogram of the speeds of planted feet, up to 4 m/s, in bins of 1 mm/s.
type SpeedHistogram = Histogram<1000, 4000>;

/// The bottom of the heel and the ball of the left and of the right foot, in the world (m).
pub type Soles = [[Vec3; 2]; 2];

/// Measures from step to step how fast planted feet move over the ground, by heels and balls of their soles.
#[derive(Clone, Debug)]
pub struct SlipMeter {
    /// Soles and contacts of each character at the last step.
    before: Vec<Option<(Soles, Contacts)>>,
    /// Bottoms of the heels of those that are observed by joints (m).
    heels: [Vec3; 2],
    speeds: SpeedHistogram,
}

impl SlipMeter {
    /// A meter for a number of characters with a skeleton.
    pub fn new(num_characters: usize, skeleton: &Skeleton) -> Self {
        let (before, speeds) = (vec![None; num_characters], SpeedHistogram::default());
        Self { before, heels: skeleton.heels(), speeds }
    }

    /// Observes one character after a step of `dt_s`; feet count that were planted before and still are.
    pub fn observe(&mut self, character: usize, dt_s: f32, contacts: Contacts, soles: Soles) {
        let Some((before, were)) = self.before[character].replace((soles, contacts)) else { return };
        let is_planted = |part: Contacts| dt_s > 0.0 && contacts.any(part) && were.any(part);
        for k in (0..FOOT_PARTS.len()).filter(|&k| is_planted(FOOT_PARTS[k].1)) {
            let moved_m = (soles[k / 2][k % 2] - before[k / 2][k % 2]).xz().length();
            self.speeds.add(moved_m / dt_s);
        }
    }

    /// Observes one character whose joints are there, as [`Self::observe`] does.
    ///
    /// - `joint`: its place and rotation in the world (m).
    pub fn observe_joints(&mut self, c: usize, dt_s: f32, contacts: Contacts, joint: impl Fn(Joint) -> (Vec3, Quat)) {
        let soles = [0, 1].map(|side| {
            let (ankle, turn) = joint(FEET[2 * side]);
            [ankle + turn * self.heels[side], joint(FEET[2 * side + 1]).0]
        });
        self.observe(c, dt_s, contacts, soles);
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
            let at = |j: Joint| (turn * pose[j.index()].translation() + by, turn * pose[j.index()].rotation());
            self.observe_joints(c, dt_s, characters.contacts(c), at);
        }
    }

    /// Observes characters of a simulation after a step, except those without bodies.
    pub fn observe_simulation(&mut self, sim: &Simulation, characters: impl Iterator<Item = usize>, dt_s: f32) {
        for c in characters {
            let (Some(root), Some(pose)) = (sim.root(c), sim.pose(c)) else { continue };
            let (turn, by) = (root.rotation(), root.translation());
            let at = |j: Joint| (turn * pose[j.index()].translation() + by, turn * pose[j.index()].rotation());
            match sim.soles(c) {
                Some(soles) => self.observe(c, dt_s, sim.contacts(c), soles),
                None => self.observe_joints(c, dt_s, sim.contacts(c), at),
            }
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
        let mut meter = SlipMeter::new(1, &Skeleton::default());
        for step in 0..3 {
            let at = |v: Vec3| v * (0.1 * step as f32);
            meter.observe(0, 0.1, contacts, [[at(heel), at(ball)], [at(Vec3::X * 9.0); 2]]);
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
    fn an_ankle_moves_where_a_foot_rolls_over_its_ball_and_does_not_slip() {
        let skeleton = Skeleton::default();
        let mut meter = SlipMeter::new(1, &skeleton);
        let (ball, along) = (Vec3::new(0.1, 0.02, 3.0), skeleton.offsets[Joint::LeftToe.index()]);
        for step in 0..10 {
            let turn = Quat::from_rotation_x(0.05 * step as f32);
            let at = |j: Joint| if j == Joint::LeftToe { (ball, turn) } else { (ball - turn * along, turn) };
            meter.observe_joints(0, 0.1, Contacts::LEFT_TOE, at);
        }
        assert!(meter.samples() == 9 && meter.p95_mps() < 1e-3, "{} m/s", meter.p95_mps());
    }

    #[test]
    fn steps_that_are_no_neighbours_do_not_count() {
        let mut meter = slip(Vec3::X, Vec3::X, Contacts::LEFT);
        meter.forget_step();
        meter.observe(0, 0.1, Contacts::LEFT, Soles::default());
        assert_eq!(meter.samples(), 4);
    }
}
