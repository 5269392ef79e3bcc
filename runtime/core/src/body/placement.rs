//! Placement of eight characters: from model space to the world and back.

use throng_base::simd::{Lanes, V};

/// The planar roots of eight characters, as what turns model space into world space and back.
pub(crate) struct PlacementLanes<F> {
    pub x: F,
    /// Height of the ground that the clip stands on, which model space contains (m).
    pub y: F,
    pub z: F,
    pub sin: F,
    pub cos: F,
}

impl<F: Lanes> PlacementLanes<F> {
    #[inline(always)]
    pub fn to_world(&self, p: V<F>) -> V<F> {
        V::new(self.cos * p.x + self.sin * p.z + self.x, p.y, self.cos * p.z - self.sin * p.x + self.z)
    }

    #[inline(always)]
    pub fn point_to_model(&self, p: V<F>) -> V<F> {
        self.vector_to_model(V::new(p.x - self.x, p.y, p.z - self.z))
    }

    #[inline(always)]
    pub fn vector_to_world(&self, v: V<F>) -> V<F> {
        V::new(self.cos * v.x + self.sin * v.z, v.y, self.cos * v.z - self.sin * v.x)
    }

    #[inline(always)]
    pub fn vector_to_model(&self, v: V<F>) -> V<F> {
        V::new(self.cos * v.x - self.sin * v.z, v.y, self.sin * v.x + self.cos * v.z)
    }
}
