//! Places of hands for grips.

use super::{ObjectGrip, SecondHand, StageActor, ThingPlacement, hand_joint, palm};
use crate::linkage::{Chain, LIMB_JOINTS, Limb, LimbPose};
use crate::rotation::{Rigid, angle_between, rotation_about, rotation_between};
use glam::{DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Tilts of a hand with any turn, away from the line from the shoulder (rad).
const TILTS: [f64; 5] = [0.0, 0.5, -0.5, 1.0, -1.0];
/// Turns of it about itself (rad).
const ROLLS: [f64; 7] = [0.0, FRAC_PI_4, -FRAC_PI_4, FRAC_PI_2, -FRAC_PI_2, 0.75 * PI, -0.75 * PI];

/// A place for a hand, with the object where it is then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HandTarget {
    /// Rank: goals of a lower one are preferred; within one rank, the most natural pose.
    pub rank: usize,
    pub hand: Rigid,
    pub object: Rigid,
}

impl HandTarget {
    /// Placement of the object in the hand of a limb, and in the second one if there is one.
    pub fn placement_in_hand(&self, character: usize, limb: Limb, second: Option<SecondHand>) -> ThingPlacement {
        let offset = self.hand.to_local(self.object);
        ThingPlacement::OnJoint { character, joint: hand_joint(limb), offset, holder: Some(limb), second }
    }
}

impl StageActor {
    /// Goals of hands for grips on something at `object`: each grip has its own rank.
    pub fn hand_targets(&self, limb: Limb, grips: &[ObjectGrip], object: &Rigid, time_s: f64) -> Vec<HandTarget> {
        let goals = |(rank, grip): (usize, &ObjectGrip)| {
            let hands = match grip {
                ObjectGrip::Turned(wrist) => vec![object.compose(*wrist)],
                ObjectGrip::Any(middle) => turned_hands(object.transform_point(*middle), self, limb, time_s),
            };
            hands.into_iter().map(move |hand| HandTarget { rank, hand, object: *object })
        };
        grips.iter().enumerate().flat_map(goals).collect()
    }
}

/// Measure of how unnatural a pose of an arm is: the bend of the wrist (rad), and the height of the elbow above the middle
/// between shoulder and hand, weighted so that a hand's breadth counts as half a radian.
pub(super) fn awkwardness(chain: &Chain, placed: &[Rigid; LIMB_JOINTS], pose: &LimbPose) -> f64 {
    if !chain.limb.is_arm() {
        return 0.0;
    }
    let [shoulder, elbow, wrist] = placed.map(|p| p.position.y);
    angle_between(pose.0[2], DQuat::IDENTITY) + 5.0 * (elbow - 0.5 * (shoulder + wrist))
}

/// Transforms of a hand whose middle is at a place, with many turns; the least turned first, relative to the motion.
fn turned_hands(middle: DVec3, actor: &StageActor, limb: Limb, time_s: f64) -> Vec<Rigid> {
    let present = actor.joint_place(hand_joint(limb), time_s).rotation;
    let palm = palm(&actor.skeleton, limb);
    let from = actor.joint_place(limb.joints()[0], time_s).position;
    let ahead = (middle - from).normalize_or(DVec3::Z);
    let straight = rotation_between(present * palm.normalize_or(DVec3::X), ahead) * present;
    let side = ahead.cross(DVec3::Y).normalize_or(DVec3::X);
    let up = side.cross(ahead);
    let tilts = TILTS.into_iter().flat_map(|tilt| [side, up].map(|axis| rotation_about(axis, tilt)));
    let all = tilts.flat_map(|tilt| ROLLS.map(|roll| tilt * rotation_about(ahead, roll) * straight));
    let mut turns: Vec<DQuat> = all.collect();
    turns.sort_by(|a, b| angle_between(*a, present).total_cmp(&angle_between(*b, present)));
    turns.into_iter().map(|rotation| Rigid { position: middle - rotation * palm, rotation }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::stage::ActorClip;
    use crate::task::tests::{TASK, parse, stand};
    use crate::testing::TestCharacter;

    #[test]
    fn the_middle_of_the_hand_comes_to_the_grip_whichever_way_it_is_turned() {
        let s = TestCharacter::standing();
        let task = parse(TASK).expect("a task");
        let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
        let stage = super::super::stage::TaskStage::new(&task, &clips);
        let object = Rigid::from_position(DVec3::new(0.3, 1.3, 0.4));
        let grip = ObjectGrip::Any(DVec3::Y * 0.1);
        let found = stage.actors[0].hand_targets(Limb::LeftArm, &[grip], &object, 0.5);
        let palm = palm(&s.skeleton, Limb::LeftArm);
        assert_eq!(found.len(), 70);
        assert!(found.iter().all(|g| g.hand.is_valid()
            && g.hand.transform_point(palm).distance(object.transform_point(DVec3::Y * 0.1)) < 1e-9));
    }
}
