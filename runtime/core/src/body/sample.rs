//! Sampling: from frame rows to local rotations of eight characters.
//!
//! Between two rows, motion follows a cubic through them whose tangents are those of the rows on either side (Catmull and
//! Rom 1974), so that its velocity is continuous: straight pieces between frames at 30 Hz jolt at every frame.

use crate::format::{FrameRow, RotationCode};
use crate::skeleton::NUM_JOINTS;
use glam::Quat;
use throng_base::simd::{ArrayLanes, LANES, Lanes, Q, V};

/// Rows that a pose is made of.
pub(crate) const WINDOW: usize = 4;

/// Frame rows and weights of eight characters.
pub(crate) struct FrameCursor<'a, F> {
    /// Rows that follow each other, of each.
    pub rows: [&'a [FrameRow; WINDOW]; LANES],
    /// Code by which the rotations are packed.
    pub code: &'a RotationCode,
    /// Weights of the rows; they add up to 1.
    pub weights: [F; WINDOW],
}

/// Position of one character in the database: a frame row and the ratio to the next.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FramePosition {
    /// The row at or before.
    pub frame: usize,
    /// Ratio to the next row, 0 to 1.
    pub ratio: f32,
    /// True where the clip has a row before, and one after the next.
    pub has: [bool; 2],
}

impl FramePosition {
    /// First row of a window that covers all rows with a weight, and the weights in the window.
    ///
    /// - `num_rows`: of the database (>= 4).
    /// - `weights`: of the row before, the rows here and next, and the one after.
    fn window(&self, num_rows: usize, [a, mut b, mut c, d]: [f32; WINDOW]) -> (usize, [f32; WINDOW]) {
        let Self { frame, has: [before, after], .. } = *self;
        // A row that is not there lies on the straight line through its two neighbours.
        if !before {
            (b, c) = (b + 2.0 * a, c - a);
        }
        if !after {
            (b, c) = (b - d, c + 2.0 * d);
        }
        let of = [if before { a } else { 0.0 }, b, c, if after { d } else { 0.0 }];
        let start = frame.saturating_sub(usize::from(before) + usize::from(!after)).min(num_rows - WINDOW);
        // The first of them is that of the frame before.
        let weight = |k: usize| of.get((start + k + 1).wrapping_sub(frame)).copied().unwrap_or(0.0);
        (start, std::array::from_fn(weight))
    }
}

/// Weights of four rows, the second at ratio 0 and the third at ratio 1.
#[inline(always)]
fn weights<F: Lanes>(ratio: F) -> [F; WINDOW] {
    let (half, one) = (F::splat(0.5), F::splat(1.0));
    let (a, b) = (F::splat(2.5), F::splat(1.5));
    let (t, s) = (ratio, one - ratio);
    let (t2, s2) = (t * t, s * s);
    [-(half * t * s2), one - t2 * (a - b * t), one - s2 * (a - b * s), -(half * t2 * s)]
}

impl<'a, F: Lanes> FrameCursor<'a, F> {
    /// Cursor at eight positions in the rows of a database (frames.len() >= 4).
    #[inline(always)]
    pub fn at_positions(spots: &[FramePosition; LANES], frames: &'a [FrameRow], code: &'a RotationCode) -> Self {
        let mut ratio = [0.0; LANES];
        for (ratio, spot) in ratio.iter_mut().zip(spots) {
            *ratio = spot.ratio;
        }
        let weights = weights(F::load(&ratio));
        let mut by_row = [[0.0; LANES]; WINDOW];
        for (row, weight) in by_row.iter_mut().zip(weights) {
            weight.store(row);
        }
        let mut first = [0; LANES];
        for (l, spot) in spots.iter().enumerate() {
            first[l] = spot.frame.wrapping_sub(1);
            if spot.has != [true; 2] {
                let (start, own) = spot.window(frames.len(), by_row.map(|row| row[l]));
                first[l] = start;
                for (row, own) in by_row.iter_mut().zip(own) {
                    row[l] = own;
                }
            }
        }
        let mut rows = [window_at(frames, 0); LANES];
        for (rows, at) in rows.iter_mut().zip(first) {
            *rows = window_at(frames, at);
        }
        let [a, b, c, d] = &by_row;
        Self { rows, code, weights: [F::load(a), F::load(b), F::load(c), F::load(d)] }
    }

    /// Planar root within the clip, x, z and heading, and the height of the hips.
    #[inline(always)]
    pub fn root(&self) -> [F; 4] {
        let mut sum = [F::splat(0.0); 4];
        for (k, &weight) in self.weights.iter().enumerate() {
            let mut roots = [self.rows[0][k].root(); LANES];
            for (root, rows) in roots.iter_mut().zip(&self.rows) {
                *root = rows[k].root();
            }
            let columns = F::columns(roots);
            for (sum, column) in sum.iter_mut().zip(columns) {
                *sum = *sum + column * weight;
            }
        }
        sum
    }
}

/// Rows from one on.
#[inline(always)]
fn window_at(frames: &[FrameRow], first: usize) -> &[FrameRow; WINDOW] {
    let rows = &frames[first..first + WINDOW];
    rows.try_into().unwrap_or_else(|_| unreachable!("it is as long as a window"))
}

/// Samples a single number of the rows, with the same weights.
pub(crate) fn sample_number(spot: FramePosition, num_rows: usize, of: impl Fn(usize) -> f32) -> f32 {
    let inside = weights(ArrayLanes::splat(spot.ratio)).map(|w| w.to_array()[0]);
    let (first, weights) = match spot.has {
        [true, true] => (spot.frame - 1, inside),
        _ => spot.window(num_rows, inside),
    };
    weights.iter().enumerate().map(|(k, weight)| weight * of(first + k)).sum()
}

/// The pose of eight characters before and after the hierarchy is applied.
pub(crate) struct LanePose<F> {
    /// Hips in model space (above the character's planar root).
    pub root: V<F>,
    /// Relative to the parent; the hips' in model space.
    pub rotations: [Q<F>; NUM_JOINTS],
}

impl<F: Lanes> LanePose<F> {
    /// A pose to be filled. One that is returned filled would be copied.
    #[inline(always)]
    pub fn unposed(zero: F) -> Self {
        let (rotation, root) = (Q { v: V { x: zero, y: zero, z: zero }, w: zero }, V { x: zero, y: zero, z: zero });
        Self { root, rotations: [rotation; NUM_JOINTS] }
    }

    /// Rotation of a joint of one lane.
    pub fn rotation(&self, joint: usize, lane: usize) -> Quat {
        self.rotations[joint].lane(lane)
    }

    /// Replaces the rotation of a joint of one lane.
    pub fn set_rotation(&mut self, joint: usize, lane: usize, to: Quat) {
        self.rotations[joint].set_lane(lane, to);
    }
}

/// Samples eight characters.
///
/// - `height`: of the hips (m).
#[inline(always)]
pub(crate) fn sample_pose<F: Lanes>(cursor: &FrameCursor<'_, F>, height: F, pose: &mut LanePose<F>) {
    pose.root = V::new(F::splat(0.0), height, F::splat(0.0));
    for (j, rotation) in pose.rotations.iter_mut().enumerate() {
        *rotation = cursor.code.rotations_between(&cursor.rows, &cursor.weights, j);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Weights by the four cubics as printed, with missing points filled in.
    fn plain(t: f32, has: [bool; 2]) -> [f32; 4] {
        let (t2, t3) = (t * t, t * t * t);
        let w = [t2 - 0.5 * t - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, 0.5 * (t3 - t2)];
        let before = if has[0] { [w[0], 0.0, 0.0] } else { [0.0, 2.0 * w[0], -w[0]] };
        let after = if has[1] { [0.0, 0.0, w[3]] } else { [-w[3], 2.0 * w[3], 0.0] };
        [before[0], w[1] + before[1] + after[0], w[2] + before[2] + after[1], after[2]]
    }

    proptest! {
        #[test]
        fn weights_are_those_of_catmull_and_rom_on_the_rows_of_the_clip(
            t in 0.0f32..=1.0,
            has in prop::array::uniform2(any::<bool>()),
            numbers in prop::array::uniform9(-3.0f32..3.0),
            at in 0usize..8,
        ) {
            let has = [has[0] && at > 0, has[1] && at < 7];
            let row = |k: i64| numbers.get((at as i64 + k) as usize).copied().unwrap_or(f32::NAN);
            let terms = plain(t, has).into_iter().zip(-1..).filter(|(w, _)| *w != 0.0);
            let want: f32 = terms.map(|(w, k)| w * row(k)).sum();
            let got = sample_number(FramePosition { frame: at, ratio: t, has }, 9, |k| numbers[k]);
            prop_assert!((got - want).abs() < 1e-5, "{got} {want}");
        }
    }

    #[test]
    fn rows_are_met_exactly_and_a_parabola_is_kept() {
        let at = |t: f32| weights(ArrayLanes::splat(t)).map(|w| w.to_array()[0]);
        assert_eq!((at(0.0), at(1.0)), ([0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]));
        let y = |x: f32| 2.0 + x - 0.7 * x * x;
        let [a, b, c, d] = at(0.3);
        assert!((a * y(-1.0) + b * y(0.0) + c * y(1.0) + d * y(2.0) - y(0.3)).abs() < 1e-6);
    }
}
