//! Work at the desk: typing, using the mouse, reading, leaning back, and talking to a visitor beside the desk.

use super::gesture::{self, TalkStyle};
use super::{KeyedHandPose, KeyedPosture, LAP, MotionScript, SITTING, ScriptStep, TOP, mirrored_for_side};
use crate::walk::wander::TOE_OUT;
use crate::{attitude::Attitude, deck::CardDeck, side::LateralSide, walk::footsteps::FeetStance};
use glam::{DVec2, DVec3};
use rand::{Rng, RngExt};

/// Height of the wrist of a hand on the desk (m).
const WRIST: f64 = TOP + 0.035;

/// A task at the desk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DeskTask {
    Type,
    Mouse,
    Read,
    LeanBack,
    Chat(LateralSide),
}

/// Dealer of tasks.
pub struct Worker {
    tasks: CardDeck<DeskTask>,
}

impl Worker {
    /// No task dealt yet.
    pub fn new() -> Self {
        use {DeskTask::*, LateralSide::*};
        let [left, right] = [Left, Right].map(Chat);
        let tasks = [Type, Mouse, Type, Read, Mouse, Type, LeanBack, Read, LeanBack, left, right, left, right];
        Self { tasks: CardDeck::new(&tasks) }
    }

    /// Works from `begin` until about `end`; the hands begin and end on the thighs.
    pub fn work(&mut self, script: &mut MotionScript, begin: f64, end: f64, rng: &mut impl Rng) {
        let (mut t, mut began) = (begin + 0.9, begin);
        let mut last = None;
        while t < end - 2.5 {
            if last.is_some() && rng.random_bool(0.5) {
                move_foot(script, t, rng);
            }
            let mut task = self.tasks.deal(rng);
            if last == Some(task) {
                task = self.tasks.deal(rng);
            }
            let mut until = (t + rng.random_range(4.0..9.0)).min(end);
            match task {
                DeskTask::Type => type_text(script, t, until, rng),
                DeskTask::Mouse => use_mouse(script, t, until, rng),
                DeskTask::Read => read_screen(script, t, until, rng),
                DeskTask::LeanBack => lean_back(script, t, until, rng),
                DeskTask::Chat(side) => {
                    close_ankles(script, "work", began, t);
                    until = chat(script, side, t, until, rng);
                    close_ankles(script, "desk_chat", t, until);
                    began = until;
                }
            }
            last = Some(task);
            t = until;
        }
        for side in LateralSide::BOTH {
            hand_to_lap(script, side, t, rng);
        }
        script.pose(t + 0.8, 0.8, SITTING);
        script.turn_head(t + 0.8, 0.6, 0.0, 0.05, 0.0);
        script.wait_until(t + 1.0);
        close_ankles(script, "work", began, t + 1.0);
    }
}

/// Left hand on the near edge of the desk, `aside` metres from its middle.
pub fn over_desk_edge(aside: f64) -> KeyedHandPose {
    KeyedHandPose {
        held: 1.0,
        room: DVec3::new(aside, WRIST, 0.515),
        placed: 1.0,
        pole: DVec3::new(0.7, -0.8, -0.5),
        twist: 1.25,
        ..KeyedHandPose::HANGING
    }
}

/// Moves one foot a little under the desk.
fn move_foot(script: &mut MotionScript, t: f64, rng: &mut impl Rng) {
    script.wait_until(t);
    let side = LateralSide::BOTH[usize::from(rng.random_bool(0.5))];
    let to = FeetStance { at: DVec2::new(0.0, rng.random_range(0.38..0.52)), heading: 0.0 };
    let (width, toe_out) = (0.24 + script.random_offset(0.04, rng), TOE_OUT * (1.0 + script.random_offset(0.8, rng)));
    script.step(ScriptStep { width, toe_out, period: 0.6, ..ScriptStep::aside(side, to) });
}

fn close_ankles(script: &mut MotionScript, name: &'static str, from: f64, to: f64) {
    if to - from > 0.5 {
        script.tags.push((name, from, to));
    }
}

/// True for a hand at or over the desk, rather than on the thigh or in the air.
fn hand_on_desk(hand: &KeyedHandPose) -> bool {
    hand.placed > 0.5 && hand.room.y > TOP
}

/// Moves a hand onto the desk, over its edge rather than through it.
///
/// - returns the time of arrival (s).
fn hand_to_desk(script: &mut MotionScript, side: LateralSide, t: f64, pose: KeyedHandPose, rng: &mut impl Rng) -> f64 {
    let now = script.hand_now(side);
    if hand_on_desk(&now) {
        let there = t + 0.3 + 1.2 * now.room.distance(pose.room);
        let over = KeyedHandPose { room: now.room.lerp(pose.room, 0.5) + DVec3::Y * 0.02, ..pose };
        script.hand(side, 0.5 * (t + there), 0.5 * (there - t), over);
        script.hand(side, there, 0.5 * (there - t), pose);
        return there;
    }
    let start = t + rng.random_range(0.0..0.15);
    let before = KeyedHandPose { room: DVec3::new(0.5 * (now.room.x + pose.room.x), 0.85, 0.39), twist: 0.7, ..pose };
    script.hand(side, start + 0.5, 0.5, before);
    script.hand(side, start + 0.95, 0.45, pose);
    start + 0.95
}

/// Moves a hand back onto the thigh.
fn hand_to_lap(script: &mut MotionScript, side: LateralSide, t: f64, rng: &mut impl Rng) -> f64 {
    let now = script.hand_now(side);
    let mut lap = mirrored_for_side(side, LAP);
    lap.room += DVec3::new(script.random_offset(0.015, rng), 0.0, script.random_offset(0.03, rng));
    let start = t + rng.random_range(0.0..0.1);
    if hand_on_desk(&now) {
        let before = KeyedHandPose { room: DVec3::new(now.room.x, 0.84, 0.42), twist: 0.8, flex: 0.1, ..lap };
        script.hand(side, start + 0.4, 0.4, before);
        script.hand(side, start + 0.85, 0.45, lap);
        return start + 0.85;
    }
    script.hand(side, start + 0.7, 0.7, lap);
    start + 0.7
}

fn sit(script: &mut MotionScript, t: f64, over: f64, lean: f64, turn: f64, rng: &mut impl Rng) {
    let vary = script.random_offset(0.03, rng);
    let posture = KeyedPosture {
        hips: Attitude { pitch: SITTING.hips.pitch + 0.35 * lean, list: script.random_offset(0.015, rng), yaw: 0.0 },
        chest: Attitude { yaw: turn, pitch: SITTING.chest.pitch + lean + vary, list: script.random_offset(0.03, rng) },
        ..SITTING
    };
    script.pose(t + over, over, posture);
}

/// Small movements of the head that follow the eyes.
fn watch_screen(script: &mut MotionScript, from: f64, to: f64, [yaw, pitch]: [f64; 2], rng: &mut impl Rng) {
    let mut t = from + 0.7;
    while t < to - 0.3 {
        let (dy, dp) = (script.random_offset(0.08, rng), script.random_offset(0.05, rng));
        script.turn_head(t, 0.45, yaw + dy, pitch + dp, 0.3 * dy);
        t += rng.random_range(0.9..2.2);
    }
}

/// Types with both hands on the keyboard: bursts of strokes, shown as small movements of the hands.
fn type_text(script: &mut MotionScript, from: f64, to: f64, rng: &mut impl Rng) {
    sit(script, from, 1.1, 0.18, 0.0, rng);
    watch_screen(script, from, to, [0.0, 0.2], rng);
    let keyboard = KeyedHandPose { room: DVec3::new(0.11, WRIST + 0.012, 0.515), flex: -0.05, ..over_desk_edge(0.0) };
    for side in LateralSide::BOTH {
        let home = mirrored_for_side(side, keyboard);
        let mut t = hand_to_desk(script, side, from, home, rng);
        let touched = t;
        while t < to - 0.4 {
            let burst = t + rng.random_range(0.8..2.6);
            while t < burst.min(to - 0.3) {
                t += rng.random_range(0.15..0.24);
                let mut vary = |amount: f64| script.random_offset(amount, rng);
                let stroke = KeyedHandPose {
                    room: home.room + DVec3::new(vary(0.016), 0.004 + vary(0.004), vary(0.01)),
                    flex: home.flex + vary(0.1),
                    twist: home.twist + vary(0.05),
                    ..home
                };
                script.hand(side, t, 0.14, stroke);
            }
            t += rng.random_range(0.2..0.8);
        }
        script.hand(side, to, 0.2, home);
        script.rest_hand(side, touched, to);
    }
}

/// Uses the mouse with one hand, with the other one on the desk or on the thigh.
fn use_mouse(script: &mut MotionScript, from: f64, to: f64, rng: &mut impl Rng) {
    sit(script, from, 1.1, 0.1, -0.05, rng);
    watch_screen(script, from, to, [0.0, 0.12], rng);
    if rng.random_bool(0.5) {
        hand_to_lap(script, LateralSide::Left, from, rng);
    } else {
        let arm = over_desk_edge(0.17 + script.random_offset(0.03, rng));
        let touched = hand_to_desk(script, LateralSide::Left, from, arm, rng);
        script.hand(LateralSide::Left, to, 0.1, arm);
        script.rest_hand(LateralSide::Left, touched, to);
    }
    let mouse =
        KeyedHandPose { room: DVec3::new(0.31, WRIST + 0.01, 0.53), flex: -0.1, ..over_desk_edge(0.0) }.mirrored();
    let touched = hand_to_desk(script, LateralSide::Right, from, mouse, rng);
    let mut t = touched;
    while t < to - 0.8 {
        let still = rng.random_range(0.15..0.9);
        let moves = rng.random_range(0.25..0.5);
        let room = mouse.room + DVec3::new(script.random_offset(0.035, rng), 0.0, script.random_offset(0.025, rng));
        let flex = mouse.flex + script.random_offset(0.06, rng);
        t = (t + still + moves).min(to - 0.3);
        script.hand(LateralSide::Right, t, moves, KeyedHandPose { room, flex, ..mouse });
    }
    script.hand(LateralSide::Right, to, 0.25, mouse);
    script.rest_hand(LateralSide::Right, touched, to);
}

/// Leans towards the screen, with the forearms on the desk, and now and then the chin on a hand.
fn read_screen(script: &mut MotionScript, from: f64, to: f64, rng: &mut impl Rng) {
    let thinker = rng.random_bool(0.5).then(|| LateralSide::BOTH[usize::from(rng.random_bool(0.5))]);
    sit(script, from, 1.3, 0.24, thinker.map_or(0.0, |s| -0.1 * s.sign()), rng);
    watch_screen(script, from, to, [0.0, 0.12], rng);
    for side in LateralSide::BOTH {
        let arm = mirrored_for_side(side, KeyedHandPose { room: DVec3::new(0.15, WRIST, 0.55), ..over_desk_edge(0.0) });
        let touched = hand_to_desk(script, side, from, arm, rng);
        if thinker == Some(side) && to - from > 4.5 {
            let chin = mirrored_for_side(side, gesture::CHIN);
            script.hand(side, touched + 1.3, 1.0, chin);
            script.hand(side, to - 1.1, 0.3, chin);
            script.hand(side, to - 0.1, 1.0, arm);
        } else {
            script.hand(side, to, 0.1, arm);
            script.rest_hand(side, touched, to);
        }
    }
}

/// Leans back, with the hands on the thighs.
fn lean_back(script: &mut MotionScript, from: f64, to: f64, rng: &mut impl Rng) {
    let lean = |pitch: f64| Attitude { pitch, ..Attitude::default() };
    let back = KeyedPosture { hips: lean(-0.34), chest: lean(-0.25), ..SITTING };
    for side in LateralSide::BOTH {
        hand_to_lap(script, side, from, rng);
        script.hand(side, to, 0.1, script.hand_now(side));
    }
    script.pose(from + 1.5, 1.3, back);
    watch_screen(script, from, to, [script.random_offset(0.3, rng), 0.08], rng);
    script.pose(to, 0.1, back);
}

/// Turns to a visitor beside the desk and talks.
///
/// - returns the end (s).
fn chat(script: &mut MotionScript, side: LateralSide, from: f64, to: f64, rng: &mut impl Rng) -> f64 {
    let turn = side.sign() * (0.5 + script.random_offset(0.12, rng));
    let turned = KeyedPosture {
        hips: Attitude { yaw: 0.12 * turn, ..SITTING.hips },
        chest: Attitude { yaw: 0.8 * turn, pitch: 0.03, list: 0.0 },
        ..SITTING
    };
    script.pose(from + 1.1, 1.1, turned);
    script.turn_head(from + 0.8, 0.8, 1.5 * turn, 0.0, 0.0);
    // The hands leave the desk before talking.
    let ready = LateralSide::BOTH.map(|s| hand_to_lap(script, s, from, rng)).into_iter().fold(from, f64::max);
    let (begin, gaze) = (ready.max(from + 1.1), 1.5 * turn);
    let talk = TalkStyle { from: begin, to: to - 0.9, facing: turned, gaze, seated: true, heat: 0.0 };
    let to = gesture::talk(script, &talk, rng) + 0.9;
    script.turn_head(to, 0.7, 0.0, 0.1, 0.0);
    script.pose(to, 0.8, SITTING);
    to
}
