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

/// Defines the counts of events, and what is done to each of them.
macro_rules! event_counts {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// Numbers of events so far.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
        pub struct EventCounts { $($(#[$doc])* pub $name: u64,)* }

        impl EventCounts {
            /// True where each of them is.
            pub(crate) fn is_below(&self, most: u64) -> bool {
                [$(self.$name),*].iter().all(|&count| count < most)
            }

            /// Sum of the counts of two parts of a crowd.
            pub(crate) fn sum_with(&self, other: &Self) -> Self {
                Self { $($name: self.$name + other.$name),* }
            }
        }
    };
}

event_counts! {
    /// See [`CrowdEventKind::Resetting`].
    resetting,
    /// See [`CrowdEventKind::Colliding`]; each counts once.
    colliding,
    /// See [`CrowdEventKind::Meeting`].
    meeting,
    /// See [`CrowdEventKind::Entering`].
    entering,
    /// See [`CrowdEventKind::Leaving`].
    leaving,
    /// See [`CrowdEventKind::Contacting`].
    contacting,
    /// See [`CrowdEventKind::Separating`].
    separating,
    /// See [`CrowdEventKind::Arrived`].
    arrived,
    /// See [`CrowdEventKind::Left`].
    left,
    /// See [`CrowdEventKind::Struck`].
    struck,
    /// See [`CrowdEventKind::Stuck`].
    stuck,
    /// Number of events of [`crate::Senses`]; each meeting counts once.
    sensed,
    /// See [`CrowdEventKind::Timer`].
    timers,
    /// Times that an agent took a new plan.
    decisions,
    /// Fixed steps that were taken, parts of one each for itself (`Scheme::Fixed`).
    steps,
    /// Fixed steps that were undone for an overlap.
    undone,
    /// Agents that overlapped others at the end of a shortest step, which was taken nevertheless.
    overlaps,
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
