//! Why a goal is not reached.

use std::fmt::{self, Display, Formatter};
use throng_core::Joint;

/// Why inverse kinematics found nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unreached<B> {
    /// Too far, or too near for the elbow.
    OutOfReach {
        /// (m, > 0)
        by_m: f64,
    },
    /// No swivel is within limits.
    OutOfLimits {
        /// The joint that is farthest outside at the best swivel.
        joint: Joint,
        /// (rad, > 0)
        by_rad: f64,
    },
    /// Every swivel within limits collides.
    Blocked {
        /// With what the first of them does.
        by: B,
    },
}

impl<B> Unreached<B> {
    /// A number to compare failures by: blocked is nearer than out of limits, that is nearer than out of reach.
    pub fn farness(&self) -> f64 {
        match self {
            Self::OutOfReach { by_m } => 100.0 + by_m,
            Self::OutOfLimits { by_rad, .. } => 10.0 + by_rad,
            Self::Blocked { .. } => 0.0,
        }
    }
}

/// What people call a joint.
pub fn plain_name(joint: Joint) -> &'static str {
    match joint {
        Joint::LeftUpperArm | Joint::RightUpperArm => "shoulder",
        Joint::LeftForearm | Joint::RightForearm => "elbow",
        Joint::LeftHand | Joint::RightHand => "wrist",
        Joint::LeftThigh | Joint::RightThigh => "hip",
        Joint::LeftShin | Joint::RightShin => "knee",
        Joint::LeftFoot | Joint::RightFoot => "ankle",
        other => other.name(),
    }
}

impl<B: Display> Display for Unreached<B> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfReach { by_m } => write!(f, "out of reach by {by_m:.2} m"),
            Self::OutOfLimits { joint, by_rad } => {
                write!(f, "out of limits of the {} by {:.1} degrees", plain_name(*joint), by_rad.to_degrees())
            }
            Self::Blocked { by } => write!(f, "blocked by {by}"),
        }
    }
}

impl<B: fmt::Debug + Display> std::error::Error for Unreached<B> {}
