//! Actions of agents: effects, which take no time, and primitive behaviours, which are functions registered by name.

use super::language::Amount;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Kind of an argument of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Word {
    /// A number, or an expression for one.
    Amount,
    /// A place by its name, a point, `me`, `other`, `home`, or `place` for that of the event.
    Target,
    /// A target; where it is a place with slots, one of them is claimed.
    Slot,
    /// A place with a queue; its last slot is claimed.
    Queue,
    /// Name of a place.
    Place,
    /// Name of a value.
    Value,
    /// Name of an event.
    Event,
    /// Name of a door.
    Door,
    /// Name of a thing that is taken.
    Take,
    /// Name of a thing that is put down.
    Put,
    /// Position of a thing: x, y up, z (m).
    Rest,
    /// Motion tag of the bundle.
    Motion,
    /// Points of a path (m).
    Points,
    /// Yes or no.
    Flag,
}

/// Effect of an action that takes no time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Effect {
    /// Sets a value.
    Set,
    /// Adds to a value.
    Add,
    /// Sets the rate of a value.
    Rate,
    /// Sets the desired speed.
    Speed,
    /// Posts an event on a blackboard.
    Post,
    /// The agent learns of an event, and passes it on.
    Learn,
    /// Conveys an event to agents within a radius, weaker at a distance and, where asked for, to strangers.
    Convey,
    /// Changes the liking for the other agent.
    Befriend,
    /// Opens a door.
    Open,
    /// Closes a door, as soon as no agent stands in it.
    Close,
    /// Releases the slot that the agent holds.
    Release,
    /// Sets the time until `timer` happens.
    Timer,
}

/// Primitive behaviour: a name, its arguments, and a function.
#[derive(Clone, Copy, Debug)]
pub struct Primitive {
    /// Name in scene files.
    pub name: &'static str,
    /// Names and kinds of its arguments. The first argument has the behaviour's own name.
    pub words: &'static [(&'static str, Word)],
    /// Motion tag of the bundle, where the arguments name none.
    pub motion: Option<&'static str>,
    /// Function that returns what the agent does now.
    pub act: fn(&Sight, &Said) -> Deed,
}

/// Input of a primitive behaviour: the state of the agent.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// Simulated time (s).
    pub time_s: f64,
    /// Position of the agent (m).
    pub position: Vec3,
    /// Velocity of the agent (m/s).
    pub velocity: Vec3,
    /// Desired speed of the agent (m/s).
    pub desired_mps: f32,
    /// Position at which the agent entered (m).
    pub home: Vec3,
    /// Random numbers, from 0 up to 1.
    pub chance: [f32; 2],
}

/// Most arguments of an action.
pub(super) const WORDS: usize = 5;

/// Values of an action's arguments, in the order of [`Primitive::words`]; `None` for one that is not given.
#[derive(Clone, Copy, Debug, Default)]
pub struct Said {
    /// Amounts and flags.
    pub amounts: [Option<f64>; WORDS],
    /// Positions of targets (m).
    pub targets: [Option<Vec3>; WORDS],
    /// Position that the agent of a slot faces (m).
    pub facing: Option<Vec3>,
    /// Distance from the target at which the agent has arrived, so that it does not stand on it (m).
    pub arrival_m: f32,
}

impl Said {
    /// Amount of an argument, or `otherwise` where it is not given.
    pub fn amount(&self, word: usize, otherwise: f64) -> f64 {
        self.amounts[word].unwrap_or(otherwise)
    }
}

/// Action command of an agent: to walk somewhere, then to stay there for a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deed {
    /// Walk at the beginning.
    pub walk: Walk,
    /// Speed; as before where absent (m/s).
    pub speed_mps: Option<f32>,
    /// Position that the agent faces after arrival (m).
    pub faces: Option<Vec3>,
    /// Time to stay after arrival; infinite where it never ends (s).
    pub stay_s: f64,
    /// Interval after which the function is called again on the way; 0 for never (s).
    pub again_s: f64,
    /// Longest duration of the behaviour, whether the agent has arrived or not; infinite for no limit (s).
    pub most_s: f64,
}

/// Walk of an action command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Walk {
    /// Goes on as before.
    Keep,
    /// Stops where the agent is.
    Halt,
    /// Walks to a place.
    To {
        /// Position (m).
        at: Vec3,
        /// Distance at which the agent has arrived (m).
        arrival_m: f32,
    },
    /// Walks to a place, and leaves the scene there.
    Out {
        /// Position (m).
        at: Vec3,
        /// Distance at which the agent has arrived (m).
        arrival_m: f32,
    },
    /// Walks along the points that the arguments name.
    Along,
}

impl Deed {
    /// Command to walk.
    pub fn walk(walk: Walk) -> Self {
        Self { walk, speed_mps: None, faces: None, stay_s: 0.0, again_s: 0.0, most_s: f64::INFINITY }
    }

    /// Command to stay in place for some time (s).
    pub fn stay(seconds: f64) -> Self {
        Self { stay_s: seconds, ..Self::walk(Walk::Halt) }
    }
}

/// Action that scene files can name.
#[derive(Clone, Copy, Debug)]
pub enum Verb {
    /// Effect, which takes no time.
    Effect(Effect),
    /// Primitive behaviour, by its number in [`Primitives`].
    Primitive(u16),
}

/// Effect of scene files: name, arguments and effect.
type EffectWords = (&'static str, &'static [(&'static str, Word)], Effect);

const EFFECTS: &[EffectWords] = &[
    ("set", &[("set", Word::Value), ("to", Word::Amount)], Effect::Set),
    ("add", &[("add", Word::Value), ("by", Word::Amount)], Effect::Add),
    ("rate", &[("rate", Word::Value), ("to", Word::Amount)], Effect::Rate),
    ("speed", &[("speed", Word::Amount)], Effect::Speed),
    ("post", &[("post", Word::Event), ("cells", Word::Amount), ("for_s", Word::Amount)], Effect::Post),
    ("learn", &[("learn", Word::Event)], Effect::Learn),
    (
        "convey",
        &[("convey", Word::Event), ("within_m", Word::Amount), ("strength", Word::Amount), ("friends", Word::Flag)],
        Effect::Convey,
    ),
    ("befriend", &[("befriend", Word::Amount)], Effect::Befriend),
    ("open", &[("open", Word::Door)], Effect::Open),
    ("close", &[("close", Word::Door)], Effect::Close),
    ("release", &[("release", Word::Flag)], Effect::Release),
    ("timer", &[("timer", Word::Amount)], Effect::Timer),
];

/// Action registry: all primitive behaviours that scene files may name.
#[derive(Clone, Debug)]
pub struct Primitives(Vec<Primitive>);

impl Default for Primitives {
    /// Registry of the built-in primitive behaviours.
    fn default() -> Self {
        Self(BUILT_IN.to_vec())
    }
}

impl Primitives {
    /// Adds a primitive behaviour, in place of one of the same name.
    pub fn with(mut self, primitive: Primitive) -> Self {
        self.0.retain(|p| p.name != primitive.name);
        self.0.push(primitive);
        self
    }

    /// The primitive behaviour of a number.
    pub fn get(&self, number: u16) -> &Primitive {
        &self.0[usize::from(number)]
    }

    /// Action of a name, with its arguments.
    pub fn verb(&self, name: &str) -> Option<(Verb, &'static [(&'static str, Word)])> {
        let effect = EFFECTS.iter().find(|e| e.0 == name).map(|e| (Verb::Effect(e.2), e.1));
        let own = || self.0.iter().position(|p| p.name == name);
        effect.or_else(|| own().map(|n| (Verb::Primitive(n as u16), self.0[n].words)))
    }

    /// Names of all actions.
    pub fn verbs(&self) -> impl Iterator<Item = &'static str> + '_ {
        EFFECTS.iter().map(|e| e.0).chain(self.0.iter().map(|p| p.name))
    }
}

const SPEED: (&str, Word) = ("speed", Word::Amount);
const FOR: (&str, Word) = ("for_s", Word::Amount);
const MOTION: (&str, Word) = ("motion", Word::Motion);

macro_rules! primitive {
    ($name:literal, [$($word:expr),*], $motion:expr, $act:expr) => {
        Primitive { name: $name, words: &[$($word),*], motion: $motion, act: $act }
    };
}

const BUILT_IN: &[Primitive] = &[
    primitive!("go", [("go", Word::Target), SPEED, ("within_m", Word::Amount)], None, |_, said| to(said, 0.0, Some(2))),
    primitive!("visit", [("visit", Word::Slot), SPEED, FOR, MOTION], None, |_, said| to(said, 0.0, None)),
    primitive!("look", [("look", Word::Slot), SPEED, FOR, MOTION], Some("look"), |_, said| to(said, 5.0, None)),
    primitive!("buy", [("buy", Word::Slot), SPEED, FOR, MOTION], Some("buy"), |_, said| to(said, 5.0, None)),
    primitive!("sit", [("sit", Word::Slot), SPEED, FOR, MOTION], Some("sit"), |_, said| to(said, 20.0, None)),
    primitive!("queue", [("queue", Word::Queue), SPEED, ("into", Word::Place), MOTION], Some("queue"), |_, said| {
        Deed { stay_s: f64::INFINITY, ..to(said, 0.0, None) }
    }),
    primitive!("follow_route", [("follow_route", Word::Points), SPEED, ("again", Word::Flag)], None, |_, said| {
        Deed { speed_mps: speed(said), ..Deed::walk(Walk::Along) }
    }),
    primitive!("follow", [("follow", Word::Target), SPEED, FOR, ("within_m", Word::Amount)], None, |sight, said| {
        let arrival_m = said.amount(3, 1.5) as f32;
        let near = |at: &Vec3| (*at - sight.position).length() <= arrival_m;
        let walk = match said.targets[0] {
            Some(at) if !near(&at) => Walk::To { at, arrival_m },
            _ => Walk::Halt,
        };
        let stay_s = f64::INFINITY;
        Deed { speed_mps: speed(said), stay_s, again_s: 0.5, most_s: said.amount(2, 10.0), ..Deed::walk(walk) }
    }),
    primitive!("stay", [("stay", Word::Amount), MOTION], None, |_, said| Deed::stay(said.amount(0, 0.0))),
    primitive!("greet", [("greet", Word::Target), FOR, MOTION], Some("greet"), |_, said| towards(said, 2.5)),
    primitive!("shake_hands", [("shake_hands", Word::Target), FOR, MOTION], Some("handshake"), |sight, said| {
        reach(sight, said, 3.0)
    }),
    primitive!("chat", [("chat", Word::Target), FOR, MOTION], Some("chat"), |_, said| towards(said, 8.0)),
    primitive!("fight", [("fight", Word::Target), FOR, MOTION], Some("fight"), |_, said| towards(said, 3.0)),
    primitive!("perform", [("perform", Word::Motion), FOR, ("facing", Word::Target)], None, |_, said| Deed {
        faces: said.targets[2],
        ..Deed::stay(said.amount(1, 3.0))
    }),
    primitive!("take", [("take", Word::Take), SPEED, FOR, MOTION], Some("take"), |_, said| to(said, 0.0, None)),
    primitive!("put", [("put", Word::Put), SPEED, FOR, MOTION, ("on", Word::Rest)], Some("put"), |_, said| {
        to(said, 0.0, None)
    }),
    primitive!("spurt", [("spurt", Word::Amount), SPEED], None, |sight, said| { pace(sight, said, 1.4) }),
    primitive!("slow_down", [("slow_down", Word::Amount), SPEED], None, |sight, said| pace(sight, said, 0.6)),
    primitive!("flee", [("flee", Word::Target), SPEED, ("distance_m", Word::Amount)], None, |sight, said| {
        let from = said.targets[0].unwrap_or(sight.home);
        let mut away = sight.position - from;
        away.y = 0.0;
        let away = away.try_normalize().unwrap_or(Vec3::X);
        let at = from + away * said.amount(2, 10.0) as f32;
        Deed { speed_mps: speed(said), ..Deed::walk(Walk::To { at, arrival_m: 1.0 }) }
    }),
    primitive!("roam", [("roam", Word::Target), SPEED, ("within_m", Word::Amount)], None, |sight, said| {
        let middle = said.targets[0].unwrap_or(sight.home);
        let [turn, far] = sight.chance;
        let far = far.sqrt() * said.amount(2, 10.0) as f32;
        let by = throng_base::maths::at_angle(turn * std::f32::consts::TAU) * far;
        let at = middle + Vec3::new(by.x, 0.0, by.y);
        Deed { speed_mps: speed(said), ..Deed::walk(Walk::To { at, arrival_m: 0.6 }) }
    }),
    primitive!("leave", [("leave", Word::Target), SPEED], None, |sight, said| Deed {
        speed_mps: speed(said),
        stay_s: f64::INFINITY,
        ..Deed::walk(Walk::Out { at: said.targets[0].unwrap_or(sight.position), arrival_m: said.arrival_m })
    }),
];

fn speed(said: &Said) -> Option<f32> {
    said.amounts[1].map(|speed| speed.clamp(0.0, 100.0) as f32)
}

/// Command to walk to a target, and to stay there for the seconds of argument 2.
fn to(said: &Said, stay_s: f64, arrival: Option<usize>) -> Deed {
    let arrival_m = arrival.and_then(|word| said.amounts[word]).map_or(said.arrival_m, |m| m as f32);
    let stay_s = if arrival.is_some() { 0.0 } else { said.amount(2, stay_s) };
    match said.targets[0] {
        Some(at) => {
            Deed { speed_mps: speed(said), faces: said.facing, stay_s, ..Deed::walk(Walk::To { at, arrival_m }) }
        }
        None => Deed::stay(0.0),
    }
}

/// Command to stay, facing a target, for the seconds of argument 1.
fn towards(said: &Said, stay_s: f64) -> Deed {
    Deed { faces: said.targets[0], ..Deed::stay(said.amount(1, stay_s)) }
}

/// Distance of two agents that shake hands (m).
const HANDS_M: f32 = 1.05;

/// Command to walk to within reach of a target, and to stay there as [`towards`] does.
fn reach(sight: &Sight, said: &Said, stay_s: f64) -> Deed {
    let stays = towards(said, stay_s);
    match said.targets[0].filter(|at| at.distance(sight.position) > 1.1 * HANDS_M) {
        Some(at) => {
            let walk = Deed::walk(Walk::To { at, arrival_m: HANDS_M });
            Deed { faces: stays.faces, stay_s: stays.stay_s, again_s: 0.2, most_s: stays.stay_s + 4.0, ..walk }
        }
        None => stays,
    }
}

/// Command to go on for some seconds at another speed: that of argument 1, or this share of the desired one. Afterwards the
/// speed is as before.
fn pace(sight: &Sight, said: &Said, share: f32) -> Deed {
    let speed_mps = speed(said).or(Some(sight.desired_mps * share));
    Deed { speed_mps, most_s: said.amount(0, 5.0), stay_s: f64::INFINITY, ..Deed::walk(Walk::Keep) }
}

/// Argument of a compiled action.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) enum Operand {
    #[default]
    Nothing,
    Amount(Amount),
    Spot(super::language::Spot),
    /// Place to which the arrow of the event's place points.
    Arrow,
    Point([f32; 3]),
    Number(u16),
    Flag(bool),
}
