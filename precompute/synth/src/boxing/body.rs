//! The body between feet and fists: balanced over the feet, as high as the knees allow, turned and leaned as planned.

use super::{BoxingPosture, BoxingScript, DesiredFoot};
use crate::frame::{Samples, upper_chest};
use crate::side::{LateralSide, forward, ground_position, leftward, over_ground};
use crate::signal::{smooth, smooth_below};
use crate::{attitude::Attitude, foot::FootPose, leg::LegShape, pendulum::pendulum};
use glam::{DQuat, DVec2, DVec3};
use throng_core::{Joint, Skeleton};

/// Largest upward acceleration of the hips (m/s^2).
const SPRING: f64 = 14.0;
/// Amplitude and frequency of a bouncing knee (rad, Hz).
const BOUNCE: (f64, f64) = (0.045, 1.7);
/// Largest flexion of a ducking boxer's knees: 110 degrees, thigh a little above level (rad).
const DEEPEST: f64 = 1.92;

/// Largest speed of a standing heel (m/s).
const HEEL_SPEED: f64 = 0.015;

/// Body of a boxer at one sample, in the world.
#[derive(Clone, Copy, Debug)]
pub struct BoxerBody {
    /// The facing (rad).
    pub facing: f64,
    /// Hips joint (m).
    pub root: DVec3,
    /// Hips.
    pub hips: DQuat,
    /// Spine, chest, upper chest, neck, head.
    pub trunk: [DQuat; 5],
    /// Upper chest joint (m).
    pub chest: DVec3,
    /// Neck joint (m).
    pub neck: DVec3,
    /// Frame of hands on guard: at the neck, oriented between facing, head and chest.
    pub guard: DQuat,
    /// Both feet.
    pub feet: [FootPose; 2],
}

/// Moves the body through a script.
///
/// - `rhythm`: strength of the bouncing at every sample, 1 on average.
pub fn follow_script(script: &BoxingScript, skeleton: &Skeleton, samples: &Samples, rhythm: &[f64]) -> Vec<BoxerBody> {
    let mut postures = script.body.sample(samples, &BoxingPosture::AHEAD, 0.022);
    let facing = script.facing.sample(samples, &[], 0.06);
    for ((p, t), r) in postures.iter_mut().zip(&samples.times).zip(rhythm) {
        let beat = (t * std::f64::consts::TAU * BOUNCE.1).sin();
        p.flexion += BOUNCE.0 * r * (1.0 - beat);
        p.heels[1] += 0.04 * r * beat;
    }
    let feet = feet(script, &postures, samples);
    let under = |f: &FootPose| ground_position(f.ankle.lerp(f.ball, 0.6));
    let share = lead_foot_share(script, &postures, samples);
    let pressure: Vec<DVec2> =
        feet.iter().zip(share).map(|(f, s)| under(&f[0]) * s + under(&f[1]) * (1.0 - s)).collect();
    let mass = pendulum(&pressure, samples.dt);
    let body = |(i, p): (usize, &BoxingPosture)| body_over_mass(p, facing[i], mass[i], feet[i], skeleton);
    let mut bodies: Vec<BoxerBody> = postures.iter().enumerate().map(body).collect();
    let height = hips_heights(&bodies, &postures, skeleton, samples);
    for (body, height) in bodies.iter_mut().zip(height) {
        [&mut body.root, &mut body.chest, &mut body.neck].into_iter().for_each(|point| point.y += height);
    }
    bodies
}

fn feet(script: &BoxingScript, postures: &[BoxingPosture], samples: &Samples) -> Vec<[FootPose; 2]> {
    let yaws = script.feet.each_ref().map(|foot| foot.yaws(samples));
    let foot = |k: usize, i: usize| {
        let stance = DesiredFoot { yaw: yaws[i][k] + postures[k].pivots[i], heel: postures[k].heels[i].max(0.0) };
        script.feet[i].pose(samples.times[k], stance)
    };
    let mut feet: Vec<[FootPose; 2]> = (0..postures.len()).map(|k| [0, 1].map(|i| foot(k, i))).collect();
    for i in 0..2 {
        lift_turning_heels(&mut feet, i, samples.dt);
    }
    feet
}

/// Marks heels that move over the ground while the foot turns on its ball as not carrying.
fn lift_turning_heels(feet: &mut [[FootPose; 2]], i: usize, dt: f64) {
    let ankles: Vec<DVec3> = feet.iter().map(|f| f[i].ankle).collect();
    let moves = |pair: &[DVec3]| pair[0].distance(pair[1]) > HEEL_SPEED * dt;
    for (k, _) in ankles.windows(2).enumerate().filter(|(_, pair)| moves(pair)) {
        feet[k][i].heel_down = false;
        feet[k + 1][i].heel_down = false;
    }
}

/// Share of the weight on the lead foot: all or nothing while a foot flies, otherwise as in the posture.
fn lead_foot_share(script: &BoxingScript, postures: &[BoxingPosture], samples: &Samples) -> Vec<f64> {
    let share = |(&t, p): (&f64, &BoxingPosture)| match script.feet.each_ref().map(|foot| foot.flight(t).is_some()) {
        [true, _] => 0.0,
        [_, true] => 1.0,
        _ => p.weight,
    };
    let share: Vec<f64> = samples.times.iter().zip(postures).map(share).collect();
    smooth(&share, samples.count_within(0.02))
}

/// Body over its centre of mass, with the hips at height 0. The hips move back against the lean of the trunk.
fn body_over_mass(p: &BoxingPosture, facing: f64, mass: DVec2, feet: [FootPose; 2], skeleton: &Skeleton) -> BoxerBody {
    let ahead = 0.02 - 0.3 * p.pitch.sin() + p.shift[1];
    let aside = 0.14 * p.list.sin() + p.shift[0];
    let root = over_ground(mass + forward(facing) * ahead + leftward(facing) * aside, 0.0);
    let world = DQuat::from_rotation_y(facing);
    let turned = |a: Attitude| {
        world * DQuat::from_rotation_x(a.pitch) * DQuat::from_rotation_z(a.list) * DQuat::from_rotation_y(a.yaw)
    };
    let hips = Attitude { yaw: p.hips, pitch: 0.3 * p.pitch + 0.04, list: 0.15 * p.list };
    let chest = Attitude { yaw: p.chest, pitch: 1.15 * p.pitch, list: p.list };
    let head = Attitude { yaw: 0.12 * p.chest, pitch: p.chin + 0.35 * p.pitch, list: 0.35 * p.list };
    let neck = chest.mix(head, 0.5);
    let trunk = [hips.mix(chest, 0.33), hips.mix(chest, 0.7), chest, neck, head].map(turned);
    let hips = turned(hips);
    let chest = upper_chest(root, hips, &trunk, skeleton);
    let neck = chest + trunk[2] * skeleton.offsets[Joint::Neck.index()].as_dvec3();
    let guard = turned(Attitude { yaw: 0.55 * p.chest, pitch: 0.7 * p.pitch, list: 0.7 * p.list });
    BoxerBody { facing, root, hips, trunk, chest, neck, guard, feet }
}

/// Height of the hips joint: given by the straighter knee, with no leg overstretched and no knee bent too far (m).
fn hips_heights(bodies: &[BoxerBody], postures: &[BoxingPosture], skeleton: &Skeleton, samples: &Samples) -> Vec<f64> {
    let leg = LegShape::from_skeleton(skeleton);
    let limit = |(body, p): (&BoxerBody, &BoxingPosture)| {
        let under = |side: LateralSide, flexion: f64| {
            let hip = body.root + body.hips * skeleton.offsets[side.leg()[0].index()].as_dvec3();
            let to = body.feet[side.index()].ankle - hip;
            let reach = leg.reach(flexion);
            to.y + (reach * reach - to.x * to.x - to.z * to.z).max(0.01).sqrt()
        };
        let [left, right] = LateralSide::BOTH.map(|side| (under(side, p.flexion), under(side, DEEPEST)));
        left.0.min(right.0).max(left.1.max(right.1))
    };
    let limit: Vec<f64> = bodies.iter().zip(postures).map(limit).collect();
    smooth_below(&limit, SPRING, samples.count_within(0.025), samples.dt)
}
