//! Numbers and vectors of eight characters, which one load or store moves together.

use crate::planar::Planar;
use glam::Vec3;
use throng_base::simd::{LANES, Lanes, V};

/// Blocks of eight that one thread handles together: their state and poses fit the cache of a core.
pub(crate) const RANGE_BLOCKS: usize = 16;
/// Characters of [`RANGE_BLOCKS`].
pub(crate) const RANGE_LEN: usize = RANGE_BLOCKS * LANES;

/// A number of each of eight characters.
pub(crate) type Lane = [f32; LANES];
/// A vector of each of eight characters: x, y, z.
pub(crate) type Lane3 = [Lane; 3];

/// The vector of one lane.
pub(crate) fn get_lane(v: &Lane3, lane: usize) -> Vec3 {
    Vec3::new(v[0][lane], v[1][lane], v[2][lane])
}

/// Writes the vector of one lane.
pub(crate) fn set_lane(v: &mut Lane3, lane: usize, to: Vec3) {
    for (axis, value) in v.iter_mut().zip(to.to_array()) {
        axis[lane] = value;
    }
}

/// Loads a vector of all lanes.
#[inline(always)]
pub(crate) fn load<F: Lanes>(v: &Lane3) -> V<F> {
    V::new(F::load(&v[0]), F::load(&v[1]), F::load(&v[2]))
}

/// Stores a vector of all lanes.
#[inline(always)]
pub(crate) fn store<F: Lanes>(v: &mut Lane3, from: V<F>) {
    from.x.store(&mut v[0]);
    from.y.store(&mut v[1]);
    from.z.store(&mut v[2]);
}

/// The planar transform of one lane: x, z, heading (m, m, rad).
pub(crate) fn planar_of_lane(v: &Lane3, lane: usize) -> Planar {
    Planar::new(v[0][lane], v[1][lane], v[2][lane])
}
