//! Gaits with a foot on the ground at all times, assembled from the parts of the walker.

use super::{ActTimes, AlternatingFootfalls, LocomotionAct, Manner, Stride, apply_manner};
use crate::walk::arms::{self, ArmInput};
use crate::walk::assemble::{ClipSignals, drift};
use crate::walk::pelvis::{self, PelvisInput};
use crate::walk::trunk::{self, Drift};
use crate::{foot::FootShape, frame::BodyPose, pendulum, side::LateralSide, walk::foot::FootTrack};
use crate::{walk::footsteps::Footsteps, walk::roll::Footfall};
use glam::DVec2;
use rand::{Rng, RngExt};
use std::f64::consts::TAU;

/// Share of the wandering of gaze and arms for a steady gait.
const CALM: f64 = 0.3;

/// Poses of steps that travel or turn.
pub fn poses_of_stepping(act: &LocomotionAct, scene: &ActTimes, rng: &mut impl Rng) -> Vec<BodyPose> {
    // The feet are outside an arc by as much as the centre of mass falls towards its middle.
    let outward = -act.drive.centripetal_acceleration() / pendulum::FREQUENCY.powi(2);
    let falls = AlternatingFootfalls::generate(act, outward, scene.time(), scene.variation, rng);
    let load = falls.left_foot_load();
    let shape = FootShape::from_skeleton(&scene.skeleton);
    let feet = FootTrack::pair(shape, falls.feet, |_| 0.0);
    let steps = Footsteps { feet, load, duration: scene.time().end };
    let speed = vec![act.drive.speed(); scene.samples.times.len()];
    let drift = drift(steps.duration, &scene.samples, &speed, CALM * scene.variation, rng);
    poses(act, scene, &steps, &drift)
}

/// Poses of standing at ease: weight, gaze and breath repeat after [`PERIOD`].
pub fn poses_of_standing(act: &LocomotionAct, scene: &ActTimes, rng: &mut impl Rng) -> Vec<BodyPose> {
    let stride = Stride::for_act(act);
    let shape = FootShape::from_skeleton(&scene.skeleton);
    let falls = LateralSide::BOTH.map(|side| {
        let ankle = DVec2::new(0.5 * stride.width * side.sign(), 0.0);
        vec![Footfall::standing(scene.time().start, ankle, 0.0, stride.toe_out * side.sign())]
    });
    let feet = FootTrack::pair(shape, falls, |_| 0.0);
    let ease = StandingEase::new(scene.variation, rng);
    let load = scene.samples.times.iter().map(|&t| (t, ease.left_foot_load(t))).collect();
    let steps = Footsteps { feet, load, duration: scene.time().end };
    poses(act, scene, &steps, &ease.drift(&scene.samples.times))
}

fn poses(act: &LocomotionAct, scene: &ActTimes, steps: &Footsteps, drift: &Drift) -> Vec<BodyPose> {
    let (dt, num_samples) = (scene.samples.dt, scene.samples.times.len());
    let input = PelvisInput::new(steps, &scene.skeleton, &scene.samples);
    let ahead = vec![act.drive.ahead; num_samples];
    let mut pelvis = pelvis::follow_feet(&input, &ahead);
    let sway = act.manner.sway;
    pelvis.yaw.iter_mut().chain(&mut pelvis.list).for_each(|angle| *angle *= sway);
    let trunk = trunk::balance(&pelvis, &ahead, &input.mass, drift, dt);
    let (speed, liveliness) = (vec![act.drive.ahead.abs(); num_samples], [act.manner.arm_swing; 2]);
    let input_of_arms = ArmInput { apart: &pelvis.apart, speed: &speed, trunk: &trunk, drift, liveliness, dt };
    let arms = arms::swing(&input_of_arms);
    // Equal flexion for a tired walker and a tired stander would look like sitting down; fast walking bends the knees
    // enough.
    let speed = act.drive.speed();
    let crouch = act.manner.crouch * (0.35 + speed).min(1.0) * (1.0 - 0.4 * (speed - 1.1).max(0.0));
    let manner = Manner { crouch, ..*act.manner };
    let signals = ClipSignals { feet: input.feet, pelvis, trunk, arms };
    let pose = |i: usize| {
        let mut pose = signals.pose(i);
        apply_manner(&mut pose, &manner);
        pose
    };
    (0..num_samples).map(pose).collect()
}

/// Period of standing: a breath of fifteen a minute (s).
pub const PERIOD: f64 = 4.0;

/// State of standing at ease.
pub struct StandingEase {
    variation: f64,
    /// Phases of weight, gaze, nod, arms and breath (rad).
    phases: [f64; 6],
}

impl StandingEase {
    /// Begins at random phases.
    ///
    /// - `variation`: factor on the usual amount of shifting and looking.
    pub fn new(variation: f64, rng: &mut impl Rng) -> Self {
        Self { variation, phases: [(); 6].map(|()| rng.random_range(0.0..TAU)) }
    }

    /// Share of the weight on the left foot.
    pub fn left_foot_load(&self, t: f64) -> f64 {
        0.5 + 0.09 * self.variation * self.wave(0, t)
    }

    /// Gaze, arms and breath.
    pub fn drift(&self, times: &[f64]) -> Drift {
        let of = |k: usize, amount: f64| times.iter().map(|&t| amount * self.wave(k, t)).collect();
        let small = |k: usize, amount: f64| of(k, amount * self.variation);
        let arms = [3, 4].map(|k| small(k, 0.025));
        Drift { gaze: small(1, 0.07), nod: small(2, 0.02), arms, breath: of(5, 1.0) }
    }

    /// A slightly uneven wave of the period; even for the breath.
    fn wave(&self, k: usize, t: f64) -> f64 {
        let angle = TAU * t / PERIOD + self.phases[k];
        let uneven = if k == 5 { 0.0 } else { 0.35 };
        angle.sin() + uneven * (2.0 * angle + self.phases[5]).sin()
    }
}
