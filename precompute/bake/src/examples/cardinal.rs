//! Cardinal basis functions over scattered examples: the exact weights that the weight table approximates.

use super::dense::Lu;
use throng_core::blend::MAX_AXES;

/// Pivots below this share of the largest number make a system singular.
const SINGULAR: f64 = 1e-10;

/// Least extent of examples on an axis.
const LEAST_EXTENT: f64 = 1e-3;

/// Exact weights of examples over a parameter space: one cardinal basis function per example, which is 1 at its own
/// example and 0 at the others; at every point they sum to 1.
///
/// Each function is a hyperplane, fitted to those values by least squares, plus a sum of radial cubic B-splines around
/// all examples, which takes up the residual. Each spline ends at a multiple of the distance from its example to the
/// nearest other one. Distances on each axis are measured in that axis's spacing.
///
/// # Source
/// Kim, Kim and Shin (2003a), section 4.2.1, after Sloan, Rose and Cohen (2001), *Shape by Example*.
#[derive(Clone, Debug, PartialEq)]
pub struct CardinalBasis {
    num_axes: usize,
    num_examples: usize,
    /// Lowest value of the examples on each axis, and scale that makes the spacing 1.
    low: Vec<f64>,
    scale: Vec<f64>,
    /// Parameters of the examples above the lowest value, in spacings (num_examples * num_axes).
    points: Vec<f64>,
    /// Reciprocal of the distance at which each spline ends (num_examples).
    sharpness: Vec<f64>,
    /// Hyperplanes: constants, then slopes axis by axis ((num_axes + 1) * num_examples).
    linear: Vec<f64>,
    /// Share of each spline in each weight, spline by spline (num_examples * num_examples).
    radial: Vec<f64>,
    /// True if no weight is extrapolated.
    in_hull: bool,
}

/// Reason why examples have no cardinal basis.
#[derive(Clone, Debug, PartialEq)]
pub enum CardinalFault {
    /// Fewer examples than axes + 1.
    TooFew,
    /// Equal values of all examples on this axis.
    NoExtent(usize),
    /// Dependent values on this axis, given by those on the axes before it: all examples lie in one hyperplane.
    NoSpread(usize),
    /// Coincident examples: their numbers and distance.
    Coincident(usize, usize, f64),
    /// Overlapping splines, so much so that their shares cannot be solved for.
    Overlap,
}

impl CardinalBasis {
    /// Makes the basis of examples.
    ///
    /// - `points`: parameters of each example, axis by axis (examples x axes).
    /// - `spacings`: distance that counts as 1 on each axis; [`spacing`] gives it if absent (> 0).
    /// - `reach`: radius of a spline, in distances to the nearest other example.
    /// - `min_gap`: nearer examples are coincident, with each axis scaled to [0, 1] over the examples.
    ///
    /// # Errors
    /// [`CardinalFault`] gives the reason.
    pub fn new(points: &[Vec<f64>], spacings: &[Option<f64>], reach: f64, min_gap: f64) -> Result<Self, CardinalFault> {
        let (n, d) = (points.len(), points.first().map_or(0, Vec::len));
        if n < d + 1 {
            return Err(CardinalFault::TooFew);
        }
        let (low, extent) = extents(points);
        if let Some(k) = extent.iter().position(|e| e.is_nan() || *e <= LEAST_EXTENT) {
            return Err(CardinalFault::NoExtent(k));
        }
        if let Some((a, b, distance)) = nearest_pair(points, &extent).filter(|pair| pair.2 < min_gap) {
            return Err(CardinalFault::Coincident(a, b, distance));
        }
        let usual = spacing(points);
        let chosen = |k: usize| spacings.get(k).copied().flatten().unwrap_or(usual[k]);
        let scale: Vec<f64> = (0..d).map(|k| 1.0 / chosen(k)).collect();
        let unit = points.iter().flat_map(|p| (0..d).map(|k| (p[k] - low[k]) * scale[k]).collect::<Vec<_>>()).collect();
        let mut basis = Self {
            num_axes: d,
            num_examples: n,
            low,
            scale,
            points: unit,
            sharpness: Vec::new(),
            linear: Vec::new(),
            radial: Vec::new(),
            in_hull: false,
        };
        basis.linear = basis.fit_hyperplanes()?;
        basis.sharpness = (0..n).map(|i| 1.0 / (reach * basis.to_nearest(i))).collect();
        basis.radial = basis.fit_splines()?;
        Ok(basis)
    }

    /// This basis without extrapolation: a point outside the convex hull of the examples has the weights of the nearest point
    /// of the hull, distances measured in spacings, and no weight is negative.
    pub fn within_hull(self) -> Self {
        Self { in_hull: true, ..self }
    }

    /// Number of examples, and of weights.
    pub fn num_examples(&self) -> usize {
        self.num_examples
    }

    /// Number of axes.
    pub fn num_axes(&self) -> usize {
        self.num_axes
    }

    /// Exact weights of all examples at a point; they sum to 1, and any of them may be negative.
    ///
    /// - `at`: the point (num_axes).
    /// - `out`: receives the weights (num_examples).
    ///
    /// # Panics
    /// If a slice has another length.
    pub fn weights(&self, at: &[f64], out: &mut [f64]) {
        let (n, d) = (self.num_examples, self.num_axes);
        assert!(at.len() == d && out.len() == n, "{d} axes and {n} examples");
        let mut unit = [0.0; MAX_AXES];
        (0..d).for_each(|k| unit[k] = (at[k] - self.low[k]) * self.scale[k]);
        if self.in_hull {
            self.move_into_hull(&mut unit[..d], out);
        }
        out.copy_from_slice(&self.linear[..n]);
        for k in 0..d {
            add(out, unit[k], &self.linear[(k + 1) * n..(k + 2) * n]);
        }
        for j in 0..n {
            let point = &self.points[j * d..(j + 1) * d];
            let squared: f64 = point.iter().zip(&unit).map(|(p, u)| (p - u) * (p - u)).sum();
            let distance = squared * self.sharpness[j] * self.sharpness[j];
            if distance < 1.0 {
                add(out, spline(distance.sqrt()), &self.radial[j * n..(j + 1) * n]);
            }
        }
        if self.in_hull {
            self.keep_positive(&unit[..d], out);
        }
    }

    /// Moves weights to the nearest ones that are not negative and still blend to a point, by Dykstra's projections onto both
    /// sets in turn.
    fn keep_positive(&self, point: &[f64], out: &mut [f64]) {
        /// Most rounds.
        const ROUNDS: usize = 100;
        /// A weight above this counts as not negative.
        const MOST_NEGATIVE: f64 = -1e-4;
        let n = self.num_examples;
        let mut correction = vec![0.0; n];
        for _ in 0..ROUNDS {
            let mut off = [0.0; MAX_AXES + 1];
            off[0] = out.iter().sum::<f64>() - 1.0;
            for k in 0..point.len() {
                off[k + 1] = (0..n).map(|i| out[i] * self.point(i)[k]).sum::<f64>() - point[k];
            }
            // The hyperplanes' coefficients are the pseudo-inverse of these sums.
            self.linear.chunks_exact(n).zip(off).for_each(|(row, off)| add(out, -off, row));
            if out.iter().all(|w| *w > MOST_NEGATIVE) {
                break;
            }
            for (w, correction) in out.iter_mut().zip(&mut correction) {
                *correction += *w;
                *w = correction.max(0.0);
                *correction -= *w;
            }
        }
        out.iter_mut().for_each(|w| *w = w.max(0.0));
        let sum: f64 = out.iter().sum();
        out.iter_mut().for_each(|w| *w /= sum.max(f64::MIN_POSITIVE));
    }

    /// Moves a point to the nearest one of the examples' convex hull, by pairwise Frank-Wolfe steps: each shifts share
    /// from the example farthest beyond the point to the one farthest behind.
    ///
    /// - `share`: scratch (num_examples).
    fn move_into_hull(&self, point: &mut [f64], share: &mut [f64]) {
        /// Most steps, and the gain below which no other is taken (squared spacings).
        const STEPS: usize = 256;
        const GAIN: f64 = 1e-9;
        let along = |i: usize, g: &[f64]| self.point(i).iter().zip(g).map(|(p, g)| p * g).sum::<f64>();
        share.fill(0.0);
        share[0] = 1.0;
        let mut at = [0.0; MAX_AXES];
        at[..point.len()].copy_from_slice(self.point(0));
        for _ in 0..STEPS {
            let away: [f64; MAX_AXES] = std::array::from_fn(|k| point.get(k).map_or(0.0, |p| at[k] - p));
            let (mut to, mut from) = ((0, f64::INFINITY), (0, f64::NEG_INFINITY));
            for i in 0..self.num_examples {
                let v = along(i, &away);
                to = if v < to.1 { (i, v) } else { to };
                from = if share[i] > 0.0 && v > from.1 { (i, v) } else { from };
            }
            if from.1 - to.1 < GAIN {
                break;
            }
            let (a, b) = (self.point(from.0), self.point(to.0));
            let length: f64 = a.iter().zip(b).map(|(a, b)| (b - a) * (b - a)).sum();
            let step = share[from.0].min((from.1 - to.1) / length);
            share[from.0] -= step;
            share[to.0] += step;
            (0..point.len()).for_each(|k| at[k] += step * (b[k] - a[k]));
        }
        point.copy_from_slice(&at[..point.len()]);
    }

    /// Parameters of the examples, as given.
    pub fn examples(&self) -> impl Iterator<Item = Vec<f64>> {
        let raw = |i: usize, k: usize| self.low[k] + self.point(i)[k] / self.scale[k];
        (0..self.num_examples).map(move |i| (0..self.num_axes).map(|k| raw(i, k)).collect())
    }

    fn point(&self, i: usize) -> &[f64] {
        &self.points[i * self.num_axes..(i + 1) * self.num_axes]
    }

    fn distance(&self, i: usize, j: usize) -> f64 {
        self.point(i).iter().zip(self.point(j)).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    }

    fn to_nearest(&self, i: usize) -> f64 {
        (0..self.num_examples).filter(|&j| j != i).map(|j| self.distance(i, j)).fold(f64::INFINITY, f64::min)
    }

    /// Coefficients of the hyperplanes nearest to 1 at their own example and 0 at the others.
    fn fit_hyperplanes(&self) -> Result<Vec<f64>, CardinalFault> {
        let (n, d) = (self.num_examples, self.num_axes);
        let one = |i: usize, k: usize| if k == 0 { 1.0 } else { self.point(i)[k - 1] };
        if let Some(k) = self.axis_without_spread() {
            return Err(CardinalFault::NoSpread(k));
        }
        let mut normal = vec![0.0; (d + 1) * (d + 1)];
        for (r, row) in normal.chunks_exact_mut(d + 1).enumerate() {
            row.iter_mut().enumerate().for_each(|(c, v)| *v = (0..n).map(|i| one(i, r) * one(i, c)).sum());
        }
        let lu = Lu::new(d + 1, &normal, SINGULAR).ok_or(CardinalFault::NoSpread(d - 1))?;
        let mut out = vec![0.0; (d + 1) * n];
        for i in 0..n {
            let right: Vec<f64> = (0..=d).map(|k| one(i, k)).collect();
            lu.solve(&right).into_iter().enumerate().for_each(|(k, v)| out[k * n + i] = v);
        }
        Ok(out)
    }

    /// First axis on which the examples' values depend on those on the axes before it: nothing is left of it after
    /// Gram-Schmidt.
    fn axis_without_spread(&self) -> Option<usize> {
        let n = self.num_examples;
        let mut found: Vec<Vec<f64>> = vec![vec![1.0 / (n as f64).sqrt(); n]];
        for k in 0..self.num_axes {
            let mut column: Vec<f64> = (0..n).map(|i| self.point(i)[k]).collect();
            for known in &found {
                let share: f64 = column.iter().zip(known).map(|(a, b)| a * b).sum();
                add(&mut column, -share, known);
            }
            let left = column.iter().map(|v| v * v).sum::<f64>().sqrt();
            if left < 1e-4 * (n as f64).sqrt() {
                return Some(k);
            }
            column.iter_mut().for_each(|v| *v /= left);
            found.push(column);
        }
        None
    }

    /// Shares of the splines that take up the residual of the hyperplanes at the examples.
    fn fit_splines(&self) -> Result<Vec<f64>, CardinalFault> {
        let (n, d) = (self.num_examples, self.num_axes);
        let mut values = vec![0.0; n * n];
        for (k, row) in values.chunks_exact_mut(n).enumerate() {
            row.iter_mut().enumerate().for_each(|(j, v)| *v = spline(self.distance(k, j) * self.sharpness[j]));
        }
        let lu = Lu::new(n, &values, SINGULAR).ok_or(CardinalFault::Overlap)?;
        let mut out = vec![0.0; n * n];
        for i in 0..n {
            let plane = |k: usize| {
                let slopes: f64 = (0..d).map(|a| self.linear[(a + 1) * n + i] * self.point(k)[a]).sum();
                self.linear[i] + slopes
            };
            let residual: Vec<f64> = (0..n).map(|k| f64::from(u8::from(k == i)) - plane(k)).collect();
            lu.solve(&residual).into_iter().enumerate().for_each(|(j, v)| out[j * n + i] = v);
        }
        Ok(out)
    }
}

/// Default distance that counts as 1 on each axis: how far apart examples typically are on it.
///
/// For examples on a grid, it is the grid's spacing; for scattered ones, that of a grid with as many. So an axis of
/// three manners and one of twelve speeds both have neighbours about 1 apart.
///
/// - `points`: parameters of each example, axis by axis (examples x axes).
pub fn spacing(points: &[Vec<f64>]) -> Vec<f64> {
    let (low, extent) = extents(points);
    let levels: Vec<f64> = (0..low.len()).map(|k| levels(points, k, extent[k])).collect();
    let at_most = |cap: f64| levels.iter().map(|l| l.min(cap)).product::<f64>();
    // Finest grid with no more knots than examples, by bisection of its finest axis.
    let (mut few, mut many) = (2.0, levels.iter().fold(2.0f64, |a, l| a.max(*l)));
    if at_most(many) <= points.len() as f64 {
        few = many;
    }
    for _ in 0..40 {
        let middle = 0.5 * (few + many);
        if at_most(middle) <= points.len() as f64 { few = middle } else { many = middle }
    }
    extent.iter().zip(&levels).map(|(e, l)| e / (l.min(few) - 1.0)).collect()
}

/// Number of values on an axis that differ by more than a part of its extent.
fn levels(points: &[Vec<f64>], axis: usize, extent: f64) -> f64 {
    let mut values: Vec<f64> = points.iter().map(|p| p[axis]).collect();
    values.sort_by(f64::total_cmp);
    let gaps = values.windows(2).filter(|w| w[1] - w[0] > 0.02 * extent).count();
    (1 + gaps).max(2) as f64
}

/// Lowest value and extent on each axis.
fn extents(points: &[Vec<f64>]) -> (Vec<f64>, Vec<f64>) {
    let along = |k: usize| {
        let values = || points.iter().map(move |p| p[k]);
        let low = values().fold(f64::INFINITY, f64::min);
        (low, values().fold(f64::NEG_INFINITY, f64::max) - low)
    };
    (0..points.first().map_or(0, Vec::len)).map(along).unzip()
}

/// The two nearest points, with each axis scaled to [0, 1] over all.
fn nearest_pair(points: &[Vec<f64>], extent: &[f64]) -> Option<(usize, usize, f64)> {
    let distance =
        |a: &[f64], b: &[f64]| a.iter().zip(b).zip(extent).map(|((a, b), e)| ((a - b) / e).powi(2)).sum::<f64>().sqrt();
    let pairs = (0..points.len()).flat_map(|i| (i + 1..points.len()).map(move |j| (i, j)));
    pairs.map(|(i, j)| (i, j, distance(&points[i], &points[j]))).min_by(|a, b| a.2.total_cmp(&b.2))
}

fn add(out: &mut [f64], share: f64, of: &[f64]) {
    out.iter_mut().zip(of).for_each(|(o, v)| *o += share * v);
}

/// Cubic B-spline, 2/3 at 0, which ends at 1 with its first and second derivative.
fn spline(r: f64) -> f64 {
    let x = 2.0 * r;
    let near = 2.0 / 3.0 - x * x * (1.0 - 0.5 * x);
    let far = (2.0 - x) * (2.0 - x) * (2.0 - x) / 6.0;
    if x < 1.0 {
        near
    } else if x < 2.0 {
        far
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spline_is_smooth_where_its_parts_meet_and_where_it_ends() {
        for at in [0.0, 0.5, 1.0] {
            let h = 1e-4;
            let f = |x: f64| spline(x.abs());
            let slope = |x: f64| (f(x + h) - f(x - h)) / (2.0 * h);
            let bend = |x: f64| (f(x + h) - 2.0 * f(x) + f(x - h)) / (h * h);
            assert!((slope(at + h) - slope(at - h)).abs() < 1e-2, "slope at {at}");
            assert!((bend(at + 2.0 * h) - bend(at - 2.0 * h)).abs() < 5e-2, "second derivative at {at}");
        }
        assert!((spline(0.0) - 2.0 / 3.0).abs() < 1e-12 && spline(1.0) == 0.0 && spline(3.0) == 0.0);
    }

    #[test]
    fn neighbours_on_a_grid_are_one_spacing_apart() {
        let grid = |n: [usize; 3], unit: [f64; 3]| {
            let mut points = Vec::new();
            for i in 0..n.iter().product() {
                let at = [i % n[0], i / n[0] % n[1], i / n[0] / n[1]];
                points.push((0..3).map(|k| at[k] as f64 * unit[k]).collect::<Vec<_>>());
            }
            spacing(&points)
        };
        for (n, unit) in [([3, 4, 5], [1.0, 0.4, 0.1]), ([2, 9, 2], [7.0, 2.0, 3.0])] {
            assert!(grid(n, unit).iter().zip(unit).all(|(a, b)| (a - b).abs() < 1e-6 * b), "{n:?}");
        }
        // Scattered over a square and on one of two manners: a grid of 2 x 3 x 3.
        let golden = 0.618_033_988_75;
        let points: Vec<Vec<f64>> =
            (0..18).map(|i| vec![f64::from(i % 2), f64::from(i) / 17.0, (f64::from(i) * golden).fract()]).collect();
        let found = spacing(&points);
        assert!(
            (found[0] - 1.0).abs() < 1e-9 && (found[1] - 0.5).abs() < 1e-6 && (found[2] - 0.5).abs() < 0.05,
            "{found:?}"
        );
    }

    #[test]
    fn nothing_is_extrapolated_within_the_hull() {
        let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, -1.0], [3.0, 0.0]].map(|p| p.to_vec());
        let basis = CardinalBasis::new(&points, &[], 2.0, 1e-3).unwrap();
        let mut w = [0.0; 5];
        basis.weights(&[0.0, 1.0], &mut w);
        assert!(w.iter().any(|w| *w < -0.1), "a hyperplane goes on beyond the examples: {w:?}");
        let basis = basis.within_hull();
        for at in [[0.0, 1.0], [3.0, -1.0], [9.0, 9.0], [0.4, 0.1], [1.0, 0.0], [-5.0, 0.3]] {
            basis.weights(&at, &mut w);
            assert!(w.iter().all(|w| (0.0..=1.0).contains(w)) && (w.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{w:?}");
        }
        // The nearest point to a corner of the box lies halfway between two examples.
        let unit = |p: [f64; 2]| [0, 1].map(|k| (p[k] - basis.low[k]) * basis.scale[k]);
        let mut corner = unit([0.0, 1.0]);
        basis.move_into_hull(&mut corner, &mut w);
        let side = [unit([0.0, 0.0]), unit([1.0, 1.0])];
        let off =
            (corner[0] - side[0][0]) * (side[1][1] - side[0][1]) - (corner[1] - side[0][1]) * (side[1][0] - side[0][0]);
        assert!(off.abs() < 1e-3 && w[0] > 0.2 && w[2] > 0.2, "{corner:?} {w:?}");
    }

    /// Three examples on a line at 0, 1 and 2; done by hand.
    #[test]
    fn three_examples_on_a_line() {
        let basis = CardinalBasis::new(&[vec![0.0], vec![1.0], vec![2.0]], &[], 2.0, 1e-3).unwrap();
        let mut w = [0.0; 3];
        // The hyperplane of the middle one is 1/3 everywhere; the splines' values at distance 0 and 1 are 2/3, 1/6.
        // Its residual (-1/3, 2/3, -1/3) is theirs with the shares (-6/7, 10/7, -6/7).
        basis.weights(&[0.5], &mut w);
        let half = 23.0 / 48.0; // the B-spline at half a knot
        let far = 1.0 / 48.0; // and at one and a half
        let middle = 1.0 / 3.0 + half * (10.0 / 7.0 - 6.0 / 7.0) - far * 6.0 / 7.0;
        assert!((w[1] - middle).abs() < 1e-12, "{w:?}, {middle}");
        assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}
