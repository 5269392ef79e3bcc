//! Faults that make a problem impossible before any search.

/// Reason why a problem cannot be solved, or is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProblemError {
    /// A number is out of range, a name is unknown, or a joint has no limits; the text says what to do.
    #[error("{0}")]
    Invalid(String),
    /// Joints that are not planned collide: no plan can help.
    #[error(
        "{part} is {depth_m:.3} m too near {with} at {time_s:.2} s, where the motion itself has it; move {with}, or plan {part} too"
    )]
    DrivenCollides {
        /// Part of the character.
        part: String,
        /// Obstacle that it collides with.
        with: String,
        /// Time at which the collision is deepest (s).
        time_s: f64,
        /// Depth (m).
        depth_m: f64,
    },
    /// The limb collides at its start or goal.
    #[error("the {end} collides: {part} is {depth_m:.3} m too near {with}; choose another, or allow them to touch")]
    EndCollides {
        /// "start" or "goal".
        end: &'static str,
        /// Part of the limb.
        part: String,
        /// Obstacle that it collides with.
        with: String,
        /// Depth (m).
        depth_m: f64,
    },
    /// Start or goal is outside limits.
    #[error("the {end} is out of limits of {joint} by {by_rad:.2} rad; choose another, or admit it")]
    EndOutOfLimits {
        /// "start" or "goal".
        end: &'static str,
        /// The joint.
        joint: String,
        /// Excess (rad).
        by_rad: f64,
    },
    /// There is too little time.
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

impl From<String> for ProblemError {
    fn from(why: String) -> Self {
        Self::Invalid(why)
    }
}
