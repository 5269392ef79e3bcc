//! Vectors in two and three dimensions.

pub(crate) mod batch;
pub(crate) mod cells;
pub(crate) mod obstacle;
pub(crate) mod plan;
pub(crate) mod solid;

use glam::{Vec2, Vec3};
use serde::{Serialize, de::DeserializeOwned};
use std::fmt::Debug;
use std::ops::{AddAssign, Neg, SubAssign};
use throng_geometry::Vector;

mod sealed {
    /// Seal: no other crate can implement a space.
    pub trait Sealed {}
    impl Sealed for glam::Vec2 {}
    impl Sealed for glam::Vec3 {}
}

/// Space in which a crowd moves: on the ground ([`Vec2`]: x and z of the world) or through the air ([`Vec3`]).
pub trait Space:
    sealed::Sealed
    + Copy
    + Debug
    + Default
    + PartialEq
    + Send
    + Sync
    + Serialize
    + DeserializeOwned
    + Vector
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + 'static
{
    /// Number of dimensions.
    const DIMENSIONS: usize;

    /// Converts a vector of the world; on the ground, its height is left out.
    fn from_world(v: Vec3) -> Self;

    /// Vector of the world; on the ground, its height is 0.
    fn to_world(self) -> Vec3;

    /// Coordinates x and z in the world.
    fn on_ground(self) -> Vec2 {
        let v = self.to_world();
        Vec2::new(v.x, v.z)
    }

    /// Vector of x and z of the world; in the air at height 0.
    fn over_ground(v: Vec2) -> Self {
        Self::from_world(Vec3::new(v.x, 0.0, v.y))
    }

    /// A vector from its first coordinates; the third is ignored in 2-D.
    fn from_coordinates(c: [f32; 3]) -> Self;

    /// Coordinates; the third is 0 in 2-D.
    fn coordinates(self) -> [f32; 3];

    /// Smaller of each coordinate.
    fn min(self, other: Self) -> Self;

    /// Larger of each coordinate.
    fn max(self, other: Self) -> Self;

    /// Perpendicular to a direction, to the right of an agent facing that way, head up; of the same length, except
    /// that there is no right to straight up and down in 3-D, where X takes its place.
    fn right(self) -> Self;

    /// Eight unit vectors within sight along a unit vector. The first is that vector; in 2-D they
    /// then turn left and right by turns, ever farther.
    fn fan(self) -> [Self; 8];

    /// Square of the length.
    fn length_squared(self) -> f32 {
        self.dot(self)
    }

    /// Length.
    fn length(self) -> f32 {
        self.dot(self).sqrt()
    }

    /// Unit vector and length; zero and zero where it is too short to have a direction.
    fn unit_and_length(self) -> (Self, f32) {
        let length = self.length();
        if length > 1e-12 { (self * length.recip(), length) } else { (Self::default(), 0.0) }
    }

    /// Shortened to a length where it is longer.
    fn at_most(self, length: f32) -> Self {
        let square = self.length_squared();
        if square > length * length { self * (length / square.sqrt()) } else { self }
    }

    /// Largest integers that are not above the coordinates; those of numbers that are too large are the largest there
    /// are.
    #[inline]
    fn floor(self) -> [i32; 3] {
        self.coordinates().map(|c| {
            let toward_zero = c as i32;
            toward_zero.saturating_sub(i32::from(c < toward_zero as f32))
        })
    }

    /// True where every coordinate is a number.
    fn is_finite(self) -> bool {
        self.coordinates().iter().all(|c| c.is_finite())
    }
}

/// Cosine and sine of 0, 17, -17, 37, -37, 63, -63 and 50 degrees to the right.
const FAN: [[f32; 2]; 8] = [
    [1.000000, 0.000000],
    [0.956305, 0.292372],
    [0.956305, -0.292372],
    [0.798636, 0.601815],
    [0.798636, -0.601815],
    [0.453990, 0.891007],
    [0.453990, -0.891007],
    [0.642788, 0.766044],
];

/// Straight on, three directions at 25 degrees and four at 60 around it.
const CONE: [[f32; 3]; 8] = [
    [1.0, 0.0, 0.0],
    [0.906308, 0.422618, 0.000000],
    [0.906308, -0.211309, 0.365998],
    [0.906308, -0.211309, -0.365998],
    [0.500000, 0.612372, 0.612372],
    [0.500000, -0.612372, 0.612372],
    [0.500000, -0.612372, -0.612372],
    [0.500000, 0.612372, -0.612372],
];

impl Space for Vec2 {
    const DIMENSIONS: usize = 2;

    fn from_world(v: Vec3) -> Self {
        Vec2::new(v.x, v.z)
    }

    fn to_world(self) -> Vec3 {
        Vec3::new(self.x, 0.0, self.y)
    }

    #[inline]
    fn from_coordinates(c: [f32; 3]) -> Self {
        Vec2::new(c[0], c[1])
    }

    #[inline]
    fn coordinates(self) -> [f32; 3] {
        [self.x, self.y, 0.0]
    }

    #[inline]
    fn min(self, other: Self) -> Self {
        Vec2::min(self, other)
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        Vec2::max(self, other)
    }

    #[inline]
    fn right(self) -> Self {
        Vec2::new(-self.y, self.x)
    }

    #[inline]
    fn fan(self) -> [Self; 8] {
        FAN.map(|[along, across]| self * along + self.right() * across)
    }
}

impl Space for Vec3 {
    const DIMENSIONS: usize = 3;

    fn from_world(v: Vec3) -> Self {
        v
    }

    fn to_world(self) -> Vec3 {
        self
    }

    #[inline]
    fn from_coordinates(c: [f32; 3]) -> Self {
        Vec3::from_array(c)
    }

    #[inline]
    fn coordinates(self) -> [f32; 3] {
        self.to_array()
    }

    #[inline]
    fn min(self, other: Self) -> Self {
        Vec3::min(self, other)
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        Vec3::max(self, other)
    }

    #[inline]
    fn right(self) -> Self {
        let right = self.cross(Vec3::Y);
        if right.length_squared() > 1e-12 * self.length_squared() {
            right * (self.length_squared() / right.length_squared()).sqrt()
        } else {
            Vec3::X * Space::length(self)
        }
    }

    #[inline]
    fn fan(self) -> [Self; 8] {
        let right = self.right();
        let up = right.cross(self);
        CONE.map(|[along, across, above]| self * along + right * across + up * above)
    }
}
