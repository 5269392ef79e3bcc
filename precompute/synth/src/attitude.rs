//! Orientation of a segment of the trunk.

use bytemuck::{Pod, Zeroable};
use glam::DQuat;

/// Heading, forward tilt and list of a segment of the trunk (rad).
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Attitude {
    /// Heading.
    pub yaw: f64,
    /// Forward tilt.
    pub pitch: f64,
    /// Left side up.
    pub list: f64,
}

/// Attitudes of spine, chest, upper chest, neck and head.
pub type Trunk = [Attitude; 5];

/// Trunk whose lower segments lie between the hips and the chest, and whose neck lies between the chest and the head.
pub fn trunk_between(hips: Attitude, chest: Attitude, head: Attitude) -> Trunk {
    [hips.mix(chest, 0.3), hips.mix(chest, 0.65), chest, chest.mix(head, 0.45), head]
}

impl Attitude {
    /// Mix of this attitude and another one.
    pub fn mix(self, other: Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        Self { yaw: mix(self.yaw, other.yaw), pitch: mix(self.pitch, other.pitch), list: mix(self.list, other.list) }
    }

    /// World rotation: heading, then forward tilt, then left side up.
    pub fn rotation(self) -> DQuat {
        DQuat::from_rotation_y(self.yaw) * DQuat::from_rotation_x(self.pitch) * DQuat::from_rotation_z(self.list)
    }
}
