//! Why a crowd cannot be.

use super::Id;

/// What is wrong with what a crowd is given.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CrowdError {
    /// A number out of its range.
    #[error("{what} {index} has {field} {got}, expected {expected}")]
    Value {
        /// Member, route, field, obstacle, interest or config.
        what: &'static str,
        /// Its number.
        index: usize,
        /// Which of its settings.
        field: &'static str,
        /// What it is.
        got: f32,
        /// What it may be.
        expected: &'static str,
    },
    /// Something that does not exist.
    #[error("{what} {got} does not exist, there are {limit}")]
    Index {
        /// What was named.
        what: &'static str,
        /// Its number.
        got: usize,
        /// How many there are.
        limit: usize,
    },
    /// Two members in one place.
    #[error(
        "members {first} and {second} overlap by {overlap_m:.3} m at the start, or could not brake in time; move one of \
         them, or let it start slower"
    )]
    Overlap {
        /// Number of the one.
        first: usize,
        /// Number of the other.
        second: usize,
        /// How far their discs, or the ways they need to stop, reach into each other. [Unit: m]
        overlap_m: f32,
    },
    /// A member in an obstacle.
    #[error("member {member} stands in obstacle {obstacle} or cannot stop before it; move it, or let it start slower")]
    Inside {
        /// Number of the member.
        member: usize,
        /// Number of the obstacle.
        obstacle: usize,
    },
    /// A goal that nobody can reach.
    #[error("subgoal {subgoal} of route {route} is in obstacle {obstacle}: move it out")]
    Goal {
        /// Number of the route.
        route: usize,
        /// Number of the subgoal.
        subgoal: usize,
        /// Number of the obstacle.
        obstacle: usize,
    },
    /// No room for another one.
    #[error("the crowd is full: it was made for {capacity} members; ask for a larger capacity")]
    Full {
        /// See [`super::CrowdConfig::capacity`].
        capacity: usize,
    },
    /// One who is not there any more.
    #[error("member {} is not in the crowd: it has left", .0.index)]
    Gone(Id),
    /// A time before the present.
    #[error("{got} s was asked for, but the crowd is at {now} s; time does not go back, restore a snapshot instead")]
    Past {
        /// What was asked for. [Unit: s]
        got: f64,
        /// Where the crowd is. [Unit: s]
        now: f64,
    },
    /// The crowd does not get on.
    #[error(
        "{} {events} events within {seconds} s, where at most {most} are possible; restore an older snapshot to go on, and \
         please report it with the scene",
        who_had(.first, .second)
    )]
    Storm {
        /// The one that acts and acts.
        first: Id,
        /// The one that it met last, if it met anybody.
        second: Option<Id>,
        /// Events of the first.
        events: u64,
        /// How many are possible.
        most: u64,
        /// In which time. [Unit: s]
        seconds: f64,
    },
    /// Bytes that are no snapshot of this crowd.
    #[error("this is no snapshot of this crowd: {message}; restore into a crowd made with the same setup")]
    Snapshot {
        /// What is wrong.
        message: String,
    },
}

/// Who does not get on, as the message of a storm begins.
fn who_had(first: &Id, second: &Option<Id>) -> String {
    match second {
        Some(second) => format!("members {} and {} do not get on: the first had", first.index, second.index),
        None => format!("member {} does not get on: it had", first.index),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_storm_names_those_who_are_in_it() {
        let id = |index| Id { index, generation: 0 };
        let text = |second| CrowdError::Storm { first: id(3), second, events: 12, most: 11, seconds: 0.5 }.to_string();
        assert!(text(None).starts_with("member 3 does not get on: it had 12 events within 0.5 s"), "{}", text(None));
        let both = text(Some(id(5)));
        assert!(both.starts_with("members 3 and 5 do not get on: the first had 12 events"), "{both}");
    }
}
