//! Linear inverted pendulum: the centre of mass for a given centre of pressure.

use glam::DVec2;

/// Natural frequency of the pendulum. A pendulum of the hips' height has 3.2; human sway and anticipation,
/// with ankles and arms at work, fit a stiffer one (rad/s).
pub const FREQUENCY: f64 = 3.9;

/// Centre of mass over a centre of pressure: solves `x - x''/w^2 = p` with `x' = 0` at both ends (Thomas algorithm).
///
/// # Source
/// Kajita et al. 2001, *The 3D linear inverted pendulum mode*: `x'' = w^2 (x - p)`. Instead of stepping it forward
/// in time, which is unstable, the whole clip is solved at once as a boundary value problem (a tridiagonal system)
/// that starts and ends at rest over the feet.
pub fn pendulum(p: &[DVec2], dt: f64) -> Vec<DVec2> {
    let n = p.len();
    let k = 1.0 / (FREQUENCY * dt).powi(2);
    let mut upper = vec![0.0; n];
    let mut x = p.to_vec();
    for i in 0..n {
        let (below, above) = (if i > 0 { k } else { 0.0 }, if i + 1 < n { k } else { 0.0 });
        let (last_upper, last_x) = if i > 0 { (upper[i - 1], x[i - 1]) } else { (0.0, DVec2::ZERO) };
        let pivot = 1.0 + below + above - below * last_upper;
        upper[i] = above / pivot;
        x[i] = (x[i] + last_x * below) / pivot;
    }
    for i in (0..n.saturating_sub(1)).rev() {
        x[i] = x[i] + x[i + 1] * upper[i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pendulum_rests_over_a_resting_pressure() {
        let p = vec![DVec2::new(0.3, -2.0); 50];
        assert!(pendulum(&p, 0.01).iter().all(|x| (*x - p[0]).length() < 1e-9));
    }

    #[test]
    fn pendulum_obeys_its_equation() {
        let dt = 1.0 / 120.0;
        let p: Vec<_> = (0..400).map(|i| DVec2::new((f64::from(i) * 0.05).sin(), f64::from(i / 100))).collect();
        let x = pendulum(&p, dt);
        for i in 1..p.len() - 1 {
            let a = (x[i - 1] - 2.0 * x[i] + x[i + 1]) / (dt * dt);
            assert!((a - (x[i] - p[i]) * FREQUENCY * FREQUENCY).length() < 1e-6);
        }
    }
}
