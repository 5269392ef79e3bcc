//! Scripts of the acts.

use crate::office::gesture::{self, CHIN, TalkStyle, hand_before_body, on_hip};
use crate::office::posture::{KeyedHandPose, KeyedPosture};
use crate::office::stand::{clasp_hands, lean_on, look_around, look_at_watch};
use crate::office::visit::{self, mirrored_for_side};
use crate::walk::footsteps::FeetStance;
use crate::{attitude::Attitude, office::desk::BEFORE_SEAT, office::script::MotionScript, side::LateralSide};
use HandsAtRest::{Chin, Clasp, Hang, Hip, Watch};
use LateralSide::{Left, Right};
use PersonAct::{Buy, Chat, Cheer, Handshake, Look, Nod, Put, Queue, Sit, Take, Wave};
use glam::{DVec2, DVec3};
use rand::{Rng, RngExt};

/// Act of a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PersonAct {
    /// Waves with a hand.
    Wave(LateralSide),
    /// Nods to a partner, with a hand half raised.
    Nod(LateralSide),
    /// Gives the right hand.
    Handshake,
    /// Looks at something in front.
    Look(HandsAtRest),
    /// Hands something over and takes something.
    Buy(LateralSide),
    /// Talks to a partner, in a mood from calm (0) to heated (1).
    Chat(f64),
    /// Sits down, sits and stands up.
    Sit,
    /// Waits.
    Queue(HandsAtRest),
    /// Throws the arms up.
    Cheer,
    /// Takes a thing in front.
    Take(LateralSide, Height),
    /// Puts down a thing in front.
    Put(LateralSide, Height),
}

/// Height of a thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Height {
    /// On a table.
    Table,
    /// On a shelf, as high as the chest.
    Shelf,
}

/// Resting position of the hands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HandsAtRest {
    /// Hanging.
    Hang,
    /// Clasped before the belly.
    Clasp,
    /// One hand on the hip.
    Hip(LateralSide),
    /// One hand at the chin, the other under its elbow.
    Chin(LateralSide),
    /// One hand raised now and then, to look at the watch.
    Watch,
}

/// Time of standing before an act (s).
const BEFORE_S: f64 = 0.6;

/// Forearm up beside the head, palm ahead.
const WAVE: KeyedHandPose = hand_before_body([0.33, 0.1, 0.24], [0.7, -1.0, 0.0], 1.5);
/// Hand half up, palm ahead.
const HALF: KeyedHandPose = hand_before_body([0.27, -0.12, 0.3], [0.6, -1.0, -0.2], 1.2);
/// Hand given to a partner half a step away.
const GIVEN: KeyedHandPose =
    KeyedHandPose { reach: 0.22, ..hand_before_body([0.045, -0.3, 0.45], [0.35, -1.0, -0.2], 0.05) };
/// Hand over a counter, palm down and palm up.
const OVER: KeyedHandPose =
    KeyedHandPose { reach: 0.2, ..hand_before_body([0.12, -0.3, 0.46], [0.5, -1.0, -0.2], 0.7) };
const UNDER: KeyedHandPose =
    KeyedHandPose { reach: 0.15, ..hand_before_body([0.12, -0.34, 0.43], [0.5, -1.0, -0.2], -0.9) };
/// Hand around a thing on a table, and on a shelf; carrying it beside the hip.
const ON_TABLE: KeyedHandPose =
    KeyedHandPose { reach: 0.2, ..hand_before_body([0.15, -0.52, 0.4], [0.7, -0.8, -0.4], 0.25) };
const ON_SHELF: KeyedHandPose =
    KeyedHandPose { reach: 0.25, ..hand_before_body([0.14, -0.28, 0.46], [0.7, -1.0, -0.2], 0.2) };
const CARRIED: KeyedHandPose = hand_before_body([0.2, -0.42, 0.16], [0.5, -1.0, -0.5], 0.4);
/// Hand at a bag or a pocket.
const POCKET: KeyedHandPose = hand_before_body([0.2, -0.48, 0.1], [0.6, -0.6, -0.8], 0.9);
/// Hand under the elbow of the other arm.
const UNDER_ELBOW: KeyedHandPose = hand_before_body([-0.02, -0.32, 0.19], [0.9, -0.9, -0.2], 0.4);
/// Hand over the head.
const UP: KeyedHandPose = KeyedHandPose { shrug: 0.25, ..hand_before_body([0.34, 0.38, 0.1], [1.0, -0.4, -0.1], 1.2) };

impl PersonAct {
    /// All acts, in the order in which clips are made.
    pub const LIST: [&[Self]; 5] = [
        &[Wave(Right), Handshake, Look(Chin(Right)), Buy(Right), Chat(0.1), Sit, Queue(Hang), Cheer],
        &[Nod(Right), Look(Clasp), Chat(0.4), Queue(Hip(Left)), Buy(Left), Sit, Wave(Left), Look(Hang)],
        &[Chat(0.0), Queue(Watch), Cheer, Look(Hip(Right)), Chat(0.2), Queue(Clasp), Nod(Left)],
        &[Take(Right, Height::Table), Put(Right, Height::Table), Take(Left, Height::Table), Put(Left, Height::Table)],
        &[Take(Right, Height::Shelf), Put(Right, Height::Shelf), Take(Left, Height::Shelf), Put(Left, Height::Shelf)],
    ];

    /// Tag of the act.
    pub fn tag(self) -> &'static str {
        match self {
            Wave(_) | Nod(_) => "greet",
            Handshake => "handshake",
            Look(_) => "look",
            Buy(_) => "buy",
            Chat(_) => "chat",
            Sit => "sit",
            Queue(_) => "queue",
            Cheer => "cheer",
            Take(..) => "take",
            Put(..) => "put",
        }
    }

    /// The script of a clip.
    ///
    /// - `variation`: factor on the usual variation.
    pub fn script(self, variation: f64, rng: &mut impl Rng) -> MotionScript {
        let at = if self == Sit { DVec2::new(0.0, BEFORE_SEAT) } else { DVec2::ZERO };
        let mut script = MotionScript::new(FeetStance { at, heading: 0.0 }, variation);
        let s = &mut script;
        s.wait_until(BEFORE_S);
        let looped = match self {
            Wave(side) => wave(s, side, rng),
            Nod(side) => nod(s, side, rng),
            Handshake => shake_hands(s, rng),
            Look(rest) => stand(s, rest, 9.0, true, rng),
            Buy(side) => buy(s, side, rng),
            Chat(heat) => chat(s, heat, rng),
            Sit => sit(s, rng),
            Queue(rest) => stand(s, rest, 10.0, false, rng),
            Cheer => cheer(s, rng),
            Take(side, height) => handle(s, side, height, true, rng),
            Put(side, height) => handle(s, side, height, false, rng),
        };
        let end = s.now;
        s.tags.push((self.tag(), 0.5 * BEFORE_S, end + 0.3));
        s.tags.extend(looped.map(|[from, to]| ("loop", from, to)));
        s.wait_until(end + 0.4);
        script
    }
}

/// Begin and end of the part of an act that may loop (s).
type LoopSpan = Option<[f64; 2]>;

/// Returns everything to rest.
fn return_to_rest(s: &mut MotionScript, t: f64, over: f64) {
    s.relax(t + over, over);
    s.wait_until(t + over);
}

fn wave(s: &mut MotionScript, side: LateralSide, rng: &mut impl Rng) -> LoopSpan {
    let from = s.now;
    let raised = KeyedHandPose {
        body: WAVE.body + DVec3::new(0.0, s.random_offset(0.04, rng), s.random_offset(0.03, rng)),
        ..WAVE
    };
    s.hand(side, from + 0.55, 0.55, mirrored_for_side(side, raised));
    s.pose(from + 0.5, 0.5, KeyedPosture::with_chest(-0.06 * side.sign(), -0.03));
    s.turn_head(from + 0.4, 0.4, 0.0, -0.12, 0.06 * side.sign());
    let mut t = from + 0.55;
    for out in [0.1, -0.05, 0.09, -0.05, 0.06] {
        let over = 0.2 + s.random_offset(0.02, rng);
        t += over;
        let body = raised.body + DVec3::X * out;
        s.hand(side, t, over, mirrored_for_side(side, KeyedHandPose { body, twist: raised.twist, ..raised }));
    }
    s.turn_head(t, 0.4, 0.0, 0.0, 0.0);
    return_to_rest(s, t, 0.75);
    None
}

fn nod(s: &mut MotionScript, side: LateralSide, rng: &mut impl Rng) -> LoopSpan {
    let from = s.now;
    let raised = KeyedHandPose {
        body: HALF.body + DVec3::new(s.random_offset(0.03, rng), s.random_offset(0.03, rng), 0.0),
        ..HALF
    };
    s.hand(side, from + 0.5, 0.5, mirrored_for_side(side, raised));
    s.turn_head(from + 0.3, 0.3, 0.0, -0.1, 0.0);
    s.turn_head(from + 0.65, 0.3, 0.0, 0.22, 0.0);
    s.turn_head(from + 0.95, 0.3, 0.0, 0.0, 0.0);
    s.pose(from + 0.65, 0.5, KeyedPosture::with_chest(0.0, 0.06));
    s.hand(side, from + 1.0, 0.1, mirrored_for_side(side, raised));
    return_to_rest(s, from + 1.0, 0.8);
    None
}

fn shake_hands(s: &mut MotionScript, rng: &mut impl Rng) -> LoopSpan {
    let from = s.now;
    let side = Right;
    s.hand(side, from + 0.7, 0.7, mirrored_for_side(side, GIVEN));
    s.pose(from + 0.7, 0.7, KeyedPosture::with_chest(0.16, 0.1));
    s.turn_head(from + 0.4, 0.4, 0.0, 0.05, 0.0);
    let mut t = from + 0.75;
    for up in [0.035, -0.045, 0.035, -0.04, 0.02] {
        let over = 0.17 + s.random_offset(0.02, rng);
        t += over;
        s.hand(side, t, over, mirrored_for_side(side, KeyedHandPose { body: GIVEN.body + DVec3::Y * up, ..GIVEN }));
    }
    s.turn_head(t, 0.3, 0.0, 0.14, 0.0);
    s.hand(side, t + 0.15, 0.1, mirrored_for_side(side, GIVEN));
    return_to_rest(s, t + 0.15, 0.85);
    None
}

fn buy(s: &mut MotionScript, side: LateralSide, rng: &mut impl Rng) -> LoopSpan {
    let from = s.now;
    s.hand(side, from + 0.6, 0.6, mirrored_for_side(side, POCKET));
    s.turn_head(from + 0.5, 0.4, 0.15 * side.sign(), 0.3, 0.0);
    s.hand(side, from + 1.4, 0.65, mirrored_for_side(side, OVER));
    s.pose(from + 1.4, 0.7, KeyedPosture::with_chest(-0.12 * side.sign(), 0.14));
    s.turn_head(from + 1.2, 0.45, 0.0, 0.22, 0.0);
    s.hand(side, from + 1.7, 0.1, mirrored_for_side(side, OVER));
    s.let_hang(side, from + 2.5, 0.7);
    s.turn_head(from + 2.1, 0.4, s.random_offset(0.05, rng), 0.0, 0.0);
    let other = side.other();
    let take = from + 2.4 + s.random_offset(0.15, rng);
    s.hand(other, take + 0.7, 0.7, mirrored_for_side(other, UNDER));
    s.pose(take + 0.7, 0.8, KeyedPosture::with_chest(0.12 * side.sign(), 0.13));
    s.turn_head(take + 0.6, 0.4, 0.0, 0.25, 0.0);
    s.hand(other, take + 1.0, 0.1, mirrored_for_side(other, UNDER));
    s.turn_head(take + 1.3, 0.3, 0.0, 0.12, 0.0);
    return_to_rest(s, take + 1.0, 0.9);
    None
}

/// Takes a thing, or puts it down. The hand is tagged from the grasp to the end of the act, or from its begin to the
/// release.
fn handle(s: &mut MotionScript, side: LateralSide, height: Height, takes: bool, rng: &mut impl Rng) -> LoopSpan {
    let begin = 0.5 * BEFORE_S;
    let from = s.now;
    let (around, lean, down) = match height {
        Height::Table => (ON_TABLE, 0.36, 0.35),
        Height::Shelf => (ON_SHELF, 0.04, 0.1),
    };
    let body = around.body + DVec3::new(0.0, s.random_offset(0.02, rng), s.random_offset(0.02, rng));
    let around = mirrored_for_side(side, KeyedHandPose { body, ..around });
    s.turn_head(from + 0.4, 0.4, -0.08 * side.sign(), down, 0.0);
    s.pose(from + 0.85, 0.85, KeyedPosture::with_chest(-0.1 * side.sign(), lean));
    s.hand(side, from + 0.85, 0.8, around);
    let grasp = from + 0.95;
    s.hand(side, grasp, 0.1, around);
    s.turn_head(grasp + 0.5, 0.45, 0.0, 0.0, 0.0);
    if takes {
        s.hand(side, grasp + 0.6, 0.55, mirrored_for_side(side, CARRIED));
    }
    return_to_rest(s, grasp + if takes { 0.65 } else { 0.1 }, 0.8);
    let tag = ["left_hand", "right_hand"][side.index()];
    s.tags.push(if takes { (tag, grasp, s.now + 0.3) } else { (tag, begin, grasp) });
    None
}

fn chat(s: &mut MotionScript, heat: f64, rng: &mut impl Rng) -> LoopSpan {
    let from = s.now;
    let side = LateralSide::BOTH[rng.random_range(0..2)];
    let lean = lean_on(side, s, rng);
    let facing = KeyedPosture { chest: Attitude { yaw: 0.0, pitch: 0.05 * heat, ..lean.chest }, ..lean };
    s.pose(from + 0.9, 0.85, facing);
    let talk = TalkStyle { from, to: from + 11.0, facing, gaze: 0.0, seated: false, heat };
    let to = gesture::talk(s, &talk, rng);
    s.pose(to, 0.9, KeyedPosture::default());
    s.turn_head(to, 0.7, 0.0, 0.0, 0.0);
    s.wait_until(to + 0.3);
    Some([from + 1.0, to - 1.0])
}

fn sit(s: &mut MotionScript, rng: &mut impl Rng) -> LoopSpan {
    visit::take_seat(s, false, rng);
    let seated = s.now;
    for k in 0..3 {
        let t = seated + 1.0 + 2.6 * f64::from(k);
        s.turn_head(t, 0.8, s.random_offset(0.45, rng), s.random_offset(0.08, rng), 0.0);
    }
    s.wait_until(seated + 8.0);
    let rises = s.now;
    s.turn_head(rises, 0.8, 0.0, 0.1, 0.0);
    visit::rise(s, false, rng);
    Some([seated + 0.1, rises])
}

/// Stands with the weight on alternating legs, and looks ahead or about.
fn stand(s: &mut MotionScript, rest: HandsAtRest, long: f64, ahead: bool, rng: &mut impl Rng) -> LoopSpan {
    let from = s.now;
    let sides = if rng.random_bool(0.5) { LateralSide::BOTH } else { [Right, Left] };
    let first = lean_on(sides[0], s, rng);
    let second = lean_on(sides[1], s, rng);
    s.pose(from + 1.1, 1.1, first);
    let ready = take_rest_pose(s, rest, from);
    let to = ready + long;
    s.pose(ready + 0.45 * long, 1.2, second);
    s.pose(to, 1.2, first);
    if ahead {
        gaze(s, ready, to, rng);
    } else {
        let free = if rest == Watch { look_at_watch(s, ready + 1.0, rng) } else { ready };
        look_around(s, free, to - 0.8, rng);
    }
    s.turn_head(to, 0.7, 0.0, 0.0, 0.0);
    return_to_rest(s, to, 1.1);
    Some([ready, to])
}

/// Moves the hands to their resting position.
///
/// - returns the time of arrival (s).
fn take_rest_pose(s: &mut MotionScript, rest: HandsAtRest, from: f64) -> f64 {
    let there = from + 1.1;
    match rest {
        Hang | Watch => {}
        Clasp => clasp_hands(s, there),
        Hip(side) => s.hand(side, there, 0.9, on_hip(side)),
        Chin(side) => {
            s.hand(side, there, 0.9, mirrored_for_side(side, CHIN));
            s.hand(side.other(), there, 0.95, mirrored_for_side(side.other(), UNDER_ELBOW));
        }
    }
    there + 0.1
}

/// Lets the eyes wander over something ahead.
fn gaze(s: &mut MotionScript, from: f64, to: f64, rng: &mut impl Rng) {
    let mut t = from;
    while t < to - 2.4 {
        let over = 0.6 + s.random_offset(0.15, rng).abs();
        t += over;
        s.turn_head(t, over, s.random_offset(0.22, rng), -0.06 + s.random_offset(0.1, rng), s.random_offset(0.06, rng));
        t += rng.random_range(0.6..1.6);
    }
}

fn cheer(s: &mut MotionScript, rng: &mut impl Rng) -> LoopSpan {
    let from = s.now;
    let up = |side: LateralSide, s: &MotionScript, rng: &mut _| {
        let by = DVec3::new(s.random_offset(0.05, rng), s.random_offset(0.03, rng), s.random_offset(0.05, rng));
        mirrored_for_side(side, KeyedHandPose { body: UP.body + by, ..UP })
    };
    let poses = LateralSide::BOTH.map(|side| up(side, s, rng));
    let low = KeyedPosture { dip: 0.05, ..KeyedPosture::with_chest(0.0, 0.08) };
    let high = KeyedPosture { dip: 0.0, ..KeyedPosture::with_chest(0.0, -0.08) };
    s.pose(from + 0.35, 0.35, low);
    s.pose(from + 0.7, 0.35, high);
    s.turn_head(from + 0.7, 0.5, 0.0, -0.15, 0.0);
    for (side, pose) in LateralSide::BOTH.into_iter().zip(poses) {
        s.hand(side, from + 0.7, 0.55, pose);
    }
    let ready = from + 0.7;
    let mut t = ready;
    for _ in 0..4 {
        s.pose(t + 0.32, 0.3, low);
        s.pose(t + 0.64, 0.3, high);
        for (side, pose) in LateralSide::BOTH.into_iter().zip(poses) {
            let down = KeyedHandPose { body: pose.body + DVec3::new(0.0, -0.14, 0.03), ..pose };
            s.hand(side, t + 0.32, 0.3, down);
            s.hand(side, t + 0.64, 0.3, pose);
        }
        t += 0.64 + s.random_offset(0.04, rng).abs();
    }
    LateralSide::BOTH.into_iter().zip(poses).for_each(|(side, pose)| s.hand(side, t, 0.05, pose));
    return_to_rest(s, t, 0.9);
    Some([ready, t])
}
