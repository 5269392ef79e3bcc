//! Behaviours of standing people: they wait, chat, dispute and present, and stand still in between.

use super::gesture::{self, CLASP, TalkStyle, hand_before_body as pose, on_hip};
use super::{KeyedHandPose, KeyedPosture, MotionScript, ScriptStep, mirrored_for_side};
use crate::side::{LateralSide, leftward};
use crate::{attitude::Attitude, deck::CardDeck, walk::footsteps::FeetStance};
use glam::DVec3;
use rand::{Rng, RngExt};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StandingBehaviour {
    Idle,
    Chat,
    Dispute,
    Present(LateralSide),
}

/// Dealer of behaviours. One serves all clips of a set, so that they come equally often.
pub struct Stander {
    behaviours: CardDeck<StandingBehaviour>,
    idling: CardDeck<Idling>,
    partners: CardDeck<f64>,
}

/// Headings of the partner in a talk (rad).
const PARTNERS: [f64; 7] = [0.0, 0.0, 0.15, -0.15, 0.35, -0.35, 0.0];

/// Activity of a waiting character.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Idling {
    LookAround,
    Watch,
    HipsHand(LateralSide),
    Scratch(LateralSide),
    Clasp,
    Stretch,
}

impl Stander {
    /// No behaviour dealt yet.
    pub fn new() -> Self {
        use {Idling::*, LateralSide::*, StandingBehaviour::*};
        let behaviours = [Idle, Chat, Dispute, Present(Left), Idle, Chat, Dispute, Present(Right)];
        let idling =
            [LookAround, Watch, HipsHand(Left), Scratch(Right), Clasp, HipsHand(Right), Stretch, Scratch(Left)];
        let (behaviours, idling) = (CardDeck::new(&behaviours), CardDeck::new(&idling));
        Self { behaviours, idling, partners: CardDeck::new(&PARTNERS) }
    }

    /// Timeline of behaviours for about `seconds`, from neutral stand to neutral stand.
    pub fn stand(&mut self, seconds: f64, variation: f64, rng: &mut impl Rng) -> MotionScript {
        let mut script = MotionScript::new(FeetStance::default(), variation);
        while script.now < seconds - 1.5 || script.now == 0.0 {
            let before = script.now;
            script.wait_until(before + rng.random_range(1.0..1.9));
            script.tag("stand", before);
            let (from, long) = (script.now, rng.random_range(5.5..11.5));
            let name = match self.behaviours.deal(rng) {
                StandingBehaviour::Idle => self.idle_for(&mut script, from, from + long, rng),
                StandingBehaviour::Chat => self.talk(&mut script, from, from + long, 0.0, rng),
                StandingBehaviour::Dispute => self.talk(&mut script, from, from + long, 1.0, rng),
                StandingBehaviour::Present(side) => present(&mut script, side, from, from + long.max(7.0), rng),
            };
            script.tag(name, from);
        }
        let end = script.now;
        script.wait_until(end + 1.0);
        script.tag("stand", end);
        script
    }

    /// Shifts the weight, and does something with the hands.
    fn idle_for(&mut self, script: &mut MotionScript, from: f64, to: f64, rng: &mut impl Rng) -> &'static str {
        let mut t = from;
        let mut side = LateralSide::BOTH[rng.random_range(0..2)];
        while t < to - 2.6 {
            let there = t + rng.random_range(0.9..1.3);
            script.pose(there, there - t, lean_on(side, script, rng));
            t = there + rng.random_range(1.2..2.6);
            side = side.other();
        }
        self.occupy_hands(script, from + 0.3, to, rng);
        script.relax(to, 1.1);
        script.wait_until(to);
        "idle"
    }

    fn occupy_hands(&mut self, script: &mut MotionScript, from: f64, to: f64, rng: &mut impl Rng) {
        let end = to - 1.2;
        let free = match self.idling.deal(rng) {
            Idling::LookAround => from,
            Idling::HipsHand(side) => {
                script.hand(side, from + 1.0, 0.9, on_hip(side));
                if rng.random_bool(0.5) {
                    script.hand(side.other(), from + 1.2, 0.95, on_hip(side.other()));
                }
                from + 1.0
            }
            Idling::Watch => look_at_watch(script, from, rng),
            Idling::Scratch(side) => scratch(script, side, from),
            Idling::Clasp => {
                clasp_hands(script, from + 1.0);
                from + 0.8
            }
            Idling::Stretch => stretch(script, from),
        };
        look_around(script, free, end, rng);
    }

    /// Turns to a partner and talks.
    fn talk(&mut self, script: &mut MotionScript, from: f64, to: f64, heat: f64, rng: &mut impl Rng) -> &'static str {
        let partner = self.partners.deal(rng);
        let side = LateralSide::BOTH[rng.random_range(0..2)];
        let lean = lean_on(side, script, rng);
        let facing = face_partner(lean, partner, heat);
        script.pose(from + 0.9, 0.85, facing);
        script.turn_head(from + 0.6, 0.55, 1.3 * partner, 0.02, 0.0);
        let talk = TalkStyle { from: from + 0.2, to: to - 0.1, facing, gaze: 1.3 * partner, seated: false, heat };
        let to = gesture::talk(script, &talk, rng).max(to);
        script.pose(to, 0.9, KeyedPosture::default());
        script.turn_head(to, 0.7, 0.0, 0.0, 0.0);
        script.wait_until(to + 0.1);
        if heat > 0.5 { "dispute" } else { "chat" }
    }
}

/// Posture with the weight on one leg: its hip out and up, the shoulders tilted the other way.
pub fn lean_on(side: LateralSide, script: &MotionScript, rng: &mut impl Rng) -> KeyedPosture {
    let s = side.sign();
    let out = 0.036 + script.random_offset(0.012, rng);
    KeyedPosture {
        hips: Attitude { yaw: -0.03 * s, pitch: 0.0, list: 1.3 * out * s },
        chest: Attitude { yaw: script.random_offset(0.06, rng), pitch: 0.0, list: -0.3 * out * s },
        shift: [out * s, script.random_offset(0.01, rng)],
        dip: 0.0,
    }
}

/// Posture of a talker who leans and turns to a partner at a heading: the hotter, the less it leans aside.
pub fn face_partner(lean: KeyedPosture, partner: f64, heat: f64) -> KeyedPosture {
    let share = 1.0 - 0.6 * heat;
    KeyedPosture {
        hips: Attitude { yaw: 0.25 * partner, list: share * lean.hips.list, ..Attitude::default() },
        chest: Attitude { yaw: 0.7 * partner, pitch: 0.1 * heat, list: 0.0 },
        shift: [share * lean.shift[0], 0.03 * heat],
        dip: 0.01 * heat,
    }
}

/// Brings both hands together before the belly at about `t`.
pub fn clasp_hands(script: &mut MotionScript, t: f64) {
    for side in LateralSide::BOTH {
        script.hand(side, t + 0.06 * side.sign(), 0.9, mirrored_for_side(side, CLASP));
    }
}

/// Raises the left wrist, looks at it and lets it down.
///
/// - returns the time at which the eyes are free (s).
pub fn look_at_watch(script: &mut MotionScript, from: f64, rng: &mut impl Rng) -> f64 {
    let watch = pose([0.06, -0.27, 0.27], [0.9, -0.7, 0.0], 1.2);
    let at = from + rng.random_range(0.6..1.2);
    script.hand(LateralSide::Left, at + 0.8, 0.8, watch);
    script.turn_head(at + 0.8, 0.6, 0.1, 0.42, 0.0);
    script.hand(LateralSide::Left, at + 1.8, 0.1, watch);
    script.turn_head(at + 1.9, 0.1, 0.1, 0.42, 0.0);
    script.let_hang(LateralSide::Left, at + 2.8, 0.9);
    at + 1.9
}

/// Scratches the head.
///
/// - returns the time at which the head is free (s).
fn scratch(script: &mut MotionScript, side: LateralSide, from: f64) -> f64 {
    let head = mirrored_for_side(side, pose([0.09, 0.09, 0.1], [0.9, -0.6, 0.2], 0.3));
    script.hand(side, from + 1.0, 0.95, head);
    script.turn_head(from + 1.0, 0.6, -0.1 * side.sign(), 0.12, 0.1 * side.sign());
    let mut t = from + 1.0;
    for up in [0.02, -0.01, 0.02, -0.01, 0.02] {
        t += 0.2;
        script.hand(side, t, 0.2, KeyedHandPose { body: head.body + DVec3::Y * up, ..head });
    }
    script.let_hang(side, t + 1.1, 1.0);
    t + 0.4
}

/// Bends backwards a little, the hands on the hips.
///
/// - returns the time at which the head is free (s).
fn stretch(script: &mut MotionScript, from: f64) -> f64 {
    let lean = |pitch: f64| Attitude { pitch, ..Attitude::default() };
    let back = KeyedPosture { hips: lean(-0.03), chest: lean(-0.09), shift: [0.0, 0.025], dip: 0.0 };
    LateralSide::BOTH.into_iter().for_each(|side| script.hand(side, from + 1.0, 0.9, on_hip(side)));
    script.pose(from + 1.8, 0.9, back);
    script.turn_head(from + 1.8, 0.8, 0.0, -0.2, 0.0);
    script.pose(from + 2.6, 0.2, back);
    script.turn_head(from + 2.6, 0.2, 0.0, -0.2, 0.0);
    from + 2.6
}

/// Turns the head to and fro.
pub fn look_around(script: &mut MotionScript, from: f64, to: f64, rng: &mut impl Rng) {
    let mut t = from + 0.3;
    while t < to - 0.7 {
        let yaw = script.random_offset(0.75, rng);
        let over = 0.35 + 0.35 * (yaw - script.head.last().1.yaw).abs();
        script.turn_head(t + over, over, yaw, script.random_offset(0.1, rng), 0.1 * yaw);
        t += over + rng.random_range(0.4..1.6);
    }
}

/// Steps half aside, points at a wall on one side, looks from it to the listeners, and steps back.
fn present(script: &mut MotionScript, side: LateralSide, from: f64, to: f64, rng: &mut impl Rng) -> &'static str {
    let s = side.sign();
    let home = script.stance;
    let open = FeetStance {
        at: home.at + leftward(home.heading) * (s * (0.07 + script.random_offset(0.02, rng))),
        heading: home.heading + s * 0.3,
    };
    for foot in [side, side.other()] {
        script.step(ScriptStep { toe_out: 0.16, ..ScriptStep::aside(foot, open) });
    }
    let back_at = to - 2.6;
    show(script, side, from + 0.4, back_at, rng);
    script.wait_until(back_at);
    [side.other(), side].into_iter().for_each(|foot| script.step(ScriptStep::aside(foot, home)));
    let end = to.max(script.now + 0.4);
    script.relax(end, 1.3);
    script.wait_until(end);
    "present"
}

/// Points and sweeps with the arm at the wall's side; the other one hangs or helps.
fn show(script: &mut MotionScript, side: LateralSide, from: f64, to: f64, rng: &mut impl Rng) {
    let s = side.sign();
    let points = [[0.5, -0.1, 0.24], [0.46, 0.06, 0.26], [0.52, -0.22, 0.2], [0.4, -0.02, 0.34]]
        .map(|p| pose(p, [0.3, -1.0, -0.4], -0.2));
    let open = pose([0.34, -0.3, 0.27], [0.5, -1.0, -0.3], -0.7);
    let mut t = from;
    let mut to_wall = true;
    while t < to - 1.6 {
        let until = (t + rng.random_range(1.6..2.8)).min(to - 0.2);
        let turn = if to_wall { 0.32 } else { -0.18 };
        let chest = Attitude { yaw: s * turn, pitch: script.random_offset(0.03, rng), list: -0.03 * s };
        let hips = Attitude { yaw: 0.2 * s * turn, ..Attitude::default() };
        let shift = [script.random_offset(0.02, rng), 0.0];
        script.pose(t + 0.9, 0.85, KeyedPosture { chest, hips, shift, dip: 0.0 });
        let gaze = if to_wall { 0.85 } else { -0.35 };
        script.turn_head(t + 0.6, 0.55, s * gaze, if to_wall { -0.08 } else { 0.02 }, 0.0);
        if to_wall {
            let first = rng.random_range(0..points.len());
            let goal = mirrored_for_side(side, points[first]);
            script.hand(side, t + 0.85, 0.85, goal);
            script.hand(side, until - 0.2, 0.6, mirrored_for_side(side, points[(first + 1) % points.len()]));
            if rng.random_bool(0.5) {
                script.let_hang(side.other(), t + 0.9, 0.9);
            }
        } else {
            script.hand(side, t + 0.8, 0.8, mirrored_for_side(side, open));
            script.hand(side.other(), t + 0.9, 0.8, mirrored_for_side(side.other(), open));
            script.turn_head(until - 0.4, 0.5, s * (gaze + 0.3), 0.02, 0.0);
        }
        to_wall = !to_wall;
        t = until;
    }
}
