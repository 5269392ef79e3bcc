//! Errors of setups and of runs.

use throng_base::{Id, error::Error};

/// Result of what a crowd does.
pub(crate) type Result<T, E = CrowdError> = std::result::Result<T, E>;

/// Error of a crowd. Converts into [`Error`], for callers that need not tell the kinds apart.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum CrowdError {
    /// Two agents in one place.
    #[error(
        "agents {first} and {second} overlap by {overlap_m:.3} m at the start, or could not brake in time; move one of \
         them, or let it start slower"
    )]
    Overlap {
        /// First of the two.
        first: Id,
        /// Second of the two; for a newcomer, the id that it would have.
        second: Id,
        /// Depth to which their discs, or their stopping distances, overlap (m).
        overlap_m: f32,
    },
    /// An agent in an obstacle.
    #[error("agent {agent} stands in obstacle {obstacle} or cannot stop before it; move it, or let it start slower")]
    Inside {
        /// The agent; the id that it would have.
        agent: Id,
        /// Number of the obstacle.
        obstacle: usize,
    },
    /// A goal that cannot be reached.
    #[error("subgoal {subgoal} of route {route} is in obstacle {obstacle}: move it out")]
    Goal {
        /// Number of the route.
        route: usize,
        /// Number of the subgoal.
        subgoal: usize,
        /// Number of the obstacle.
        obstacle: usize,
    },
    /// An agent acts more often than is possible, so that time does not pass.
    #[error(
        "{} {events} events within {seconds} s, where at most {most} are possible; load an older snapshot to go on, and \
         please report it with the scene",
        subject(.first, .second)
    )]
    Stalled {
        /// Agent that acts too often.
        first: Id,
        /// The partner of its last meeting, if any.
        second: Option<Id>,
        /// Events of the first.
        events: u64,
        /// Largest possible number of events.
        most: u64,
        /// Time in which they happened (s).
        seconds: f64,
    },
    /// Error of any group of characters: a value out of range, a full crowd, an agent that left, a goal without a path,
    /// a snapshot of something else.
    #[error(transparent)]
    Other(#[from] Error),
}

/// Beginning of the message of a stalled crowd.
fn subject(first: &Id, second: &Option<Id>) -> String {
    match second {
        Some(second) => format!("agents {first} and {second} block time: the first had"),
        None => format!("agent {first} blocks time: it had"),
    }
}

impl From<CrowdError> for Error {
    fn from(e: CrowdError) -> Self {
        match e {
            CrowdError::Other(e) => e,
            CrowdError::Overlap { first, second, overlap_m } => {
                Error::Occupied { who: second, by: format!("agent {first}, by {overlap_m:.3} m,") }
            }
            CrowdError::Inside { agent, obstacle } => {
                Error::Occupied { who: agent, by: format!("obstacle {obstacle}") }
            }
            CrowdError::Goal { route, subgoal, obstacle } => Error::Occupied {
                who: Id::first(route),
                by: format!("obstacle {obstacle}, at subgoal {subgoal} of the route,"),
            },
            CrowdError::Stalled { first, events, .. } => Error::Value {
                what: "number of events within a second",
                who: Some(first),
                got: events as f64,
                expected: "as many as the smallest interval allows; load an older snapshot, and please report it",
            },
        }
    }
}

/// [`Error::Value`] about the setting of something, unless `good`.
pub fn check(what: &'static str, who: usize, got: f32, good: bool, expected: &'static str) -> throng_base::Result<()> {
    throng_base::error::check_value(what, Some(Id::first(who)), got, good, expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stalled_crowd_names_the_agents_that_stall_it() {
        let stalled = |second| {
            CrowdError::Stalled { first: Id::first(3), second, events: 12, most: 11, seconds: 0.5 }.to_string()
        };
        assert!(stalled(None).starts_with("agent 3 blocks time: it had 12 events within 0.5 s"), "{}", stalled(None));
        let both = stalled(Some(Id::first(5)));
        assert!(both.starts_with("agents 3 and 5 block time: the first had 12 events"), "{both}");
    }
}
