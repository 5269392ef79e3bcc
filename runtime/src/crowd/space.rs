//! Two and three dimensions.

use glam::{Vec2, Vec3};
use serde::{Serialize, de::DeserializeOwned};
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

mod sealed {
    pub trait Sealed {}
    impl Sealed for glam::Vec2 {}
    impl Sealed for glam::Vec3 {}
}

/// Where a crowd moves: on the ground ([`Vec2`]: x and z of the world) or through the air ([`Vec3`]).
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
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<f32, Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + 'static
{
    /// Number of dimensions.
    const DIMENSIONS: usize;

    /// A vector from its first coordinates; the third is ignored in 2-D.
    fn from_coordinates(c: [f32; 3]) -> Self;

    /// Its coordinates; the third is 0 in 2-D.
    fn coordinates(self) -> [f32; 3];

    /// Scalar product.
    fn dot(self, other: Self) -> f32;

    /// Smaller of each coordinate.
    fn min(self, other: Self) -> Self;

    /// Larger of each coordinate.
    fn max(self, other: Self) -> Self;

    /// Square of the length.
    fn length_squared(self) -> f32 {
        self.dot(self)
    }

    /// Length.
    fn length(self) -> f32 {
        self.dot(self).sqrt()
    }
}

impl Space for Vec2 {
    const DIMENSIONS: usize = 2;

    #[inline]
    fn from_coordinates(c: [f32; 3]) -> Self {
        Vec2::new(c[0], c[1])
    }

    #[inline]
    fn coordinates(self) -> [f32; 3] {
        [self.x, self.y, 0.0]
    }

    #[inline]
    fn dot(self, other: Self) -> f32 {
        Vec2::dot(self, other)
    }

    #[inline]
    fn min(self, other: Self) -> Self {
        Vec2::min(self, other)
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        Vec2::max(self, other)
    }
}

impl Space for Vec3 {
    const DIMENSIONS: usize = 3;

    #[inline]
    fn from_coordinates(c: [f32; 3]) -> Self {
        Vec3::from_array(c)
    }

    #[inline]
    fn coordinates(self) -> [f32; 3] {
        self.to_array()
    }

    #[inline]
    fn dot(self, other: Self) -> f32 {
        Vec3::dot(self, other)
    }

    #[inline]
    fn min(self, other: Self) -> Self {
        Vec3::min(self, other)
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        Vec3::max(self, other)
    }
}
