//! Contacts: the planted parts of the body, a bit each.

/// Contact of heels and toes (balls of the feet), hands and seat with the ground or an object at one frame.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable, serde::Serialize, serde::Deserialize,
)]
#[repr(transparent)]
pub struct Contacts(pub u8);

impl Contacts {
    /// Nothing touches the ground.
    pub const NONE: Self = Self(0);
    /// The left heel (ankle joint low and slow).
    pub const LEFT_HEEL: Self = Self(1);
    /// The left toe (ball of the foot).
    pub const LEFT_TOE: Self = Self(2);
    /// The right heel.
    pub const RIGHT_HEEL: Self = Self(4);
    /// The right toe.
    pub const RIGHT_TOE: Self = Self(8);
    /// The left hand holds or leans on something.
    pub const LEFT_HAND: Self = Self(16);
    /// The right hand.
    pub const RIGHT_HAND: Self = Self(32);
    /// The seat, at rest or sliding.
    pub const SEAT: Self = Self(64);
    /// Either part of the left foot.
    pub const LEFT: Self = Self(3);
    /// Either part of the right foot.
    pub const RIGHT: Self = Self(12);

    /// Heel and toe of the left foot, then of the right.
    pub const FEET: [[Self; 2]; 2] = [[Self::LEFT_HEEL, Self::LEFT_TOE], [Self::RIGHT_HEEL, Self::RIGHT_TOE]];

    /// True where any of `parts` touches.
    pub fn any(self, parts: Self) -> bool {
        self.0 & parts.0 != 0
    }

    /// True where all of `parts` touch.
    pub fn all(self, parts: Self) -> bool {
        self.0 & parts.0 == parts.0
    }

    /// Adds `parts`.
    pub fn insert(&mut self, parts: Self) {
        self.0 |= parts.0;
    }

    /// Takes `parts` away.
    pub fn remove(&mut self, parts: Self) {
        self.0 &= !parts.0;
    }

    /// Contacts with left and right exchanged.
    pub fn mirrored(self) -> Self {
        let b = self.0;
        Self((b & 3) << 2 | (b >> 2) & 3 | (b & 16) << 1 | (b & 32) >> 1 | b & 64)
    }
}
