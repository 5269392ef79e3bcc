//! Talking: gestures of the hands, nods and glances, from a quiet chat to a dispute.

use super::super::attitude::Attitude;
use super::super::side::LateralSide;
use super::posture::{KeyedHandPose, KeyedPosture};
use super::script::MotionScript;
use super::visit::{LAP, mirrored_for_side};
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
    let speaks = rng.random_range(0..4);
    let free = |side: LateralSide| speaks > 1 || speaks == side.index();
    // The other hand hangs, or is on the hip.
    for side in LateralSide::BOTH {
        if free(side) {
            script.hand(side, talk.from + 0.7, 0.65, home_pose(talk, side, script, rng));
        } else if !talk.seated && rng.random_bool(0.2 + 0.4 * talk.heat) {
            script.hand(side, talk.from + 0.9, 0.8, mirrored_for_side(side, ON_HIP));
        }
    }
    let mut t = talk.from + 0.8;
    while t < talk.to - 2.0 {
        let phrase = deal_phrase(talk.heat, rng);
        let leader = if speaks < 2 { LateralSide::BOTH[speaks] } else { LateralSide::BOTH[rng.random_range(0..2)] };
        let both = speaks > 1 && (phrase == Phrase::Open || rng.random_bool(0.4));
        let mut until = t;
        for side in LateralSide::BOTH.into_iter().filter(|s| *s == leader || both) {
            let lag = if side == leader { 0.0 } else { rng.random_range(0.02..0.09) };
            until = until.max(gesture(script, talk, phrase, side, t + lag, rng));
        }
        move_head_and_trunk(script, talk, phrase, t, until, rng);
        t = until.max(t + 0.5);
    }
    let end = talk.to.max(t + 0.9);
    for side in LateralSide::BOTH {
        if talk.seated {
            script.hand(side, end, 0.85, mirrored_for_side(side, LAP));
        } else {
            script.let_hang(side, end, 0.85);
        }
    }
    end
}

fn deal_phrase(heat: f64, rng: &mut impl Rng) -> Phrase {
    use Phrase::*;
    let calm = [Beat, Beat, Open, Offer, Listen, Listen, Listen];
    let hot = [Beat, Chop, Chop, Point, Point, Open, Listen];
    let of = if rng.random_bool(heat) { hot } else { calm };
    of[rng.random_range(0..of.len())]
}

fn home_pose(talk: &TalkStyle, side: LateralSide, script: &MotionScript, rng: &mut impl Rng) -> KeyedHandPose {
    let base = if rng.random_bool(0.75) || talk.seated { HOME } else { LOW };
    let lift = if talk.seated { 0.04 } else { 0.03 * talk.heat };
    let jitter = DVec3::new(
        script.random_offset(0.025, rng),
        lift + script.random_offset(0.025, rng),
        script.random_offset(0.02, rng),
    );
    let lap = LAP.room;
    mirrored_for_side(side, KeyedHandPose { body: base.body + jitter, room: lap, ..base })
}

/// Adds one phrase of one hand, from `t`.
///
/// - returns its end (s).
fn gesture(
    script: &mut MotionScript,
    talk: &TalkStyle,
    phrase: Phrase,
    side: LateralSide,
    t: f64,
    rng: &mut impl Rng,
) -> f64 {
    let size = (1.0 + 0.45 * talk.heat) * (1.0 + script.random_offset(0.2, rng));
    let rest = home_pose(talk, side, script, rng);
    match phrase {
        Phrase::Listen => {
            let until = t + rng.random_range(0.9..2.0) * (1.0 - 0.4 * talk.heat);
            script.hand(side, t + 0.7, 0.6, rest);
            until.max(t + 0.8)
        }
        Phrase::Beat => strokes(script, side, t, script.hand_now(side), [0.03, 0.075, 0.05], size, rng),
        Phrase::Chop => {
            let out = reach_gesture(script, talk, side, CHOP, t, rng);
            let end = strokes(script, side, out.0, out.1, [0.0, 0.1, 0.02], size, rng);
            return_hand(script, side, end, rest)
        }
        Phrase::Open | Phrase::Offer | Phrase::Point => {
            let goal = match phrase {
                Phrase::Open => OPEN,
                Phrase::Offer => OFFER,
                _ => POINT,
            };
            let (there, pose) = reach_gesture(script, talk, side, goal, t, rng);
            let hold = there + rng.random_range(0.2..0.7);
            let end = if phrase == Phrase::Point {
                strokes(script, side, there, pose, [0.0, 0.05, 0.03], size, rng)
            } else {
                script.hand(side, hold, 0.1, pose);
                hold
            };
            if rng.random_bool(0.7) { return_hand(script, side, end, rest) } else { end }
        }
    }
}

/// Brings a hand to a gesture.
///
/// - returns the time of arrival, and the pose.
fn reach_gesture(
    script: &mut MotionScript,
    talk: &TalkStyle,
    side: LateralSide,
    goal: KeyedHandPose,
    t: f64,
    rng: &mut impl Rng,
) -> (f64, KeyedHandPose) {
    let jitter =
        DVec3::new(script.random_offset(0.03, rng), script.random_offset(0.03, rng), script.random_offset(0.02, rng));
    let wide = DVec3::new(1.0 + 0.15 * talk.heat, 1.0, 1.0);
    let pose =
        mirrored_for_side(side, KeyedHandPose { body: goal.body * wide + jitter, room: LAP.room, reach: 0.08, ..goal });
    let now = script.hand_now(side);
    let distance = now.body.distance(pose.body) + 0.06 * (now.twist - pose.twist).abs();
    let there = t + 0.24 + distance * (1.15 - 0.4 * talk.heat);
    script.hand(side, there, there - t, pose);
    (there, pose)
}

fn return_hand(script: &mut MotionScript, side: LateralSide, t: f64, rest: KeyedHandPose) -> f64 {
    let distance = script.hand_now(side).body.distance(rest.body);
    let there = t + 0.35 + 1.3 * distance;
    script.hand(side, there, there - t, rest);
    there
}

/// Adds a few strokes around a pose: up slowly, down quickly.
fn strokes(
    script: &mut MotionScript,
    side: LateralSide,
    mut t: f64,
    pose: KeyedHandPose,
    distance: [f64; 3],
    size: f64,
    rng: &mut impl Rng,
) -> f64 {
    let [x, y, z] = distance;
    for _ in 0..rng.random_range(1..4) {
        let size = size * rng.random_range(0.6..1.1);
        let up = DVec3::new(side.sign() * x, y, 0.3 * z) * size;
        let down = DVec3::new(side.sign() * x, -0.25 * y, z) * size;
        let (rise, fall) = (rng.random_range(0.24..0.36), rng.random_range(0.2..0.28));
        script.hand(side, t + rise, rise, KeyedHandPose { body: pose.body + up, flex: pose.flex - 0.15, ..pose });
        script.hand(
            side,
            t + rise + fall,
            fall,
            KeyedHandPose { body: pose.body + down, flex: pose.flex + 0.1, ..pose },
        );
        t += rise + fall + rng.random_range(0.0..0.15);
    }
    script.hand(side, t + 0.25, 0.2, pose);
    t + 0.25
}

/// Moves head and trunk in a phrase: nods while listening, emphasis while speaking, a shake in a dispute.
fn move_head_and_trunk(
    script: &mut MotionScript,
    talk: &TalkStyle,
    phrase: Phrase,
    from: f64,
    to: f64,
    rng: &mut impl Rng,
) {
    let (yaw, list) = (talk.gaze + script.random_offset(0.07, rng), script.random_offset(0.06, rng));
    if phrase == Phrase::Listen {
        nod(script, from + 0.2, to, yaw, list, rng);
    } else if rng.random_bool(0.35 * talk.heat) {
        shake(script, from + 0.1, to, yaw);
    } else {
        let glance = if rng.random_bool(0.25) { script.random_offset(0.35, rng) } else { 0.0 };
        script.turn_head(from + 0.45, 0.4, yaw + glance, 0.02 + script.random_offset(0.06, rng), list);
    }
    let facing = talk.facing;
    let emphasis = if phrase == Phrase::Listen { -0.02 } else { 0.03 + 0.07 * talk.heat };
    let turn = script.random_offset(0.05 + 0.05 * talk.heat, rng);
    let chest = Attitude {
        yaw: facing.chest.yaw + turn,
        pitch: facing.chest.pitch + emphasis,
        list: facing.chest.list + script.random_offset(0.02, rng),
    };
    let shift =
        if talk.seated { [0.0; 2] } else { [facing.shift[0] + script.random_offset(0.012, rng), facing.shift[1]] };
    script.pose(from + 0.6, 0.55, KeyedPosture { chest, shift, ..facing });
}

/// Nods once or twice.
fn nod(script: &mut MotionScript, from: f64, to: f64, yaw: f64, list: f64, rng: &mut impl Rng) {
    let mut t = from + 0.3;
    for _ in 0..rng.random_range(1..3) {
        if t + 0.5 > to {
            return;
        }
        script.turn_head(t, 0.25, yaw, 0.15, list);
        script.turn_head(t + 0.26, 0.26, yaw, 0.0, list);
        t += 0.55;
    }
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
