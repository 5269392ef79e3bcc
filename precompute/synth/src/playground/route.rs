//! Walks that end at an exact place and heading: before the stairs, a ladder, a slide.
//!
//! The walker's own steps and turns are kept. Of many possible paths, each of straight legs and turns, the one is taken
//! whose straight steps have to be stretched least for the last step to arrive.

use super::gym::{self, Stairs};
use crate::side::{LateralSide, forward};
use crate::walk::footsteps::{FeetStance, timing};
use crate::walk::gait::{StepShape, step_at};
use crate::walk::wander::{Intent, SPEEDS, TOE_OUT, WALKING_WIDTH, WalkSteps};
use glam::{DMat2, DVec2};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::{f64::consts::PI, ops::Range};
use throng_core::planar::wrap_angle;

/// Largest stretch of steps, as a share of their length.
const STRETCH: f64 = 0.22;

/// Penalty of every step, so that detours are short.
const STEP_PENALTY: f64 = 0.06;

/// End of a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WalkEnding {
    /// Stops and stands.
    Stand,
    /// Ends walking, about to go on.
    Pass,
}

/// A walk, with its path so far.
#[derive(Clone, Debug)]
pub struct WalkRoute {
    /// Initial stance.
    pub start: FeetStance,
    /// Current stance of the path.
    pub at: FeetStance,
    /// The steps.
    pub walk: WalkSteps,
    /// Runs of steps on stairs.
    pub stairs: Vec<Range<usize>>,
    cruise: f64,
}

/// Penalty function of places on a path, 0 for free ones.
pub type PathPenalty<'a> = &'a dyn Fn(DVec2) -> f64;

impl WalkRoute {
    /// A walk that begins standing.
    pub fn standing_at(start: FeetStance, variation: f64, rng: &mut impl Rng) -> Self {
        let cruise = SPEEDS[rng.random_range(1..5)];
        let mut walk = WalkSteps::new(variation);
        walk.pause = rng.random_range(0.5..1.4);
        Self { start, at: start, walk, stairs: Vec::new(), cruise }
    }

    /// True before the first step and after a stop.
    pub fn is_standing(&self) -> bool {
        self.walk.speed == 0.0
    }

    /// Duration so far (s).
    pub fn seconds(&self) -> f64 {
        self.walk.steps.iter().fold(0.0, |last, step| timing(step, last).1)
    }

    /// Stance after the steps since `first`.
    fn stance_after(&self, first: usize) -> FeetStance {
        self.walk.steps[first..].iter().fold(self.at, |at, step| at.after_step(step))
    }

    /// Turns by an angle: on the spot or into the first steps from a stand, on the way otherwise.
    fn turn_by(&mut self, angle: f64, rng: &mut impl Rng) {
        if !self.is_standing() {
            self.walk.turn(angle, rng.random_range(0.3..0.6), self.cruise, rng);
            return;
        }
        self.walk.next = LateralSide::inside(angle);
        if angle.abs() > 1.0 {
            self.walk.turn_in_place(angle, rng);
            self.walk.start(self.cruise, 0.0, rng);
        } else {
            self.walk.start(self.cruise, angle, rng);
        }
    }

    /// Walks to a place and heading. If passing there is impossible, it stops there.
    ///
    /// - `against`: penalty of places on the path; a stretch of all steps by a tenth counts 0.1.
    pub fn walk_to(&mut self, goal: FeetStance, arrival: WalkEnding, against: PathPenalty, rng: &mut impl Rng) {
        let seed = rng.random();
        let plans = plans(self.at, goal, arrival, step_at(self.cruise).length);
        let routes = plans.map(|plan| self.try_plan(&plan, goal, against, seed));
        if let Some((_, route)) = routes.reduce(|best, next| if next.0 < best.0 { next } else { best }) {
            *self = route;
        }
    }

    /// Tries a plan of arrival; returns its penalty and the resulting walk.
    fn try_plan(&self, plan: &ArrivalPlan, goal: FeetStance, against: PathPenalty, seed: u64) -> (f64, Self) {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut route = self.clone();
        let begin = route.walk.steps.len();
        let mut groups = [begin..begin, begin..begin];
        route.turn_by(plan.first, &mut rng);
        let walk = &mut route.walk;
        groups[0].start = if self.is_standing() { walk.steps.len() - 2 } else { walk.steps.len() };
        walk.straight(plan.steps[0], self.cruise, &mut rng);
        groups[0].end = walk.steps.len();
        walk.turn(plan.second, plan.rate, self.cruise, &mut rng);
        groups[1].start = walk.steps.len();
        walk.straight(plan.steps[1], self.cruise, &mut rng);
        if plan.arrival == WalkEnding::Stand {
            walk.stop(&mut rng);
        }
        groups[1].end = walk.steps.len();
        if plan.last != 0.0 {
            walk.next = LateralSide::inside(plan.last);
            walk.pause = rng.random_range(0.1..0.5);
            walk.turn_in_place(plan.last, &mut rng);
        }
        let cost = route.stretch_to(begin, &groups, goal, against);
        (cost + 0.02 * (plan.first.abs() + plan.second.abs()) + plan.cost, route)
    }

    /// Stretches the steps of two groups so that the last one arrives; returns the penalty of stretching and of the
    /// path.
    fn stretch_to(&mut self, begin: usize, groups: &[Range<usize>; 2], goal: FeetStance, against: PathPenalty) -> f64 {
        self.straighten(begin, groups[1].start, goal.heading);
        let end = self.stance_after(begin).at;
        let [a, b] = [0, 1].map(|g: usize| self.travel(begin, &groups[g]));
        let missing = DMat2::from_cols(a, b);
        let stretch = if missing.determinant().abs() < 1e-3 {
            let both = a + b;
            DVec2::splat((goal.at - end).dot(both) / both.length_squared().max(1e-6))
        } else {
            missing.inverse() * (goal.at - end)
        };
        for (group, stretch) in groups.iter().zip(stretch.to_array()) {
            self.walk.steps[group.clone()].iter_mut().for_each(|step| step.shape.length *= 1.0 + stretch);
        }
        let mut cost = stretch.to_array().iter().map(|s| s.abs() + 50.0 * (s.abs() - STRETCH).max(0.0)).sum::<f64>();
        let mut at = self.at;
        for step in &self.walk.steps[begin..] {
            at = at.after_step(step);
            cost += STEP_PENALTY + against(at.at);
        }
        cost += 1e4 * (at.at - goal.at).length();
        self.at = FeetStance { at: at.at, heading: goal.heading };
        cost
    }

    /// Adds the remaining heading error of turns to the last of them.
    fn straighten(&mut self, begin: usize, last: usize, heading: f64) {
        let end = self.stance_after(begin).heading;
        if let Some(step) = self.walk.steps[..last].last_mut() {
            step.turn += f64::from(wrap_angle((heading - end) as f32));
        }
    }

    /// Displacement by the steps of a group.
    fn travel(&self, begin: usize, group: &Range<usize>) -> DVec2 {
        let (mut at, mut sum) = (self.at, DVec2::ZERO);
        for (i, step) in self.walk.steps.iter().enumerate().skip(begin) {
            let next = at.after_step(step);
            sum += if group.contains(&i) { next.at - at.at } else { DVec2::ZERO };
            at = next;
        }
        sum
    }

    /// Takes a flight of stairs, one step to every place, and stops and stands behind it now and then.
    fn stairs(&mut self, steps: impl Iterator<Item = FeetStance>, period: f64, rng: &mut impl Rng) {
        let first = self.walk.steps.len();
        for step in steps {
            let offset = step.at - self.at.at;
            let ahead = forward(step.heading);
            let period = period * (1.0 + self.walk.variation * rng.random_range(-0.04..0.04));
            let shape = StepShape { length: offset.dot(ahead), period, double_support: 0.26 * period };
            let turn = f64::from(wrap_angle((step.heading - self.at.heading) as f32));
            let (side, pause) = (self.walk.next, std::mem::take(&mut self.walk.pause));
            let width = WALKING_WIDTH + 0.03;
            self.walk.steps.push(Intent { side, pause, turn, aside: 0.0, width, toe_out: TOE_OUT, shape });
            self.walk.next = side.other();
            self.at = FeetStance { at: self.at.at + ahead * shape.length, heading: self.at.heading + turn };
        }
        let end = self.walk.steps.len();
        self.stairs.push(first..end);
        self.walk.speed = 0.5;
        if rng.random_bool(0.5) {
            self.walk.stop(rng);
            self.at = self.stance_after(end);
            self.walk.pause = rng.random_range(0.6..2.2);
        }
    }

    /// Turns round on the spot, and stands.
    pub fn turn_round(&mut self, rng: &mut impl Rng) {
        let first = self.walk.steps.len();
        let angle = if rng.random_bool(0.5) { PI } else { -PI };
        self.walk.pause = rng.random_range(0.2..0.8);
        self.walk.next = LateralSide::inside(angle);
        self.walk.turn_in_place(angle, rng);
        self.at = self.stance_after(first);
    }

    /// Climbs stairs from their foot.
    pub fn climb(&mut self, stairs: &Stairs, aside: f64, rng: &mut impl Rng) {
        let period = rng.random_range(0.56..0.68);
        self.stairs((1..=stairs.num_steps).map(|k| gym::tread_up(stairs, aside, k)), period, rng);
    }

    /// Goes down stairs from their upper end.
    pub fn descend(&mut self, stairs: &Stairs, aside: f64, rng: &mut impl Rng) {
        let period = rng.random_range(0.54..0.64);
        self.stairs((1..=stairs.num_steps + 1).map(|k| gym::tread_down(stairs, aside, k)), period, rng);
    }
}

/// A plan of arrival: a turn, straight steps, another turn, straight steps, and possibly a last turn on the spot.
struct ArrivalPlan {
    first: f64,
    second: f64,
    rate: f64,
    steps: [usize; 2],
    arrival: WalkEnding,
    last: f64,
    /// Penalty of the plan.
    cost: f64,
}

/// Plans from a stance that come near another one. If passing is too hard, it may stand.
///
/// - `length`: length of a step (m).
fn plans(from: FeetStance, goal: FeetStance, arrival: WalkEnding, length: f64) -> impl Iterator<Item = ArrivalPlan> {
    const BENDS: [f64; 15] = [0.0, 0.15, -0.15, 0.3, -0.3, 0.5, -0.5, 0.75, -0.75, 1.0, -1.0, 1.3, -1.3, 1.6, -1.6];
    const LAST: [f64; 6] = [1.0, -1.0, 1.8, -1.8, 2.6, -2.6];
    let stop = if arrival == WalkEnding::Stand { 0.0 } else { 0.6 };
    let rates = move |bend: f64| {
        let walked = [0.35, 0.6].map(|rate| (bend, rate, arrival, 0.0, 0.0));
        let spot = LAST.map(|last| (bend, 0.45, WalkEnding::Stand, last, 0.12 + stop));
        walked.into_iter().chain(spot).chain([(bend, 0.45, WalkEnding::Stand, 0.0, stop)])
    };
    let offset = goal.at - from.at;
    let distance = offset.length();
    let towards = f64::from(wrap_angle((offset.x.atan2(offset.y) - from.heading) as f32));
    let (most, least) = ((distance / length) as usize + 4, ((distance / length) as usize).saturating_sub(5));
    BENDS.into_iter().flat_map(rates).flat_map(move |(bend, rate, arrival, last, cost)| {
        let first = f64::from(wrap_angle((towards + bend) as f32));
        let second = f64::from(wrap_angle((goal.heading - last - from.heading - first) as f32));
        let counts = (0..=most).flat_map(move |a| (0..=(most - a).min(6)).map(move |b| [a, b]));
        let likely = counts.filter(move |[a, b]| a + b >= least);
        likely.map(move |steps| ArrivalPlan { first, second, rate, steps, arrival, last, cost })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrives_exactly_from_anywhere() {
        for seed in 0..30u64 {
            let mut rng = Pcg64Mcg::seed_from_u64(seed);
            let from = FeetStance {
                at: DVec2::new(rng.random_range(-4.0..4.0), rng.random_range(-4.0..4.0)),
                heading: rng.random_range(-3.0..3.0),
            };
            let goal = FeetStance { at: DVec2::new(0.0, 6.0), heading: rng.random_range(-3.0..3.0) };
            let mut route = WalkRoute::standing_at(from, 1.0, &mut rng);
            let arrival = if seed % 2 == 0 { WalkEnding::Stand } else { WalkEnding::Pass };
            route.walk_to(goal, arrival, &|_| 0.0, &mut rng);
            let end = route.walk.steps.iter().fold(from, |at, s| at.after_step(s));
            assert!((end.at - goal.at).length() < 1e-9, "seed {seed}: {end:?}");
            assert!(wrap_angle((end.heading - goal.heading) as f32).abs() < 1e-6, "seed {seed}: {end:?}");
            for step in &route.walk.steps {
                assert!(step.shape.length < 1.0 && step.shape.length > -0.1, "seed {seed}: {step:?}");
            }
        }
    }
}
