//! Constants of the skeleton that inverse kinematics needs, computed once.

use crate::pose::LegJoints;
use crate::skeleton::Skeleton;
use glam::Vec3;

/// Limbs and points of a skeleton that joints are displaced by.
#[derive(Clone, Debug)]
pub(crate) struct Anatomy {
    /// Left, right.
    pub legs: [LegJoints; 2],
    /// Middle of the head, in the head joint's frame (m).
    pub head_centre: Vec3,
}

impl Anatomy {
    pub fn new(skeleton: &Skeleton) -> Self {
        Self { legs: LegJoints::left_and_right(skeleton), head_centre: head_centre(skeleton) }
    }
}

/// Middle of the head, in the head joint's frame (m).
pub fn head_centre(skeleton: &Skeleton) -> Vec3 {
    skeleton.tips[0] * 0.5
}
