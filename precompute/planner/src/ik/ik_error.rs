//! Reasons why a goal is not reached.

use std::fmt::{self, Display, Formatter};
use throng_core::Joint;

/// Reason why inverse kinematics found no pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IkError<B> {
    /// The goal is too far away, or too near for the elbow.
    OutOfReach {
        /// Distance out of reach (m, > 0).
        by_m: f64,
    },
    /// No swivel is within limits.
    OutOfLimits {
        /// The joint with the largest excess at the best swivel.
        joint: Joint,
        /// Excess (rad, > 0).
        by_rad: f64,
    },
    /// Every swivel within limits collides.
    Blocked {
        /// Obstacle of the first of these swivels.
        by: B,
    },
}

impl<B> IkError<B> {
    /// Rank of a failure, to compare failures by: blocked is nearer than out of limits, that is nearer than out of reach.
    pub fn failure_rank(&self) -> f64 {
        match self {
            Self::OutOfReach { by_m } => 100.0 + by_m,
            Self::OutOfLimits { by_rad, .. } => 10.0 + by_rad,
            Self::Blocked { .. } => 0.0,
        }
    }
}

/// Everyday name of a joint.
pub fn common_joint_name(joint: Joint) -> &'static str {
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

impl<B: Display> Display for IkError<B> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfReach { by_m } => write!(f, "out of reach by {by_m:.2} m"),
            Self::OutOfLimits { joint, by_rad } => {
                write!(f, "out of limits of the {} by {:.1} degrees", common_joint_name(*joint), by_rad.to_degrees())
            }
            Self::Blocked { by } => write!(f, "blocked by {by}"),
        }
    }
}

impl<B: fmt::Debug + Display> std::error::Error for IkError<B> {}
