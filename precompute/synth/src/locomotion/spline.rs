//! A smooth curve through knots, with given rates at its ends.

use super::super::track::hermite_piece;

/// A cubic spline: continuous in value, rate and acceleration, with given rates at both ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    /// Times and values, at least two, ascending in time.
    knots: Vec<(f64, f64)>,
    rates: Vec<f64>,
}

impl Spline {
    /// The curve through `knots` that begins and ends with the given rates.
    ///
    /// - `knots`: time and value, ascending in time, at least two.
    pub fn new(knots: Vec<(f64, f64)>, first: f64, last: f64) -> Self {
        let n = knots.len();
        let mut rates = vec![first; n];
        rates[n - 1] = last;
        // Equal accelerations on both sides of every inner knot: a tridiagonal system for the rates (Thomas algorithm).
        let mut upper = vec![0.0; n];
        for i in 1..n - 1 {
            let (a, b) = (1.0 / (knots[i].0 - knots[i - 1].0), 1.0 / (knots[i + 1].0 - knots[i].0));
            let slope = |i: usize, inverse: f64| 3.0 * inverse * inverse * (knots[i + 1].1 - knots[i].1);
            let pivot = 2.0 * (a + b) - a * upper[i - 1];
            upper[i] = b / pivot;
            rates[i] = (slope(i - 1, a) + slope(i, b) - a * rates[i - 1]) / pivot;
        }
        for i in (1..n - 1).rev() {
            rates[i] -= upper[i] * rates[i + 1];
        }
        Self { knots, rates }
    }

    /// Value at a time; extrapolated by the outer pieces.
    pub fn value_at(&self, t: f64) -> f64 {
        let i = self.knots.partition_point(|k| k.0 <= t).clamp(1, self.knots.len() - 1) - 1;
        hermite_piece([self.knots[i], self.knots[i + 1]], [self.rates[i], self.rates[i + 1]], t)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::signal::PieceEnd;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_cubic_is_its_own_spline() {
        let f = |t: f64| t * t * t - 2.0 * t + 1.0;
        let rate = |t: f64| 3.0 * t * t - 2.0;
        let spline = Spline::new([0.0, 0.3, 0.7, 1.5].map(|t| (t, f(t))).to_vec(), rate(0.0), rate(1.5));
        for k in 0..=30 {
            let t = 0.05 * f64::from(k);
            assert!((spline.value_at(t) - f(t)).abs() < 1e-12);
        }
    }

    proptest! {
        #[test]
        fn passes_its_knots_without_a_jump_in_acceleration(values in prop::array::uniform5(-1.0f64..1.0), first in -5.0f64..5.0) {
            let times = [0.0, 0.25, 0.5, 0.8, 1.0];
            let spline = Spline::new(times.into_iter().zip(values).collect(), first, 1.0);
            for (t, v) in times.into_iter().zip(values) {
                prop_assert!((spline.value_at(t) - v).abs() < 1e-12);
            }
            for t in &times[1..4] {
                let (before, after) = (PieceEnd::from_function(|t| spline.value_at(t), t - 2e-4), PieceEnd::from_function(|t| spline.value_at(t), t + 2e-4));
                prop_assert!((before.acceleration - after.acceleration).abs() < 2.0);
                prop_assert!((before.rate - after.rate).abs() < 0.2);
            }
            prop_assert!((PieceEnd::from_function(|t| spline.value_at(t), 0.0).rate - first).abs() < 1e-4);
        }
    }
}
