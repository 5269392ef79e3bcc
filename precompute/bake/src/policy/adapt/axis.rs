//! One axis of a coarser grid: the fit of values to its cells, and the interpolation of the fit.

/// A matrix, row-major.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AxisMatrix {
    pub rows: usize,
    pub columns: usize,
    pub elements: Vec<f32>,
}

impl AxisMatrix {
    /// Multiplies the matrix with a block of values along one of its axes.
    ///
    /// - `values`: (outer * columns * inner).
    /// - `out`: receives (outer * rows * inner).
    pub fn apply(&self, values: &[f32], inner: usize, out: &mut Vec<f32>) {
        out.clear();
        out.resize(values.len() / self.columns * self.rows, 0.0);
        let blocks = values.chunks_exact(self.columns * inner).zip(out.chunks_exact_mut(self.rows * inner));
        for (from, to) in blocks {
            for (weights, to) in self.elements.chunks_exact(self.columns).zip(to.chunks_exact_mut(inner)) {
                for (&w, from) in weights.iter().zip(from.chunks_exact(inner)) {
                    if w != 0.0 {
                        to.iter_mut().zip(from).for_each(|(to, &v)| *to += w * v);
                    }
                }
            }
        }
    }
}

/// An axis with a number of cells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Resolution {
    /// Number of cells.
    pub count: u32,
    /// Matrix from values of the finest cells to the least-squares values of these cells (count x finest).
    pub fit: AxisMatrix,
    /// Matrix from values of the finest cells to those interpolated at them after the fit (finest x finest).
    pub interpolation: AxisMatrix,
}

/// Possible numbers of cells of an axis, finest first: each about 0.7 of the one before.
///
/// - `around`: true for a periodic axis.
/// - `least`: (1 to finest)
pub(super) fn resolutions(finest: u32, least: u32, around: bool) -> Vec<Resolution> {
    let mut counts = vec![finest];
    let mut next = f64::from(finest);
    while counts[counts.len() - 1] > least {
        next *= std::f64::consts::FRAC_1_SQRT_2;
        let count = (next.round() as u32).max(least);
        if count < counts[counts.len() - 1] {
            counts.push(count);
        }
    }
    counts.into_iter().map(|count| Resolution::new(count, finest, around)).collect()
}

impl Resolution {
    /// - `count`: (1 to finest)
    pub fn new(count: u32, finest: u32, around: bool) -> Self {
        let (m, n) = (count as usize, finest as usize);
        let spread = interpolation(m, n, around);
        let fit = least_squares(&spread, m);
        let mut seen = vec![0.0f64; n * n];
        for i in 0..n {
            for k in 0..m {
                for j in 0..n {
                    seen[i * n + j] += spread[i * m + k] * fit[k * n + j];
                }
            }
        }
        let matrix = |rows, columns, elements: Vec<f64>| AxisMatrix {
            rows,
            columns,
            // Values that are only rounding are set to zero, so that they involve no neighbours.
            elements: elements.into_iter().map(|v| if v.abs() < 1e-9 { 0.0 } else { v as f32 }).collect(),
        };
        Self { count, fit: matrix(m, n, fit), interpolation: matrix(n, n, seen) }
    }
}

/// Weights with which each of `n` finest cells reads `m` cells over the same range (n x m).
fn interpolation(m: usize, n: usize, around: bool) -> Vec<f64> {
    let mut weights = vec![0.0; n * m];
    for i in 0..n {
        let t = match (m, around) {
            (1, _) => 0.0,
            (_, true) => (i * m) as f64 / n as f64,
            (_, false) => (i * (m - 1)) as f64 / (n - 1) as f64,
        };
        let low = (t as usize).min(m - 1);
        let ratio = t - low as f64;
        weights[i * m + low] += 1.0 - ratio;
        weights[i * m + if low + 1 < m { low + 1 } else { 0 }] += ratio;
    }
    weights
}

/// Matrix from `n` values to the `m` whose interpolation is nearest to them: (B'B)^-1 B'.
fn least_squares(spread: &[f64], m: usize) -> Vec<f64> {
    let n = spread.len() / m;
    // Normal equations with B' on the right-hand side, by Gauss-Jordan: positive definite, so without pivoting.
    let width = m + n;
    let mut a = vec![0.0f64; m * width];
    for i in 0..m {
        for j in 0..m {
            a[i * width + j] = (0..n).map(|k| spread[k * m + i] * spread[k * m + j]).sum();
        }
        for k in 0..n {
            a[i * width + m + k] = spread[k * m + i];
        }
    }
    for pivot in 0..m {
        let inverse = a[pivot * width + pivot].recip();
        a[pivot * width..][..width].iter_mut().for_each(|v| *v *= inverse);
        let row = a[pivot * width..][..width].to_vec();
        for i in (0..m).filter(|&i| i != pivot) {
            let factor = a[i * width + pivot];
            if factor != 0.0 {
                a[i * width..][..width].iter_mut().zip(&row).for_each(|(v, p)| *v -= factor * p);
            }
        }
    }
    a.chunks_exact(width).flat_map(|row| row[m..].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn counts_fall_from_the_finest_to_the_least() {
        let counts = |finest, least, around| -> Vec<u32> {
            resolutions(finest, least, around).iter().map(|r| r.count).collect()
        };
        assert_eq!(counts(20, 2, false), [20, 14, 10, 7, 5, 4, 3, 2]);
        assert_eq!(counts(8, 1, false), [8, 6, 4, 3, 2, 1]);
        assert_eq!(counts(1, 1, false), [1]);
        assert_eq!(counts(2, 2, true), [2]);
    }

    #[test]
    fn the_finest_changes_nothing() {
        for around in [false, true] {
            let finest = &resolutions(9, 2, around)[0];
            for (i, w) in finest.interpolation.elements.iter().enumerate() {
                let expected = if i % 10 == 0 { 1.0 } else { 0.0 };
                assert!((w - expected).abs() < 1e-6, "{around} {i} {w}");
            }
        }
    }

    proptest! {
        #[test]
        fn no_other_values_come_nearer(
            finest in 2u32..40, around in any::<bool>(), values in prop::collection::vec(-1.0f32..1.0, 40),
            nudges in prop::collection::vec(-0.1f64..0.1, 40),
        ) {
            let values = &values[..finest as usize];
            for r in resolutions(finest, 1, around) {
                let (m, n) = (r.count as usize, finest as usize);
                let (mut fitted, mut seen) = (Vec::new(), Vec::new());
                r.fit.apply(values, 1, &mut fitted);
                r.interpolation.apply(values, 1, &mut seen);
                let spread = interpolation(m, n, around);
                let error = |of: &dyn Fn(usize) -> f64| -> f64 {
                    let at = |i: usize| (0..m).map(|k| spread[i * m + k] * of(k)).sum::<f64>();
                    (0..n).map(|i| (at(i) - f64::from(values[i])).powi(2)).sum()
                };
                let own: f64 = seen.iter().zip(values).map(|(a, b)| f64::from(a - b).powi(2)).sum();
                let best = error(&|k| f64::from(fitted[k]));
                prop_assert!((own - best).abs() < 1e-4, "{} of {}: {} {}", m, n, own, best);
                let other = error(&|k| f64::from(fitted[k]) + nudges[k]);
                prop_assert!(best <= other + 1e-5, "{} of {}: {} {}", m, n, best, other);
            }
        }
    }
}
