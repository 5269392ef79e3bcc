//! The distance of two rows, and the search that looks at all of them.

use super::features::{Row, WIDTH};
use throng_core::simd::vectorize;

/// Numbers that are added side by side.
const LANES: usize = 8;

/// The nearest row of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Its number; none where no row is nearer than what the search began with.
    pub row: Option<u32>,
    /// Its squared distance from the query.
    pub distance: f32,
}

impl Nearest {
    /// Nothing found yet, and nothing wanted that is not nearer than this (>= 0, or infinite).
    pub fn within(distance: f32) -> Self {
        Self { row: None, distance }
    }

    /// Takes a row in if it is nearer; of equally near ones, the one with the lower number stays.
    #[inline(always)]
    pub(super) fn offer(&mut self, row: u32, distance: f32) {
        let first = distance == self.distance && self.row.is_some_and(|r| row < r);
        if distance < self.distance || first {
            (self.row, self.distance) = (Some(row), distance);
        }
    }
}

/// The squared distance of two rows, or something above `limit` where it is above it.
#[inline(always)]
pub(super) fn to_row(query: &Row, row: &Row, limit: f32) -> f32 {
    add_up(query, limit, |k, q| q - row[k])
}

/// The squared distance of a row from a box, or something above `limit` where it is above it. Rounding never makes it
/// more than the distance from a row within the box.
#[inline(always)]
pub(super) fn to_box(query: &Row, low: &Row, high: &Row, limit: f32) -> f32 {
    add_up(query, limit, |k, q| (low[k] - q).max(q - high[k]).max(0.0))
}

/// Sums squares eight by eight, and gives up once they are too many.
#[inline(always)]
fn add_up(query: &Row, limit: f32, difference: impl Fn(usize, f32) -> f32) -> f32 {
    let mut sums = [0.0f32; LANES];
    let mut total = 0.0;
    for from in (0..WIDTH).step_by(2 * LANES) {
        for half in [from, from + LANES] {
            for l in 0..LANES {
                let d = difference(half + l, query[half + l]);
                sums[l] += d * d;
            }
        }
        let [a, b, c, d, e, f, g, h] = sums;
        total = ((a + e) + (b + f)) + ((c + g) + (d + h));
        if total > limit {
            break;
        }
    }
    total
}

/// Looks at every row: what the other searches must find.
pub fn brute_force(rows: &[Row], query: &Row, mut nearest: Nearest) -> Nearest {
    vectorize(
        #[inline(always)]
        || {
            for (i, row) in rows.iter().enumerate() {
                nearest.offer(i as u32, to_row(query, row, nearest.distance));
            }
            nearest
        },
    )
}
