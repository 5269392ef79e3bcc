//! The linear part of the cardinal weights, computed from the positions of the examples.

use super::records::{AxisRecord, ExampleRecord, MAX_AXES};

/// Numbers of a linear function: one an axis, and the constant.
const N: usize = MAX_AXES + 1;

/// Gradient of the linear part of each example's weight: that of the hyperplane that best fits "1 at the example, 0 at
/// the others" (Kim, Kim and Shin 2003a, section 4.2.1) (num_axes * stride).
///
/// Axes along which the examples do not differ have slope 0.
pub(crate) fn linear_part(examples: &[ExampleRecord], axes: &[AxisRecord], stride: usize) -> Vec<f32> {
    let d = axes.len();
    // Axes are normalised to -1..1, so that units do not matter.
    let row = |e: &ExampleRecord| {
        let mut r = [0.0; N];
        r[d] = 1.0;
        for (a, axis) in axes.iter().enumerate() {
            let (low, high) = (f64::from(axis.low), f64::from(axis.high));
            r[a] = (2.0 * f64::from(e.parameters[a]) - low - high) / (high - low);
        }
        r
    };
    let rows: Vec<[f64; N]> = examples.iter().map(row).collect();
    let mut normal = [[0.0; N]; N];
    for r in &rows {
        for i in 0..=d {
            for j in 0..=d {
                normal[i][j] += r[i] * r[j];
            }
        }
    }
    let mut slopes = vec![0.0; d * stride];
    for (e, r) in rows.iter().enumerate() {
        let x = solve(normal, *r, d + 1);
        for (a, axis) in axes.iter().enumerate() {
            slopes[a * stride + e] = (x[a] * 2.0 / f64::from(axis.high - axis.low)) as f32;
        }
    }
    slopes
}

/// Solves a symmetric positive semidefinite system by elimination with diagonal pivots; undetermined unknowns are 0.
fn solve(mut m: [[f64; N]; N], mut b: [f64; N], n: usize) -> [f64; N] {
    let largest = (0..n).fold(0.0f64, |l, i| l.max(m[i][i]));
    let mut done = [false; N];
    let mut order = Vec::with_capacity(n);
    while let Some(p) = (0..n).filter(|&i| !done[i]).max_by(|&i, &j| m[i][i].total_cmp(&m[j][j])) {
        done[p] = true;
        if m[p][p] <= 1e-10 * largest {
            continue;
        }
        order.push(p);
        for i in (0..n).filter(|&i| i != p) {
            let factor = m[i][p] / m[p][p];
            for j in 0..n {
                m[i][j] -= factor * m[p][j];
            }
            b[i] -= factor * b[p];
        }
    }
    let mut x = [0.0; N];
    order.into_iter().for_each(|p| x[p] = b[p] / m[p][p]);
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn example(parameters: &[f32]) -> ExampleRecord {
        let mut e = ExampleRecord::zeroed();
        e.parameters[..parameters.len()].copy_from_slice(parameters);
        e
    }

    fn axis(low: f32, high: f32) -> AxisRecord {
        AxisRecord { kind: 0, num_knots: 2, low, high }
    }

    #[test]
    fn linear_functions_are_extrapolated_exactly() {
        let places = [[0.0, -1.0], [1.0, 0.5], [3.0, 1.0], [2.0, -0.7], [0.5, 0.0]];
        let examples: Vec<_> = places.iter().map(|p| example(p)).collect();
        let slopes = linear_part(&examples, &[axis(0.0, 3.0), axis(-1.0, 1.0)], 8);
        for a in 0..2 {
            let row = &slopes[8 * a..][..8];
            assert!(row.iter().sum::<f32>().abs() < 1e-6, "weights keep their sum");
            for b in 0..2 {
                let slope: f32 = row.iter().zip(places).map(|(s, p)| s * p[b]).sum();
                assert!((slope - if a == b { 1.0 } else { 0.0 }).abs() < 1e-5, "{a} {b}: {slope}");
            }
        }
    }

    #[test]
    fn axis_along_which_examples_coincide_has_no_slope() {
        let examples = [example(&[0.0, 2.0]), example(&[1.0, 2.0]), example(&[2.0, 2.0])];
        let slopes = linear_part(&examples, &[axis(0.0, 2.0), axis(0.0, 4.0)], 8);
        assert!(slopes[8..].iter().all(|s| s.abs() < 1e-6));
        assert!((slopes[0] + 0.5).abs() < 1e-6 && slopes[1].abs() < 1e-6 && (slopes[2] - 0.5).abs() < 1e-6);
    }
}
