//! Left and right, and the directions of a heading on the ground.

use glam::{DVec2, DVec3};
use throng_core::Joint;
use throng_core::skeleton::LEGS;

/// A side of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LateralSide {
    /// The left side, +X of a character that faces +Z.
    Left,
    /// The right side.
    Right,
}

impl LateralSide {
    /// Both sides, left first.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// Index: 0 for left, 1 for right.
    pub fn index(self) -> usize {
        self as usize
    }

    /// Sign of X: +1 for left, -1 for right.
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }

    /// The other side.
    pub fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

    /// Thigh joint of the side.
    pub fn thigh(self) -> Joint {
        self.leg()[0]
    }

    /// Thigh, shin, foot and toe joints of the side.
    pub fn leg(self) -> [Joint; 4] {
        LEGS[self as usize]
    }

    /// Clavicle, upper arm, forearm and hand joints of the side.
    pub fn arm(self) -> [Joint; 4] {
        use Joint::*;
        match self {
            Self::Left => [LeftClavicle, LeftUpperArm, LeftForearm, LeftHand],
            Self::Right => [RightClavicle, RightUpperArm, RightForearm, RightHand],
        }
    }

    /// Inner side of a turn by a positive (left) or negative (right) angle.
    pub fn inside(turn: f64) -> Self {
        if turn >= 0.0 { Self::Left } else { Self::Right }
    }
}

/// The ground direction (x, z) of a heading.
pub fn forward(heading: f64) -> DVec2 {
    DVec2::new(heading.sin(), heading.cos())
}

/// The ground direction (x, z) to the left of a heading.
pub fn leftward(heading: f64) -> DVec2 {
    DVec2::new(heading.cos(), -heading.sin())
}

/// A point or direction on the ground (x, z), at a height.
pub fn over_ground(p: DVec2, height: f64) -> DVec3 {
    DVec3::new(p.x, height, p.y)
}

/// Ground position (x, z) of a point.
pub fn ground_position(p: DVec3) -> DVec2 {
    DVec2::new(p.x, p.z)
}
