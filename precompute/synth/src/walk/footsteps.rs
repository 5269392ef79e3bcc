//! Placement of intended steps on the ground and in time: footfalls of both feet, and their shares of the weight.

use super::wander::{Intent, STANDING_WIDTH, TOE_OUT};
use super::{foot::FootTrack, roll::Footfall};
use crate::foot::FootShape;
use crate::side::{LateralSide, forward, leftward};
use glam::DVec2;
use rand::{Rng, RngExt};

/// Time to bring the weight onto one foot before the first step after a pause (s).
pub const SHIFT: f64 = 0.5;
/// Time to come to rest on both feet after the last step (s).
const SETTLING_S: f64 = 0.45;
/// Duration of the stand at the end of a clip (s).
pub const LAST_STAND: f64 = 1.6;

/// Both feet over a whole clip.
pub struct Footsteps {
    /// Tracks of the left and the right foot.
    pub feet: [FootTrack; 2],
    /// Share of the weight on the left foot as `(time, share)` knots.
    pub load: Vec<(f64, f64)>,
    /// Length of the clip (s).
    pub duration: f64,
}

/// Stance of a pair of feet side by side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FeetStance {
    /// Midpoint of the ankles on the ground plane (x, z) (m).
    pub at: DVec2,
    /// Heading (rad).
    pub heading: f64,
}

impl FeetStance {
    /// Stance after a step: the path bends evenly over the step, and is moved aside.
    pub fn after_step(self, step: &Intent) -> Self {
        let along = self.heading + 0.5 * step.turn;
        let at = self.at + forward(along) * step.shape.length + leftward(along) * step.aside;
        Self { at, heading: self.heading + step.turn }
    }

    /// Ankle of a foot, `width` metres from the other one (m).
    pub fn ankle(self, side: LateralSide, width: f64) -> DVec2 {
        self.at + leftward(self.heading) * (0.5 * width * side.sign())
    }
}

/// Lift and landing of a step, given the previous landing (s).
pub fn timing(step: &Intent, last: f64) -> (f64, f64) {
    let wait = if step.pause > 0.0 { step.pause + SHIFT } else { step.shape.double_support };
    (last + wait, last + wait + step.shape.swing())
}

/// A step with its time and place.
struct PlacedStep<'a> {
    intent: &'a Intent,
    lift: f64,
    land: f64,
    ankle: DVec2,
    heading: f64,
}

/// Places steps from a stand, followed by a stand of `last` seconds.
///
/// - `ground`: height anywhere on the path (m).
pub fn place_footsteps(
    shape: FootShape,
    start: FeetStance,
    intents: &[Intent],
    last: f64,
    ground: impl Fn(DVec2) -> f64,
    rng: &mut impl Rng,
) -> Footsteps {
    let placed = place_steps(start, intents);
    let duration = placed.last().map_or(0.0, |s| s.land) + last;
    let mut falls = LateralSide::BOTH.map(|side| falls_of(side, start, &placed));
    falls.iter_mut().for_each(|falls| step_on(falls, &shape, &ground));
    let feet = FootTrack::pair(shape, falls, &ground);
    Footsteps { feet, load: load_knots(&placed, duration, rng), duration }
}

/// Time and place of every step's landing.
fn place_steps(start: FeetStance, intents: &[Intent]) -> Vec<PlacedStep<'_>> {
    let (mut stance, mut last) = (start, 0.0);
    let mut out = Vec::with_capacity(intents.len());
    for intent in intents {
        stance = stance.after_step(intent);
        let (lift, land) = timing(intent, last);
        last = land;
        let ankle = stance.ankle(intent.side, intent.width);
        out.push(PlacedStep { intent, lift, land, ankle, heading: stance.heading });
    }
    out
}

/// Footfalls of one foot, from the stand before the first step to the stand after the last one.
fn falls_of(side: LateralSide, start: FeetStance, placed: &[PlacedStep]) -> Vec<Footfall> {
    let yaw = |heading: f64, toe_out: f64| heading + toe_out * side.sign();
    let mut falls =
        vec![Footfall::standing(0.0, start.ankle(side, STANDING_WIDTH), start.heading, yaw(start.heading, TOE_OUT))];
    for (k, step) in placed.iter().enumerate().filter(|(_, s)| s.intent.side == side) {
        let ahead = forward(step.heading);
        let other = placed[..k].iter().rev().find(|s| s.intent.side != side);
        let other = other.map_or(start.ankle(side.other(), STANDING_WIDTH), |s| s.ankle);
        // The foot leaves its last footfall for this one.
        if let Some(fall) = falls.last_mut() {
            let travel = (step.ankle - fall.ankle).dot(forward(fall.heading));
            fall.lift = step.lift;
            fall.heel_off = (step.lift - 0.46 * step.intent.shape.period).max(fall.flat + 0.02);
            fall.push = 0.2 + 0.5 * (travel.max(0.0) / 1.45).min(1.0);
        }
        let reach = (step.ankle - other).dot(ahead);
        falls.push(Footfall {
            land: step.land,
            flat: step.land + (0.15 * step.intent.shape.period).clamp(0.07, 0.1),
            strike: 0.36 * (reach / 0.75).clamp(0.03, 1.0),
            ..Footfall::standing(step.land, step.ankle, step.heading, yaw(step.heading, step.intent.toe_out))
        });
    }
    falls
}

/// Raises the footfalls of one foot to the ground; they land flat on the way up and on the ball on the way down.
fn step_on(falls: &mut [Footfall], shape: &FootShape, ground: &impl Fn(DVec2) -> f64) {
    for i in 0..falls.len() {
        let fall = falls[i];
        falls[i].ground = ground(fall.ankle + forward(fall.yaw) * shape.ball);
        let rise = falls[i].ground - falls[i.saturating_sub(1)].ground;
        if rise > 0.05 {
            falls[i].strike = 0.02;
        } else if rise < -0.05 {
            falls[i].strike = -0.32;
        }
    }
}

/// Share of the left foot: 0 while it is in the air, 1 while the right one is, and in between linear, or standing on
/// both with occasional shifts of the weight.
fn load_knots(placed: &[PlacedStep], duration: f64, rng: &mut impl Rng) -> Vec<(f64, f64)> {
    let share_on = |side: LateralSide| if side == LateralSide::Left { 1.0 } else { 0.0 };
    let mut knots = vec![(0.0, 0.5)];
    let mut last = 0.0;
    for step in placed {
        let carried = share_on(step.intent.side.other());
        stand_knots(&mut knots, last, step.lift - SHIFT, rng);
        knots.extend([(step.lift, carried), (step.land, carried)]);
        last = step.land;
    }
    stand_knots(&mut knots, last, duration, rng);
    knots
}

/// Weight shifts of a stand between two times; none if it is too short.
fn stand_knots(knots: &mut Vec<(f64, f64)>, from: f64, to: f64, rng: &mut impl Rng) {
    let mut t = from + SETTLING_S;
    while t < to {
        knots.push((t, 0.5 + rng.random_range(-0.14..0.14)));
        t += rng.random_range(0.9..1.5);
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::signal::interpolate;
    use super::super::wander::Wanderer;
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;
    use throng_core::Skeleton;

    fn footsteps(seed: u64) -> Footsteps {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let intents = Wanderer::new(1.0).wander(120.0, &mut rng);
        let shape = FootShape::from_skeleton(&Skeleton::default());
        place_footsteps(shape, FeetStance::default(), &intents, LAST_STAND, |_| 0.0, &mut rng)
    }

    #[test]
    fn every_stay_rolls_from_strike_to_toe_off() {
        for foot in &footsteps(1).feet {
            for f in &foot.falls {
                assert!(f.land < f.flat && f.flat < f.heel_off && f.heel_off < f.lift || f.lift.is_infinite(), "{f:?}");
            }
            for w in foot.falls.windows(2) {
                assert!((0.3..0.7).contains(&(w[1].land - w[0].lift)), "{w:?}");
            }
        }
    }

    #[test]
    fn a_foot_in_the_air_carries_nothing() {
        let steps = footsteps(2);
        for (foot, empty) in steps.feet.iter().zip([0.0, 1.0]) {
            for w in foot.falls.windows(2) {
                for u in [0.0, 0.4, 1.0] {
                    let t = w[0].lift + u * (w[1].land - w[0].lift);
                    assert!((interpolate(&steps.load, t) - empty).abs() < 1e-9);
                }
            }
        }
        assert!(steps.load.windows(2).all(|k| k[0].0 <= k[1].0));
    }

    #[test]
    fn one_foot_is_always_on_the_ground() {
        let [left, right] = footsteps(3).feet;
        for (a, b) in [(&left, &right), (&right, &left)] {
            for w in a.falls.windows(2) {
                assert!(b.falls.iter().any(|f| f.land <= w[0].lift && f.lift >= w[1].land));
            }
        }
    }
}
