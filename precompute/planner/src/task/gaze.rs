//! Head and neck turn to what a limb reaches for, and back.

use super::ahead::target;
use super::stage::{Looked, Stage};
use super::step::Step;
use crate::rotation::{about, wrap};
use glam::{DQuat, DVec3};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS};

/// Farthest to the sides, up and down, as seen from the upper chest (rad).
pub(super) const FARTHEST: [f64; 2] = [1.2, 0.75];
/// Beyond this to the side, nobody looks there (rad).
const BEHIND: f64 = 1.9;
/// Nearer than this to the head, nothing is looked at (m).
const NEAR_M: f64 = 0.15;
/// Share of the turn that the neck has.
const NECK: f64 = 0.45;
/// Least time in which the head turns there, and fastest turn (s, rad/s).
const LEAST_S: f64 = 0.25;
const RATE: f64 = 3.5;
/// The eyes are there so long before the hand is (s).
const AHEAD_S: f64 = 0.1;
/// Joints that a gaze moves.
pub(super) const JOINTS: [Joint; 2] = [Joint::Neck, Joint::Head];

/// Lets a character look at what a step takes, or where it brings it, from some time before it is there until some time after.
///
/// # Source
/// Shapiro, Kallmann and Faloutsos 2007 leave the gaze to the application; angles and shares are those of walkers.
pub(super) fn look(stage: &mut Stage<'_>, step: &Step) {
    let (who, times_s) = (step.character, step.times_s);
    let [from_s, at_s, to_s] = times_s;
    let rate_hz = stage.actors[who].clip.rate_hz;
    let last = stage.actors[who].clip.num_frames() - 1;
    let frames = (from_s * rate_hz).round().max(0.0) as usize..=((to_s * rate_hz).round() as usize).min(last);
    let offs: Vec<[f64; 2]> = frames.clone().map(|f| off(stage, step, f as f64 / rate_hz)).collect();
    let most = offs.iter().flatten().fold(0.0f64, |m, o| m.max(o.abs()));
    // Eased, it is fastest in the middle: by half more than in the mean.
    let turn_s = (1.5 * most / RATE).max(LEAST_S);
    // The eyes are there before the hand is, and go on before it is back.
    let [there_s, back_s] = [at_s - from_s, to_s - at_s];
    let [up_s, down_s] = [(there_s - AHEAD_S).min(turn_s.max(0.5 * there_s)), back_s.min(turn_s.max(0.7 * back_s))];
    if up_s < turn_s || down_s < turn_s || most < 1e-3 {
        return;
    }
    let mut clip = stage.actors[who].clip.clone();
    for (frame, off) in frames.zip(offs) {
        let t = frame as f64 / rate_hz;
        let share = ease((t - from_s) / up_s) * ease((to_s - t) / down_s);
        let row = frame * NUM_JOINTS;
        let at = |j: Joint| stage.actors[who].joint(j, t).rotation;
        let [chest, neck, head] = [Joint::UpperChest, Joint::Neck, Joint::Head].map(at);
        let facing = direction(head * DVec3::Z)[0];
        let turned = |part: f64, q: DQuat| {
            let [yaw, pitch] = off.map(|o| o * share * part);
            about(DVec3::Y, facing + yaw) * about(DVec3::X, -pitch) * about(DVec3::Y, -facing) * q
        };
        let (neck, head) = (turned(NECK, neck), turned(1.0, head));
        for (joint, local) in [(Joint::Neck, chest.inverse() * neck), (Joint::Head, neck.inverse() * head)] {
            let i = row + joint.index();
            let new = local.as_quat().normalize();
            if share > 0.0 {
                clip.rotations[i] = if new.dot(clip.rotations[i]) < 0.0 { -new } else { new };
            }
        }
    }
    stage.actors[who].change(clip);
    let at = target(stage, step, at_s).position;
    stage.looked.push(Looked { character: who, times_s, at });
}

/// How far the head is from looking at a thing, within what it can (rad to the left and up).
fn off(stage: &Stage<'_>, step: &Step, time_s: f64) -> [f64; 2] {
    let actor = &stage.actors[step.character];
    let [chest, head] = [Joint::UpperChest, Joint::Head].map(|j| actor.joint(j, time_s));
    let to = target(stage, step, time_s).position - head.position;
    let [facing, wanted] = [chest.rotation * DVec3::Z, to].map(direction);
    let [yaw, pitch] = direction(head.rotation * DVec3::Z);
    let aside = wrap(wanted[0] - facing[0]);
    if to.length() < NEAR_M || aside.abs() > BEHIND {
        return [0.0; 2];
    }
    let yaw_to = facing[0] + aside.clamp(-FARTHEST[0], FARTHEST[0]);
    [wrap(yaw_to - yaw), wanted[1].clamp(-FARTHEST[1], FARTHEST[1]) - pitch]
}

/// Angles to the left and up (rad).
fn direction(v: DVec3) -> [f64; 2] {
    [maths::atan2(v.x, v.z), maths::atan2(v.y, maths::hypot(v.x, v.z))]
}

/// From 0 to 1, without a jump in speed or acceleration.
fn ease(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (x * (6.0 * x - 15.0) + 10.0)
}
