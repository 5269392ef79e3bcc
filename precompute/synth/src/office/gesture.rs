//! Talking: gestures of the hands, nods and glances, from a quiet chat to a dispute.

use super::{KeyedHandPose, KeyedPosture, LAP, MotionScript, mirrored_for_side};
use crate::{attitude::Attitude, side::LateralSide};
use glam::DVec3;
use rand::{Rng, RngExt};

/// Pose of the left hand before the body: wrist, pole, twist.
pub const fn hand_before_body(body: [f64; 3], pole: [f64; 3], twist: f64) -> KeyedHandPose {
    KeyedHandPose {
        held: 1.0,
        body: DVec3::from_array(body),
        pole: DVec3::from_array(pole),
        twist,
        ..KeyedHandPose::HANGING
    }
}

/// Forearm level, the hand before the belly.
const HOME: KeyedHandPose = hand_before_body([0.12, -0.37, 0.23], [0.55, -1.0, -0.4], 0.55);
/// Arm a little bent at the side.
const LOW: KeyedHandPose = hand_before_body([0.2, -0.44, 0.17], [0.4, -1.0, -0.6], 0.45);
/// Hand out to the side, palm up.
const OPEN: KeyedHandPose = hand_before_body([0.32, -0.32, 0.27], [0.5, -1.0, -0.3], -0.7);
/// Hand forward, palm up.
const OFFER: KeyedHandPose = hand_before_body([0.15, -0.32, 0.38], [0.5, -1.0, -0.2], -0.8);
/// Hand forward, edge down.
const CHOP: KeyedHandPose = hand_before_body([0.12, -0.24, 0.37], [0.6, -1.0, -0.2], 0.0);
/// Pointing at the partner.
const POINT: KeyedHandPose = hand_before_body([0.1, -0.17, 0.46], [0.6, -1.0, -0.1], 0.9);
/// Hand on the hip.
const ON_HIP: KeyedHandPose =
    KeyedHandPose { flex: 0.5, ..hand_before_body([0.245, -0.53, 0.03], [1.0, -0.1, -0.7], 0.9) };
/// Hands clasped before the belly.
pub const CLASP: KeyedHandPose = hand_before_body([0.055, -0.49, 0.21], [0.8, -0.9, -0.5], 0.5);
/// Chin on the hand.
pub const CHIN: KeyedHandPose =
    KeyedHandPose { flex: 0.2, ..hand_before_body([0.05, -0.09, 0.15], [0.5, -1.0, 0.3], -0.5) };

/// A stretch of talking.
#[derive(Clone, Copy, Debug)]
pub struct TalkStyle {
    /// Time at which the hands begin to rise (s).
    pub from: f64,
    /// Time at which the hands are back (s).
    pub to: f64,
    /// Posture while talking.
    pub facing: KeyedPosture,
    /// Heading of the partner relative to the talker (rad).
    pub gaze: f64,
    /// True if the hands start from the thighs and return there.
    pub seated: bool,
    /// Mood: 0 for a chat, 1 for a dispute.
    pub heat: f64,
}

/// Phrase of gestures of the hands.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Phrase {
    Beat,
    Open,
    Offer,
    Listen,
    Point,
    Chop,
}

/// Adds talking: phrases with one hand or both, and listening now and then.
///
/// - returns the time at which the hands are back, possibly a little later than requested (s).
pub fn talk(script: &mut MotionScript, talk: &TalkStyle, rng: &mut impl Rng) -> f64 {
    Talker { script, talk, rng }.speak()
}

/// A person who talks.
struct Talker<'a, R> {
    script: &'a mut MotionScript,
    talk: &'a TalkStyle,
    rng: &'a mut R,
}

impl<R: Rng> Talker<'_, R> {
    fn speak(&mut self) -> f64 {
        let talk = *self.talk;
        let speaks = self.rng.random_range(0..4);
        let free = |side: LateralSide| speaks > 1 || speaks == side.index();
        // The other hand hangs, or is on the hip.
        for side in LateralSide::BOTH {
            if free(side) {
                let home = self.home_pose(side);
                self.script.hand(side, talk.from + 0.7, 0.65, home);
            } else if !talk.seated && self.rng.random_bool(0.2 + 0.4 * talk.heat) {
                self.script.hand(side, talk.from + 0.9, 0.8, on_hip(side));
            }
        }
        let mut t = talk.from + 0.8;
        while t < talk.to - 2.0 {
            let phrase = deal_phrase(talk.heat, self.rng);
            let leader = LateralSide::BOTH[if speaks < 2 { speaks } else { self.rng.random_range(0..2) }];
            let both = speaks > 1 && (phrase == Phrase::Open || self.rng.random_bool(0.4));
            let mut until = t;
            for side in LateralSide::BOTH.into_iter().filter(|s| *s == leader || both) {
                let lag = if side == leader { 0.0 } else { self.rng.random_range(0.02..0.09) };
                until = until.max(self.gesture(phrase, side, t + lag));
            }
            self.move_head_and_trunk(phrase, t, until);
            t = until.max(t + 0.5);
        }
        let end = talk.to.max(t + 0.9);
        for side in LateralSide::BOTH {
            if talk.seated {
                self.script.hand(side, end, 0.85, mirrored_for_side(side, LAP));
            } else {
                self.script.let_hang(side, end, 0.85);
            }
        }
        end
    }

    /// Random offset of up to `amount` either way, by the variation of the script.
    fn vary(&mut self, amount: f64) -> f64 {
        self.script.random_offset(amount, self.rng)
    }

    fn home_pose(&mut self, side: LateralSide) -> KeyedHandPose {
        let seated = self.talk.seated;
        let base = if self.rng.random_bool(0.75) || seated { HOME } else { LOW };
        let lift = if seated { 0.04 } else { 0.03 * self.talk.heat };
        let jitter = DVec3::new(self.vary(0.025), lift + self.vary(0.025), self.vary(0.02));
        mirrored_for_side(side, KeyedHandPose { body: base.body + jitter, room: LAP.room, ..base })
    }

    /// Adds one phrase of one hand, from `t`.
    ///
    /// - returns its end (s).
    fn gesture(&mut self, phrase: Phrase, side: LateralSide, t: f64) -> f64 {
        let heat = self.talk.heat;
        let size = (1.0 + 0.45 * heat) * (1.0 + self.vary(0.2));
        let rest = self.home_pose(side);
        let goal = match phrase {
            Phrase::Listen => {
                let until = t + self.rng.random_range(0.9..2.0) * (1.0 - 0.4 * heat);
                self.script.hand(side, t + 0.7, 0.6, rest);
                return until.max(t + 0.8);
            }
            Phrase::Beat => return self.strokes(side, t, self.script.hand_now(side), [0.03, 0.075, 0.05], size),
            Phrase::Chop => CHOP,
            Phrase::Open => OPEN,
            Phrase::Offer => OFFER,
            Phrase::Point => POINT,
        };
        let (there, pose) = self.reach_gesture(side, goal, t);
        if phrase == Phrase::Chop {
            let end = self.strokes(side, there, pose, [0.0, 0.1, 0.02], size);
            return self.return_hand(side, end, rest);
        }
        let hold = there + self.rng.random_range(0.2..0.7);
        let end = if phrase == Phrase::Point {
            self.strokes(side, there, pose, [0.0, 0.05, 0.03], size)
        } else {
            self.script.hand(side, hold, 0.1, pose);
            hold
        };
        if self.rng.random_bool(0.7) { self.return_hand(side, end, rest) } else { end }
    }

    /// Brings a hand to a gesture.
    ///
    /// - returns the time of arrival, and the pose.
    fn reach_gesture(&mut self, side: LateralSide, goal: KeyedHandPose, t: f64) -> (f64, KeyedHandPose) {
        let jitter = DVec3::new(self.vary(0.03), self.vary(0.03), self.vary(0.02));
        let heat = self.talk.heat;
        let body = goal.body * DVec3::new(1.0 + 0.15 * heat, 1.0, 1.0) + jitter;
        let pose = mirrored_for_side(side, KeyedHandPose { body, room: LAP.room, reach: 0.08, ..goal });
        let now = self.script.hand_now(side);
        let distance = now.body.distance(pose.body) + 0.06 * (now.twist - pose.twist).abs();
        let there = t + 0.24 + distance * (1.15 - 0.4 * heat);
        self.script.hand(side, there, there - t, pose);
        (there, pose)
    }

    fn return_hand(&mut self, side: LateralSide, t: f64, rest: KeyedHandPose) -> f64 {
        let distance = self.script.hand_now(side).body.distance(rest.body);
        let there = t + 0.35 + 1.3 * distance;
        self.script.hand(side, there, there - t, rest);
        there
    }

    /// Adds a few strokes around a pose: up slowly, down quickly.
    fn strokes(&mut self, side: LateralSide, mut t: f64, pose: KeyedHandPose, [x, y, z]: [f64; 3], size: f64) -> f64 {
        for _ in 0..self.rng.random_range(1..4) {
            let size = size * self.rng.random_range(0.6..1.1);
            let up = DVec3::new(side.sign() * x, y, 0.3 * z) * size;
            let down = DVec3::new(side.sign() * x, -0.25 * y, z) * size;
            let (rise, fall) = (self.rng.random_range(0.24..0.36), self.rng.random_range(0.2..0.28));
            let stroke = |by: DVec3, flex: f64| KeyedHandPose { body: pose.body + by, flex: pose.flex + flex, ..pose };
            self.script.hand(side, t + rise, rise, stroke(up, -0.15));
            self.script.hand(side, t + rise + fall, fall, stroke(down, 0.1));
            t += rise + fall + self.rng.random_range(0.0..0.15);
        }
        self.script.hand(side, t + 0.25, 0.2, pose);
        t + 0.25
    }

    /// Moves head and trunk in a phrase: nods while listening, emphasis while speaking, a shake in a dispute.
    fn move_head_and_trunk(&mut self, phrase: Phrase, from: f64, to: f64) {
        let TalkStyle { facing, gaze, seated, heat, .. } = *self.talk;
        let (yaw, list) = (gaze + self.vary(0.07), self.vary(0.06));
        if phrase == Phrase::Listen {
            self.nod(from + 0.2, to, yaw, list);
        } else if self.rng.random_bool(0.35 * heat) {
            shake(self.script, from + 0.1, to, yaw);
        } else {
            let glance = if self.rng.random_bool(0.25) { self.vary(0.35) } else { 0.0 };
            let pitch = 0.02 + self.vary(0.06);
            self.script.turn_head(from + 0.45, 0.4, yaw + glance, pitch, list);
        }
        let emphasis = if phrase == Phrase::Listen { -0.02 } else { 0.03 + 0.07 * heat };
        let yaw = facing.chest.yaw + self.vary(0.05 + 0.05 * heat);
        let chest = Attitude { yaw, pitch: facing.chest.pitch + emphasis, list: facing.chest.list + self.vary(0.02) };
        let shift = if seated { [0.0; 2] } else { [facing.shift[0] + self.vary(0.012), facing.shift[1]] };
        self.script.pose(from + 0.6, 0.55, KeyedPosture { chest, shift, ..facing });
    }

    /// Nods once or twice.
    fn nod(&mut self, from: f64, to: f64, yaw: f64, list: f64) {
        let mut t = from + 0.3;
        for _ in 0..self.rng.random_range(1..3) {
            if t + 0.5 > to {
                return;
            }
            self.script.turn_head(t, 0.25, yaw, 0.15, list);
            self.script.turn_head(t + 0.26, 0.26, yaw, 0.0, list);
            t += 0.55;
        }
    }
}

fn deal_phrase(heat: f64, rng: &mut impl Rng) -> Phrase {
    use Phrase::*;
    let calm = [Beat, Beat, Open, Offer, Listen, Listen, Listen];
    let hot = [Beat, Chop, Chop, Point, Point, Open, Listen];
    let of = if rng.random_bool(heat) { hot } else { calm };
    of[rng.random_range(0..of.len())]
}

/// Shakes the head.
fn shake(script: &mut MotionScript, from: f64, to: f64, yaw: f64) {
    let (mut t, mut turn) = (from + 0.25, 0.2);
    while t < (from + 1.1).min(to) {
        script.turn_head(t, 0.25, yaw + turn, 0.04, 0.0);
        turn *= -0.8;
        t += 0.27;
    }
    script.turn_head(t, 0.27, yaw, 0.03, 0.0);
}

/// Pose of a hand on the hip, for waiting.
pub fn on_hip(side: LateralSide) -> KeyedHandPose {
    mirrored_for_side(side, ON_HIP)
}
