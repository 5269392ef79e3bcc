//! Sampling: from frame rows to local rotations of eight characters.

use crate::format::FrameRow;
use crate::skeleton::NUM_JOINTS;
use throng_base::simd::{LANES, Lanes, Q, V};

/// Where eight characters are in the database.
pub(crate) struct Cursor<'a, F> {
    /// The frame at or before, and the one after.
    pub rows: [[&'a FrameRow; LANES]; 2],
    /// How far between them, 0 to 1.
    pub ratio: F,
}

/// The pose of eight characters before and after the hierarchy is applied.
pub(crate) struct LanePose<F> {
    /// Hips in model space (above the character's planar root).
    pub root: V<F>,
    /// Relative to the parent; the hips' in model space.
    pub rotations: [Q<F>; NUM_JOINTS],
}

/// Samples eight characters.
#[inline(always)]
pub(crate) fn sample<F: Lanes>(cursor: &Cursor<'_, F>) -> LanePose<F> {
    let [from, to] = &cursor.rows;
    let height = between(&heights(from), &heights(to), cursor.ratio);
    let zero = F::splat(0.0);
    let mut rotations = [Q::new(V::new(zero, zero, zero), zero); NUM_JOINTS];
    for (j, rotation) in rotations.iter_mut().enumerate() {
        let a = F::decode(from.map(|r| &r.rotations[j]));
        let b = F::decode(to.map(|r| &r.rotations[j]));
        let x = a[0] + (b[0] - a[0]) * cursor.ratio;
        let y = a[1] + (b[1] - a[1]) * cursor.ratio;
        let z = a[2] + (b[2] - a[2]) * cursor.ratio;
        let w = a[3] + (b[3] - a[3]) * cursor.ratio;
        *rotation = Q::new(V::new(x, y, z), w).normalize();
    }
    LanePose { root: V::new(zero, height, zero), rotations }
}

fn heights(rows: &[&FrameRow; LANES]) -> [f32; LANES] {
    rows.map(|r| r.height)
}

/// From `a` at ratio 0 to `b` at ratio 1.
#[inline(always)]
pub(crate) fn between<F: Lanes>(a: &[f32; LANES], b: &[f32; LANES], ratio: F) -> F {
    let (a, b) = (F::load(a), F::load(b));
    a + (b - a) * ratio
}
