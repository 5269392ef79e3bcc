//! Which parts of the feet are planted, a bit each.

/// Contact of heels and toes (balls of the feet) with the ground at one frame.
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
    /// Either part of the left foot.
    pub const LEFT: Self = Self(3);
    /// Either part of the right foot.
    pub const RIGHT: Self = Self(12);

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

    /// The same with left and right exchanged.
    pub fn mirrored(self) -> Self {
        Self((self.0 & 3) << 2 | (self.0 >> 2) & 3)
    }
}
