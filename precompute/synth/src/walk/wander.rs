//! Intentions of the walker: a seeded sequence of steps that stands, starts, walks, turns and stops.

use super::gait::{StepShape, pivot_step, step_at, turning_step_at};
use crate::{deck::CardDeck, side::LateralSide};
use rand::{Rng, RngExt};

/// An intended step, relative to the previous one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intent {
    /// The foot that steps.
    pub side: LateralSide,
    /// Time of standing still before the step; 0 inside a walk (s).
    pub pause: f64,
    /// Change of the path's heading (rad).
    pub turn: f64,
    /// Sideways shift of the path to the left, beside its bend; 0 in walking (m).
    pub aside: f64,
    /// Distance between the feet across the path (m).
    pub width: f64,
    /// Outward turn of the foot from the path (rad).
    pub toe_out: f64,
    /// Length and timing.
    pub shape: StepShape,
}

/// Cruising speeds, from strolling to brisk. Few, so that poses recur (m/s).
pub const SPEEDS: [f64; 6] = [0.65, 0.95, 1.2, 1.35, 1.5, 1.75];
/// Heading changes to start with, in degrees; the last ones are made on the spot.
const FIRST_TURNS: [f64; 12] = [0.0, 0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0, 135.0, -135.0, 180.0, -180.0];
/// Turns on the way: mean heading change a step, and heading changes at it, in degrees; each to the left and to the
/// right. Long turns are not gentle, as they would take a long time with little variety.
const TURNS: [(f64, &[f64]); 3] = [
    (11.0, &[0.0, 0.0, 25.0, 50.0]),
    (22.0, &[45.0, 70.0, 90.0, 135.0]),
    (45.0, &[45.0, 70.0, 90.0, 120.0, 150.0, 180.0]),
];
/// Distance between the feet across the path in walking (m).
pub const WALKING_WIDTH: f64 = 0.115;
/// Outward turn of the feet (rad).
pub const TOE_OUT: f64 = 0.12;
/// Distance between the feet in standing (m).
pub const STANDING_WIDTH: f64 = 0.185;

/// Dealer of episodes: stand, start into a turn, walk, turn, walk, stop. One serves all clips of a set, so that turns
/// and speeds are spread evenly over the set.
pub struct Wanderer {
    speeds: CardDeck<f64>,
    first_turns: CardDeck<f64>,
    turns: CardDeck<(f64, f64)>,
    straights: CardDeck<usize>,
    legs: CardDeck<usize>,
    starters: CardDeck<LateralSide>,
    variation: f64,
}

impl Wanderer {
    /// A dealer whose steps vary by `variation` times the usual amount.
    pub fn new(variation: f64) -> Self {
        let both_ways =
            |(rate, angles): (f64, &[f64])| angles.iter().flat_map(|a| [(*a, rate), (-a, rate)]).collect::<Vec<_>>();
        Self {
            speeds: CardDeck::new(&SPEEDS),
            first_turns: CardDeck::new(&FIRST_TURNS),
            turns: CardDeck::new(&TURNS.map(both_ways).concat()),
            straights: CardDeck::new(&[0, 1, 1, 2, 2, 3, 3, 4, 5]),
            legs: CardDeck::new(&[1, 1, 1, 2, 2, 3, 4]),
            starters: CardDeck::new(&LateralSide::BOTH),
            variation,
        }
    }

    /// Steps for about `seconds` of wandering, from standing to standing.
    pub fn wander(&mut self, seconds: f64, rng: &mut impl Rng) -> Vec<Intent> {
        let mut walk = WalkSteps::new(self.variation);
        while walk.seconds < seconds {
            self.episode(&mut walk, rng);
        }
        walk.steps
    }

    /// Adds an episode: stand, set off, some legs of turning and walking, stop.
    fn episode(&mut self, walk: &mut WalkSteps, rng: &mut impl Rng) {
        walk.pause = rng.random_range(0.6..1.9);
        let first = self.first_turns.deal(rng).to_radians();
        let cruise = self.speeds.deal(rng);
        walk.next = if first == 0.0 { self.starters.deal(rng) } else { LateralSide::inside(first) };
        let on_the_spot = first.abs() > 1.8 || (first.abs() > 0.7 && rng.random_bool(0.5));
        if on_the_spot {
            walk.turn_in_place(first, rng);
            if rng.random_bool(0.45) {
                return;
            }
            walk.pause = if rng.random_bool(0.4) { rng.random_range(0.4..1.0) } else { 0.0 };
        }
        walk.start(cruise, if on_the_spot { 0.0 } else { first }, rng);
        for _ in 0..self.legs.deal(rng) {
            walk.straight(self.straights.deal(rng), cruise, rng);
            let (angle, rate) = self.turns.deal(rng);
            walk.turn(angle.to_radians(), rate.to_radians(), cruise, rng);
            if rng.random_bool(0.3) {
                walk.straight(2, self.speeds.deal(rng), rng);
            }
        }
        walk.straight(self.straights.deal(rng) / 2, cruise, rng);
        walk.stop(rng);
    }
}

/// Steps so far, with the initial state of the next one.
#[derive(Clone, Debug)]
pub struct WalkSteps {
    /// The steps.
    pub steps: Vec<Intent>,
    seconds: f64,
    /// The foot that steps next.
    pub next: LateralSide,
    /// Time of standing still before the next step (s).
    pub pause: f64,
    /// Speed (m/s).
    pub speed: f64,
    /// Factor on the usual variation.
    pub variation: f64,
}

impl WalkSteps {
    /// Begins standing, with the left foot next.
    pub fn new(variation: f64) -> Self {
        Self { steps: Vec::new(), seconds: 0.0, next: LateralSide::Left, pause: 0.0, speed: 0.0, variation }
    }

    /// Adds one step.
    pub fn step(&mut self, turn: f64, width: f64, shape: StepShape, rng: &mut impl Rng) {
        let mut vary = |amount: f64| 1.0 + self.variation * amount * rng.random_range(-1.0..1.0);
        let time = vary(0.025);
        let shape = StepShape {
            length: shape.length * vary(0.03),
            period: shape.period * time,
            double_support: shape.double_support * time,
        };
        let width = width * vary(0.06);
        let toe_out = TOE_OUT * vary(0.2);
        self.steps.push(Intent { side: self.next, pause: self.pause, turn, aside: 0.0, width, toe_out, shape });
        self.seconds += self.pause + shape.period;
        self.pause = 0.0;
        self.next = self.next.other();
    }

    /// Adds two steps up to `cruise`, turning by `turn` meanwhile.
    ///
    /// The first step covers about three quarters of the length (Breniere and Do 1986 find the steady state after one
    /// to three steps).
    pub fn start(&mut self, cruise: f64, turn: f64, rng: &mut impl Rng) {
        let mut left = turn;
        for part in [0.72, 0.92] {
            let bend = limit_turn(left, self.next, 0.75);
            left -= bend;
            let shape = turning_step_at(cruise, bend);
            let shape = StepShape { length: shape.length * part, period: (shape.period * 1.06).min(0.68), ..shape };
            self.step(bend, WALKING_WIDTH, shape, rng);
        }
        self.speed = cruise;
        self.turn(left, 0.6, cruise, rng);
    }

    /// Adds steps straight ahead, approaching `cruise`.
    pub fn straight(&mut self, num_steps: usize, cruise: f64, rng: &mut impl Rng) {
        for _ in 0..num_steps {
            self.speed += (cruise - self.speed).clamp(-0.35, 0.3);
            self.step(0.0, WALKING_WIDTH, step_at(self.speed), rng);
        }
    }

    /// Adds steps through a turn by `angle`, `rate` a step on average: more with the inner foot than with the outer.
    pub fn turn(&mut self, angle: f64, rate: f64, cruise: f64, rng: &mut impl Rng) {
        let mut left = angle;
        while left.abs() > 0.02 {
            let share = if self.next == LateralSide::inside(angle) { 1.25 } else { 0.75 };
            let bend = limit_turn(left, self.next, rate * share);
            left -= bend;
            // A small rest joins this step.
            let bend = if left.abs() < 0.08 { bend + std::mem::take(&mut left) } else { bend };
            // Sharp turns are slower.
            self.speed += (cruise.min(1.75 - 1.05 * rate) - self.speed).clamp(-0.35, 0.3);
            self.step(bend, WALKING_WIDTH, turning_step_at(self.speed, bend), rng);
        }
    }

    /// Adds a shorter step, and one that closes the feet.
    pub fn stop(&mut self, rng: &mut impl Rng) {
        let shape = step_at(self.speed);
        if self.speed > 1.1 {
            self.step(0.0, WALKING_WIDTH, StepShape { length: shape.length * 0.88, ..shape }, rng);
        }
        let period = shape.period.clamp(0.52, 0.64);
        let slowing = StepShape { length: shape.length * 0.62, period, double_support: 0.15 };
        self.step(0.0, 0.5 * (WALKING_WIDTH + STANDING_WIDTH), slowing, rng);
        let stagger = self.variation * rng.random_range(-0.02..0.02);
        let closing = StepShape { length: stagger, period: 0.6, double_support: 0.17 };
        self.step(0.0, STANDING_WIDTH, closing, rng);
        self.speed = 0.0;
    }

    /// Adds steps on the spot: the inner foot opens, the outer one follows, and the feet end side by side.
    pub fn turn_in_place(&mut self, angle: f64, rng: &mut impl Rng) {
        let opening = if angle.abs() > 1.2 { 1.1 } else { 0.85 };
        let mut left = angle;
        let mut apart = 0.0;
        while left.abs() > 0.03 || f64::abs(apart) > 0.03 {
            let inner = self.next == LateralSide::inside(angle);
            let most = if inner { opening } else { 0.3 };
            let bend = left.clamp(-most, most);
            self.step(bend, STANDING_WIDTH, pivot_step(bend + apart), rng);
            left -= bend;
            apart = bend;
        }
        self.speed = 0.0;
    }
}

/// Heading change limited to `most` and to what the hips allow for the stepping foot: opening is easier than crossing.
pub fn limit_turn(turn: f64, foot: LateralSide, most: f64) -> f64 {
    let most = most.min(if foot == LateralSide::inside(turn) { 0.9 } else { 0.55 });
    turn.clamp(-most, most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    #[test]
    fn feet_alternate_inside_a_walk() {
        let steps = Wanderer::new(1.0).wander(120.0, &mut Pcg64Mcg::seed_from_u64(1));
        for w in steps.windows(2) {
            assert!(w[1].pause > 0.0 || w[1].side != w[0].side);
        }
    }

    #[test]
    fn no_step_turns_further_than_hips_can() {
        let steps = Wanderer::new(1.0).wander(600.0, &mut Pcg64Mcg::seed_from_u64(2));
        for s in &steps {
            let most = if s.side == LateralSide::inside(s.turn) { 1.11 } else { 0.64 };
            assert!(s.turn.abs() <= most, "{s:?}");
        }
    }
}
