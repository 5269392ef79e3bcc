//! Events, and how many there were.

use serde::{Deserialize, Serialize};
use throng_base::Id;

/// Kind of an event: its cause, or its effect.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrowdEventKind {
    /// The bound touched the side of its region, or the agent was woken.
    Resetting,
    /// The bound touched that of another agent; both are renewed, unless the other one was in the meantime.
    Colliding {
        /// The other agent.
        other: Id,
    },
    /// The bound touched an obstacle.
    Meeting {
        /// Number in [`crate::CrowdSetup::obstacles`].
        obstacle: usize,
    },
    /// The bound touched a face, and occupies the cells behind it (`Scheme::Occupancy`).
    Entering,
    /// The bound no longer occupies the cells behind a face (`Scheme::Occupancy`).
    Leaving,
    /// The agent touches another one, and neither moves relative to the other (`Scheme::Occupancy`).
    Contacting {
        /// The other agent.
        other: Id,
    },
    /// The agent moves relative to another one that it touched (`Scheme::Occupancy`).
    Separating {
        /// The other agent.
        other: Id,
    },
    /// The agent was at the end of its route.
    Arrived,
    /// The agent left the crowd at the end of its route, see [`crate::AtEnd::Leave`].
    Left,
    /// An obstacle that moves ran into it.
    Struck {
        /// Number in [`crate::CrowdSetup::obstacles`].
        obstacle: usize,
    },
    /// The agent and another one have come near each other, and one sends on a channel that the other receives;
    /// reported once, for the agent with the smaller number. See [`crate::Senses::meet_m`].
    Met {
        /// The other agent.
        other: Id,
    },
    /// The agent entered a zone.
    CameTo {
        /// Number in [`crate::Senses::zones`].
        zone: usize,
    },
    /// The agent left a zone.
    WentFrom {
        /// Number in [`crate::Senses::zones`].
        zone: usize,
    },
    /// The agent crossed the side of a cell of [`crate::Senses::cell_m`].
    Crossed {
        /// Coordinates of the cell that it left.
        from: [i32; 2],
        /// Coordinates of the cell that it entered.
        to: [i32; 2],
    },
    /// The time set by [`crate::Crowd::set_timer`] has come.
    Timer,
    /// The agent has made no progress for some time, see [`crate::SteeringConfig::stuck_after_s`].
    Stuck,
}

/// An event of an agent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrowdEvent {
    /// Time of the event (s).
    pub time: f64,
    /// The agent.
    pub agent: Id,
    /// Kind of the event.
    pub kind: CrowdEventKind,
}

/// Numbers of events so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EventCounts {
    /// See [`CrowdEventKind::Resetting`].
    pub resetting: u64,
    /// See [`CrowdEventKind::Colliding`]; each counts once.
    pub colliding: u64,
    /// See [`CrowdEventKind::Meeting`].
    pub meeting: u64,
    /// See [`CrowdEventKind::Entering`].
    pub entering: u64,
    /// See [`CrowdEventKind::Leaving`].
    pub leaving: u64,
    /// See [`CrowdEventKind::Contacting`].
    pub contacting: u64,
    /// See [`CrowdEventKind::Separating`].
    pub separating: u64,
    /// See [`CrowdEventKind::Arrived`].
    pub arrived: u64,
    /// See [`CrowdEventKind::Left`].
    pub left: u64,
    /// See [`CrowdEventKind::Struck`].
    pub struck: u64,
    /// See [`CrowdEventKind::Stuck`].
    pub stuck: u64,
    /// Number of events of [`crate::Senses`]; each meeting counts once.
    pub sensed: u64,
    /// See [`CrowdEventKind::Timer`].
    pub timers: u64,
    /// Times that an agent took a new plan.
    pub decisions: u64,
    /// Fixed steps that were taken, parts of one each for itself (`Scheme::Fixed`).
    pub steps: u64,
    /// Fixed steps that were undone for an overlap.
    pub undone: u64,
    /// Agents that overlapped others at the end of a shortest step, which was taken nevertheless.
    pub overlaps: u64,
}

impl CrowdEventKind {
    /// True for events that end [`crate::Crowd::advance_to_signal`]: sensed events, timers, and for agents that sense
    /// them, arrivals and the like.
    pub(crate) fn is_signal(self, arrivals: bool) -> bool {
        match self {
            Self::Met { .. } | Self::CameTo { .. } | Self::WentFrom { .. } | Self::Crossed { .. } | Self::Timer => true,
            Self::Arrived | Self::Left | Self::Stuck => arrivals,
            _ => false,
        }
    }
}

impl EventCounts {
    /// True where each of them is.
    pub(crate) fn is_below(&self, most: u64) -> bool {
        let Self { resetting, colliding, meeting, entering, leaving, contacting, separating, .. } = *self;
        let Self { arrived, left, struck, stuck, sensed, timers, decisions, steps, undone, overlaps, .. } = *self;
        let of_events = [resetting, colliding, meeting, entering, leaving, contacting, separating];
        let others = [arrived, left, struck, stuck, sensed, timers, decisions, steps, undone, overlaps];
        of_events.iter().chain(&others).all(|&count| count < most)
    }

    /// Sum of the counts of two parts of a crowd.
    pub(crate) fn sum_with(&self, other: &Self) -> Self {
        Self {
            resetting: self.resetting + other.resetting,
            colliding: self.colliding + other.colliding,
            meeting: self.meeting + other.meeting,
            entering: self.entering + other.entering,
            leaving: self.leaving + other.leaving,
            contacting: self.contacting + other.contacting,
            separating: self.separating + other.separating,
            arrived: self.arrived + other.arrived,
            left: self.left + other.left,
            struck: self.struck + other.struck,
            stuck: self.stuck + other.stuck,
            sensed: self.sensed + other.sensed,
            timers: self.timers + other.timers,
            decisions: self.decisions + other.decisions,
            steps: self.steps + other.steps,
            undone: self.undone + other.undone,
            overlaps: self.overlaps + other.overlaps,
        }
    }

    /// Counts one event.
    pub(crate) fn add(&mut self, kind: CrowdEventKind) {
        *match kind {
            CrowdEventKind::Resetting => &mut self.resetting,
            CrowdEventKind::Colliding { .. } => &mut self.colliding,
            CrowdEventKind::Meeting { .. } => &mut self.meeting,
            CrowdEventKind::Entering => &mut self.entering,
            CrowdEventKind::Leaving => &mut self.leaving,
            CrowdEventKind::Contacting { .. } => &mut self.contacting,
            CrowdEventKind::Separating { .. } => &mut self.separating,
            CrowdEventKind::Arrived => &mut self.arrived,
            CrowdEventKind::Left => &mut self.left,
            CrowdEventKind::Struck { .. } => &mut self.struck,
            CrowdEventKind::Stuck => &mut self.stuck,
            CrowdEventKind::Met { .. }
            | CrowdEventKind::CameTo { .. }
            | CrowdEventKind::WentFrom { .. }
            | CrowdEventKind::Crossed { .. } => &mut self.sensed,
            CrowdEventKind::Timer => &mut self.timers,
        } += 1;
    }
}
