//! Search through boxes around runs of frames: neighbours in time are neighbours in features.

use super::distance::{Nearest, to_box, to_row};
use super::features::{Row, WIDTH};
use throng_core::simd::vectorize;

/// Rows in a small and in a large box.
const SIZES: [usize; 2] = [16, 64];

/// Rows with a box around every 16 and every 64 of them.
///
/// A box whose nearest point is farther than what is found already is left out with all that is in it. Exact: finds
/// what [`super::brute_force`] finds.
#[derive(Clone, Debug)]
pub struct BoxSearch<'a> {
    rows: &'a [Row],
    small: Vec<[Row; 2]>,
    large: Vec<[Row; 2]>,
}

impl<'a> BoxSearch<'a> {
    /// Puts boxes around rows in their order.
    pub fn new(rows: &'a [Row]) -> Self {
        let around = |size: usize| rows.chunks(size).map(bounding_box).collect();
        Self { rows, small: around(SIZES[0]), large: around(SIZES[1]) }
    }

    /// The nearest row that is nearer than what the search begins with.
    pub fn find(&self, query: &Row, nearest: Nearest) -> Nearest {
        vectorize(
            #[inline(always)]
            || self.walk(query, nearest),
        )
    }

    #[inline(always)]
    fn walk(&self, query: &Row, mut nearest: Nearest) -> Nearest {
        for (l, [low, high]) in self.large.iter().enumerate() {
            if to_box(query, low, high, nearest.distance) >= nearest.distance {
                continue;
            }
            let first = l * (SIZES[1] / SIZES[0]);
            let last = (first + SIZES[1] / SIZES[0]).min(self.small.len());
            for s in first..last {
                let [low, high] = &self.small[s];
                if to_box(query, low, high, nearest.distance) >= nearest.distance {
                    continue;
                }
                let end = ((s + 1) * SIZES[0]).min(self.rows.len());
                for i in s * SIZES[0]..end {
                    nearest.offer(i as u32, to_row(query, &self.rows[i], nearest.distance));
                }
            }
        }
        nearest
    }
}

/// Least and greatest of every number (at least one row).
pub(super) fn bounding_box(rows: &[Row]) -> [Row; 2] {
    let mut bounds = [rows[0]; 2];
    for row in &rows[1..] {
        for k in 0..WIDTH {
            bounds[0][k] = bounds[0][k].min(row[k]);
            bounds[1][k] = bounds[1][k].max(row[k]);
        }
    }
    bounds
}
