//! Flat tables of a scenario, which the compiler writes and the evaluator reads.

use super::action_registry::{ActionOperand, ActionRegistry, ActionWords, Effect};
use super::language::{Amount, Op, Program, ScenarioVocabulary};
use super::services::ServiceTable;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::text::TomlSource;

/// Number that stands for no item.
pub(super) const NONE: u32 = u32::MAX;

/// Triggers that rules and edges wait for, by number: built-in ones, then the events of the scene, then its thresholds.
pub(super) mod trigger {
    /// Names of the built-in triggers, in the order of their numbers.
    pub const NAMES: [&str; 13] = [
        "starts", "meets", "enters", "leaves", "crosses", "arrives", "stuck", "done", "full", "timer", "gives_up",
        "lap", "strays",
    ];
    pub const STARTS: u16 = 0;
    pub const MEETS: u16 = 1;
    pub const ENTERS: u16 = 2;
    pub const LEAVES: u16 = 3;
    pub const CROSSES: u16 = 4;
    pub const ARRIVES: u16 = 5;
    pub const STUCK: u16 = 6;
    pub const DONE: u16 = 7;
    pub const FULL: u16 = 8;
    pub const TIMER: u16 = 9;
    pub const GIVES_UP: u16 = 10;
    pub const LAP: u16 = 11;
    pub const STRAYS: u16 = 12;
    /// Number of the first event of the scene.
    pub const EVENTS: u16 = NAMES.len() as u16;
}

/// Way in which an agent learns of an event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum LearningMode {
    /// The event happens to the agent.
    #[default]
    Happens,
    /// Another agent tells of it.
    PassedOn,
    /// A blackboard shows it.
    Read,
    /// The emotion of another agent is conveyed.
    Felt,
}

impl LearningMode {
    /// Names in predicates, in the order of variants.
    pub const NAMES: [&str; 4] = ["happens", "passed_on", "read", "felt"];

    /// Name in predicates.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

/// A compiled scenario.
#[derive(Clone, Debug, Default)]
pub struct Scenario {
    /// The scene file, for messages.
    pub(super) source: TomlSource,
    pub(super) code: Vec<Op>,
    pub(super) names: ScenarioVocabulary,
    pub(super) primitives: ActionRegistry,
    pub(super) values: Vec<ValueTable>,
    pub(super) thresholds: Vec<Threshold>,
    pub(super) events: Vec<EventTable>,
    pub(super) places: Vec<PlaceTable>,
    pub(super) slots: Vec<SlotTable>,
    pub(super) services: Vec<ServiceTable>,
    /// Positions of things at the start (m).
    pub(super) things: Vec<Vec3>,
    pub(super) rules: Vec<RuleTable>,
    /// Rules of each trigger: first and last + 1 in `rule_order`.
    pub(super) rules_of: Vec<[u32; 2]>,
    pub(super) rule_order: Vec<u32>,
    /// Number of rules with a pause.
    pub(super) num_pauses: usize,
    /// Names of graphs.
    pub(super) graphs: Vec<String>,
    pub(super) states: Vec<StateTable>,
    /// Edges of each state, in the order of states: those from it, then those from any state of its graph.
    pub(super) edges: Vec<EdgeTable>,
    pub(super) actions: Vec<CompiledAction>,
    /// Keys and positions of slots, and of goals of actions (m).
    pub(crate) goals: Vec<(String, Vec3)>,
    /// Corners of paths that actions follow (m).
    pub(super) paths: Vec<Vec<Vec3>>,
    pub(super) relations: Vec<RelationTable>,
    pub(super) groups: Vec<GroupTable>,
    /// Motion tags that actions name.
    pub(super) motions: Vec<String>,
    pub(super) blackboards: BlackboardTable,
    /// Time to tell news (s), and distance at which they can be heard (m).
    pub(super) telling_s: f64,
    pub(super) hearing_m: f32,
    pub(super) end: EndTable,
    pub(super) expectations: Vec<ExpectationTable>,
    /// Whether any rule or edge needs places, meetings and cells to be sensed.
    pub(crate) senses_zones: bool,
    pub(super) meets: bool,
    pub(crate) senses_cells: bool,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct ValueTable {
    pub start: [f32; 2],
    pub rate: f32,
    /// Value of rest, and rate of the return to it (1/s, 0 for none).
    pub rest: f32,
    pub pull: f32,
    pub limits: [f32; 2],
    /// Range of its thresholds: first and last + 1.
    pub thresholds: [u16; 2],
}

/// Threshold of a value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Threshold {
    pub value: u16,
    pub at: f32,
    pub rises: bool,
}

#[derive(Clone, Debug, Default)]
pub(super) struct EventTable {
    pub schedule: Schedule,
    /// Predicate of the agents to which it happens; all where absent.
    pub who: Option<Program>,
    pub nobody: bool,
    /// Bit by which agents pass it on.
    pub channel: Option<u8>,
    pub posted: bool,
    pub fresh_s: f64,
    /// Doors that open (true) or close with it.
    pub doors: Vec<(u16, bool)>,
    /// Condition at which it happens, each time that it becomes true.
    pub condition: Option<Program>,
}

/// Schedule of an event.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Schedule {
    #[default]
    Never,
    At(f64),
    Between(f64, f64),
    Poisson(f64),
    Period(f64),
}

#[derive(Clone, Debug)]
pub(super) struct PlaceTable {
    pub at: Vec3,
    pub radius_m: f32,
    pub kind: u16,
    pub guidepost: bool,
    /// Bit among the places that are entered once.
    pub once: Option<u8>,
    pub arrow: Option<u16>,
    /// Range of its slots: first and last + 1.
    pub slots: [u32; 2],
    pub is_queue: bool,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct SlotTable {
    pub at: Vec3,
    pub facing: Vec3,
    pub place: u16,
}

#[derive(Clone, Debug, Default)]
pub(super) struct RuleTable {
    pub name: String,
    /// Groups that it is for, as bits.
    pub who: u64,
    pub when: Option<Program>,
    pub probability: f32,
    /// First of its actions; an end follows the last.
    pub actions: u32,
    /// Whether all of its actions take no time.
    pub is_instant: bool,
    pub priority: i8,
    /// Whether the other agent follows it, too.
    pub both: bool,
    pub pause_s: f32,
    /// Number among the rules with a pause.
    pub pause: u32,
}

#[derive(Clone, Debug)]
pub(super) struct StateTable {
    pub name: String,
    /// Number of the name among those of states.
    pub word: u16,
    pub level: u8,
    /// Number of its graph.
    pub graph_number: u16,
    /// First of its actions; [`NONE`] where it has none.
    pub actions: u32,
    /// Start state of the graph below it; [`NONE`] where it has none.
    pub graph: u32,
    /// Range of its edges: first and last + 1.
    pub edges: [u32; 2],
}

#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeTable {
    pub trigger: u16,
    pub to: u16,
    pub when: Option<Program>,
    /// Probability; where negative, an equal share of what the other edges leave.
    pub probability: f32,
    /// Number among the edges of its graph, as in the scene file.
    pub number: u16,
    /// Whether the agent takes it without its companions.
    pub alone: bool,
}

/// One action of a behaviour.
#[derive(Clone, Copy, Debug)]
pub(super) enum CompiledAction {
    End,
    /// Walks to the goal of a happening.
    Happening(u16),
    Effect(Effect, ActionWords),
    Primitive {
        number: u16,
        words: ActionWords,
        /// Number of the motion tag.
        motion: Option<u16>,
        /// Path of [`Scenario::paths`] that it follows.
        route: Option<u16>,
        claims: ActionClaim,
    },
}

/// Claim of an action on a slot or a thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ActionClaim {
    Nothing,
    Slot,
    /// Claims a slot of a queue, and waits until a slot of this place is free, where one is named.
    Queue(Option<u16>),
    /// Claims a slot in a line of a service, and waits until it is called to a till.
    Serve(u16),
    /// Claims a thing, which is taken.
    Take(u16),
    Put(u16),
}

/// Party of a relation: an agent, a group or a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Party {
    Group(u16),
    Agent(u32),
    Place(u16),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct RelationTable {
    pub of: Party,
    pub to: Party,
    /// Whether it does not hold the other way round.
    pub one_sided: bool,
    pub share: f32,
    pub friendship: f32,
    pub curiosity: f32,
}

#[derive(Clone, Debug)]
pub(super) struct GroupTable {
    /// Number in the scene file.
    pub number: usize,
    /// Start state of its agents; [`NONE`] where they follow their goal.
    pub start: u32,
    /// Range of its agents: first and last + 1.
    pub agents: [u32; 2],
    /// Number of its agents that are there at the start.
    pub num_at_start: u32,
    /// Rates of entry, as (from time, per second) (s, 1/s).
    pub rates: Vec<[f64; 2]>,
    /// Time after which these begin again; infinite for never (s).
    pub period_s: f64,
    /// Whether agents that have left enter again.
    pub reuses: bool,
}

/// Blackboards of cells: levels of squares, each twice as wide as those of the level below.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BlackboardTable {
    /// Side of the smallest cells; 0 where there are none (m).
    pub cell_m: f32,
    pub levels: u32,
}

/// Compiled expectation.
#[derive(Clone, Debug, Default)]
pub(super) struct ExpectationTable {
    /// Groups that it is about, as bits.
    pub who: u64,
    /// Predicates, or an amount.
    pub programs: Vec<Program>,
    /// Number of its event, place or action.
    pub number: u16,
}

/// End of the scene.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct EndTable {
    /// Groups that must have left, as bits; 0 for none.
    pub left: u64,
    pub known: Option<u16>,
    pub event: Option<u16>,
}

impl Scenario {
    /// True where agents must sense each other nearby, to pass events on or for `meets`.
    pub(crate) fn senses_meetings(&self) -> bool {
        self.meets || self.events.iter().any(|e| e.channel.is_some())
    }

    /// True where an action changes relationships.
    pub(super) fn changes_relationships(&self) -> bool {
        self.actions.iter().any(|a| matches!(a, CompiledAction::Effect(Effect::Befriend, _)))
    }

    /// Largest speed that an action names as a number (m/s).
    pub(crate) fn largest_speed_mps(&self) -> f32 {
        self.actions.iter().filter_map(|a| a.named_speed(&self.primitives)).fold(0.0, f32::max)
    }

    /// Name of a trigger.
    pub(super) fn trigger_name(&self, trigger: u16) -> String {
        let number = usize::from(trigger);
        let events = self.names.events.0.iter().map(String::as_str);
        if let Some(name) = trigger::NAMES.into_iter().chain(events).nth(number) {
            return name.into();
        }
        let t = &self.thresholds[number - trigger::NAMES.len() - self.events.len()];
        let sign = if t.rises { '>' } else { '<' };
        format!("{} {sign} {}", self.names.values.0[usize::from(t.value)], t.at)
    }
}

impl CompiledAction {
    /// Speed that the action names as a number; `None` for others (m/s).
    fn named_speed(&self, primitives: &ActionRegistry) -> Option<f32> {
        let amount = match self {
            Self::Effect(Effect::Speed, words) => words[0],
            Self::Primitive { number, words, .. } => {
                let at = primitives.get(*number).words.iter().position(|w| w.0 == "speed")?;
                words[at]
            }
            _ => return None,
        };
        if let ActionOperand::Amount(Amount::Number(mps)) = amount { Some(mps as f32) } else { None }
    }
}
