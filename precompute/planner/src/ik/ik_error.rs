//! Reasons why a goal is not reached.

use throng_core::Joint;

/// Reason why inverse kinematics found no pose.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum IkError<B> {
    /// The goal is too far away, or too near for the elbow.
    #[error("out of reach by {by_m:.2} m")]
    OutOfReach {
        /// Distance out of reach (m, > 0).
        by_m: f64,
    },
    /// No swivel is within limits.
    #[error("out of limits of the {} by {:.1} degrees", common_joint_name(*joint), by_rad.to_degrees())]
    OutOfLimits {
        /// The joint with the largest excess at the best swivel.
        joint: Joint,
        /// Excess (rad, > 0).
        by_rad: f64,
    },
    /// Every swivel within limits collides.
    #[error("blocked by {by}")]
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

    /// Keeps the lower-ranked of two failures, the first one of equals.
    pub(crate) fn keep_nearest(nearest: &mut Option<Self>, why: Self) {
        if nearest.as_ref().is_none_or(|n| why.failure_rank() < n.failure_rank()) {
            *nearest = Some(why);
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
