//! Walking along a curve that avoids furniture.

use super::script::{MotionScript, ScriptStep};
use crate::side::{LateralSide, forward};
use crate::walk::gait::{StepShape, step_at, turning_step_at};
use crate::walk::wander::{STANDING_WIDTH, TOE_OUT, WALKING_WIDTH, limit_turn};
use crate::{signal::interpolate, walk::footsteps::FeetStance};
use glam::DVec2;
use rand::{Rng, RngExt};
use std::ops::Range;
use throng_core::planar::wrap_angle;

/// A cubic Bezier curve on the ground.
#[derive(Clone, Copy, Debug)]
struct GroundCurve([DVec2; 4]);

/// Number of random curves among which the best is walked.
const TRIES: usize = 32;
/// Number of sample points on a curve.
const POINTS: usize = 48;
/// Largest curvature of a path without penalty (rad/m).
const BENDING: f64 = 1.1;

impl GroundCurve {
    fn from_ends(from: DVec2, depart: f64, to: DVec2, arrive: f64) -> Self {
        let reach = 0.36 * (to - from).length();
        Self([from, from + forward(depart) * reach, to - forward(arrive) * reach, to])
    }

    fn position(&self, u: f64) -> DVec2 {
        let [a, b, c, d] = self.0;
        let v = 1.0 - u;
        a * (v * v * v) + b * (3.0 * v * v * u) + c * (3.0 * v * u * u) + d * (u * u * u)
    }

    fn heading(&self, u: f64) -> f64 {
        let offset = self.position((u + 0.01).min(1.0)) - self.position((u - 0.01).max(0.0));
        offset.x.atan2(offset.y)
    }

    /// Points spaced evenly in the parameter, with the distance travelled so far.
    fn lengths(&self) -> Vec<(f64, f64)> {
        let (mut gone, mut last) = (0.0, self.0[0]);
        let point = |k: usize| {
            let u = k as f64 / POINTS as f64;
            let at = self.position(u);
            gone += (at - std::mem::replace(&mut last, at)).length();
            (gone, u)
        };
        (0..=POINTS).map(point).collect()
    }

    /// Penalty of a curve: furniture in the way, and sharp bends.
    fn penalty(&self, blocked: Obstacles) -> f64 {
        let lengths = self.lengths();
        let in_the_way: f64 = lengths.iter().map(|(_, u)| blocked(self.position(*u))).sum();
        let bend = lengths.windows(2).map(|w| {
            let turn = wrap_angle((self.heading(w[1].1) - self.heading(w[0].1)) as f32).abs();
            (f64::from(turn) - BENDING * (w[1].0 - w[0].0)).max(0.0)
        });
        20.0 * in_the_way + bend.sum::<f64>()
    }
}

/// Goal of a walk.
pub struct GroundGoal {
    /// Position (m).
    pub at: DVec2,
    /// Acceptable headings of the last step (rad).
    pub arrive: Range<f64>,
    /// Speed of walking (m/s).
    pub cruise: f64,
}

/// Depth of a point in obstacles (m).
type Obstacles = fn(DVec2) -> f64;

/// Walks from a stand to a stand.
///
/// - returns the time at which the first foot leaves the ground (s).
pub fn walk_route(script: &mut MotionScript, goal: &GroundGoal, blocked: Obstacles, rng: &mut impl Rng) -> f64 {
    let from = script.stance;
    let curve = choose(from, goal, blocked, rng);
    let began = script.next_lift();
    let first = turn_to(from.heading, curve.heading(0.0));
    if first.abs() > 0.8 {
        script.turn_in_place(first);
        if rng.random_bool(0.3) {
            script.wait_until(script.now + rng.random_range(0.2..0.6));
        }
    }
    follow_curve(script, &curve, goal.cruise, rng);
    began
}

fn turn_to(from: f64, to: f64) -> f64 {
    f64::from(wrap_angle((to - from) as f32))
}

fn choose(from: FeetStance, goal: &GroundGoal, blocked: Obstacles, rng: &mut impl Rng) -> GroundCurve {
    let offset = goal.at - from.at;
    let direct = offset.x.atan2(offset.y);
    let mut best = (f64::INFINITY, GroundCurve::from_ends(from.at, direct, goal.at, direct));
    for _ in 0..TRIES {
        let depart = direct + rng.random_range(-1.2..1.2);
        let arrive = rng.random_range(goal.arrive.clone());
        let curve = GroundCurve::from_ends(from.at, depart, goal.at, arrive);
        let taste = rng.random_range(0.0..0.25) + 0.1 * turn_to(from.heading, depart).abs();
        let penalty = curve.penalty(blocked) + taste;
        if penalty < best.0 {
            best = (penalty, curve);
        }
    }
    best.1
}

/// Lengths of the steps, as shares of the usual length: two to start, one to slow down.
fn shares(distance: f64, usual: f64) -> Vec<f64> {
    let mut shares = vec![0.72, 0.62];
    while shares.iter().sum::<f64>() * usual < distance - 0.45 * usual {
        let last = shares.len() - 1;
        shares.insert(last, if shares.len() == 2 { 0.92 } else { 1.0 });
    }
    let total: f64 = shares.iter().sum();
    shares.iter().map(|s| s / total).collect()
}

/// Steps along a curve, and stops at its end, feet side by side.
fn follow_curve(script: &mut MotionScript, curve: &GroundCurve, cruise: f64, rng: &mut impl Rng) {
    let lengths = curve.lengths();
    let distance = lengths[POINTS].0;
    let shares = shares(distance, step_at(cruise).length);
    let turn = turn_to(script.stance.heading, curve.heading(0.15));
    let inside = if turn.abs() < 0.1 && rng.random_bool(0.5) { LateralSide::Right } else { LateralSide::inside(turn) };
    let mut side = script.free_foot().unwrap_or(inside);
    let mut gone = 0.0;
    for (k, share) in shares.iter().enumerate() {
        gone += share * distance;
        let u = interpolate(&lengths, gone);
        let here = script.stance;
        let bend = limit_turn(turn_to(here.heading, curve.heading(u)), side, 0.75);
        let to = FeetStance { at: curve.position(u), heading: here.heading + bend };
        let last = k + 1 == shares.len();
        let shape = shape(cruise, bend, k < 2, last);
        let period = shape.period * (1.0 + script.random_offset(0.025, rng));
        let width = if last { 0.5 * (WALKING_WIDTH + STANDING_WIDTH) } else { WALKING_WIDTH };
        let toe_out = TOE_OUT * (1.0 + script.random_offset(0.2, rng));
        script.step(ScriptStep { side, to, width, toe_out, period, double_support: shape.double_support });
        side = side.other();
    }
    let here = script.stance;
    let rest = limit_turn(turn_to(here.heading, curve.heading(1.0)), side, 0.75);
    let to = FeetStance { at: here.at, heading: here.heading + rest };
    script.step(ScriptStep { double_support: 0.17, ..ScriptStep::aside(side, to) });
}

/// Timing of a walking step.
fn shape(cruise: f64, bend: f64, starts: bool, stops: bool) -> StepShape {
    let usual = turning_step_at(cruise, bend);
    if stops {
        StepShape { period: usual.period.clamp(0.52, 0.64), double_support: 0.15, ..usual }
    } else if starts {
        StepShape { period: (usual.period * 1.06).min(0.68), ..usual }
    } else {
        usual
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    #[test]
    fn a_walk_ends_where_it_should_and_goes_around_what_is_in_the_way() {
        let mut rng = Pcg64Mcg::seed_from_u64(5);
        let obstacle = |p: DVec2| (0.3 - p.distance(DVec2::new(0.1, 1.2))).max(0.0);
        for k in 0..20 {
            let mut script = MotionScript::new(FeetStance { at: DVec2::ZERO, heading: 0.3 * f64::from(k) }, 1.0);
            let goal = GroundGoal { at: DVec2::new(0.0, 2.4), arrive: -1.0..1.0, cruise: 1.0 };
            walk_route(&mut script, &goal, obstacle, &mut rng);
            let end = script.stance;
            assert!(end.at.distance(goal.at) < 1e-6, "{end:?}");
            let (mut at, mut deepest) = (script.start, 0.0f64);
            for step in &script.steps {
                at = at.after_step(step);
                deepest = deepest.max(obstacle(at.at));
                assert!(step.shape.length.hypot(step.aside) < 0.85, "{step:?}");
            }
            assert!(deepest < 0.05, "{deepest}");
        }
    }
}
