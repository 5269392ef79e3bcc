//! Left and right, and the joints of their limbs.

use throng_core::Joint;
use throng_core::skeleton::{ARMS, LEGS};

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

    /// Name: `left` or `right`.
    pub fn name(self) -> &'static str {
        ["left", "right"][self.index()]
    }

    /// Sign of X: +1 for left, -1 for right.
    pub fn sign(self) -> f64 {
        [1.0, -1.0][self.index()]
    }

    /// The other side.
    pub fn other(self) -> Self {
        Self::BOTH[1 - self.index()]
    }

    /// Thigh, shin, foot and toe joints of the side.
    pub fn leg(self) -> [Joint; 4] {
        LEGS[self.index()]
    }

    /// Clavicle, upper arm, forearm and hand joints of the side.
    pub fn arm(self) -> [Joint; 4] {
        let [upper_arm, forearm, hand] = ARMS[self.index()];
        [[Joint::LeftClavicle, Joint::RightClavicle][self.index()], upper_arm, forearm, hand]
    }

    /// Inner side of a turn by a positive (left) or negative (right) angle.
    pub fn inside(turn: f64) -> Self {
        if turn >= 0.0 { Self::Left } else { Self::Right }
    }
}
