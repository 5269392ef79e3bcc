//! Work at the desk: typing, using the mouse, reading, leaning back, and talking to a visitor beside the desk.

use super::super::attitude::Attitude;
use super::super::deck::Deck;
use super::super::side::Side;
use super::super::walk::footsteps::Stance;
use super::super::walk::wander::TOE_OUT;
use super::desk::TOP;
use super::gesture::{self, Talk};
use super::posture::{HandPose, Posture};
use super::script::{Script, Step};
use super::visit::{LAP, SITTING, on};
use glam::{DVec2, DVec3};
use rand::{Rng, RngExt};

/// Height of the wrist of a hand on the desk (m).
const WRIST: f64 = TOP + 0.035;

/// A task at the desk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    Type,
    Mouse,
    Read,
    LeanBack,
    Chat(Side),
}

/// Dealer of tasks.
pub struct Worker {
    tasks: Deck<Task>,
}

impl Worker {
    /// No task dealt yet.
    pub fn new() -> Self {
        use Task::*;
        let chats = [Chat(Side::Left), Chat(Side::Right), Chat(Side::Left), Chat(Side::Right)];
        let tasks = [&[Type, Mouse, Type, Read, Mouse, Type, LeanBack, Read, LeanBack], chats.as_slice()].concat();
        Self { tasks: Deck::new(&tasks) }
    }
}

/// Left hand on the near edge of the desk, `aside` metres from its middle.
pub fn edge(aside: f64) -> HandPose {
    HandPose {
        held: 1.0,
        room: DVec3::new(aside, WRIST, 0.515),
        placed: 1.0,
        pole: DVec3::new(0.7, -0.8, -0.5),
        twist: 1.25,
        ..HandPose::HANGING
    }
}

/// Left hand over the keyboard.
fn keys() -> HandPose {
    HandPose { room: DVec3::new(0.11, WRIST + 0.012, 0.515), flex: -0.05, ..edge(0.0) }
}

/// Works from `begin` until about `end`; the hands begin and end on the thighs.
pub fn work(worker: &mut Worker, script: &mut Script, begin: f64, end: f64, rng: &mut impl Rng) {
    let (mut t, mut began) = (begin + 0.9, begin);
    let mut last = None;
    while t < end - 2.5 {
        if last.is_some() && rng.random_bool(0.5) {
            move_foot(script, t, rng);
        }
        let mut task = worker.tasks.deal(rng);
        if last == Some(task) {
            task = worker.tasks.deal(rng);
        }
        let mut until = (t + rng.random_range(4.0..9.0)).min(end);
        match task {
            Task::Type => type_text(script, t, until, rng),
            Task::Mouse => use_mouse(script, t, until, rng),
            Task::Read => read(script, t, until, rng),
            Task::LeanBack => lean_back(script, t, until, rng),
            Task::Chat(side) => {
                close(script, "work", began, t);
                until = chat(script, side, t, until, rng);
                close(script, "desk_chat", t, until);
                began = until;
            }
        }
        last = Some(task);
        t = until;
    }
    for side in Side::BOTH {
        to_lap(script, side, t, rng);
    }
    script.pose(t + 0.8, 0.8, SITTING);
    script.look(t + 0.8, 0.6, 0.0, 0.05, 0.0);
    script.wait_until(t + 1.0);
    close(script, "work", began, t + 1.0);
}

/// Moves one foot a little under the desk.
fn move_foot(script: &mut Script, t: f64, rng: &mut impl Rng) {
    script.wait_until(t);
    let side = Side::BOTH[usize::from(rng.random_bool(0.5))];
    let to = Stance { at: DVec2::new(0.0, rng.random_range(0.38..0.52)), heading: 0.0 };
    let (width, toe_out) = (0.24 + script.vary(0.04, rng), TOE_OUT * (1.0 + script.vary(0.8, rng)));
    script.step(Step { width, toe_out, period: 0.6, ..Step::aside(side, to) });
}

fn close(script: &mut Script, name: &'static str, from: f64, to: f64) {
    if to - from > 0.5 {
        script.tags.push((name, from, to));
    }
}

/// True for a hand at or over the desk, rather than on the thigh or in the air.
fn at_desk(hand: &HandPose) -> bool {
    hand.placed > 0.5 && hand.room.y > TOP
}

/// Moves a hand onto the desk, over its edge rather than through it.
///
/// - returns the time of arrival (s).
fn to_desk(script: &mut Script, side: Side, t: f64, pose: HandPose, rng: &mut impl Rng) -> f64 {
    let now = script.hand_now(side);
    if at_desk(&now) {
        let there = t + 0.3 + 1.2 * now.room.distance(pose.room);
        let over = HandPose { room: now.room.lerp(pose.room, 0.5) + DVec3::Y * 0.02, ..pose };
        script.hand(side, 0.5 * (t + there), 0.5 * (there - t), over);
        script.hand(side, there, 0.5 * (there - t), pose);
        return there;
    }
    let start = t + rng.random_range(0.0..0.15);
    let before = HandPose { room: DVec3::new(0.5 * (now.room.x + pose.room.x), 0.85, 0.39), twist: 0.7, ..pose };
    script.hand(side, start + 0.5, 0.5, before);
    script.hand(side, start + 0.95, 0.45, pose);
    start + 0.95
}

/// Moves a hand back onto the thigh.
fn to_lap(script: &mut Script, side: Side, t: f64, rng: &mut impl Rng) -> f64 {
    let now = script.hand_now(side);
    let lap = on(side, LAP);
    let lap = HandPose { room: lap.room + DVec3::new(script.vary(0.015, rng), 0.0, script.vary(0.03, rng)), ..lap };
    let start = t + rng.random_range(0.0..0.1);
    if at_desk(&now) {
        let before = HandPose { room: DVec3::new(now.room.x, 0.84, 0.42), twist: 0.8, flex: 0.1, ..lap };
        script.hand(side, start + 0.4, 0.4, before);
        script.hand(side, start + 0.85, 0.45, lap);
        return start + 0.85;
    }
    script.hand(side, start + 0.7, 0.7, lap);
    start + 0.7
}

fn sit(script: &mut Script, t: f64, over: f64, lean: f64, turn: f64, rng: &mut impl Rng) {
    let vary = script.vary(0.03, rng);
    let posture = Posture {
        hips: Attitude { pitch: SITTING.hips.pitch + 0.35 * lean, list: script.vary(0.015, rng), yaw: 0.0 },
        chest: Attitude { yaw: turn, pitch: SITTING.chest.pitch + lean + vary, list: script.vary(0.03, rng) },
        ..SITTING
    };
    script.pose(t + over, over, posture);
}

/// Small movements of the head that follow the eyes.
fn watch(script: &mut Script, from: f64, to: f64, [yaw, pitch]: [f64; 2], rng: &mut impl Rng) {
    let mut t = from + 0.7;
    while t < to - 0.3 {
        let (dy, dp) = (script.vary(0.08, rng), script.vary(0.05, rng));
        script.look(t, 0.45, yaw + dy, pitch + dp, 0.3 * dy);
        t += rng.random_range(0.9..2.2);
    }
}

/// Types with both hands on the keyboard: bursts of strokes, shown as small movements of the hands.
fn type_text(script: &mut Script, from: f64, to: f64, rng: &mut impl Rng) {
    sit(script, from, 1.1, 0.18, 0.0, rng);
    watch(script, from, to, [0.0, 0.2], rng);
    for side in Side::BOTH {
        let home = on(side, keys());
        let mut t = to_desk(script, side, from, home, rng);
        let touched = t;
        while t < to - 0.4 {
            let burst = t + rng.random_range(0.8..2.6);
            while t < burst.min(to - 0.3) {
                t += rng.random_range(0.15..0.24);
                let room = home.room
                    + DVec3::new(script.vary(0.016, rng), 0.004 + script.vary(0.004, rng), script.vary(0.01, rng));
                let flex = home.flex + script.vary(0.1, rng);
                script.hand(side, t, 0.14, HandPose { room, flex, twist: home.twist + script.vary(0.05, rng), ..home });
            }
            t += rng.random_range(0.2..0.8);
        }
        script.hand(side, to, 0.2, home);
        script.rest(side, touched, to);
    }
}

/// Uses the mouse with one hand, with the other one on the desk or on the thigh.
fn use_mouse(script: &mut Script, from: f64, to: f64, rng: &mut impl Rng) {
    sit(script, from, 1.1, 0.1, -0.05, rng);
    watch(script, from, to, [0.0, 0.12], rng);
    if rng.random_bool(0.5) {
        to_lap(script, Side::Left, from, rng);
    } else {
        let arm = edge(0.17 + script.vary(0.03, rng));
        let touched = to_desk(script, Side::Left, from, arm, rng);
        script.hand(Side::Left, to, 0.1, arm);
        script.rest(Side::Left, touched, to);
    }
    let mouse = HandPose { room: DVec3::new(0.31, WRIST + 0.01, 0.53), flex: -0.1, ..edge(0.0) }.mirrored();
    let touched = to_desk(script, Side::Right, from, mouse, rng);
    let mut t = touched;
    while t < to - 0.8 {
        let still = rng.random_range(0.15..0.9);
        let moves = rng.random_range(0.25..0.5);
        let room = mouse.room + DVec3::new(script.vary(0.035, rng), 0.0, script.vary(0.025, rng));
        let flex = mouse.flex + script.vary(0.06, rng);
        t = (t + still + moves).min(to - 0.3);
        script.hand(Side::Right, t, moves, HandPose { room, flex, ..mouse });
    }
    script.hand(Side::Right, to, 0.25, mouse);
    script.rest(Side::Right, touched, to);
}

/// Leans towards the screen, with the forearms on the desk, and now and then the chin on a hand.
fn read(script: &mut Script, from: f64, to: f64, rng: &mut impl Rng) {
    let thinker = rng.random_bool(0.5).then(|| Side::BOTH[usize::from(rng.random_bool(0.5))]);
    sit(script, from, 1.3, 0.24, thinker.map_or(0.0, |s| -0.1 * s.sign()), rng);
    watch(script, from, to, [0.0, 0.12], rng);
    for side in Side::BOTH {
        let arm = on(side, HandPose { room: DVec3::new(0.15, WRIST, 0.55), ..edge(0.0) });
        let touched = to_desk(script, side, from, arm, rng);
        if thinker == Some(side) && to - from > 4.5 {
            let chin = on(side, gesture::CHIN);
            script.hand(side, touched + 1.3, 1.0, chin);
            script.hand(side, to - 1.1, 0.3, chin);
            script.hand(side, to - 0.1, 1.0, arm);
        } else {
            script.hand(side, to, 0.1, arm);
            script.rest(side, touched, to);
        }
    }
}

/// Leans back, with the hands on the thighs.
fn lean_back(script: &mut Script, from: f64, to: f64, rng: &mut impl Rng) {
    let back = Posture {
        hips: Attitude { pitch: -0.34, ..Attitude::default() },
        chest: Attitude { pitch: -0.25, ..Attitude::default() },
        ..SITTING
    };
    for side in Side::BOTH {
        to_lap(script, side, from, rng);
        script.hand(side, to, 0.1, script.hand_now(side));
    }
    script.pose(from + 1.5, 1.3, back);
    watch(script, from, to, [script.vary(0.3, rng), 0.08], rng);
    script.pose(to, 0.1, back);
}

/// Turns to a visitor beside the desk and talks.
///
/// - returns the end (s).
fn chat(script: &mut Script, side: Side, from: f64, to: f64, rng: &mut impl Rng) -> f64 {
    let turn = side.sign() * (0.5 + script.vary(0.12, rng));
    let turned = Posture {
        hips: Attitude { yaw: 0.12 * turn, ..SITTING.hips },
        chest: Attitude { yaw: 0.8 * turn, pitch: 0.03, list: 0.0 },
        ..SITTING
    };
    script.pose(from + 1.1, 1.1, turned);
    script.look(from + 0.8, 0.8, 1.5 * turn, 0.0, 0.0);
    // The hands leave the desk before talking.
    let ready = Side::BOTH.map(|s| to_lap(script, s, from, rng)).into_iter().fold(from, f64::max);
    let (begin, gaze) = (ready.max(from + 1.1), 1.5 * turn);
    let talk = Talk { from: begin, to: to - 0.9, facing: turned, gaze, seated: true, heat: 0.0 };
    let to = gesture::talk(script, &talk, rng) + 0.9;
    script.look(to, 0.7, 0.0, 0.1, 0.0);
    script.pose(to, 0.8, SITTING);
    to
}
