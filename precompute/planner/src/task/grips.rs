//! Where a hand may be for a grip.

use super::stage::{Actor, hand, palm};
use super::step::Grip;
use crate::linkage::Limb;
use crate::rotation::{Rigid, about, angle, between};
use glam::{DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// How far a hand that may be turned in any way tilts away from the line from the shoulder (rad).
const TILTS: [f64; 5] = [0.0, 0.5, -0.5, 1.0, -1.0];
/// How far it turns about itself (rad).
const ROLLS: [f64; 7] = [0.0, FRAC_PI_4, -FRAC_PI_4, FRAC_PI_2, -FRAC_PI_2, 0.75 * PI, -0.75 * PI];

/// Hands for grips on something at `object`, in the order of the grips; those of one grip that leaves the turn open begin
/// with the least turned ones, as seen from the motion.
pub(super) fn targets(grips: &[Grip], object: &Rigid, actor: &Actor, limb: Limb, time_s: f64) -> Vec<Rigid> {
    let mut out = Vec::new();
    for grip in grips {
        match grip {
            Grip::Turned(wrist) => out.push(object.then(*wrist)),
            Grip::Any(middle) => out.extend(any_turn(object.point(*middle), actor, limb, time_s)),
        }
    }
    out
}

fn any_turn(middle: DVec3, actor: &Actor, limb: Limb, time_s: f64) -> Vec<Rigid> {
    let present = actor.joint(hand(limb), time_s).rotation;
    let palm = palm(&actor.skeleton, limb);
    let from = actor.joint(limb.joints()[0], time_s).position;
    let ahead = (middle - from).normalize_or(DVec3::Z);
    let straight = between(present * palm.normalize_or(DVec3::X), ahead) * present;
    let side = ahead.cross(DVec3::Y).normalize_or(DVec3::X);
    let up = side.cross(ahead);
    let mut turns: Vec<DQuat> = Vec::new();
    for tilt in TILTS {
        for axis in [side, up] {
            turns.extend(ROLLS.map(|roll| about(axis, tilt) * about(ahead, roll) * straight));
        }
    }
    turns.sort_by(|a, b| angle(*a, present).total_cmp(&angle(*b, present)));
    turns.into_iter().map(|rotation| Rigid { position: middle - rotation * palm, rotation }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::stage::ActorClip;
    use crate::task::tests::{TASK, parse, stand};
    use crate::testing::Somebody;

    #[test]
    fn the_middle_of_the_hand_comes_to_the_grip_whichever_way_it_is_turned() {
        let s = Somebody::standing();
        let task = parse(TASK).expect("a task");
        let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
        let stage = super::super::stage::Stage::new(&task, &clips);
        let object = Rigid::at(DVec3::new(0.3, 1.3, 0.4));
        let grip = Grip::Any(DVec3::Y * 0.1);
        let found = targets(&[grip], &object, &stage.actors[0], Limb::LeftArm, 0.5);
        let palm = palm(&s.skeleton, Limb::LeftArm);
        assert_eq!(found.len(), 70);
        assert!(found.iter().all(|t| t.is_valid() && t.point(palm).distance(object.point(DVec3::Y * 0.1)) < 1e-9));
    }
}
