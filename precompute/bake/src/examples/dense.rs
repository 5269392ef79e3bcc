//! Small dense linear systems in double precision.

/// The LU factors of a square matrix with its rows exchanged.
#[derive(Clone, Debug)]
pub struct Lu {
    n: usize,
    /// L below the diagonal, U on and above it, row-major (n * n).
    factors: Vec<f64>,
    /// Row of the matrix that became row i.
    order: Vec<usize>,
}

impl Lu {
    /// Factors a matrix, exchanging rows so that the largest pivot of each column is taken.
    ///
    /// - `matrix`: row-major (n * n).
    /// - returns nothing where a pivot is below `least` times the largest number of the matrix.
    pub fn new(n: usize, matrix: &[f64], least: f64) -> Option<Self> {
        let mut m = matrix.to_vec();
        let mut order: Vec<usize> = (0..n).collect();
        let largest = m.iter().fold(0.0f64, |a, v| a.max(v.abs()));
        for k in 0..n {
            let pivot = (k..n).max_by(|&a, &b| m[a * n + k].abs().total_cmp(&m[b * n + k].abs()))?;
            let size = m[pivot * n + k].abs();
            if size.is_nan() || size <= least * largest {
                return None;
            }
            if pivot != k {
                (0..n).for_each(|c| m.swap(k * n + c, pivot * n + c));
                order.swap(k, pivot);
            }
            for r in k + 1..n {
                let factor = m[r * n + k] / m[k * n + k];
                m[r * n + k] = factor;
                for c in k + 1..n {
                    m[r * n + c] -= factor * m[k * n + c];
                }
            }
        }
        Some(Self { n, factors: m, order })
    }

    /// The x of `matrix * x = b` (n).
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let (n, m) = (self.n, &self.factors);
        let mut x: Vec<f64> = self.order.iter().map(|&r| b[r]).collect();
        for r in 0..n {
            x[r] -= (0..r).map(|c| m[r * n + c] * x[c]).sum::<f64>();
        }
        for r in (0..n).rev() {
            let known: f64 = (r + 1..n).map(|c| m[r * n + c] * x[c]).sum();
            x[r] = (x[r] - known) / m[r * n + r];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_system_that_needs_its_rows_exchanged() {
        let lu = Lu::new(3, &[0.0, 2.0, 1.0, 1.0, 0.0, 0.0, 3.0, 0.0, 1.0], 1e-12).unwrap();
        assert_eq!(lu.solve(&[7.0, 2.0, 9.0]), [2.0, 2.0, 3.0]);
    }

    #[test]
    fn rows_that_depend_on_one_another_have_no_factors() {
        assert!(Lu::new(2, &[1.0, 2.0, 2.0, 4.0], 1e-12).is_none());
        assert!(Lu::new(2, &[0.0; 4], 1e-12).is_none());
    }

    proptest! {
        #[test]
        fn the_solution_gives_the_right_hand_side(m in prop::collection::vec(-1.0f64..1.0, 36), b in prop::collection::vec(-1.0f64..1.0, 6)) {
            if let Some(lu) = Lu::new(6, &m, 1e-3) {
                let x = lu.solve(&b);
                for r in 0..6 {
                    let got: f64 = (0..6).map(|c| m[r * 6 + c] * x[c]).sum();
                    prop_assert!((got - b[r]).abs() < 1e-8);
                }
            }
        }
    }
}
