//! Weight tables: rows of numbers at the knots of a grid, interpolated between them.

use super::records::{AxisRecord, MAX_AXES};
use crate::format::Table;
use throng_base::simd::{LANES, Lanes};

/// A table of weight rows over the knots of a parameter box; the last axis runs fastest.
///
/// Between knots a row is interpolated linearly within the simplices of Kuhn's triangulation: from the lowest corner
/// of the cell, the path to the highest one that steps along the axes in the order of their fractions, the largest
/// first. With d axes that reads d + 1 rows, where multilinear interpolation reads 2^d; it is continuous, exact at the
/// knots, exact for linear functions, and its shares are not negative and sum to one.
///
/// The build measures the error of a table with this function.
#[derive(Clone, Debug)]
pub struct WeightGrid {
    axes: Table<AxisRecord>,
    stride: usize,
    /// Rows of all knots (number of knots * stride).
    pub(super) table: Table<f32>,
    /// Rows from a knot to the next along each axis.
    steps: [u32; MAX_AXES],
    /// Knots per unit of each parameter.
    densities: [f32; MAX_AXES],
}

/// Most knots of a grid, since row numbers are computed in `f32`.
pub const MAX_KNOTS: u32 = 1 << 23;

/// The simplices around eight points, one per lane: corner by corner from the lowest to the highest.
struct WeightSimplices {
    /// Number of the corner's row plus [`MAX_KNOTS`], so that it is the lower bits of the float.
    rows: [[f32; LANES]; MAX_AXES + 1],
    /// The corner's share.
    shares: [[f32; LANES]; MAX_AXES + 1],
}

impl WeightGrid {
    /// Wraps a table; `None` if its length does not match the grid, or an axis is malformed.
    ///
    /// - `axes`: at least one, at most [`MAX_AXES`]. Each of at least 2 knots, its low below its high; of all together
    ///   no more than [`MAX_KNOTS`].
    /// - `stride`: numbers of a row (a multiple of 8, > 0).
    /// - `table`: (product of the numbers of knots * stride)
    pub fn new(axes: &[AxisRecord], stride: usize, table: impl Into<Table<f32>>) -> Option<Self> {
        let table = table.into();
        let good = |a: &AxisRecord| a.num_knots >= 2 && (a.high - a.low).is_finite() && a.high > a.low;
        let is_grid = (1..=MAX_AXES).contains(&axes.len()) && axes.iter().all(good);
        if !is_grid || stride == 0 || !stride.is_multiple_of(LANES) {
            return None;
        }
        let mut steps = [0; MAX_AXES];
        let mut rows = 1u32;
        for (step, axis) in steps[..axes.len()].iter_mut().zip(axes).rev() {
            *step = rows;
            rows = rows.checked_mul(axis.num_knots).filter(|rows| *rows <= MAX_KNOTS)?;
        }
        let mut densities = [0.0; MAX_AXES];
        for (d, axis) in densities.iter_mut().zip(axes) {
            *d = (axis.num_knots - 1) as f32 / (axis.high - axis.low);
        }
        let fits = (rows as usize).checked_mul(stride) == Some(table.len());
        let is_good = fits && densities.iter().all(|d| d.is_finite());
        is_good.then(|| Self { axes: axes.into(), stride, table, steps, densities })
    }

    /// The axes.
    pub fn axes(&self) -> &[AxisRecord] {
        &self.axes
    }

    /// Numbers of a row.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Clamps a point to the box; NaN becomes the low end.
    pub fn clamp(&self, parameters: &[f32; MAX_AXES]) -> [f32; MAX_AXES] {
        let mut p = [0.0; MAX_AXES];
        for ((p, &v), axis) in p.iter_mut().zip(parameters).zip(&self.axes) {
            *p = if v > axis.low { v.min(axis.high) } else { axis.low };
        }
        p
    }

    /// Writes the row at a point, which is clamped to the box. Writes nothing if `out` is shorter than a row.
    pub fn interpolate(&self, parameters: &[f32; MAX_AXES], out: &mut [f32]) {
        self.interpolate_all(std::slice::from_ref(parameters), out);
    }

    /// Interpolates at many points, see [`Self::interpolate`]; surplus points or rows are ignored.
    ///
    /// - `out`: (parameters.len() * stride)
    pub fn interpolate_all(&self, parameters: &[[f32; MAX_AXES]], out: &mut [f32]) {
        throng_base::simd::dispatch(InterpolateJob { grid: self, parameters, out });
    }

    /// Writes the rows at many points (`out`: parameters.len() * stride).
    #[inline(always)]
    pub(crate) fn read_all<F: Lanes>(&self, parameters: &[[f32; MAX_AXES]], out: &mut [f32]) {
        match self.axes.len() {
            1 => self.read_each::<F, 1>(parameters, out),
            2 => self.read_each::<F, 2>(parameters, out),
            3 => self.read_each::<F, 3>(parameters, out),
            4 => self.read_each::<F, 4>(parameters, out),
            5 => self.read_each::<F, 5>(parameters, out),
            _ => self.read_each::<F, 6>(parameters, out),
        }
    }

    /// Plain loops, since closures would be compiled separately, without the wide vectors.
    #[inline(always)]
    fn read_each<F: Lanes, const D: usize>(&self, parameters: &[[f32; MAX_AXES]], out: &mut [f32]) {
        let mut around = WeightSimplices { rows: [[0.0; LANES]; MAX_AXES + 1], shares: [[0.0; LANES]; MAX_AXES + 1] };
        for (parameters, out) in parameters.chunks(LANES).zip(out.chunks_mut(LANES * self.stride)) {
            self.locate_simplices::<F, D>(parameters, &mut around);
            for (lane, out) in out.chunks_exact_mut(self.stride).take(parameters.len()).enumerate() {
                self.read_weights::<F, D>(&around, lane, out);
            }
        }
    }

    /// The simplices around up to eight points.
    #[inline(always)]
    fn locate_simplices<F: Lanes, const D: usize>(&self, parameters: &[[f32; MAX_AXES]], around: &mut WeightSimplices) {
        let zero = F::splat(0.0);
        let mut row = F::splat(MAX_KNOTS as f32);
        let (mut fractions, mut steps) = ([zero; D], [zero; D]);
        for a in 0..D {
            let mut values = [0.0; LANES];
            for (value, parameters) in values.iter_mut().zip(parameters) {
                *value = parameters[a];
            }
            let axis = &self.axes[a];
            let at = (F::load(&values) - F::splat(axis.low)) * F::splat(self.densities[a]);
            // NaN becomes 0.
            let at = at.max(zero).min(F::splat((axis.num_knots - 1) as f32));
            let nearest = at.round();
            let whole = F::select_lt(at, nearest, nearest - F::splat(1.0), nearest);
            let whole = whole.min(F::splat((axis.num_knots - 2) as f32));
            (fractions[a], steps[a]) = (at - whole, F::splat(self.steps[a] as f32));
            row = row + whole * steps[a];
        }
        for i in 0..D {
            for j in i + 1..D {
                let (a, b) = (fractions[i], fractions[j]);
                (steps[i], steps[j]) = (F::select_lt(a, b, steps[j], steps[i]), F::select_lt(a, b, steps[i], steps[j]));
                (fractions[i], fractions[j]) = (a.max(b), a.min(b));
            }
        }
        row.store(&mut around.rows[0]);
        (F::splat(1.0) - fractions[0]).store(&mut around.shares[0]);
        for i in 0..D {
            row = row + steps[i];
            row.store(&mut around.rows[i + 1]);
            let rest = if i + 1 < D { fractions[i + 1] } else { zero };
            (fractions[i] - rest).store(&mut around.shares[i + 1]);
        }
    }

    #[inline(always)]
    fn read_weights<F: Lanes, const D: usize>(&self, around: &WeightSimplices, lane: usize, out: &mut [f32]) {
        let num_chunks = out.len() / LANES;
        let mut rows = [&[][..]; MAX_AXES + 1];
        let mut shares = [F::splat(0.0); MAX_AXES + 1];
        for i in 0..=D {
            let row = around.rows[i][lane].to_bits() & (MAX_KNOTS - 1);
            rows[i] = &self.row(row as usize)[..num_chunks];
            shares[i] = F::splat(around.shares[i][lane]);
        }
        for (c, out) in out.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let mut sum = F::load(&rows[0][c]) * shares[0];
            for i in 1..=D {
                sum = sum + F::load(&rows[i][c]) * shares[i];
            }
            sum.store(out);
        }
    }

    #[inline(always)]
    fn row(&self, row: usize) -> &[[f32; LANES]] {
        self.table[row * self.stride..][..self.stride].as_chunks().0
    }
}

struct InterpolateJob<'a> {
    grid: &'a WeightGrid,
    parameters: &'a [[f32; MAX_AXES]],
    out: &'a mut [f32],
}

impl throng_base::simd::LaneWork for InterpolateJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        self.grid.read_all::<F>(self.parameters, self.out);
    }
}
