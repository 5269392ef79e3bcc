//! Sampling: from frame rows to local rotations of eight characters.

use crate::format::{FrameRow, RotationCode};
use crate::skeleton::NUM_JOINTS;
use throng_base::simd::{LANES, Lanes, Q, V};

/// Where eight characters are in the database.
pub(crate) struct Cursor<'a, F> {
    /// The frame at or before, and the one after.
    pub rows: [[&'a FrameRow; LANES]; 2],
    /// How their rotations are packed.
    pub code: &'a RotationCode,
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
        *rotation = cursor.code.between([from, to], cursor.ratio, j);
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
