//! Sampling: from frame rows to local rotations of eight characters.
//!
//! Between two rows, motion follows a cubic through them whose tangents are those of the rows on either side (Catmull and
//! Rom 1974), so that its velocity is continuous: straight pieces between frames at 30 Hz jolt at every frame.

use crate::format::{FrameRow, RotationCode};
use crate::skeleton::NUM_JOINTS;
use throng_base::simd::{LANES, Lanes, Q, V};

/// Where eight characters are in the database.
pub(crate) struct Cursor<'a, F> {
    /// The frame before the last one, the one at or before, the one after, and the next. Where a clip has no such frame, any,
    /// as its weight is zero.
    pub rows: [[&'a FrameRow; LANES]; 4],
    /// How their rotations are packed.
    pub code: &'a RotationCode,
    /// Weights of the rows.
    pub weights: [F; 4],
}

/// Where one character is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spot {
    /// Rows of [`Cursor::rows`].
    pub rows: [usize; 4],
    /// How far from the second row to the third, 0 to 1.
    pub ratio: f32,
    /// 1 where the first and the last row are of the clip, 0 where they are not.
    pub has: [f32; 2],
}

impl Spot {
    /// The same, where no row may be after one.
    pub fn until(self, last: usize) -> Self {
        Self { rows: self.rows.map(|row| row.min(last)), ..self }
    }
}

/// Weights of four rows, the second at ratio 0 and the third at ratio 1. A row that is not there lies on the straight line
/// through its two neighbours.
#[inline(always)]
pub(crate) fn weights<F: Lanes>(ratio: F, [before, after]: [F; 2]) -> [F; 4] {
    let [half, one, two] = [0.5, 1.0, 2.0].map(F::splat);
    let t = ratio;
    let (t2, s) = (t * t, one - t);
    let first = half * t * s * s;
    let last = half * t2 * s;
    // Negative weights, as much of them as is there, and what is left.
    let (here, gone) = ([first * before, last * after], [first * (one - before), last * (one - after)]);
    let from = one - t2 * (F::splat(2.5) - F::splat(1.5) * t) - two * gone[0] + gone[1];
    let to = one - s * s * (F::splat(2.5) - F::splat(1.5) * s) - two * gone[1] + gone[0];
    [-here[0], from, to, -here[1]]
}

impl<'a, F: Lanes> Cursor<'a, F> {
    /// At eight places in the rows of a database.
    #[inline(always)]
    pub fn at(spots: &[Spot; LANES], frames: &'a [FrameRow], code: &'a RotationCode) -> Self {
        let lanes = |of: &dyn Fn(&Spot) -> f32| F::from_array(std::array::from_fn(|l| of(&spots[l])));
        let weights = weights(lanes(&|s| s.ratio), [lanes(&|s| s.has[0]), lanes(&|s| s.has[1])]);
        Self { rows: std::array::from_fn(|k| std::array::from_fn(|l| &frames[spots[l].rows[k]])), code, weights }
    }

    /// A number of the rows.
    #[inline(always)]
    pub fn number(&self, of: impl Fn(&FrameRow) -> f32) -> F {
        let of = |k: usize| F::from_array(self.rows[k].map(&of)) * self.weights[k];
        (of(1) + of(2)) + (of(0) + of(3))
    }
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
    let height = cursor.number(|r| r.height);
    let zero = F::splat(0.0);
    let mut rotations = [Q::new(V::new(zero, zero, zero), zero); NUM_JOINTS];
    for (j, rotation) in rotations.iter_mut().enumerate() {
        *rotation = cursor.code.between(&cursor.rows, &cursor.weights, j);
    }
    LanePose { root: V::new(zero, height, zero), rotations }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use throng_base::simd::Array;

    /// Weights by the four cubics as they are printed, with missing points put in.
    fn plain(t: f32, has: [bool; 2]) -> [f32; 4] {
        let (t2, t3) = (t * t, t * t * t);
        let w = [t2 - 0.5 * t - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, 0.5 * (t3 - t2)];
        let before = if has[0] { [w[0], 0.0, 0.0] } else { [0.0, 2.0 * w[0], -w[0]] };
        let after = if has[1] { [0.0, 0.0, w[3]] } else { [-w[3], 2.0 * w[3], 0.0] };
        [before[0], w[1] + before[1] + after[0], w[2] + before[2] + after[1], after[2]]
    }

    proptest! {
        #[test]
        fn weights_are_those_of_catmull_and_rom(t in 0.0f32..=1.0, has in prop::array::uniform2(any::<bool>())) {
            let there = has.map(|h| Array::splat(f32::from(u8::from(h))));
            let got = weights(Array::splat(t), there).map(|w| w.to_array()[0]);
            for (got, want) in got.iter().zip(plain(t, has)) {
                prop_assert!((got - want).abs() < 1e-6);
            }
            prop_assert!((got.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn rows_are_met_exactly_and_a_parabola_is_kept() {
        let at = |t: f32| weights(Array::splat(t), [Array::splat(1.0); 2]).map(|w| w.to_array()[0]);
        assert_eq!((at(0.0), at(1.0)), ([0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]));
        let y = |x: f32| 2.0 + x - 0.7 * x * x;
        let [a, b, c, d] = at(0.3);
        assert!((a * y(-1.0) + b * y(0.0) + c * y(1.0) + d * y(2.0) - y(0.3)).abs() < 1e-6);
    }
}
