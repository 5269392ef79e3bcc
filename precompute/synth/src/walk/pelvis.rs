//! The pelvis: heading from the feet, turning, listing and bobbing with the steps, as high as both legs allow.

use super::{footsteps::Footsteps, roll::Footfall};
use crate::foot::{FootPose, FootShape};
use crate::side::{LateralSide, forward, ground_position, over_ground};
use crate::signal::{PieceEnd, interpolate, quintic, shifted, smooth, smooth_below};
use crate::{attitude::Attitude, frame::Samples, leg::LegShape, pendulum::pendulum};
use glam::{DQuat, DVec2, DVec3};
use throng_core::{Joint, Skeleton};

/// The pelvis at every sample. All vectors have the same length.
pub struct Pelvis {
    /// Heading of the body, without the swing of the steps (rad).
    pub heading: Vec<f64>,
    /// Axial rotation relative to the heading, positive to the left (rad).
    pub yaw: Vec<f64>,
    /// Forward tilt (rad).
    pub pitch: Vec<f64>,
    /// List, left side up (rad).
    pub list: Vec<f64>,
    /// Hips joint (m).
    pub position: Vec<DVec3>,
    /// Distance of the left ankle in front of the right one, along the heading (m).
    pub apart: Vec<f64>,
    /// Rate at which the ground rises under the feet (m/s).
    pub climb: Vec<f64>,
}

impl Pelvis {
    /// Raises the hips as high as both legs allow.
    pub fn stand_up(&mut self, input: &PelvisInput) {
        let height = height(input, self);
        self.position.iter_mut().zip(height).for_each(|(p, h)| p.y = h);
    }

    /// World rotation at a sample.
    pub fn rotation(&self, i: usize) -> DQuat {
        Attitude { yaw: self.heading[i] + self.yaw[i], pitch: self.pitch[i], list: self.list[i] }.rotation()
    }
}

/// Inputs of the pelvis's motion.
pub struct PelvisInput {
    /// Both feet at every sample.
    pub feet: Vec<[FootPose; 2]>,
    /// Share of weight on the left foot at every sample.
    load: Vec<f64>,
    /// Centre of mass on the ground at every sample (m).
    pub mass: Vec<DVec2>,
    /// Hip joints as seen from the hips joint, left and right (m).
    hips: [DVec3; 2],
    /// Lengths of the legs.
    leg: LegShape,
    /// Time between samples (s).
    dt: f64,
}

impl PelvisInput {
    /// Inputs from footsteps.
    pub fn new(steps: &Footsteps, skeleton: &Skeleton, samples: &Samples) -> Self {
        let times = samples.times.iter();
        Self {
            feet: times.clone().map(|&t| [0, 1].map(|s: usize| steps.feet[s].pose(t))).collect(),
            load: times.map(|&t| interpolate(&steps.load, t)).collect(),
            mass: centre_of_mass(steps, &FootShape::from_skeleton(skeleton), samples),
            hips: [Joint::LeftThigh, Joint::RightThigh].map(|j| skeleton.offsets[j.index()].as_dvec3()),
            leg: LegShape::from_skeleton(skeleton),
            dt: samples.dt,
        }
    }
}

/// Largest upward acceleration of the hips (m/s^2).
const BOB: f64 = 8.0;
/// Largest rise of the hips above their height in the longest steps: brisk walkers bend the standing knee (m).
const RISE: f64 = 0.055;
/// Least knee flexion of a leg under the body (rad).
const STANDING_FLEXION: f64 = 0.11;
/// Least knee flexion of a reaching leg: larger values round its turn from stretching to bending (rad).
const REACHING_FLEXION: f64 = 0.22;
/// Offset of the hips joint in front of the centre of mass in standing, and its increase with speed: in walking, the
/// pelvis is pushed forward over the leading foot (m, s).
const HIPS_FORWARD: [f64; 2] = [-0.035, 0.026];

/// Moves the pelvis over the feet.
///
/// - `speed`: at every sample (m/s).
pub fn follow_feet(input: &PelvisInput, speed: &[f64]) -> Pelvis {
    let frames = |seconds: f64| (seconds / input.dt).round() as usize;
    let mean_heading: Vec<f64> = input.feet.iter().map(|f| 0.5 * (f[0].heading + f[1].heading)).collect();
    let heading = smooth(&shifted(&mean_heading, 0.06, input.dt), frames(0.09));
    let apart = |(f, &h): (&[FootPose; 2], &f64)| (f[0].ankle - f[1].ankle).dot(over_ground(forward(h), 0.0));
    let apart: Vec<f64> = input.feet.iter().zip(&heading).map(apart).collect();
    let yaw: Vec<f64> = smooth(&apart, frames(0.03)).iter().map(|d| -0.21 * d).collect();
    let list = list(input, speed);
    let pitch: Vec<f64> = speed.iter().map(|v| 0.04 + 0.02 * v).collect();
    let position = (0..input.mass.len()).map(|i| {
        let ahead = HIPS_FORWARD[0] + HIPS_FORWARD[1] * speed[i].min(1.4);
        over_ground(input.mass[i] + forward(heading[i]) * ahead, 0.0)
    });
    let climb = rate(&ground(input), input.dt);
    let mut out = Pelvis { position: position.collect(), heading, yaw, pitch, list, apart, climb };
    out.stand_up(input);
    out
}

/// List of the pelvis: the unloaded side drops, most soon after its foot has left the ground (rad).
fn list(input: &PelvisInput, speed: &[f64]) -> Vec<f64> {
    let frames = |seconds: f64| (seconds / input.dt).round() as usize;
    let load = smooth(&input.load, frames(0.035));
    let slow = smooth(&load, frames(0.12));
    let vigour = |v: f64| 0.17 + 0.1 * v.min(1.5);
    let early: Vec<f64> =
        (0..load.len()).map(|i| vigour(speed[i]) * (0.35 * (slow[i] - 0.5) + 0.75 * (load[i] - slow[i]))).collect();
    smooth(&early, frames(0.02))
}

/// Height of the ground under both feet, smoothed over a step or two (m).
fn ground(input: &PelvisInput) -> Vec<f64> {
    let mean: Vec<f64> = input.feet.iter().map(|f| 0.5 * (f[0].ground + f[1].ground)).collect();
    smooth(&mean, (0.15 / input.dt).round() as usize)
}

/// First derivative by central differences, zero at both ends (1/s).
fn rate(x: &[f64], dt: f64) -> Vec<f64> {
    let mut out = vec![0.0; x.len()];
    for i in 1..x.len().saturating_sub(1) {
        out[i] = (x[i + 1] - x[i - 1]) / (2.0 * dt);
    }
    out
}

/// Greatest smooth height that both legs reach: never above the limit by the least flexion of either knee (m).
fn height(input: &PelvisInput, pelvis: &Pelvis) -> Vec<f64> {
    let lower = |i: usize| {
        let [left, right] = LateralSide::BOTH.map(|side| leg_limit(input, pelvis, i, side));
        left.min(right)
    };
    let limit: Vec<f64> = (0..input.feet.len()).map(lower).collect();
    let ground = ground(input);
    let above: Vec<f64> = limit.iter().zip(&ground).map(|(l, g)| l - g).collect();
    let (stride, rounding) = ((0.55 / input.dt).round() as usize, (0.02 / input.dt).round() as usize);
    let highest = smooth(&lowest_within(&above, stride), stride / 3);
    let limit: Vec<f64> = limit.iter().zip(highest).zip(ground).map(|((l, low), g)| l.min(low + RISE + g)).collect();
    smooth_below(&limit, BOB, rounding, input.dt)
}

/// Minimum within `radius` samples.
fn lowest_within(x: &[f64], radius: usize) -> Vec<f64> {
    let around = |i: usize| &x[i.saturating_sub(radius)..(i + radius + 1).min(x.len())];
    (0..x.len()).map(|i| around(i).iter().copied().fold(f64::INFINITY, f64::min)).collect()
}

/// Height of the hips joint at which one leg has its least flexion (m).
fn leg_limit(input: &PelvisInput, pelvis: &Pelvis, i: usize, side: LateralSide) -> f64 {
    let offset = pelvis.rotation(i) * input.hips[side.index()];
    let ankle = input.feet[i][side.index()].ankle;
    let across = ground_position(ankle) - ground_position(pelvis.position[i] + offset);
    let at = |flexion: f64| {
        let reach = input.leg.reach(flexion);
        ankle.y - offset.y + (reach * reach - across.length_squared()).max(0.01).sqrt()
    };
    let (under, reaching) = (PieceEnd::at_rest(STANDING_FLEXION), PieceEnd::at_rest(REACHING_FLEXION));
    at(quintic(under, reaching, 0.2, across.length().min(0.2)))
}

/// The centre of mass on the ground plane (x, z) at every sample, balanced over the feet as a linear inverted pendulum (m).
///
/// The centre of pressure follows from the stance of the feet and the transfer of weight between them; the pendulum
/// turns it into a centre of mass that sways over the standing foot, shifts before the first step, speeds up and slows
/// down within each step, and leans into starts, stops and turns, without further rules.
fn centre_of_mass(steps: &Footsteps, shape: &FootShape, samples: &Samples) -> Vec<DVec2> {
    let pressure: Vec<DVec2> = samples.times.iter().map(|&t| centre_of_pressure(steps, shape, t)).collect();
    pendulum(&pressure, samples.dt)
}

fn centre_of_pressure(steps: &Footsteps, shape: &FootShape, t: f64) -> DVec2 {
    let under = |side: LateralSide| {
        let falls = &steps.feet[side.index()].falls;
        let i = falls.partition_point(|f| f.land <= t).saturating_sub(1);
        pressure_under(&falls[i], shape, t)
    };
    let share = interpolate(&steps.load, t);
    under(LateralSide::Left) * share + under(LateralSide::Right) * (1.0 - share)
}

/// Pressure under one foot, which moves from the heel over the middle, where it stays in standing, to the ball.
fn pressure_under(fall: &Footfall, shape: &FootShape, t: f64) -> DVec2 {
    const ROLL: f64 = 0.25;
    let flat = fall.flat + 0.05;
    let mut knots = vec![(fall.land, -0.1 * shape.ball), (flat, 0.35 * shape.ball)];
    if fall.lift.is_finite() {
        let leave = fall.heel_off.max(flat + 0.01);
        if leave - ROLL > flat {
            knots.push((leave - ROLL, 0.35 * shape.ball));
        }
        knots.extend([(leave, 0.7 * shape.ball), (fall.lift.max(leave + 0.01), shape.ball)]);
    }
    fall.ankle + forward(fall.yaw) * interpolate(&knots, t)
}
