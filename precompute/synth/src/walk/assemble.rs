//! Assembles the parts of the walker, sample by sample, into a clip.

use super::arms::{self, ArmInput};
use super::footsteps::Footsteps;
use super::pelvis::{self, Pelvis, PelvisInput};
use super::trunk::{self, Drift};
use crate::attitude::{Attitude, Trunk};
use crate::frame::{self, ArmPose, BodyPose, Samples};
use crate::signal::{interpolate, smooth};
use crate::{SynthConfig, foot::FootPose, side::forward_direction};
use glam::{DQuat, DVec2, DVec3};
use rand::{Rng, RngExt};
use throng_core::{Contacts, Planar, Skeleton, planar::wrap_angle};
use throng_motion::clip::Clip;

/// All signals of a clip at the working rate.
pub struct ClipSignals {
    pub feet: Vec<[FootPose; 2]>,
    pub pelvis: Pelvis,
    pub trunk: Vec<Trunk>,
    pub arms: Vec<[ArmPose; 2]>,
}

/// Makes a clip from its footsteps.
pub fn clip(name: String, steps: &Footsteps, skeleton: &Skeleton, cfg: &SynthConfig, rng: &mut impl Rng) -> Clip {
    let samples = Samples::for_clip(steps.duration, cfg.rate_hz);
    let signals = ClipSignals::new(steps, skeleton, &samples, cfg.variation, rng, |_, _| {}, |_| {});
    let mut clip = frame::empty_clip(name, "walk", cfg);
    for i in samples.frames() {
        frame::push_pose(&mut clip, &signals.pose(i), Contacts::NONE, skeleton);
    }
    clip
}

impl ClipSignals {
    /// Signals of a body over its feet.
    ///
    /// - `move_hips`: moves the pelvis before the trunk balances over it.
    /// - `bend`: bends the trunk before the arms swing at it.
    pub fn new(
        steps: &Footsteps,
        skeleton: &Skeleton,
        samples: &Samples,
        variation: f64,
        rng: &mut impl Rng,
        move_hips: impl FnOnce(&mut Pelvis, &PelvisInput),
        bend: impl FnOnce(&mut [Trunk]),
    ) -> Self {
        let dt = samples.dt;
        let input = PelvisInput::new(steps, skeleton, samples);
        let speed = speed(&input.mass, dt);
        let mut pelvis = pelvis::follow_feet(&input, &speed);
        move_hips(&mut pelvis, &input);
        let drift = drift(steps.duration, samples, &speed, variation, rng);
        let mut trunk = trunk::balance(&pelvis, &speed, &input.mass, &drift, dt);
        bend(&mut trunk);
        let arms = arms::swing(&ArmInput {
            apart: &pelvis.apart,
            speed: &speed,
            trunk: &trunk,
            drift: &drift,
            liveliness: [0, 1].map(|_| 1.0 + variation * rng.random_range(-0.08..0.08)),
            dt,
        });
        Self { feet: input.feet, pelvis, trunk, arms }
    }

    /// Pose of one sample.
    pub fn pose(&self, i: usize) -> BodyPose {
        let (root, hips, feet) = (self.pelvis.position[i], self.pelvis.rotation(i), self.feet[i]);
        let trunk = self.trunk[i].map(Attitude::rotation);
        BodyPose { root, hips, trunk, arms: self.arms[i], feet, knees: knees(root, hips, &feet) }
    }
}

/// Speed of the centre of mass, smoothed over about a step.
fn speed(mass: &[DVec2], dt: f64) -> Vec<f64> {
    let around = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(mass.len() - 1));
        (mass[b] - mass[a]).length() / ((b - a).max(1) as f64 * dt)
    };
    let raw: Vec<f64> = (0..mass.len()).map(around).collect();
    smooth(&raw, (0.13 / dt).round() as usize)
}

/// Slow random changes of gaze, and breathing. A walker looks around less.
pub fn drift(duration: f64, samples: &Samples, speed: &[f64], variation: f64, rng: &mut impl Rng) -> Drift {
    let mut wander = |amount: f64, every: f64| -> Vec<f64> {
        let (mut t, mut knots) = (0.0, Vec::new());
        while t < duration + every {
            knots.push((t, variation * rng.random_range(-amount..amount)));
            t += every * rng.random_range(0.6..1.4);
        }
        let raw: Vec<f64> = samples.times.iter().map(|&t| interpolate(&knots, t)).collect();
        smooth(&raw, samples.count_within(0.15))
    };
    let (gaze, nod) = (wander(0.2, 1.6), wander(0.04, 1.9));
    let arms = [wander(0.06, 1.7), wander(0.06, 1.7)];
    let calm = |x: Vec<f64>| x.iter().zip(speed).map(|(x, v)| x * (1.0 - 0.65 * v.min(1.0))).collect();
    let phase = rng.random_range(0.0..std::f64::consts::TAU);
    let breath = samples.times.iter().map(|t| (phase + t * std::f64::consts::TAU * 0.27).sin()).collect();
    Drift { gaze: calm(gaze), nod: calm(nod), arms: arms.map(calm), breath }
}

/// Directions of the knees, between the hips and the feet.
pub fn knees(root: DVec3, hips: DQuat, feet: &[FootPose; 2]) -> [DVec3; 2] {
    let heading = f64::from(Planar::split(root.as_vec3(), hips.as_quat()).0.heading);
    feet.map(|foot| forward_direction(heading + 0.6 * f64::from(wrap_angle((foot.yaw - heading) as f32))))
}
