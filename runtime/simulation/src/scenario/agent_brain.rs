//! State of one agent's brain.

use super::tables::{LearningMode, NONE, Threshold, ValueTable};
use serde::{Deserialize, Serialize};
use throng_base::maths;

/// No state, no place, no event.
pub(super) const NO_NUMBER: u16 = u16::MAX;

/// Brain state of one agent, beside its values and the events that it has learnt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AgentBrain {
    /// Whether the agent has entered and not left.
    pub(super) is_there: bool,
    pub(super) group: u16,
    /// State of each level; [`NO_NUMBER`] where there is none.
    pub(super) states: [u16; 3],
    /// Start of its state of the highest level (s).
    pub(super) state_since: f64,
    /// Current action; [`NONE`] where the agent follows its goal.
    pub(super) action: u32,
    pub(super) phase: ActionPhase,
    /// End of standing (s).
    pub(super) stands_until_s: f64,
    /// Time of the next call of its action's function (s).
    pub(super) acts_again_at_s: f64,
    /// Time at which it gives up its action, or a line in which it stands (s).
    pub(super) gives_up_at_s: f64,
    /// Whether a rule's behaviour lasts.
    pub(super) is_busy: bool,
    /// Priority of the rule whose behaviour lasts.
    pub(super) priority: i8,
    /// Action that goes on after a rule's behaviour.
    pub(super) resumed: u32,
    /// Contexts of the current action and of `resumed`.
    pub(super) context: EventContext,
    pub(super) resumed_context: EventContext,
    /// Time at which `timer` happens (s).
    pub(super) timer: f64,
    /// Events that the agent knows of, as bits.
    pub(super) news: u64,
    /// Places of one visit that the agent has entered, as bits.
    pub(super) entered: u64,
    /// Thresholds that values have passed, in the direction that counts, as bits.
    pub(super) passed: u32,
    /// Next threshold that a value passes by itself, and the time of that (s).
    pub(super) crossing: u16,
    pub(super) crossing_at: f64,
    /// Slot that the agent holds; [`NONE`] for none.
    pub(super) slot: u32,
    /// Slot of a queue to which the agent walks, to join the queue there, until it has come to a slot of its own; [`NONE`] for none.
    pub(super) aim: u32,
    /// Agent that tells it news; [`NONE`] for none. Time at which these are told (s).
    pub(super) told_by: u32,
    pub(super) told_at: f64,
    /// Time at which it tells its own news again to those around it (s).
    pub(super) tells_at: f64,
    /// Number of random numbers drawn so far.
    pub(super) draws: u32,
    /// Position at which the agent entered (m).
    pub(super) home: [f32; 3],
    /// Desired speed, without that of a behaviour for its own time (m/s).
    pub(super) speed: f32,
    /// Number of behaviours that it began.
    pub(super) begun: u16,
    /// Number of stimuli handled at one time, and that time (s).
    pub(super) handled: u32,
    pub(super) handled_at: f64,
    /// Cause of the current action.
    pub(super) reason: ActionReason,
}

/// Engagement of one agent in services, on a course and with companions, beside its brain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct AgentEngagement {
    /// Time at which it joined the line in which it stands; infinite for none (s).
    pub joined: f64,
    /// Its last wait until a service began (s), the number of that service, and the number of services so far.
    pub waited: f64,
    pub served_by: u16,
    pub served: u32,
    /// Course that it follows, or has followed last; [`NO_NUMBER`] for none. Number of its legs that are done, in all laps.
    pub course: u16,
    pub legs_done: u32,
    /// Whether its last order leads along the course, and whether it is too far from it.
    pub runs_course: bool,
    pub has_strayed: bool,
    /// Whether its behaviour is over, and it waits for its companions to end theirs.
    pub is_done: bool,
    /// Trigger on which a companion took it along last, and the time of that (s).
    pub led_on: u16,
    pub led_at: f64,
    /// Number of times that it has entered.
    pub entries: u32,
}

impl Default for AgentEngagement {
    fn default() -> Self {
        Self {
            joined: f64::INFINITY,
            waited: 0.0,
            served_by: NO_NUMBER,
            served: 0,
            course: NO_NUMBER,
            legs_done: 0,
            runs_course: false,
            has_strayed: false,
            is_done: false,
            led_on: 0,
            led_at: -1.0,
            entries: 0,
        }
    }
}

/// Phase of an action.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum ActionPhase {
    /// No action.
    #[default]
    Idle,
    /// The agent walks to the place of its action.
    Walking,
    /// The agent stands there until its time is over.
    Standing,
    /// The agent waits in a queue.
    Waiting,
}

/// Context of a behaviour: the event that it is about.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EventContext {
    /// Agent that is met, or that tells; [`NONE`] for none.
    pub(super) other: u32,
    pub(super) place: u16,
    /// Number of the event; [`NO_NUMBER`] where it is built in.
    pub(super) event: u16,
    pub(super) how: LearningMode,
    pub(super) strength: f32,
}

/// An agent in the context of an event.
#[derive(Clone, Copy, Debug)]
pub(super) struct Occasion {
    pub agent: u32,
    pub context: EventContext,
}

impl Default for EventContext {
    fn default() -> Self {
        Self { other: NONE, place: NO_NUMBER, event: NO_NUMBER, how: LearningMode::Happens, strength: 1.0 }
    }
}

/// Cause of an agent's activity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActionReason {
    /// Time (s).
    pub time_s: f64,
    /// Number of the trigger.
    pub(super) trigger: u16,
    /// Number of the rule that was followed; [`NONE`] for none.
    pub(super) rule: u32,
    /// Number of the edge that was taken; [`NONE`] for none.
    pub(super) edge: u32,
    /// Other agent of the event; [`NONE`] for none.
    pub(super) other: u32,
    /// Place of the event; [`NO_NUMBER`] for none.
    pub(super) place: u16,
}

/// Record of how an agent learnt of an event.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearntEvent {
    /// Time (s).
    pub time_s: f64,
    /// Agent that it was learnt from; [`NONE`] for none.
    pub(super) from: u32,
    pub(super) how: LearningMode,
    /// Position of the agent then, x and z (m).
    pub at: [f32; 2],
}

impl AgentBrain {
    /// Times at which it has to act by itself (s).
    pub(super) fn wake_times(&self) -> [f64; 7] {
        [
            self.stands_until_s,
            self.acts_again_at_s,
            self.gives_up_at_s,
            self.timer,
            self.crossing_at,
            self.told_at,
            self.tells_at,
        ]
    }

    pub(super) fn new(group: u16) -> Self {
        let context = EventContext::default();
        Self {
            is_there: false,
            group,
            states: [NO_NUMBER; 3],
            state_since: 0.0,
            action: NONE,
            phase: ActionPhase::Idle,
            stands_until_s: f64::INFINITY,
            acts_again_at_s: f64::INFINITY,
            gives_up_at_s: f64::INFINITY,
            is_busy: false,
            priority: i8::MIN,
            resumed: NONE,
            context,
            resumed_context: context,
            timer: f64::INFINITY,
            news: 0,
            entered: 0,
            passed: 0,
            crossing: NO_NUMBER,
            crossing_at: f64::INFINITY,
            slot: NONE,
            aim: NONE,
            told_by: NONE,
            told_at: f64::INFINITY,
            tells_at: f64::INFINITY,
            draws: 0,
            home: [0.0; 3],
            speed: 0.0,
            begun: 0,
            handled: 0,
            handled_at: -1.0,
            reason: ActionReason { time_s: 0.0, trigger: 0, rule: NONE, edge: NONE, other: NONE, place: NO_NUMBER },
        }
    }
}

/// A value of one agent: exact between two events.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Feeling {
    /// Value at `since`.
    pub(super) value: f32,
    /// Growth by itself (1/s).
    pub(super) rate: f32,
    /// Time of the last change (s).
    pub(super) since: f64,
}

impl Feeling {
    /// Value at a time not before the last change: v' = rate + pull (rest - v), clamped to its limits.
    pub(super) fn value_at(&self, table: &ValueTable, time_s: f64) -> f32 {
        let after = (time_s - self.since).max(0.0);
        let value = if table.pull > 0.0 {
            let end = f64::from(table.rest) + f64::from(self.rate / table.pull);
            end + (f64::from(self.value) - end) * maths::exp(-f64::from(table.pull) * after)
        } else {
            f64::from(self.value) + f64::from(self.rate) * after
        };
        (value as f32).clamp(table.limits[0], table.limits[1])
    }

    /// Time at which it reaches a threshold, in closed form; `None` where it never does (s).
    pub(super) fn crossing_time(&self, table: &ValueTable, threshold: &Threshold) -> Option<f64> {
        let (from, to) = (f64::from(self.value), f64::from(threshold.at));
        let after = if table.pull > 0.0 {
            let end = f64::from(table.rest) + f64::from(self.rate / table.pull);
            let left = (to - end) / (from - end);
            if !(left > 0.0 && left < 1.0) {
                return None;
            }
            -maths::ln(left) / f64::from(table.pull)
        } else {
            (to - from) / f64::from(self.rate)
        };
        (0.0..1e9).contains(&after).then_some(self.since + after)
    }
}

impl Threshold {
    /// True for a value on the far side of the threshold, the threshold itself included.
    pub(super) fn is_passed(&self, value: f32) -> bool {
        if self.rises { value >= self.at } else { value <= self.at }
    }
}
