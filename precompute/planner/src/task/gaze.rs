//! Head and neck turn to the target of a limb, and back.

use super::{Anchor, TaskGaze, TaskStage, TaskStep, ThingPlacement, ease, object_target};
use crate::rotation::{rotation_about, wrap_angle};
use glam::{DQuat, DVec3};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS};

/// Largest turns to the sides, and up and down, relative to the upper chest (rad).
pub(super) const FARTHEST: [f64; 2] = [1.2, 0.75];
/// Turn to the side above which a target is not looked at (rad).
const BEHIND: f64 = 1.9;
/// Distance from the head below which a target is not looked at (m).
const NEAR_M: f64 = 0.15;
/// Share of the turn that the neck takes.
const NECK: f64 = 0.45;
/// Least time in which the head turns to a target, and greatest speed of a turn (s, rad/s).
const LEAST_S: f64 = 0.25;
const RATE: f64 = 3.5;
/// Time by which the eyes are at the target before the hand (s).
const AHEAD_S: f64 = 0.1;
/// Least time for which they stay there, before they turn to something else (s).
const HELD_S: f64 = 0.1;
/// Greatest speed of heads (rad/s).
const TOP_RATE: f64 = 4.2;
/// Angle to a target within which it has to be faced in time, or else it is not looked at (rad).
const NEAR_ENOUGH: f64 = 0.2;
/// Frames to either side over which corners are rounded.
const ROUND: usize = 2;
/// Joints that a gaze turns.
pub(super) const JOINTS: [Joint; 2] = [Joint::Neck, Joint::Head];

/// Turns a character's head to the object of a step, or to its destination, from some time before the limb is there until some
/// time after.
///
/// From another gaze just before, the head goes on directly; it turns no faster than heads do. A target that it could not face
/// in time is not looked at.
///
/// # Source
/// Shapiro, Kallmann and Faloutsos 2007 leave the gaze to the application; angles and shares are those of walkers.
pub(super) fn look_at_target(stage: &mut TaskStage<'_>, step: &TaskStep) {
    let (who, [from_s, at_s, to_s]) = (step.character, step.times_s);
    if is_on_own_head(stage, step) {
        return;
    }
    // Gazes follow one another.
    let others = || stage.gazes.iter().filter(|l| l.character == who);
    if others().any(|l| (l.times_s[1] - at_s).abs() < HELD_S) {
        return;
    }
    let from_s = others().map(|l| l.times_s[1] + HELD_S).filter(|t| *t < at_s + HELD_S).fold(from_s, f64::max);
    let to_s = others().map(|l| l.times_s[1] - HELD_S).filter(|t| *t > at_s - HELD_S).fold(to_s, f64::min);
    let rate_hz = stage.actors[who].clip.rate_hz;
    let last = stage.actors[who].clip.num_frames() - 1;
    let frame_of = |t: f64| (t * rate_hz).round().max(0.0) as usize;
    let frames = frame_of(from_s)..=frame_of(to_s).min(last);
    if frame_of(at_s) <= *frames.start() || frame_of(at_s) >= *frames.end() {
        return;
    }
    let time_of = |frame: usize| frame as f64 / rate_hz;
    let offs: Vec<[f64; 2]> = frames.clone().map(|f| head_offset(stage, step, time_of(f))).collect();
    let most = offs.iter().flatten().fold(0.0f64, |m, o| m.max(o.abs()));
    if most < 1e-3 {
        return;
    }
    // The eyes arrive before the hand, and leave before it is back.
    let [there_s, back_s] = [at_s - from_s, to_s - at_s];
    // An eased turn is fastest in the middle: by half more than in the mean.
    let turn_s = (1.5 * most / RATE).max(LEAST_S);
    let up_s = (there_s - AHEAD_S).min(turn_s.max(0.5 * there_s)).max(1.0 / rate_hz);
    let down_s = back_s.min(turn_s.max(0.7 * back_s));
    let share = |t: f64| ease((t - from_s) / up_s) * ease((to_s - t) / down_s);
    // Turn of the head away from the clip, as it is and as it should be.
    let (actor, skeleton) = (&stage.actors[who], &stage.actors[who].skeleton);
    let known = |frame: usize| {
        let before = actor.before.joint_transforms(skeleton, frame)[Joint::Head.index()].1.as_dquat();
        let now = actor.joint_place(Joint::Head, time_of(frame)).rotation;
        let [before, now] = [before, now].map(|q| direction(q * DVec3::Z));
        [wrap_angle(now[0] - before[0]), now[1] - before[1]]
    };
    let now: Vec<[f64; 2]> = frames.clone().map(known).collect();
    let wanted = frames.clone().zip(&now).zip(&offs).map(|((f, now), off)| {
        let share = share(time_of(f));
        [now[0] + off[0] * share, now[1] + off[1] * share]
    });
    let turns = limit_turn_rate(wanted.collect(), [now[0], now[now.len() - 1]], TOP_RATE / rate_hz);
    let k = frame_of(at_s) - frames.start();
    let left = [0, 1].map(|i| offs[k][i] - (turns[k][i] - now[k][i]));
    if maths::hypot(left[0], left[1]) > NEAR_ENOUGH {
        return;
    }
    let mut clip = stage.actors[who].clip.clone();
    for ((frame, turn), now) in frames.clone().zip(&turns).zip(&now) {
        let by = [turn[0] - now[0], turn[1] - now[1]];
        if by == [0.0; 2] {
            continue;
        }
        let row = frame * NUM_JOINTS;
        let at = |j: Joint| stage.actors[who].joint_place(j, time_of(frame)).rotation;
        let [chest, neck, head] = [Joint::UpperChest, Joint::Neck, Joint::Head].map(at);
        let facing = direction(head * DVec3::Z)[0];
        let turned = |part: f64, q: DQuat| {
            let [yaw, pitch] = by.map(|o| o * part);
            rotation_about(DVec3::Y, facing + yaw)
                * rotation_about(DVec3::X, -pitch)
                * rotation_about(DVec3::Y, -facing)
                * q
        };
        let (neck, head) = (turned(NECK, neck), turned(1.0, head));
        for (joint, local) in [(Joint::Neck, chest.inverse() * neck), (Joint::Head, neck.inverse() * head)] {
            let i = row + joint.index();
            let new = local.as_quat().normalize();
            clip.rotations[i] = if new.dot(clip.rotations[i]) < 0.0 { -new } else { new };
        }
    }
    stage.actors[who].replace_clip(clip);
    let target = object_target(stage, step, at_s).position;
    let times_s = [time_of(*frames.start()), at_s, time_of(*frames.end())];
    stage.gazes.push(TaskGaze { character: who, times_s, target });
}

/// True for an object on the character's own head, or brought there: it turns along and is out of sight.
fn is_on_own_head(stage: &TaskStage<'_>, step: &TaskStep) -> bool {
    let is_own = |character: usize, joint: Joint| character == step.character && JOINTS.contains(&joint);
    let carried = |thing: usize| match stage.placement_at(thing, step.times_s[0]) {
        ThingPlacement::OnJoint { character, joint, .. } => is_own(*character, *joint),
        _ => false,
    };
    match (step.to.map(|to| to.on), step.object) {
        (Some(Anchor::Joint(character, joint)), _) => is_own(character, joint),
        (Some(Anchor::Thing(thing)), _) | (None, Some(thing)) => carried(thing),
        _ => false,
    }
}

/// Turns that change by at most a step from frame to frame, near the wanted ones; both ends are kept.
fn limit_turn_rate(wanted: Vec<[f64; 2]>, ends: [[f64; 2]; 2], step: f64) -> Vec<[f64; 2]> {
    let toward = |from: [f64; 2], to: [f64; 2]| {
        let [a, b] = [to[0] - from[0], to[1] - from[1]];
        let length = maths::hypot(a, b);
        if length <= step { to } else { [from[0] + a * step / length, from[1] + b * step / length] }
    };
    let mut out = wanted;
    let last = out.len() - 1;
    out[0] = ends[0];
    for i in 1..=last {
        out[i] = toward(out[i - 1], out[i]);
    }
    out[last] = ends[1];
    for i in (0..last).rev() {
        out[i] = toward(out[i + 1], out[i]);
    }
    if maths::hypot(out[0][0] - ends[0][0], out[0][1] - ends[0][1]) > 1e-9 {
        // There is only time for the straight path.
        let between = |i: usize, k: usize| ends[0][k] + (ends[1][k] - ends[0][k]) * i as f64 / last as f64;
        return (0..=last).map(|i| [between(i, 0), between(i, 1)]).collect();
    }
    // Corners are rounded; the mean of neighbours changes no faster than they do.
    let sharp = out.clone();
    for i in 1..last {
        let reach = ROUND.min(i).min(last - i);
        let near = &sharp[i - reach..=i + reach];
        out[i] = [0, 1].map(|k| near.iter().map(|v| v[k]).sum::<f64>() / near.len() as f64);
    }
    out
}

/// Turn of the head that would face a thing, within what necks allow (rad to the left and up).
fn head_offset(stage: &TaskStage<'_>, step: &TaskStep, time_s: f64) -> [f64; 2] {
    let actor = &stage.actors[step.character];
    let [chest, head] = [Joint::UpperChest, Joint::Head].map(|j| actor.joint_place(j, time_s));
    let to = object_target(stage, step, time_s).position - head.position;
    let [facing, wanted] = [chest.rotation * DVec3::Z, to].map(direction);
    let [yaw, pitch] = direction(head.rotation * DVec3::Z);
    let aside = wrap_angle(wanted[0] - facing[0]);
    if to.length() < NEAR_M || aside.abs() > BEHIND {
        return [0.0; 2];
    }
    let yaw_to = facing[0] + aside.clamp(-FARTHEST[0], FARTHEST[0]);
    [wrap_angle(yaw_to - yaw), wanted[1].clamp(-FARTHEST[1], FARTHEST[1]) - pitch]
}

/// Angles to the left and up (rad).
fn direction(v: DVec3) -> [f64; 2] {
    [maths::atan2(v.x, v.z), maths::atan2(v.y, maths::hypot(v.x, v.z))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn heads_never_turn_faster_than_they_may(
            wanted in prop::collection::vec(prop::array::uniform2(-1.2f64..1.2), 3..80), step in 0.02f64..0.3
        ) {
            let ends = [wanted[0], wanted[wanted.len() - 1]];
            let enough = maths::hypot(ends[0][0] - ends[1][0], ends[0][1] - ends[1][1]) <= step * (wanted.len() - 1) as f64;
            prop_assume!(enough);
            let out = limit_turn_rate(wanted.clone(), ends, step);
            let apart = |a: [f64; 2], b: [f64; 2]| maths::hypot(a[0] - b[0], a[1] - b[1]);
            prop_assert!(apart(out[0], ends[0]) < 1e-9 && apart(out[out.len() - 1], ends[1]) < 1e-9);
            for w in out.windows(2) {
                prop_assert!(maths::hypot(w[1][0] - w[0][0], w[1][1] - w[0][1]) <= step * (1.0 + 1e-9));
            }
        }
    }

    #[test]
    fn slow_turns_stay_as_they_are_but_for_their_corners() {
        let wanted: Vec<[f64; 2]> = (0..40).map(|i| [0.02 * f64::from(i), -0.01 * f64::from(i)]).collect();
        let out = limit_turn_rate(wanted.clone(), [wanted[0], wanted[39]], 0.1);
        assert!(out.iter().zip(&wanted).all(|(a, b)| (a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9));
    }
}
