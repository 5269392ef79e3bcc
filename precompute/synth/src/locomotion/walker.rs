//! Gaits with a foot on the ground at all times, assembled from the parts of the walker.

use super::super::foot::FootShape;
use super::super::frame::BodyPose;
use super::super::pendulum;
use super::super::side::LateralSide;
use super::super::walk::arms::{self, ArmInput};
use super::super::walk::assemble::{ClipSignals, drift};
use super::super::walk::foot::FootTrack;
use super::super::walk::footsteps::Footsteps;
use super::super::walk::pelvis::{self, PelvisInput};
use super::super::walk::roll::Footfall;
use super::super::walk::trunk::{self, Drift};
use super::falls::AlternatingFootfalls;
use super::manner::Manner;
use super::motion_set::LocomotionAct;
use super::posture::apply_manner;
use super::scene::ActTimes;
use super::still;
use super::stride::Stride;
use glam::DVec2;
use rand::Rng;

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

/// Poses of standing at ease: weight, gaze and breath repeat after [`still::PERIOD`].
pub fn poses_of_standing(act: &LocomotionAct, scene: &ActTimes, rng: &mut impl Rng) -> Vec<BodyPose> {
    let stride = Stride::for_act(act);
    let shape = FootShape::from_skeleton(&scene.skeleton);
    let falls = LateralSide::BOTH.map(|side| {
        let ankle = DVec2::new(0.5 * stride.width * side.sign(), 0.0);
        vec![Footfall::standing(scene.time().start, ankle, 0.0, stride.toe_out * side.sign())]
    });
    let feet = FootTrack::pair(shape, falls, |_| 0.0);
    let ease = still::StandingEase::new(scene.variation, rng);
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
    let arms = arms::swing(&ArmInput {
        apart: &pelvis.apart,
        speed: &vec![act.drive.ahead.abs(); num_samples],
        trunk: &trunk,
        drift,
        liveliness: [act.manner.arm_swing; 2],
        dt,
    });
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
