//! Scripts of the acts.

use super::super::attitude::Attitude;
use super::super::office::desk::BEFORE_SEAT;
use super::super::office::gesture::{self, CHIN, Talk, held, on_hip};
use super::super::office::posture::{HandPose, Posture};
use super::super::office::script::Script;
use super::super::office::stand::{lean_on, look_around, look_at_watch};
use super::super::office::visit::{self, on};
use super::super::side::Side;
use super::super::walk::footsteps::Stance;
use glam::{DVec2, DVec3};
use rand::{Rng, RngExt};

/// Act of a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Act {
    /// Waves with a hand.
    Wave(Side),
    /// Nods to a partner, with a hand half raised.
    Nod(Side),
    /// Gives the right hand.
    Handshake,
    /// Looks at something in front.
    Look(Rest),
    /// Hands something over and takes something.
    Buy(Side),
    /// Talks to a partner, in a mood from calm (0) to heated (1).
    Chat(f64),
    /// Sits down, sits and stands up.
    Sit,
    /// Waits.
    Queue(Rest),
    /// Throws the arms up.
    Cheer,
    /// Takes a thing in front.
    Take(Side, Height),
    /// Puts down a thing in front.
    Put(Side, Height),
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
pub enum Rest {
    /// Hanging.
    Hang,
    /// Clasped before the belly.
    Clasp,
    /// One hand on the hip.
    Hip(Side),
    /// One hand at the chin, the other under its elbow.
    Chin(Side),
    /// One hand raised now and then, to look at the watch.
    Watch,
}

/// Time of standing before an act (s).
const BEFORE_S: f64 = 0.6;

/// Forearm up beside the head, palm ahead.
const WAVE: HandPose = held([0.33, 0.1, 0.24], [0.7, -1.0, 0.0], 1.5);
/// Hand half up, palm ahead.
const HALF: HandPose = held([0.27, -0.12, 0.3], [0.6, -1.0, -0.2], 1.2);
/// Hand given to a partner half a step away.
const GIVEN: HandPose = HandPose { reach: 0.22, ..held([0.045, -0.3, 0.45], [0.35, -1.0, -0.2], 0.05) };
/// Hand over a counter, palm down and palm up.
const OVER: HandPose = HandPose { reach: 0.2, ..held([0.12, -0.3, 0.46], [0.5, -1.0, -0.2], 0.7) };
const UNDER: HandPose = HandPose { reach: 0.15, ..held([0.12, -0.34, 0.43], [0.5, -1.0, -0.2], -0.9) };
/// Hand around a thing on a table, and on a shelf; carrying it beside the hip.
const ON_TABLE: HandPose = HandPose { reach: 0.2, ..held([0.15, -0.52, 0.4], [0.7, -0.8, -0.4], 0.25) };
const ON_SHELF: HandPose = HandPose { reach: 0.25, ..held([0.14, -0.28, 0.46], [0.7, -1.0, -0.2], 0.2) };
const CARRIED: HandPose = held([0.2, -0.42, 0.16], [0.5, -1.0, -0.5], 0.4);
/// Hand at a bag or a pocket.
const POCKET: HandPose = held([0.2, -0.48, 0.1], [0.6, -0.6, -0.8], 0.9);
/// Hands clasped before the belly.
const CLASP: HandPose = held([0.055, -0.49, 0.21], [0.8, -0.9, -0.5], 0.5);
/// Hand under the elbow of the other arm.
const UNDER_ELBOW: HandPose = held([-0.02, -0.32, 0.19], [0.9, -0.9, -0.2], 0.4);
/// Hand over the head.
const UP: HandPose = HandPose { shrug: 0.25, ..held([0.34, 0.38, 0.1], [1.0, -0.4, -0.1], 1.2) };

impl Act {
    /// All acts, in the order in which clips are made.
    pub const LIST: [Self; 31] = [
        Self::Wave(Side::Right),
        Self::Handshake,
        Self::Look(Rest::Chin(Side::Right)),
        Self::Buy(Side::Right),
        Self::Chat(0.1),
        Self::Sit,
        Self::Queue(Rest::Hang),
        Self::Cheer,
        Self::Nod(Side::Right),
        Self::Look(Rest::Clasp),
        Self::Chat(0.4),
        Self::Queue(Rest::Hip(Side::Left)),
        Self::Buy(Side::Left),
        Self::Sit,
        Self::Wave(Side::Left),
        Self::Look(Rest::Hang),
        Self::Chat(0.0),
        Self::Queue(Rest::Watch),
        Self::Cheer,
        Self::Look(Rest::Hip(Side::Right)),
        Self::Chat(0.2),
        Self::Queue(Rest::Clasp),
        Self::Nod(Side::Left),
        Self::Take(Side::Right, Height::Table),
        Self::Put(Side::Right, Height::Table),
        Self::Take(Side::Left, Height::Table),
        Self::Put(Side::Left, Height::Table),
        Self::Take(Side::Right, Height::Shelf),
        Self::Put(Side::Right, Height::Shelf),
        Self::Take(Side::Left, Height::Shelf),
        Self::Put(Side::Left, Height::Shelf),
    ];

    /// Tag of the act.
    pub fn tag(self) -> &'static str {
        match self {
            Self::Wave(_) | Self::Nod(_) => "greet",
            Self::Handshake => "handshake",
            Self::Look(_) => "look",
            Self::Buy(_) => "buy",
            Self::Chat(_) => "chat",
            Self::Sit => "sit",
            Self::Queue(_) => "queue",
            Self::Cheer => "cheer",
            Self::Take(..) => "take",
            Self::Put(..) => "put",
        }
    }

    /// The script of a clip.
    ///
    /// - `variation`: factor on the usual variation.
    pub fn script(self, variation: f64, rng: &mut impl Rng) -> Script {
        let at = if self == Self::Sit { DVec2::new(0.0, BEFORE_SEAT) } else { DVec2::ZERO };
        let mut script = Script::new(Stance { at, heading: 0.0 }, variation);
        let s = &mut script;
        s.wait_until(BEFORE_S);
        let looped = match self {
            Self::Wave(side) => wave(s, side, rng),
            Self::Nod(side) => nod(s, side, rng),
            Self::Handshake => shake_hands(s, rng),
            Self::Look(rest) => stand(s, rest, 9.0, true, rng),
            Self::Buy(side) => buy(s, side, rng),
            Self::Chat(heat) => chat(s, heat, rng),
            Self::Sit => sit(s, rng),
            Self::Queue(rest) => stand(s, rest, 10.0, false, rng),
            Self::Cheer => cheer(s, rng),
            Self::Take(side, height) => handle(s, side, height, true, rng),
            Self::Put(side, height) => handle(s, side, height, false, rng),
        };
        let end = s.now();
        s.tags.push((self.tag(), 0.5 * BEFORE_S, end + 0.3));
        s.tags.extend(looped.map(|[from, to]| ("loop", from, to)));
        s.wait_until(end + 0.4);
        script
    }
}

/// Begin and end of the part of an act that may loop (s).
type Looped = Option<[f64; 2]>;

/// Posture with the chest leaned and turned.
fn chest(yaw: f64, pitch: f64) -> Posture {
    Posture { chest: Attitude { yaw, pitch, list: 0.0 }, ..Posture::default() }
}

/// Returns everything to rest.
fn end(s: &mut Script, t: f64, over: f64) {
    s.relax(t + over, over);
    s.wait_until(t + over);
}

fn wave(s: &mut Script, side: Side, rng: &mut impl Rng) -> Looped {
    let from = s.now();
    let raised = HandPose { body: WAVE.body + DVec3::new(0.0, s.vary(0.04, rng), s.vary(0.03, rng)), ..WAVE };
    s.hand(side, from + 0.55, 0.55, on(side, raised));
    s.pose(from + 0.5, 0.5, chest(-0.06 * side.sign(), -0.03));
    s.look(from + 0.4, 0.4, 0.0, -0.12, 0.06 * side.sign());
    let mut t = from + 0.55;
    for out in [0.1, -0.05, 0.09, -0.05, 0.06] {
        let over = 0.2 + s.vary(0.02, rng);
        t += over;
        let body = raised.body + DVec3::X * out;
        s.hand(side, t, over, on(side, HandPose { body, twist: raised.twist, ..raised }));
    }
    s.look(t, 0.4, 0.0, 0.0, 0.0);
    end(s, t, 0.75);
    None
}

fn nod(s: &mut Script, side: Side, rng: &mut impl Rng) -> Looped {
    let from = s.now();
    let raised = HandPose { body: HALF.body + DVec3::new(s.vary(0.03, rng), s.vary(0.03, rng), 0.0), ..HALF };
    s.hand(side, from + 0.5, 0.5, on(side, raised));
    s.look(from + 0.3, 0.3, 0.0, -0.1, 0.0);
    s.look(from + 0.65, 0.3, 0.0, 0.22, 0.0);
    s.look(from + 0.95, 0.3, 0.0, 0.0, 0.0);
    s.pose(from + 0.65, 0.5, chest(0.0, 0.06));
    s.hand(side, from + 1.0, 0.1, on(side, raised));
    end(s, from + 1.0, 0.8);
    None
}

fn shake_hands(s: &mut Script, rng: &mut impl Rng) -> Looped {
    let from = s.now();
    let side = Side::Right;
    s.hand(side, from + 0.7, 0.7, on(side, GIVEN));
    s.pose(from + 0.7, 0.7, chest(0.16, 0.1));
    s.look(from + 0.4, 0.4, 0.0, 0.05, 0.0);
    let mut t = from + 0.75;
    for up in [0.035, -0.045, 0.035, -0.04, 0.02] {
        let over = 0.17 + s.vary(0.02, rng);
        t += over;
        s.hand(side, t, over, on(side, HandPose { body: GIVEN.body + DVec3::Y * up, ..GIVEN }));
    }
    s.look(t, 0.3, 0.0, 0.14, 0.0);
    s.hand(side, t + 0.15, 0.1, on(side, GIVEN));
    end(s, t + 0.15, 0.85);
    None
}

fn buy(s: &mut Script, side: Side, rng: &mut impl Rng) -> Looped {
    let from = s.now();
    s.hand(side, from + 0.6, 0.6, on(side, POCKET));
    s.look(from + 0.5, 0.4, 0.15 * side.sign(), 0.3, 0.0);
    s.hand(side, from + 1.4, 0.65, on(side, OVER));
    s.pose(from + 1.4, 0.7, chest(-0.12 * side.sign(), 0.14));
    s.look(from + 1.2, 0.45, 0.0, 0.22, 0.0);
    s.hand(side, from + 1.7, 0.1, on(side, OVER));
    s.let_hang(side, from + 2.5, 0.7);
    s.look(from + 2.1, 0.4, s.vary(0.05, rng), 0.0, 0.0);
    let other = side.other();
    let take = from + 2.4 + s.vary(0.15, rng);
    s.hand(other, take + 0.7, 0.7, on(other, UNDER));
    s.pose(take + 0.7, 0.8, chest(0.12 * side.sign(), 0.13));
    s.look(take + 0.6, 0.4, 0.0, 0.25, 0.0);
    s.hand(other, take + 1.0, 0.1, on(other, UNDER));
    s.look(take + 1.3, 0.3, 0.0, 0.12, 0.0);
    end(s, take + 1.0, 0.9);
    None
}

/// Takes a thing, or puts it down. The hand is tagged from the grasp to the end of the act, or from its begin to the
/// release.
fn handle(s: &mut Script, side: Side, height: Height, takes: bool, rng: &mut impl Rng) -> Looped {
    let begin = 0.5 * BEFORE_S;
    let from = s.now();
    let (around, lean, down) = match height {
        Height::Table => (ON_TABLE, 0.36, 0.35),
        Height::Shelf => (ON_SHELF, 0.04, 0.1),
    };
    let body = around.body + DVec3::new(0.0, s.vary(0.02, rng), s.vary(0.02, rng));
    let around = on(side, HandPose { body, ..around });
    s.look(from + 0.4, 0.4, -0.08 * side.sign(), down, 0.0);
    s.pose(from + 0.85, 0.85, chest(-0.1 * side.sign(), lean));
    s.hand(side, from + 0.85, 0.8, around);
    let grasp = from + 0.95;
    s.hand(side, grasp, 0.1, around);
    s.look(grasp + 0.5, 0.45, 0.0, 0.0, 0.0);
    if takes {
        s.hand(side, grasp + 0.6, 0.55, on(side, CARRIED));
    }
    end(s, grasp + if takes { 0.65 } else { 0.1 }, 0.8);
    let tag = ["left_hand", "right_hand"][side.index()];
    s.tags.push(if takes { (tag, grasp, s.now() + 0.3) } else { (tag, begin, grasp) });
    None
}

fn chat(s: &mut Script, heat: f64, rng: &mut impl Rng) -> Looped {
    let from = s.now();
    let side = Side::BOTH[rng.random_range(0..2)];
    let lean = lean_on(side, s, rng);
    let facing = Posture { chest: Attitude { yaw: 0.0, pitch: 0.05 * heat, ..lean.chest }, ..lean };
    s.pose(from + 0.9, 0.85, facing);
    let talk = Talk { from, to: from + 11.0, facing, gaze: 0.0, seated: false, heat };
    let to = gesture::talk(s, &talk, rng);
    s.pose(to, 0.9, Posture::default());
    s.look(to, 0.7, 0.0, 0.0, 0.0);
    s.wait_until(to + 0.3);
    Some([from + 1.0, to - 1.0])
}

fn sit(s: &mut Script, rng: &mut impl Rng) -> Looped {
    visit::take_seat(s, false, rng);
    let seated = s.now();
    for k in 0..3 {
        let t = seated + 1.0 + 2.6 * f64::from(k);
        s.look(t, 0.8, s.vary(0.45, rng), s.vary(0.08, rng), 0.0);
    }
    s.wait_until(seated + 8.0);
    let rises = s.now();
    s.look(rises, 0.8, 0.0, 0.1, 0.0);
    visit::rise(s, false, rng);
    Some([seated + 0.1, rises])
}

/// Stands with the weight on alternating legs, and looks ahead or about.
fn stand(s: &mut Script, rest: Rest, long: f64, ahead: bool, rng: &mut impl Rng) -> Looped {
    let from = s.now();
    let sides = if rng.random_bool(0.5) { Side::BOTH } else { [Side::Right, Side::Left] };
    let first = lean_on(sides[0], s, rng);
    let second = lean_on(sides[1], s, rng);
    s.pose(from + 1.1, 1.1, first);
    let ready = take(s, rest, from);
    let to = ready + long;
    s.pose(ready + 0.45 * long, 1.2, second);
    s.pose(to, 1.2, first);
    if ahead {
        gaze(s, ready, to, rng);
    } else {
        let free = if rest == Rest::Watch { look_at_watch(s, ready + 1.0, rng) } else { ready };
        look_around(s, free, to - 0.8, rng);
    }
    s.look(to, 0.7, 0.0, 0.0, 0.0);
    end(s, to, 1.1);
    Some([ready, to])
}

/// Moves the hands to their resting position.
///
/// - returns the time of arrival (s).
fn take(s: &mut Script, rest: Rest, from: f64) -> f64 {
    let there = from + 1.1;
    match rest {
        Rest::Hang | Rest::Watch => {}
        Rest::Clasp => Side::BOTH.into_iter().for_each(|k| s.hand(k, there + 0.06 * k.sign(), 0.9, on(k, CLASP))),
        Rest::Hip(side) => s.hand(side, there, 0.9, on_hip(side)),
        Rest::Chin(side) => {
            s.hand(side, there, 0.9, on(side, CHIN));
            s.hand(side.other(), there, 0.95, on(side.other(), UNDER_ELBOW));
        }
    }
    there + 0.1
}

/// Lets the eyes wander over something ahead.
fn gaze(s: &mut Script, from: f64, to: f64, rng: &mut impl Rng) {
    let mut t = from;
    while t < to - 2.4 {
        let over = 0.6 + s.vary(0.15, rng).abs();
        t += over;
        s.look(t, over, s.vary(0.22, rng), -0.06 + s.vary(0.1, rng), s.vary(0.06, rng));
        t += rng.random_range(0.6..1.6);
    }
}

fn cheer(s: &mut Script, rng: &mut impl Rng) -> Looped {
    let from = s.now();
    let up = |side: Side, s: &Script, rng: &mut _| {
        let by = DVec3::new(s.vary(0.05, rng), s.vary(0.03, rng), s.vary(0.05, rng));
        on(side, HandPose { body: UP.body + by, ..UP })
    };
    let poses = Side::BOTH.map(|side| up(side, s, rng));
    let low = Posture { dip: 0.05, ..chest(0.0, 0.08) };
    let high = Posture { dip: 0.0, ..chest(0.0, -0.08) };
    s.pose(from + 0.35, 0.35, low);
    s.pose(from + 0.7, 0.35, high);
    s.look(from + 0.7, 0.5, 0.0, -0.15, 0.0);
    for (side, pose) in Side::BOTH.into_iter().zip(poses) {
        s.hand(side, from + 0.7, 0.55, pose);
    }
    let ready = from + 0.7;
    let mut t = ready;
    for _ in 0..4 {
        s.pose(t + 0.32, 0.3, low);
        s.pose(t + 0.64, 0.3, high);
        for (side, pose) in Side::BOTH.into_iter().zip(poses) {
            let down = HandPose { body: pose.body + DVec3::new(0.0, -0.14, 0.03), ..pose };
            s.hand(side, t + 0.32, 0.3, down);
            s.hand(side, t + 0.64, 0.3, pose);
        }
        t += 0.64 + s.vary(0.04, rng).abs();
    }
    for (side, pose) in Side::BOTH.into_iter().zip(poses) {
        s.hand(side, t, 0.05, pose);
    }
    end(s, t, 0.9);
    Some([ready, t])
}
