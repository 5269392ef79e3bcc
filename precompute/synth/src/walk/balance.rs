//! The centre of mass, balanced over the feet as a linear inverted pendulum.
//!
//! The centre of pressure follows from the stance of the feet and the transfer of weight between them; the pendulum
//! turns it into a centre of mass that sways over the standing foot, shifts before the first step, speeds up and slows
//! down within each step, and leans into starts, stops and turns, without further rules.

use super::super::foot::FootShape;
use super::super::frame::Samples;
use super::super::pendulum::pendulum;
use super::super::side::{LateralSide, forward};
use super::super::signal::interpolate;
use super::footsteps::Footsteps;
use super::roll::Footfall;
use glam::DVec2;

/// The centre of mass on the ground plane (x, z) at every sample (m).
pub fn centre_of_mass(steps: &Footsteps, shape: &FootShape, samples: &Samples) -> Vec<DVec2> {
    let pressure: Vec<DVec2> = samples.times.iter().map(|&t| centre_of_pressure(steps, shape, t)).collect();
    pendulum(&pressure, samples.dt)
}

fn centre_of_pressure(steps: &Footsteps, shape: &FootShape, t: f64) -> DVec2 {
    let under = |side: LateralSide| {
        let falls = &steps.feet[side.index()].falls;
        let i = falls.partition_point(|f| f.land <= t).saturating_sub(1);
        pressure_under(&falls[i], shape, t)
    };
    let share = interpolate(&steps.load, t);
    under(LateralSide::Left) * share + under(LateralSide::Right) * (1.0 - share)
}

/// Pressure under one foot, which moves from the heel over the middle, where it stays in standing, to the ball.
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
