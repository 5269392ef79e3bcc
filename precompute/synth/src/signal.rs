//! Signals on an even time grid: polynomial pieces with given ends, and filters that keep them smooth.

/// Value, first and second derivative at one end of a piece.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PieceEnd {
    /// Value.
    pub value: f64,
    /// First derivative (1/s).
    pub rate: f64,
    /// Second derivative (1/s^2).
    pub acceleration: f64,
}

impl PieceEnd {
    /// An end at rest at `value`.
    pub fn at_rest(value: f64) -> Self {
        Self { value, ..Self::default() }
    }

    /// An end that passes `value` at a constant `rate`.
    pub fn moving(value: f64, rate: f64) -> Self {
        Self { value, rate, acceleration: 0.0 }
    }

    /// An end taken from a smooth function of time at `t`, by central differences.
    pub fn from_function(f: impl Fn(f64) -> f64, t: f64) -> Self {
        const H: f64 = 1e-4;
        let (a, b, c) = (f(t - H), f(t), f(t + H));
        Self { value: b, rate: (c - a) / (2.0 * H), acceleration: (a - 2.0 * b + c) / (H * H) }
    }
}

/// The quintic that joins two ends in value, rate and acceleration, `t` seconds after the first.
pub fn quintic(from: PieceEnd, to: PieceEnd, duration: f64, t: f64) -> f64 {
    let u = t / duration;
    let (v0, a0) = (from.rate * duration, from.acceleration * duration * duration);
    let (v1, a1) = (to.rate * duration, to.acceleration * duration * duration);
    let d = to.value - from.value;
    let c3 = 10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1;
    let c4 = -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1;
    let c5 = 6.0 * d - 3.0 * v0 - 3.0 * v1 - 0.5 * a0 + 0.5 * a1;
    from.value + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5))))
}

/// A bump of height 1 over `u` in `[0, 1]` that leaves and meets zero with zero rate and acceleration.
pub fn bump(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    64.0 * (u * (1.0 - u)).powi(3)
}

/// A bump like [`bump`] that rises faster than it falls: its top is at 3/8.
pub fn early_bump(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    let top = 0.375f64.powi(3) * 0.625f64.powi(5);
    u.powi(3) * (1.0 - u).powi(5) / top
}

/// Rises from 0 to 1 over `u` in `[0, 1]`: speeds up over the first `ramp`, is even, and slows down over the last.
///
/// Rate and acceleration are zero at both ends and continuous between them. The top rate is `1 / (1 - ramp)`,
/// lower than that of a quintic (1.875).
///
/// - `ramp`: (> 0, <= 0.5)
pub fn cruise(ramp: f64, u: f64) -> f64 {
    // Distance covered while the speed rises as a cubic smoothstep.
    let rising = |u: f64| {
        let x = u / ramp;
        ramp * x * x * x * (1.0 - 0.5 * x)
    };
    let top = 1.0 / (1.0 - ramp);
    let u = u.clamp(0.0, 1.0);
    if u < ramp {
        top * rising(u)
    } else if u > 1.0 - ramp {
        1.0 - top * rising(1.0 - u)
    } else {
        top * (u - 0.5 * ramp)
    }
}

/// Piecewise linear interpolation of `(time, value)` knots, constant beyond them.
///
/// - `knots`: ascending times, at least one.
pub fn interpolate(knots: &[(f64, f64)], t: f64) -> f64 {
    let next = knots.partition_point(|k| k.0 <= t);
    match (next.checked_sub(1).map(|i| knots[i]), knots.get(next)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0),
        (Some(a), None) => a.1,
        (None, Some(b)) => b.1,
        (None, None) => 0.0,
    }
}

/// Three passes of a running mean: nearly a Gaussian, with a support of `3 * radius` samples to each side.
///
/// The ends are continued with their last value.
pub fn smooth(x: &[f64], radius: usize) -> Vec<f64> {
    (0..3).fold(x.to_vec(), |x, _| running_mean(&x, radius))
}

fn running_mean(x: &[f64], radius: usize) -> Vec<f64> {
    if x.is_empty() || radius == 0 {
        return x.to_vec();
    }
    let (n, r) = (x.len() as isize, radius as isize);
    let at = |i: isize| x[i.clamp(0, n - 1) as usize];
    (0..n).map(|i| (i - r..=i + r).map(at).sum::<f64>() / (2 * r + 1) as f64).collect()
}

/// A smooth signal that stays below `limit` and bends upwards by no more than `acceleration`.
///
/// The lower envelope of parabolas over every sample is the largest signal of that curvature below the limit; smoothing
/// raises such a signal by at most its curvature times half the variance of the filter, which is subtracted.
///
/// - `radius`: of the smoothing, as in [`smooth`].
/// - `acceleration`: (1/s^2, > 0)
pub fn smooth_below(limit: &[f64], acceleration: f64, radius: usize, dt: f64) -> Vec<f64> {
    let per_sample = 0.5 * acceleration * dt * dt;
    let range =
        limit.iter().copied().fold(f64::NEG_INFINITY, f64::max) - limit.iter().copied().fold(f64::INFINITY, f64::min);
    let reach = if limit.is_empty() { 0 } else { (range / per_sample).sqrt().ceil() as usize };
    let lowest = |i: usize| {
        let first = i.saturating_sub(reach);
        let window = limit[first..(i + reach + 1).min(limit.len())].iter().enumerate();
        window.map(|(k, y)| y + per_sample * ((first + k) as f64 - i as f64).powi(2)).fold(f64::INFINITY, f64::min)
    };
    let envelope: Vec<f64> = (0..limit.len()).map(lowest).collect();
    // A running mean over 2r + 1 samples has the variance r(r + 1)/3; three passes add up.
    let raised = per_sample * (radius * (radius + 1)) as f64;
    smooth(&envelope, radius).iter().map(|y| y - raised).collect()
}

/// Second derivative by central differences, zero at both ends (1/s^2).
pub fn acceleration(x: &[f64], dt: f64) -> Vec<f64> {
    let mut out = vec![0.0; x.len()];
    for i in 1..x.len().saturating_sub(1) {
        out[i] = (x[i - 1] - 2.0 * x[i] + x[i + 1]) / (dt * dt);
    }
    out
}

/// The signal delayed by `seconds` (advanced if negative), constant beyond its ends.
pub fn shifted(x: &[f64], seconds: f64, dt: f64) -> Vec<f64> {
    let shift = (seconds / dt).round() as isize;
    (0..x.len() as isize).map(|i| x[(i + shift).clamp(0, x.len() as isize - 1) as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn quintic_meets_both_ends() {
        let a = PieceEnd { value: 1.0, rate: -2.0, acceleration: 3.0 };
        let b = PieceEnd { value: 4.0, rate: 0.5, acceleration: -6.0 };
        for (end, t) in [(a, 0.0), (b, 0.7)] {
            let got = PieceEnd::from_function(|t| quintic(a, b, 0.7, t), t);
            assert!((got.value - end.value).abs() < 1e-9);
            assert!((got.rate - end.rate).abs() < 1e-5);
            assert!((got.acceleration - end.acceleration).abs() < 1e-3);
        }
    }

    #[test]
    fn cruise_goes_from_rest_to_rest_without_a_jump() {
        let ends = [(0.0, 0.0), (0.5, 0.5), (1.0, 1.0)];
        assert!(ends.iter().all(|(u, x)| (cruise(0.3, *u) - x).abs() < 1e-12));
        for k in 1..1000 {
            let (a, b, c) = (f64::from(k - 1) * 1e-3, f64::from(k) * 1e-3, f64::from(k + 1) * 1e-3);
            let [a, b, c] = [a, b, c].map(|u| cruise(0.3, u));
            assert!(c >= b && b >= a && c - b < 1e-3 / 0.7 + 1e-9);
            assert!((a - 2.0 * b + c).abs() < 1e-6 * 1.5 / (0.3 * 0.7) + 1e-9);
        }
    }

    #[test]
    fn interpolation_passes_through_the_knots() {
        let k = [(0.0, 1.0), (1.0, 3.0), (2.0, 0.0)];
        assert_eq!([-1.0, 0.5, 1.0, 1.5, 9.0].map(|t| interpolate(&k, t)), [1.0, 2.0, 3.0, 1.5, 0.0]);
    }

    proptest! {
        #[test]
        fn smooth_below_stays_below(x in prop::collection::vec(-1.0f64..1.0, 1..80), r in 0usize..6, a in 0.5f64..20.0) {
            let y = smooth_below(&x, a, r, 0.05);
            prop_assert!(y.iter().zip(&x).all(|(y, x)| *y <= x + 1e-12));
            prop_assert!(acceleration(&y, 0.05).iter().all(|b| *b <= a + 1e-6));
        }

        #[test]
        fn smoothing_keeps_constants(c in -5.0f64..5.0, r in 0usize..9) {
            prop_assert!(smooth(&[c; 20], r).iter().all(|v| (v - c).abs() < 1e-9));
        }
    }
}
