//! What one agent has in mind.

use super::tables::{How, NONE, Threshold, ValueTable};
use serde::{Deserialize, Serialize};
use throng_base::maths;

/// No state, no place, no event.
pub(super) const NO: u16 = u16::MAX;

/// The state of one agent, beside its values and what it has learnt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mind {
    /// It has entered, and has not left.
    pub(super) is_there: bool,
    pub(super) group: u16,
    /// Of each level; [`NO`] where there is none.
    pub(super) states: [u16; 3],
    /// When its highest state began (s).
    pub(super) state_since: f64,
    /// What it does; [`NONE`] where it follows its goal.
    pub(super) action: u32,
    pub(super) phase: Phase,
    /// When it is done standing (s).
    pub(super) until: f64,
    /// When its action is asked anew (s).
    pub(super) again: f64,
    /// When its action ends at the latest (s).
    pub(super) most: f64,
    /// A rule's behaviour lasts.
    pub(super) is_busy: bool,
    /// Of the rule whose behaviour lasts.
    pub(super) priority: i8,
    /// What it goes on with after a rule's behaviour.
    pub(super) resumed: u32,
    /// The event that its action is about, and that of `resumed`.
    pub(super) context: Context,
    pub(super) resumed_context: Context,
    /// When `timer` happens (s).
    pub(super) timer: f64,
    /// Events that it knows of.
    pub(super) news: u64,
    /// Places of one visit that it has entered.
    pub(super) entered: u64,
    /// Thresholds that it has passed, in the direction that counts.
    pub(super) passed: u32,
    /// The next threshold that it passes, and when (s).
    pub(super) crossing: u16,
    pub(super) crossing_at: f64,
    /// Slot that it holds.
    pub(super) slot: u32,
    /// Random numbers so far.
    pub(super) draws: u32,
    /// Where it entered (m).
    pub(super) home: [f32; 3],
    /// Desired speed, but for what a behaviour asks for a while (m/s).
    pub(super) speed: f32,
    /// Behaviours that it began.
    pub(super) begun: u16,
    /// Number of stimuli at one time.
    pub(super) handled: u32,
    pub(super) handled_at: f64,
    /// Why it does what it does.
    pub(super) reason: Reason,
}

/// How far an action is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Phase {
    /// No action.
    #[default]
    Idle,
    /// On its way.
    Walking,
    /// There, until its time is over.
    Standing,
    /// In a queue.
    Waiting,
}

/// The event that a behaviour is about.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Context {
    /// Who is met, or tells; [`NONE`] for nobody.
    pub(super) other: u32,
    pub(super) place: u16,
    /// Number of the event; [`NO`] where it is built in.
    pub(super) event: u16,
    pub(super) how: How,
    pub(super) strength: f32,
}

impl Default for Context {
    fn default() -> Self {
        Self { other: NONE, place: NO, event: NO, how: How::Happens, strength: 1.0 }
    }
}

/// Why somebody does what it does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reason {
    /// When (s).
    pub time_s: f64,
    /// Number of what happened.
    pub(super) trigger: u16,
    /// Number of the rule that was followed; [`NONE`] for none.
    pub(super) rule: u32,
    /// Number of the edge that was taken; [`NONE`] for none.
    pub(super) edge: u32,
    /// Who it was about; [`NONE`] for nobody.
    pub(super) other: u32,
    /// Where; [`NO`] for nowhere.
    pub(super) place: u16,
}

/// How somebody learnt of an event.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Learnt {
    /// When (s).
    pub time_s: f64,
    /// From whom; [`NONE`] for nobody.
    pub(super) from: u32,
    pub(super) how: How,
    /// Where, over the ground (m).
    pub at: [f32; 2],
}

impl Mind {
    pub(super) fn new(group: u16) -> Self {
        let context = Context::default();
        Self {
            is_there: false,
            group,
            states: [NO; 3],
            state_since: 0.0,
            action: NONE,
            phase: Phase::Idle,
            until: f64::INFINITY,
            again: f64::INFINITY,
            most: f64::INFINITY,
            is_busy: false,
            priority: i8::MIN,
            resumed: NONE,
            context,
            resumed_context: context,
            timer: f64::INFINITY,
            news: 0,
            entered: 0,
            passed: 0,
            crossing: NO,
            crossing_at: f64::INFINITY,
            slot: NONE,
            draws: 0,
            home: [0.0; 3],
            speed: 0.0,
            begun: 0,
            handled: 0,
            handled_at: -1.0,
            reason: Reason { time_s: 0.0, trigger: 0, rule: NONE, edge: NONE, other: NONE, place: NO },
        }
    }

    /// When it has to act by itself next (s).
    pub(super) fn next_s(&self) -> f64 {
        self.until.min(self.again).min(self.most).min(self.timer).min(self.crossing_at)
    }
}

/// A value of one agent: exact between two events.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Feeling {
    /// What it was (at `since`).
    pub(super) value: f32,
    /// How fast it grows by itself (1/s).
    pub(super) rate: f32,
    /// (s)
    pub(super) since: f64,
}

impl Feeling {
    /// What it is at a time, not before the last change: v' = rate + pull (rest - v), within its limits.
    pub(super) fn at(&self, table: &ValueTable, time_s: f64) -> f32 {
        let after = (time_s - self.since).max(0.0);
        let value = if table.pull > 0.0 {
            let end = f64::from(table.rest) + f64::from(self.rate / table.pull);
            end + (f64::from(self.value) - end) * maths::exp(-f64::from(table.pull) * after)
        } else {
            f64::from(self.value) + f64::from(self.rate) * after
        };
        (value as f32).clamp(table.limits[0], table.limits[1])
    }

    /// When it reaches a number, if it ever does, in closed form (s).
    pub(super) fn reaches(&self, table: &ValueTable, threshold: &Threshold) -> Option<f64> {
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
    /// True on the far side, the number itself included.
    pub(super) fn is_passed(&self, value: f32) -> bool {
        if self.rises { value >= self.at } else { value <= self.at }
    }
}
