//! Actions of agents: effects, which take no time, and primitive behaviours, which are functions registered by name.

use super::language::Amount;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::thresholds::STANDING_MPS;
use throng_core::body::ArmLayer;

/// Kind of an argument of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WordKind {
    /// A number, or an expression for one.
    Amount,
    /// A place by its name, a point, `me`, `other`, `home`, or `place` for that of the event.
    Target,
    /// A target; where it is a place with slots, one of them is claimed.
    Slot,
    /// A place with a queue; its last slot is claimed.
    Queue,
    /// Name of a service.
    Service,
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
    /// Name of a gesture.
    Gesture,
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
    /// Begins a gesture of the arms, or ends it.
    Gesture,
}

/// Gestures that scene files name, in order; their times where none is given (s). One more name, `none`, ends a gesture.
pub(crate) const GESTURES: [(&str, ArmLayer, f64); 6] = [
    ("wave", ArmLayer::Wave, 3.0),
    ("point", ArmLayer::Point(Vec3::ZERO), 3.0),
    ("phone", ArmLayer::Phone, f64::INFINITY),
    ("carry_beside", ArmLayer::CarryBeside, f64::INFINITY),
    ("carry_before", ArmLayer::CarryBefore, f64::INFINITY),
    ("carry_on_shoulder", ArmLayer::CarryOnShoulder, f64::INFINITY),
];

/// Primitive behaviour: a name, its arguments, and a function.
#[derive(Clone, Copy, Debug)]
pub struct PrimitiveBehaviour {
    /// Name in scene files.
    pub name: &'static str,
    /// Names and kinds of its arguments. The first argument has the behaviour's own name.
    pub words: &'static [(&'static str, WordKind)],
    /// Motion tag of the bundle, where the arguments name none.
    pub motion: Option<&'static str>,
    /// Function that returns what the agent does now.
    pub act: fn(&PrimitiveInput, &ActionArguments) -> ActionCommand,
}

/// Input of a primitive behaviour: the state of the agent.
#[derive(Clone, Copy, Debug)]
pub struct PrimitiveInput {
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
pub(super) const MAX_WORDS: usize = 6;
/// Operands of an action, one for each of its words.
pub(super) type ActionWords = [ActionOperand; MAX_WORDS];

/// Values of an action's arguments, in the order of [`PrimitiveBehaviour::words`]; `None` for one that is not given.
#[derive(Clone, Copy, Debug, Default)]
pub struct ActionArguments {
    /// Amounts and flags.
    pub amounts: [Option<f64>; MAX_WORDS],
    /// Positions of targets (m).
    pub targets: [Option<Vec3>; MAX_WORDS],
    /// Position that the agent of a slot faces (m).
    pub facing: Option<Vec3>,
    /// Distance from the target at which the agent has arrived, so that it does not stand on it (m).
    pub arrival_m: f32,
}

impl ActionArguments {
    /// Amount of an argument, or `otherwise` where it is not given.
    pub fn amount(&self, word: usize, otherwise: f64) -> f64 {
        self.amounts[word].unwrap_or(otherwise)
    }
}

/// Action command of an agent: to walk somewhere, then to stay there for a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActionCommand {
    /// Walk at the beginning.
    pub walk: WalkCommand,
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
pub enum WalkCommand {
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
    /// Walks to a place that is seen from a middle; where a wall or a door is before it, another one is drawn.
    Near {
        /// The middle (m).
        middle: Vec3,
        /// Position (m).
        at: Vec3,
        /// Distance at which the agent has arrived (m).
        arrival_m: f32,
    },
    /// Walks to a place, or, where a wall or a closed door is before it, to that of the seen ones which is farthest from a threat; stays
    /// where none is farther than the agent.
    Away {
        /// Position of the threat (m).
        from: Vec3,
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

impl ActionCommand {
    /// Command to walk.
    pub fn walk(walk: WalkCommand) -> Self {
        Self { walk, speed_mps: None, faces: None, stay_s: 0.0, again_s: 0.0, most_s: f64::INFINITY }
    }

    /// Command to stay in place for some time (s).
    pub fn stay_for(seconds: f64) -> Self {
        Self { stay_s: seconds, ..Self::walk(WalkCommand::Halt) }
    }
}

/// Action that scene files can name.
#[derive(Clone, Copy, Debug)]
pub enum RegisteredAction {
    /// Effect, which takes no time.
    Effect(Effect),
    /// Primitive behaviour, by its number in [`ActionRegistry`].
    Primitive(u16),
}

/// Effect of scene files: name, arguments and effect.
type EffectWords = (&'static str, &'static [(&'static str, WordKind)], Effect);

const EFFECTS: &[EffectWords] = &[
    ("set", &[("set", WordKind::Value), ("to", WordKind::Amount)], Effect::Set),
    ("add", &[("add", WordKind::Value), ("by", WordKind::Amount)], Effect::Add),
    ("rate", &[("rate", WordKind::Value), ("to", WordKind::Amount)], Effect::Rate),
    ("speed", &[("speed", WordKind::Amount)], Effect::Speed),
    ("post", &[("post", WordKind::Event), ("cells", WordKind::Amount), ("for_s", WordKind::Amount)], Effect::Post),
    ("learn", &[("learn", WordKind::Event)], Effect::Learn),
    (
        "convey",
        &[
            ("convey", WordKind::Event),
            ("within_m", WordKind::Amount),
            ("strength", WordKind::Amount),
            ("friends", WordKind::Flag),
        ],
        Effect::Convey,
    ),
    ("befriend", &[("befriend", WordKind::Amount)], Effect::Befriend),
    ("open", &[("open", WordKind::Door)], Effect::Open),
    ("close", &[("close", WordKind::Door)], Effect::Close),
    ("release", &[("release", WordKind::Flag)], Effect::Release),
    ("timer", &[("timer", WordKind::Amount)], Effect::Timer),
    (
        "gesture",
        &[("gesture", WordKind::Gesture), ("at", WordKind::Target), ("for_s", WordKind::Amount)],
        Effect::Gesture,
    ),
];

/// Action registry: all primitive behaviours that scene files may name.
///
/// ```no_run
/// use throng_simulation::Scene;
/// use throng_simulation::scenario::{ActionCommand, ActionRegistry, PrimitiveBehaviour, WordKind};
///
/// let pause = PrimitiveBehaviour {
///     name: "pause",
///     words: &[("pause", WordKind::Amount)],
///     motion: None,
///     act: |_, words| ActionCommand::stay_for(words.amount(0, 1.0)),
/// };
/// let scene = Scene::load("street.toml")?.open_with(&ActionRegistry::default().with_primitive(pause))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ActionRegistry(Vec<PrimitiveBehaviour>);

impl Default for ActionRegistry {
    /// Registry of the built-in primitive behaviours.
    fn default() -> Self {
        Self(BUILT_IN.to_vec())
    }
}

impl ActionRegistry {
    /// Adds a primitive behaviour, in place of one of the same name.
    pub fn with_primitive(mut self, primitive: PrimitiveBehaviour) -> Self {
        self.0.retain(|p| p.name != primitive.name);
        self.0.push(primitive);
        self
    }

    /// The primitive behaviour of a number.
    pub fn get(&self, number: u16) -> &PrimitiveBehaviour {
        &self.0[usize::from(number)]
    }

    /// Action of a name, with its arguments.
    pub fn find_action(&self, name: &str) -> Option<(RegisteredAction, &'static [(&'static str, WordKind)])> {
        let effect = EFFECTS.iter().find(|e| e.0 == name).map(|e| (RegisteredAction::Effect(e.2), e.1));
        let own = || self.0.iter().position(|p| p.name == name);
        effect.or_else(|| own().map(|n| (RegisteredAction::Primitive(n as u16), self.0[n].words)))
    }

    /// Names of the primitive behaviours, by number.
    pub(super) fn primitive_names(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.0.iter().map(|p| p.name)
    }

    /// Names of all actions.
    pub fn action_names(&self) -> impl Iterator<Item = &'static str> + '_ {
        EFFECTS.iter().map(|e| e.0).chain(self.primitive_names())
    }
}

const SPEED: (&str, WordKind) = ("speed", WordKind::Amount);
const FOR: (&str, WordKind) = ("for_s", WordKind::Amount);
const MOTION: (&str, WordKind) = ("motion", WordKind::Motion);

macro_rules! primitive {
    ($name:literal, [$($word:expr),*], $motion:expr, $act:expr) => {
        PrimitiveBehaviour { name: $name, words: &[$($word),*], motion: $motion, act: $act }
    };
}

const BUILT_IN: &[PrimitiveBehaviour] = &[
    primitive!(
        "go",
        [("go", WordKind::Target), SPEED, ("within_m", WordKind::Amount)],
        None,
        |_, said| walk_to_target(said, 0.0, said.amount(2, said.arrival_m.into()) as f32)
    ),
    primitive!("visit", [("visit", WordKind::Slot), SPEED, FOR, MOTION], None, |_, said| visit_target(said, 0.0)),
    primitive!("look", [("look", WordKind::Slot), SPEED, FOR, MOTION], Some("look"), |_, said| visit_target(said, 5.0)),
    primitive!("buy", [("buy", WordKind::Slot), SPEED, FOR, MOTION], Some("buy"), |_, said| visit_target(said, 5.0)),
    primitive!("sit", [("sit", WordKind::Slot), SPEED, FOR, MOTION], Some("sit"), |_, said| visit_target(said, 20.0)),
    primitive!(
        "queue",
        [("queue", WordKind::Queue), SPEED, ("into", WordKind::Place), MOTION],
        Some("queue"),
        |_, said| { ActionCommand { stay_s: f64::INFINITY, ..visit_target(said, 0.0) } }
    ),
    primitive!("be_served", [("be_served", WordKind::Service), SPEED, FOR, MOTION], Some("buy"), |_, said| {
        visit_target(said, 0.0)
    }),
    primitive!(
        "follow_route",
        [
            ("follow_route", WordKind::Points),
            SPEED,
            ("again", WordKind::Flag),
            ("laps", WordKind::Amount),
            ("within_m", WordKind::Amount),
            ("nearest", WordKind::Flag)
        ],
        None,
        |_, said| {
            let again_s = if said.amounts[3].or(said.amounts[4]).is_some() { 0.5 } else { 0.0 };
            ActionCommand { again_s, ..walk_at_speed(said, WalkCommand::Along) }
        }
    ),
    primitive!(
        "follow",
        [("follow", WordKind::Target), SPEED, FOR, ("within_m", WordKind::Amount)],
        None,
        |sight, said| {
            let arrival_m = said.amount(3, 1.5) as f32;
            // An agent that stands goes on only where it is left behind.
            let stands = sight.velocity.length() < STANDING_MPS;
            let near_m = if stands { LEFT_BEHIND * arrival_m } else { arrival_m };
            let far = said.targets[0].filter(|at| (*at - sight.position).length() > near_m);
            let walk = far.map_or(WalkCommand::Halt, |at| WalkCommand::To { at, arrival_m });
            let (stay_s, most_s) = (f64::INFINITY, said.amount(2, 10.0));
            ActionCommand { faces: said.targets[0], stay_s, again_s: 0.5, most_s, ..walk_at_speed(said, walk) }
        }
    ),
    primitive!("stay", [("stay", WordKind::Amount), MOTION], None, |_, said| ActionCommand::stay_for(
        said.amount(0, 0.0)
    )),
    primitive!("greet", [("greet", WordKind::Target), FOR, MOTION], Some("greet"), |_, said| face_target(said, 2.5)),
    primitive!("shake_hands", [("shake_hands", WordKind::Target), FOR, MOTION], Some("handshake"), |sight, said| {
        walk_within_reach(sight, said, 3.0)
    }),
    primitive!("chat", [("chat", WordKind::Target), FOR, MOTION], Some("chat"), |_, said| face_target(said, 8.0)),
    primitive!("fight", [("fight", WordKind::Target), FOR, MOTION], Some("fight"), |_, said| face_target(said, 3.0)),
    primitive!("perform", [("perform", WordKind::Motion), FOR, ("facing", WordKind::Target)], None, |_, said| {
        ActionCommand { faces: said.targets[2], ..ActionCommand::stay_for(said.amount(1, 3.0)) }
    }),
    primitive!("take", [("take", WordKind::Take), SPEED, FOR, MOTION], Some("take"), |_, said| visit_target(said, 0.0)),
    primitive!("put", [("put", WordKind::Put), SPEED, FOR, MOTION, ("on", WordKind::Rest)], Some("put"), |_, said| {
        visit_target(said, 0.0)
    }),
    primitive!("spurt", [("spurt", WordKind::Amount), SPEED], None, |sight, said| { change_pace(sight, said, 1.4) }),
    primitive!("slow_down", [("slow_down", WordKind::Amount), SPEED], None, |sight, said| change_pace(
        sight, said, 0.6
    )),
    primitive!("flee", [("flee", WordKind::Target), SPEED, ("distance_m", WordKind::Amount)], None, |sight, said| {
        let from = said.targets[0].unwrap_or(sight.home);
        let (offset, far) = ((sight.position - from).with_y(0.0), said.amount(2, 10.0) as f32);
        // Who is far enough away already does not walk towards it.
        let walk = match offset.length() < far {
            true => {
                let at = from + offset.try_normalize().unwrap_or(Vec3::X) * far;
                WalkCommand::Away { from, at, arrival_m: 1.0 }
            }
            false => WalkCommand::Halt,
        };
        walk_at_speed(said, walk)
    }),
    primitive!("roam", [("roam", WordKind::Target), SPEED, ("within_m", WordKind::Amount)], None, |sight, said| {
        let middle = said.targets[0].unwrap_or(sight.home);
        let [turn, far] = sight.chance;
        let far = far.sqrt() * said.amount(2, 10.0) as f32;
        let by = throng_base::maths::direction_at_angle(turn * std::f32::consts::TAU) * far;
        let at = middle + Vec3::new(by.x, 0.0, by.y);
        walk_at_speed(said, WalkCommand::Near { middle, at, arrival_m: 0.6 })
    }),
    primitive!("leave", [("leave", WordKind::Target), SPEED], None, |sight, said| {
        let (at, arrival_m) = (said.targets[0].unwrap_or(sight.position), said.arrival_m);
        ActionCommand { stay_s: f64::INFINITY, ..walk_at_speed(said, WalkCommand::Out { at, arrival_m }) }
    }),
];

fn speed_argument(said: &ActionArguments) -> Option<f32> {
    said.amounts[1].map(|speed| speed.clamp(0.0, 100.0) as f32)
}

/// Command to walk at the speed of argument 1.
fn walk_at_speed(said: &ActionArguments, walk: WalkCommand) -> ActionCommand {
    ActionCommand { speed_mps: speed_argument(said), ..ActionCommand::walk(walk) }
}

/// Command to walk to a target, and to stay there.
fn walk_to_target(said: &ActionArguments, stay_s: f64, arrival_m: f32) -> ActionCommand {
    let Some(at) = said.targets[0] else { return ActionCommand::stay_for(0.0) };
    ActionCommand { faces: said.facing, stay_s, ..walk_at_speed(said, WalkCommand::To { at, arrival_m }) }
}

/// Command to walk to a target, and to stay there for the seconds of argument 2.
fn visit_target(said: &ActionArguments, stay_s: f64) -> ActionCommand {
    walk_to_target(said, said.amount(2, stay_s), said.arrival_m)
}

/// Command to stay, facing a target, for the seconds of argument 1.
fn face_target(said: &ActionArguments, stay_s: f64) -> ActionCommand {
    ActionCommand { faces: said.targets[0], ..ActionCommand::stay_for(said.amount(1, stay_s)) }
}

/// Distance from whom an agent follows at which it goes on, over that at which it stops.
const LEFT_BEHIND: f32 = 1.3;

/// Distance of two agents that shake hands (m).
const HANDS_M: f32 = 1.05;

/// Distance from where it is to stand at which an agent that shakes hands has arrived (m).
const BEFORE_M: f32 = 0.15;

/// Command to walk to within reach of a target that comes as far, and to stay there as [`face_target`] does.
fn walk_within_reach(sight: &PrimitiveInput, said: &ActionArguments, stay_s: f64) -> ActionCommand {
    let stays = face_target(said, stay_s);
    let far = said.targets[0].filter(|at| at.distance(sight.position) > 1.1 * HANDS_M);
    far.map_or(stays, |at| {
        let to = at - sight.position;
        let at = sight.position + to * (0.5 * (1.0 - HANDS_M / to.length()));
        let walk = WalkCommand::To { at, arrival_m: BEFORE_M };
        ActionCommand { walk, again_s: 0.2, most_s: stays.stay_s + 4.0, ..stays }
    })
}

/// Command to go on for some seconds at another speed: that of argument 1, or this share of the desired one. Afterwards the
/// speed is as before.
fn change_pace(sight: &PrimitiveInput, said: &ActionArguments, share: f32) -> ActionCommand {
    let speed_mps = speed_argument(said).or(Some(sight.desired_mps * share));
    let (most_s, stay_s) = (said.amount(0, 5.0), f64::INFINITY);
    ActionCommand { speed_mps, most_s, stay_s, ..ActionCommand::walk(WalkCommand::Keep) }
}

/// Argument of a compiled action.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) enum ActionOperand {
    #[default]
    Nothing,
    Amount(Amount),
    Spot(super::language::SpotName),
    /// Place to which the arrow of the event's place points.
    Arrow,
    Point([f32; 3]),
    Number(u16),
    Flag(bool),
    /// Time of a service, which is drawn.
    Duration(u16),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_flees_towards_the_threat() {
        let flee = BUILT_IN.iter().find(|p| p.name == "flee").unwrap();
        for (x, distance_m) in [(1.0, 4.0), (3.9, 4.0), (5.5, 4.0), (8.8, 4.0), (-20.0, 10.0)] {
            let sight = PrimitiveInput {
                time_s: 0.0,
                position: Vec3::new(x, 0.0, 0.0),
                velocity: Vec3::ZERO,
                desired_mps: 1.3,
                home: Vec3::ZERO,
                chance: [0.5; 2],
            };
            let mut said = ActionArguments::default();
            (said.targets[0], said.amounts[2]) = (Some(Vec3::ZERO), Some(distance_m));
            match (flee.act)(&sight, &said).walk {
                WalkCommand::Away { at, .. } => {
                    assert!((at.length() - distance_m as f32).abs() < 1e-4 && at.x * x > 0.0, "{at}")
                }
                walk => assert!(walk == WalkCommand::Halt && x.abs() >= distance_m as f32, "{walk:?} at {x}"),
            }
        }
    }
}
