//! Weight table: cardinal basis functions over a uniform grid, as fine as a tolerance demands.

use super::cardinal::CardinalBasis;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use throng_core::blend::{AxisRecord, MAX_AXES, MAX_KNOTS, WeightGrid};
use throng_core::format::Table;

/// Number of random points at which a table is compared with the exact functions, and of lines that measure the error
/// along each axis.
const RANDOM_POINTS: usize = 4096;
/// Number of points compared while the size of a table is searched for; in the end all are compared.
const SOUGHT_POINTS: usize = 20_000;
/// Finest division of an axis.
const MOST_KNOTS: usize = 4096;
/// Smallest share of the tolerance that is tried; below it the box is far too wide for its examples.
const LEAST_SHARE: f64 = 1e-9;
/// Factor on the error allowed along each axis when all of them together exceed the tolerance.
const TIGHTEN: f64 = 0.85;

/// A box of parameters and the knots along each axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Lowest value on each axis.
    pub low: Vec<f64>,
    /// Highest value on each axis.
    pub high: Vec<f64>,
    /// Knots along each axis (>= 2).
    pub knots: Vec<usize>,
}

/// Weights at the knots of a grid, the last axis running fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightTable {
    /// Position of the knots.
    pub grid: Grid,
    /// Length of a row: the examples, padded with zeros to a multiple of 8.
    pub stride: usize,
    /// The rows (knots * stride).
    pub weights: Table<f32>,
    /// Largest error of an interpolated weight against the exact one.
    pub max_error: f64,
}

/// Box of the parameters that a table covers: the least and the greatest value along each axis, in the axis's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterBounds {
    /// Least value along each axis.
    pub low: Vec<f64>,
    /// Greatest value along each axis.
    pub high: Vec<f64>,
}

/// Error of a table that would exceed its limit.
#[derive(Clone, Debug, PartialEq)]
pub struct TableTooLarge {
    /// Knots along each axis that would be needed, as far as the search went.
    pub knots: Vec<usize>,
    /// Its bytes.
    pub bytes: u64,
    /// Largest error along each axis with those knots.
    pub errors: Vec<f64>,
}

/// Tabulates a basis over a box.
///
/// The error of interpolation is about the sum of the errors along each axis, so each axis is divided until the error
/// along it is below a share of the tolerance. Shares begin at the whole and shrink until the table, as stored and read
/// by the runtime, is within the tolerance at all cell centres, all midpoints of edges, and random points.
///
/// # Errors
/// [`TableTooLarge`] if it takes more than `max_bytes` or [`MAX_KNOTS`], or if no division that is tried is fine enough.
pub fn tabulate(
    basis: &CardinalBasis,
    bounds: ParameterBounds,
    tolerance: f64,
    max_bytes: u64,
) -> Result<WeightTable, TableTooLarge> {
    let ParameterBounds { low, high } = bounds;
    let mut grid = Grid { knots: vec![2; low.len()], low: low.clone(), high: high.clone() };
    let lines = SampleLines::new(basis, &low, &high);
    let mut share = tolerance;
    loop {
        for axis in 0..grid.knots.len() {
            grid.knots[axis] = lines.knots_for(axis, share, grid.knots[axis]);
        }
        let bytes = grid.num_knots() as u64 * stride(basis) as u64 * 4;
        if bytes > max_bytes || grid.num_knots() > MAX_KNOTS as usize || share < LEAST_SHARE * tolerance {
            let errors = (0..grid.knots.len()).map(|k| lines.error(k, grid.knots[k])).collect();
            return Err(TableTooLarge { knots: grid.knots, bytes, errors });
        }
        let mut table = tabulate_weights(basis, &grid);
        if table.largest_error(basis, SOUGHT_POINTS) <= tolerance {
            table.max_error = table.largest_error(basis, usize::MAX);
            if table.max_error <= tolerance {
                return Ok(table);
            }
        }
        share *= TIGHTEN;
    }
}

/// Lines parallel to an axis, through every example and through random points, along which the error is measured.
struct SampleLines<'a> {
    basis: &'a CardinalBasis,
    low: &'a [f64],
    high: &'a [f64],
    through: Vec<Vec<f64>>,
}

impl<'a> SampleLines<'a> {
    fn new(basis: &'a CardinalBasis, low: &'a [f64], high: &'a [f64]) -> Self {
        let inside = |p: &Vec<f64>| p.iter().zip(low).zip(high).all(|((p, l), h)| l <= p && p <= h);
        let mut through: Vec<Vec<f64>> = basis.examples().filter(inside).collect();
        let mut rng = Pcg64::seed_from_u64(1);
        through.extend((0..RANDOM_POINTS / 16).map(|_| random_point(&mut rng, low, high)));
        Self { basis, low, high, through }
    }

    /// The smallest number of knots, from `least` on, with which the error along an axis is below `share`.
    fn knots_for(&self, axis: usize, share: f64, least: usize) -> usize {
        let mut knots = least;
        while knots < MOST_KNOTS {
            let error = self.error(axis, knots);
            if error <= share {
                break;
            }
            // The error falls with the square of the distance between knots.
            let wanted = 1.0 + (knots - 1) as f64 * (error / share).sqrt().min(2.0);
            knots = (wanted.floor() as usize).clamp(knots + 1, MOST_KNOTS);
        }
        knots
    }

    /// Largest error of linear interpolation along one axis, halfway between its knots.
    fn error(&self, axis: usize, knots: usize) -> f64 {
        let n = self.basis.num_examples();
        let step = (self.high[axis] - self.low[axis]) / (knots - 1) as f64;
        let along = |point: &Vec<f64>| {
            let mut at = point.clone();
            let mut rows = vec![vec![0.0; n]; 3];
            let mut largest = 0.0f64;
            for cell in 0..knots - 1 {
                for (row, half) in rows.iter_mut().zip([0.0, 0.5, 1.0]) {
                    at[axis] = self.low[axis] + (cell as f64 + half) * step;
                    self.basis.weights(&at, row);
                }
                let error = |i: usize| (rows[1][i] - 0.5 * (rows[0][i] + rows[2][i])).abs();
                largest = (0..n).map(error).fold(largest, f64::max);
            }
            largest
        };
        self.through.par_iter().map(along).reduce(|| 0.0, f64::max)
    }
}

fn random_point(rng: &mut Pcg64, low: &[f64], high: &[f64]) -> Vec<f64> {
    low.iter().zip(high).map(|(&l, &h)| l + (h - l) * rng.random::<f64>()).collect()
}

fn stride(basis: &CardinalBasis) -> usize {
    basis.num_examples().next_multiple_of(8)
}

fn tabulate_weights(basis: &CardinalBasis, grid: &Grid) -> WeightTable {
    let (n, stride) = (basis.num_examples(), stride(basis));
    let mut weights = vec![0.0f32; grid.num_knots() * stride];
    weights.par_chunks_exact_mut(stride).enumerate().for_each_init(
        || vec![0.0; n],
        |exact, (knot, row)| {
            basis.weights(&grid.knot_point(&grid.indices(knot), 0.0), exact);
            row.iter_mut().zip(exact.iter()).for_each(|(r, e)| *r = *e as f32);
            normalise(&mut row[..n]);
        },
    );
    WeightTable { grid: grid.clone(), stride, weights: weights.into(), max_error: 0.0 }
}

/// Adjusts the largest weight so that the sum is 1 in spite of rounding.
fn normalise(row: &mut [f32]) {
    let left = 1.0 - row.iter().map(|w| f64::from(*w)).sum::<f64>();
    if let Some(largest) = row.iter_mut().max_by(|a, b| a.abs().total_cmp(&b.abs())) {
        *largest = (f64::from(*largest) + left) as f32;
    }
}

impl Grid {
    /// Number of all knots.
    pub fn num_knots(&self) -> usize {
        self.knots.iter().fold(1, |n: usize, k| n.saturating_mul(*k))
    }

    /// Number of the knot along each axis.
    fn indices(&self, mut knot: usize) -> [usize; MAX_AXES] {
        let mut out = [0; MAX_AXES];
        for axis in (0..self.knots.len()).rev() {
            out[axis] = knot % self.knots[axis];
            knot /= self.knots[axis];
        }
        out
    }

    /// Position of a knot moved by a part of a cell along every axis.
    fn knot_point(&self, indices: &[usize; MAX_AXES], part: f64) -> Vec<f64> {
        let along = |k: usize| {
            let ratio = (indices[k] as f64 + part) / (self.knots[k] - 1) as f64;
            self.low[k] + (self.high[k] - self.low[k]) * ratio
        };
        (0..self.knots.len()).map(along).collect()
    }

    /// Axes of the runtime's view of the table; their kinds do not matter here.
    fn axes(&self) -> [AxisRecord; MAX_AXES] {
        let mut axes = [AxisRecord::default(); MAX_AXES];
        for (axis, ((&low, &high), &knots)) in axes.iter_mut().zip(self.low.iter().zip(&self.high).zip(&self.knots)) {
            *axis = AxisRecord { num_knots: knots as u32, low: low as f32, high: high as f32, ..AxisRecord::default() };
        }
        axes
    }
}

impl WeightTable {
    /// Bytes of the table.
    pub fn num_bytes(&self) -> u64 {
        self.weights.len() as u64 * 4
    }

    /// Weights at a point, interpolated as in the runtime; outside the box, those of its nearest point inside.
    ///
    /// - `out`: receives the weights (number of examples).
    pub fn weights(&self, at: &[f64], out: &mut [f64]) {
        self.interpolate(self.as_read().as_ref(), at, out);
    }

    /// The runtime's view of the table, which shares the rows.
    fn as_read(&self) -> Option<WeightGrid> {
        WeightGrid::new(&self.grid.axes()[..self.grid.knots.len()], self.stride, &self.weights)
    }

    fn interpolate(&self, grid: Option<&WeightGrid>, at: &[f64], out: &mut [f64]) {
        let mut parameters = [0.0; MAX_AXES];
        parameters.iter_mut().zip(at).for_each(|(p, a)| *p = *a as f32);
        let mut row = vec![0.0; self.stride];
        grid.into_iter().for_each(|grid| grid.interpolate(&parameters, &mut row));
        out.iter_mut().zip(&row).for_each(|(o, w)| *o = f64::from(*w));
    }

    /// Largest error against the exact functions at cell centres, midpoints of edges and random points; near `most`
    /// evenly chosen knots.
    fn largest_error(&self, basis: &CardinalBasis, most: usize) -> f64 {
        let (n, d, total) = (basis.num_examples(), basis.num_axes(), self.grid.num_knots());
        let (every, grid) = (total.div_ceil(most).max(1), self.as_read());
        let error = |rows: &mut [Vec<f64>; 2], at: &[f64]| {
            let [exact, stored] = rows;
            basis.weights(at, exact);
            self.interpolate(grid.as_ref(), at, stored);
            exact.iter().zip(stored).map(|(a, b)| (a - *b).abs()).fold(0.0, f64::max)
        };
        let rows = || [vec![0.0; n], vec![0.0; n]];
        let beside = (0..total.div_ceil(every)).into_par_iter().map_init(rows, |rows, k| {
            let indices = self.grid.indices((k * every).min(total - 1));
            let mut largest = error(rows, &self.clamp_into_box(self.grid.knot_point(&indices, 0.5)));
            let knot = self.grid.knot_point(&indices, 0.0);
            for axis in 0..d {
                let mut at = knot.clone();
                at[axis] += 0.5 * (self.grid.high[axis] - self.grid.low[axis]) / (self.grid.knots[axis] - 1) as f64;
                largest = largest.max(error(rows, &self.clamp_into_box(at)));
            }
            largest
        });
        let mut rng = Pcg64::seed_from_u64(2);
        let random: Vec<_> =
            (0..RANDOM_POINTS).map(|_| random_point(&mut rng, &self.grid.low, &self.grid.high)).collect();
        let random = random.par_iter().map_init(rows, |rows, at| error(rows, at));
        beside.reduce(|| 0.0, f64::max).max(random.reduce(|| 0.0, f64::max))
    }

    fn clamp_into_box(&self, mut at: Vec<f64>) -> Vec<f64> {
        at.iter_mut().zip(&self.grid.low).zip(&self.grid.high).for_each(|((a, l), h)| *a = a.clamp(*l, *h));
        at
    }
}
