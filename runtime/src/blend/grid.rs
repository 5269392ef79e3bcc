//! Weight tables: rows of numbers at the knots of a grid, interpolated between them.

use super::records::{AxisRecord, MAX_AXES};
use crate::lanes::{LANES, Lanes};

/// A table of weight rows over the knots of a parameter box; the last axis runs fastest.
///
/// Between knots a row is interpolated linearly within the simplices of Kuhn's triangulation: from the lowest corner
/// of the cell, the path to the highest one that steps along the axes in the order of their fractions, the largest
/// first. With d axes that reads d + 1 rows, where multilinear interpolation reads 2^d; it is continuous, exact at the
/// knots, exact for linear functions, and its shares are not negative and sum to one.
///
/// A builder measures the error of a table by this very function.
#[derive(Clone, Copy, Debug)]
pub struct WeightGrid<'a> {
    axes: &'a [AxisRecord],
    stride: usize,
    table: &'a [f32],
    /// Rows from a knot to the next along each axis.
    steps: [u32; MAX_AXES],
    /// Knots a unit of each parameter.
    densities: [f32; MAX_AXES],
}

/// The corners of the simplex around a point.
struct Corners<const D: usize> {
    /// The lowest corner's row.
    row: usize,
    /// Fraction within the cell and rows to step, as (bits of the fraction, rows), the largest fraction first.
    path: [u64; D],
}

impl<'a> WeightGrid<'a> {
    /// A view on a table, or none where its length is not that of the grid or an axis is not one.
    ///
    /// - `axes`: at least one, at most [`MAX_AXES`]. Each of at least 2 knots, its low below its high.
    /// - `stride`: numbers of a row. [Limit: a multiple of 8, > 0]
    /// - `table`: [Size: product of the numbers of knots * stride]
    pub fn new(axes: &'a [AxisRecord], stride: usize, table: &'a [f32]) -> Option<Self> {
        let good = |a: &AxisRecord| a.num_knots >= 2 && (a.high - a.low).is_finite() && a.high > a.low;
        if axes.is_empty()
            || axes.len() > MAX_AXES
            || !axes.iter().all(good)
            || stride == 0
            || !stride.is_multiple_of(LANES)
        {
            return None;
        }
        let mut steps = [0; MAX_AXES];
        let mut rows = 1u32;
        for (step, axis) in steps[..axes.len()].iter_mut().zip(axes).rev() {
            *step = rows;
            rows = rows.checked_mul(axis.num_knots)?;
        }
        let mut densities = [0.0; MAX_AXES];
        for (d, axis) in densities.iter_mut().zip(axes) {
            *d = (axis.num_knots - 1) as f32 / (axis.high - axis.low);
        }
        let fits = (rows as usize).checked_mul(stride) == Some(table.len());
        (fits && densities.iter().all(|d| d.is_finite())).then_some(Self { axes, stride, table, steps, densities })
    }

    /// The axes.
    pub fn axes(&self) -> &'a [AxisRecord] {
        self.axes
    }

    /// Numbers of a row.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The nearest point within the box; what is not a number is taken as the low end.
    pub fn clamp(&self, parameters: &[f32; MAX_AXES]) -> [f32; MAX_AXES] {
        let mut p = [0.0; MAX_AXES];
        for ((p, &v), axis) in p.iter_mut().zip(parameters).zip(self.axes) {
            *p = if v > axis.low { v.min(axis.high) } else { axis.low };
        }
        p
    }

    /// Writes the row at a point; outside the box, that at its nearest point within. Nothing is written where `out` is
    /// shorter than a row.
    pub fn interpolate(&self, parameters: &[f32; MAX_AXES], out: &mut [f32]) {
        self.interpolate_all(std::slice::from_ref(parameters), out);
    }

    /// As [`Self::interpolate`], at many points; points or rows that are over are left.
    ///
    /// - `out`: [Size: parameters.len() * stride]
    pub fn interpolate_all(&self, parameters: &[[f32; MAX_AXES]], out: &mut [f32]) {
        crate::lanes::dispatch(Batch { grid: self, parameters, out });
    }

    /// Rows at many points. [Size of `out`: parameters.len() * stride]
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

    /// A plain loop: closures would be compiled on their own, without the wide vectors.
    #[inline(always)]
    fn read_each<F: Lanes, const D: usize>(&self, parameters: &[[f32; MAX_AXES]], out: &mut [f32]) {
        for (parameters, row) in parameters.iter().zip(out.chunks_exact_mut(self.stride)) {
            self.read::<F, D>(parameters, row);
        }
    }

    #[inline(always)]
    fn corners<const D: usize>(&self, parameters: &[f32; MAX_AXES]) -> Corners<D> {
        let mut row = 0;
        let mut path = [0u64; D];
        for a in 0..D {
            let axis = &self.axes[a];
            let last = axis.num_knots - 2;
            let at = (parameters[a] - axis.low) * self.densities[a];
            // Not a number becomes 0.
            let at = if at > 0.0 { at.min((last + 1) as f32) } else { 0.0 };
            let whole = (at as u32).min(last);
            row += (whole * self.steps[a]) as usize;
            // Fractions are not negative, so their bits are in their order.
            path[a] = u64::from((at - whole as f32).to_bits()) << 32 | u64::from(self.steps[a]);
        }
        for i in 0..D {
            for j in i + 1..D {
                (path[i], path[j]) = (path[i].max(path[j]), path[i].min(path[j]));
            }
        }
        Corners { row, path }
    }

    #[inline(always)]
    fn read<F: Lanes, const D: usize>(&self, parameters: &[f32; MAX_AXES], out: &mut [f32]) {
        let corners = self.corners::<D>(parameters);
        let mut fractions = [0.0; MAX_AXES + 1];
        for i in 0..D {
            fractions[i] = f32::from_bits((corners.path[i] >> 32) as u32);
        }
        let mut row = corners.row;
        let num_chunks = out.len() / LANES;
        let mut rows = [&self.row(row)[..num_chunks]; MAX_AXES + 1];
        let mut shares = [F::splat(0.0); MAX_AXES + 1];
        shares[0] = F::splat(1.0 - fractions[0]);
        for i in 0..D {
            row += corners.path[i] as u32 as usize;
            rows[i + 1] = &self.row(row)[..num_chunks];
            shares[i + 1] = F::splat(fractions[i] - fractions[i + 1]);
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
    fn row(&self, row: usize) -> &'a [[f32; LANES]] {
        self.table[row * self.stride..][..self.stride].as_chunks().0
    }
}

struct Batch<'a, 't> {
    grid: &'a WeightGrid<'t>,
    parameters: &'a [[f32; MAX_AXES]],
    out: &'a mut [f32],
}

impl crate::lanes::Work for Batch<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        self.grid.read_all::<F>(self.parameters, self.out);
    }
}
