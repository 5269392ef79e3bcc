//! Activities of two people: they stand face to face and chat, dispute, shake hands, hand something over, or dance.

use super::gesture::{self, TalkStyle, hand_before_body};
use super::{KeyedHandPose, KeyedPosture, MotionScript, ScriptStep, face_partner, lean_on, mirrored_for_side};
use crate::side::{LateralSide, leftward};
use crate::walk::footsteps::FeetStance;
use glam::{DVec2, DVec3};
use rand::{Rng, RngExt};
use std::f64::consts::PI;

/// Distance between the two (m).
const APART: f64 = 0.9;
/// Time for which both stand before and after (s).
const BEFORE: f64 = 1.5;
/// Offset of the wrists of hands that grip each other from the midpoint: aside, up and back (m).
const GRIP: DVec3 = DVec3::new(0.03, 1.0, 0.085);
/// Offset of the wrists of hands at the two ends of a handed-over thing from the midpoint (m).
const ENDS: DVec3 = DVec3::new(0.0, 1.02, 0.13);

/// Pitch of a head that looks a partner in the face; a person alone looks a little down (rad).
const FACE: f64 = -0.09;

/// An activity of two people.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairActivity {
    Chat,
    Dispute,
    Handshake,
    Handover,
    Dance,
}

impl PairActivity {
    /// All activities.
    pub const ALL: [Self; 5] = [Self::Chat, Self::Dispute, Self::Handshake, Self::Handover, Self::Dance];

    /// Tag of the activity.
    pub fn name(self) -> &'static str {
        ["chat", "dispute", "handshake", "handover", "dance"][self as usize]
    }
}

/// Scripts of the two, equally long: from neutral stand to neutral stand. The first one faces +Z.
pub fn pair_scripts(what: PairActivity, variation: f64, rng: &mut impl Rng) -> [MotionScript; 2] {
    let stance = |k: usize| {
        let side = if k == 0 { -1.0 } else { 1.0 };
        FeetStance { at: DVec2::new(0.0, side * 0.5 * APART), heading: if k == 0 { 0.0 } else { PI } }
    };
    let mut two = [0, 1].map(|k| MotionScript::new(stance(k), variation));
    for s in &mut two {
        greet_with_nod(s, 0.45);
        s.wait_until(BEFORE);
    }
    match what {
        PairActivity::Chat => talk(&mut two, 0.0, rng),
        PairActivity::Dispute => talk(&mut two, 1.0, rng),
        PairActivity::Handshake => shake_hands(&mut two, rng),
        PairActivity::Handover => hand_over(&mut two, rng),
        PairActivity::Dance => dance(&mut two),
    }
    let end = two.iter().map(|s| s.now).fold(0.0, f64::max);
    for s in &mut two {
        s.wait_until(end);
        s.tag(what.name(), BEFORE);
        greet_with_nod(s, end + 0.9);
        s.wait_until(end + BEFORE);
    }
    two
}

/// Adds a nod, before and after an activity.
fn greet_with_nod(s: &mut MotionScript, at: f64) {
    s.turn_head(at, 0.25, 0.0, FACE + 0.16, 0.0);
    look_at_face(s, at + 0.35, 0.3);
}

/// Looks at the partner's face at `t`, starting `over` seconds before.
fn look_at_face(s: &mut MotionScript, t: f64, over: f64) {
    s.turn_head(t, over, 0.0, FACE, 0.0);
}

/// Pose of the right hand with its wrist between the two: aside (to the right), up and back from the midpoint.
fn meeting_hand(k: usize, DVec3 { x, y, z }: DVec3, twist: f64) -> KeyedHandPose {
    let turn = if k == 0 { -1.0 } else { 1.0 };
    let pose = mirrored_for_side(LateralSide::Right, hand_before_body([0.1, -0.35, 0.3], [0.35, -1.0, -0.2], twist));
    KeyedHandPose { room: DVec3::new(turn * x, y, turn * z), placed: 1.0, reach: 0.2, ..pose }
}

/// One person speaks while the other one listens and nods, in turns; in a dispute the turns overlap.
fn talk(two: &mut [MotionScript; 2], heat: f64, rng: &mut impl Rng) {
    let from = two[0].now;
    let facing = [0, 1]
        .map(|k: usize| face_partner(lean_on(LateralSide::BOTH[rng.random_range(0..2)], &two[k], rng), 0.0, heat));
    two.iter_mut().zip(facing).for_each(|(s, facing)| s.pose(from + 0.9, 0.85, facing));
    let mut free = [from + 0.2; 2];
    let mut at = from + 0.2;
    for turn in 0..3 {
        let (speaker, long) = (turn % 2, rng.random_range(2.6..3.6));
        let begin = at.max(free[speaker]);
        let said = TalkStyle { from: begin, to: begin + long, facing: facing[speaker], gaze: 0.0, seated: false, heat };
        free[speaker] = gesture::talk(&mut two[speaker], &said, rng);
        if heat < 0.5 {
            nod(&mut two[1 - speaker], begin.max(free[1 - speaker]) + 0.5, free[speaker] - 0.6, rng);
            free[1 - speaker] = free[1 - speaker].max(free[speaker] - 0.4);
        }
        at = begin + long * (1.0 - 0.45 * heat);
    }
    let end = free[0].max(free[1]) + 0.2;
    for s in two {
        s.pose(end, 0.9, KeyedPosture::default());
        s.turn_head(end, 0.7, 0.0, 0.0, 0.0);
        s.wait_until(end + 0.1);
    }
}

/// Adds occasional nods.
fn nod(s: &mut MotionScript, from: f64, to: f64, rng: &mut impl Rng) {
    let mut t = from;
    while t < to - 0.6 {
        let yaw = s.random_offset(0.06, rng);
        s.turn_head(t + 0.28, 0.25, yaw, FACE + 0.16, 0.0);
        s.turn_head(t + 0.58, 0.28, yaw, FACE, 0.0);
        t += rng.random_range(0.9..1.8);
    }
}

/// Hands meet at the midpoint, go up and down together, and part. Both glance at the hands before they meet.
fn shake_hands(two: &mut [MotionScript; 2], rng: &mut impl Rng) {
    let from = two[0].now;
    let beats: Vec<f64> = [0.035, -0.04, 0.03, -0.035, 0.0].iter().map(|u| u * rng.random_range(0.8..1.2)).collect();
    let over = rng.random_range(0.16..0.19);
    for (k, s) in two.iter_mut().enumerate() {
        s.turn_head(from + 0.4, 0.35, 0.0, 0.12, 0.0);
        look_at_face(s, from + 0.85, 0.4);
        s.pose(from + 0.8, 0.8, KeyedPosture::with_chest(0.14, 0.1));
        s.hand(LateralSide::Right, from + 0.8, 0.75, meeting_hand(k, GRIP, 0.0));
        let mut t = from + 0.9;
        s.hand(LateralSide::Right, t, 0.1, meeting_hand(k, GRIP, 0.0));
        for up in &beats {
            t += over;
            s.hand(LateralSide::Right, t, over, meeting_hand(k, GRIP + DVec3::Y * *up, 0.0));
        }
        s.hand(LateralSide::Right, t + 0.2, 0.15, meeting_hand(k, GRIP, 0.0));
        s.relax(t + 1.1, 0.85);
        s.wait_until(t + 1.2);
    }
}

/// The first person holds something out, the second one takes it.
fn hand_over(two: &mut [MotionScript; 2], rng: &mut impl Rng) {
    let from = two[0].now;
    let near = mirrored_for_side(LateralSide::Right, hand_before_body([0.1, -0.36, 0.24], [0.5, -1.0, -0.3], -0.5));
    let meet = from + 1.9 + rng.random_range(0.0..0.3);
    let [giver, taker] = two;
    // The thing comes up to the belly, is looked at, and is held out.
    giver.hand(LateralSide::Right, from + 0.8, 0.75, near);
    giver.turn_head(from + 0.7, 0.5, 0.0, 0.3, 0.0);
    look_at_face(giver, from + 1.4, 0.4);
    giver.pose(meet, 0.9, KeyedPosture::with_chest(0.14, 0.11));
    giver.hand(LateralSide::Right, meet, 0.85, meeting_hand(0, ENDS, -0.6));
    giver.hand(LateralSide::Right, meet + 0.45, 0.1, meeting_hand(0, ENDS, -0.6));
    giver.turn_head(meet, 0.4, 0.0, 0.2, 0.0);
    look_at_face(giver, meet + 0.5, 0.4);
    giver.relax(meet + 1.5, 0.95);
    taker.turn_head(meet - 0.5, 0.5, 0.0, 0.22, 0.0);
    taker.pose(meet + 0.05, 0.9, KeyedPosture::with_chest(0.14, 0.11));
    taker.hand(LateralSide::Right, meet + 0.05, 0.8, meeting_hand(1, ENDS, -0.5));
    taker.hand(LateralSide::Right, meet + 0.35, 0.1, meeting_hand(1, ENDS, -0.5));
    taker.hand(LateralSide::Right, meet + 1.1, 0.7, near);
    taker.pose(meet + 1.2, 0.8, KeyedPosture::with_chest(0.0, 0.03));
    taker.turn_head(meet + 1.2, 0.4, 0.0, 0.28, 0.0);
    look_at_face(taker, meet + 1.8, 0.4);
    taker.relax(meet + 2.8, 0.8);
    two.iter_mut().for_each(|s| s.wait_until(meet + 2.9));
}

/// Both hold each other's hands and step aside together, forth and back.
fn dance(two: &mut [MotionScript; 2]) {
    let from = two[0].now;
    for (k, s) in two.iter_mut().enumerate() {
        let hands = hand_before_body([0.17, -0.33, 0.31], [0.7, -1.0, -0.2], 0.35);
        LateralSide::BOTH.into_iter().for_each(|side| s.hand(side, from + 1.0, 0.9, mirrored_for_side(side, hands)));
        look_at_face(s, from + 0.8, 0.5);
        s.wait_until(from + 1.1);
        let home = s.stance;
        // Equal direction in the room: left for one is right for the other.
        let offset = leftward(0.0) * 0.22;
        let lead = if k == 0 { LateralSide::Left } else { LateralSide::Right };
        for there in [1.0, 0.0, -1.0, 0.0, 1.0, 0.0] {
            let to = FeetStance { at: home.at + offset * there, heading: home.heading };
            let forth = to.at.dot(offset) > s.stance.at.dot(offset);
            let first = if forth { lead } else { lead.other() };
            for side in [first, first.other()] {
                s.step(ScriptStep { period: 0.56, ..ScriptStep::aside(side, to) });
            }
        }
        let t = s.now + 0.3;
        s.relax(t + 1.0, 0.95);
        s.wait_until(t + 1.1);
    }
}
