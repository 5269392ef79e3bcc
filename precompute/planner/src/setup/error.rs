//! What makes a problem impossible before any search.

use throng_core::Joint;

/// Why a problem cannot be solved, or is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProblemError {
    /// A number that is none, or out of range.
    #[error("{what}: expected {expected}")]
    Value {
        /// What it is of.
        what: String,
        /// What it should be.
        expected: &'static str,
    },
    /// A joint of the linkage without limits.
    #[error("{joint} has no limits; add it to the limits file (data/skeletons/README.md says how)")]
    NoLimits {
        /// Which joint.
        joint: String,
    },
    /// An allowance that names nothing there is.
    #[error("allowed contact: there is no `{name}`.{meant}")]
    Unknown {
        /// The name.
        name: String,
        /// The nearest known name, as a sentence.
        meant: String,
    },
    /// The joints that are not planned collide: no plan can help.
    #[error(
        "{part} is {depth_m:.3} m too near {with} at {time_s:.2} s, where the motion itself has it; move {with}, or plan {part} too"
    )]
    DrivenCollides {
        /// Of the character.
        part: String,
        /// What it collides with.
        with: String,
        /// When it is worst (s).
        time_s: f64,
        /// By how much (m).
        depth_m: f64,
    },
    /// The linkage collides where it begins or ends.
    #[error("the {end} collides: {part} is {depth_m:.3} m too near {with}; choose another, or allow them to touch")]
    EndCollides {
        /// "start" or "goal".
        end: &'static str,
        /// Of the linkage.
        part: String,
        /// What it collides with.
        with: String,
        /// By how much (m).
        depth_m: f64,
    },
    /// Start or goal outside limits.
    #[error("the {end} is out of limits of {joint} by {by_rad:.2} rad; choose another, or admit it")]
    EndOutOfLimits {
        /// "start" or "goal".
        end: &'static str,
        /// Which joint.
        joint: String,
        /// (rad)
        by_rad: f64,
    },
    /// Too little time.
    #[error("{joint} needs at least {least_s:.3} s at its speed limit, but has {given_s:.3} s; give more time")]
    TooLittleTime {
        /// The joint that needs it.
        joint: String,
        /// (s)
        least_s: f64,
        /// (s)
        given_s: f64,
    },
}

impl ProblemError {
    pub(super) fn value(what: impl Into<String>, expected: &'static str) -> Self {
        Self::Value { what: what.into(), expected }
    }

    pub(super) fn no_limits(joint: Joint) -> Self {
        Self::NoLimits { joint: joint.name().into() }
    }
}
