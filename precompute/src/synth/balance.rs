//! The centre of mass, balanced over the feet as a linear inverted pendulum.
//!
//! The centre of pressure follows from where the feet stand and how the weight moves from one to the other; the
//! pendulum turns it into a centre of mass that sways over the standing foot, shifts before the first step, speeds
//! up and slows down within each step, and leans into starts, stops and turns, all without a rule for any of them.

use super::foot::{FootShape, Footfall};
use super::footsteps::Footsteps;
use super::side::{Side, forward};
use super::signal::interpolate;
use glam::DVec2;

/// Natural frequency of the pendulum. A pendulum of the hips' height has 3.2; sway and anticipation of people,
/// who also use their ankles and arms, fit a stiffer one. [Unit: rad/s]
const FREQUENCY: f64 = 3.9;

/// The centre of mass on the ground plane (x, z) at every sample. [Unit: m]
///
/// # Source
/// Kajita et al. 2001, *The 3D linear inverted pendulum mode*: `x'' = w^2 (x - p)`. Instead of stepping it forward
/// in time, which is unstable, the whole clip is solved at once as a boundary value problem (a tridiagonal system)
/// that starts and ends at rest over the feet.
pub fn centre_of_mass(steps: &Footsteps, shape: &FootShape, times: &[f64], dt: f64) -> Vec<DVec2> {
    let pressure: Vec<DVec2> = times.iter().map(|&t| centre_of_pressure(steps, shape, t)).collect();
    pendulum(&pressure, dt)
}

fn centre_of_pressure(steps: &Footsteps, shape: &FootShape, t: f64) -> DVec2 {
    let under = |side: Side| {
        let falls = steps.feet[side.index()].falls();
        let i = falls.partition_point(|f| f.land <= t).saturating_sub(1);
        pressure_under(&falls[i], shape, t)
    };
    let share = interpolate(&steps.load, t);
    under(Side::Left) * share + under(Side::Right) * (1.0 - share)
}

/// The pressure under one foot moves from the heel over the middle, where it stays in standing, to the ball.
fn pressure_under(fall: &Footfall, shape: &FootShape, t: f64) -> DVec2 {
    const ROLL: f64 = 0.25;
    let flat = fall.flat + 0.05;
    let mut knots = vec![(fall.land, -0.1 * shape.ball), (flat, 0.35 * shape.ball)];
    if fall.lift.is_finite() {
        let leave = fall.heel_off.max(flat + 0.01);
        if leave - ROLL > flat {
            knots.push((leave - ROLL, 0.35 * shape.ball));
        }
        knots.extend([(leave, 0.7 * shape.ball), (fall.lift.max(leave + 0.01), shape.ball)]);
    }
    fall.ankle + forward(fall.yaw) * interpolate(&knots, t)
}

/// Solves `x - x''/w^2 = p` with `x' = 0` at both ends (Thomas algorithm).
fn pendulum(p: &[DVec2], dt: f64) -> Vec<DVec2> {
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
