//! The foot of a runner over time: its contacts, and the swing that folds the leg, lifts the knee and reaches out.

use super::drive::Drive;
use crate::foot::{FootPose, FootShape};
use crate::side::{LateralSide, ground_position, over_ground};
use crate::signal::{PieceEnd, early_bump, quintic};
use crate::walk::roll::{Footfall, standing};
use crate::{leg::LegShape, track::hermite_piece};
use glam::DVec3;
use throng_base::thresholds::TOE_CLEARANCE_M_F64;

/// Key of the leg during the swing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegKey {
    /// Ratio of the swing.
    pub at: f64,
    /// Forward angle of the thigh from the vertical (rad).
    pub thigh: f64,
    /// Flexion of the knee (rad).
    pub knee: f64,
    /// Downward angle of the foot from a right angle with the shank (rad).
    pub ankle: f64,
}

/// Inputs of a runner's swings.
pub struct RunnerSwing<'a> {
    /// Motion of the body.
    pub drive: Drive,
    /// Keys of the leg between lift and landing, in order.
    pub keys: [LegKey; 3],
    /// Hip joint of a side at a time (m).
    pub hip: &'a dyn Fn(LateralSide, f64) -> DVec3,
    /// Lean of the body to the left (rad).
    pub bank: f64,
    /// Lengths of the leg.
    pub leg: LegShape,
}

/// One flight: the leg relative to the moving body, and the pitch of the foot.
struct RunnerFlight {
    /// Offset of the ankle to the left of the hip (m).
    left: Spline,
    /// Angle of the line from the hip to the ankle, forward from the vertical (rad).
    angle: Spline,
    /// Flexion of the knee (rad).
    knee: Spline,
    /// Pitch, heel up (rad).
    pitch: Spline,
    /// Extra height a little after half of the flight, to clear the ground (m).
    clear: f64,
}

/// All contacts of one foot, in order, and the flights between them.
pub struct RunnerFoot {
    drive: Drive,
    shape: FootShape,
    leg: LegShape,
    falls: Vec<Footfall>,
    flights: Vec<RunnerFlight>,
}

/// Share of a flight after which the toes are in line with the foot.
const TOES: f64 = 0.45;
/// Distance by which the swinging ankle is nearer to the middle of the body than the hip (m).
const INWARD: f64 = 0.012;
/// Largest rate of the knee at begin and end of a swing. A foot pinned to the ground would need more of a nearly
/// straight leg; muscles give way (rad/s).
const KNEE_RATE: f64 = 5.0;

impl RunnerFoot {
    /// A foot that stands on `falls` in turn.
    pub fn new(side: LateralSide, shape: FootShape, falls: Vec<Footfall>, swing: &RunnerSwing) -> Self {
        let flights = falls.windows(2).map(|w| flight(side, &shape, &w[0], &w[1], swing)).collect();
        let mut foot = Self { drive: swing.drive, shape, leg: swing.leg, falls, flights };
        for i in 0..foot.flights.len() {
            foot.flights[i].clear = foot.shortfall(i, |t| (swing.hip)(side, t));
        }
        foot
    }

    /// Extra height that flight `i` needs for its sole to clear the ground (m).
    fn shortfall(&self, i: usize, hip: impl Fn(f64) -> DVec3) -> f64 {
        let (from, to) = (&self.falls[i], &self.falls[i + 1]);
        let moments = (1..40).map(|k| f64::from(k) / 40.0).filter(|u| passing(*u) > 0.4);
        let missing = |u: f64| {
            let t = from.lift + u * (to.land - from.lift);
            let foot = self.pose_in_flight(from, to, &self.flights[i], t, hip(t));
            (TOE_CLEARANCE_M_F64 - self.shape.sole(&foot, |_| 0.0)) / passing(u)
        };
        moments.map(missing).fold(0.0, f64::max)
    }

    /// The foot at `t` seconds.
    ///
    /// - `hip`: joint of its side at that time (m).
    pub fn pose(&self, t: f64, hip: DVec3) -> FootPose {
        let i = self.falls.partition_point(|f| f.land <= t).saturating_sub(1);
        let fall = &self.falls[i];
        match (self.falls.get(i + 1), self.flights.get(i)) {
            (Some(next), Some(flight)) if t > fall.lift => self.pose_in_flight(fall, next, flight, t, hip),
            _ => standing(&self.shape, fall, t),
        }
    }

    fn pose_in_flight(&self, from: &Footfall, to: &Footfall, flight: &RunnerFlight, t: f64, hip: DVec3) -> FootPose {
        let (since, duration) = (t - from.lift, to.land - from.lift);
        let turned = |a: f64, b: f64| quintic(PieceEnd::at_rest(a), PieceEnd::at_rest(b), duration, since);
        let (yaw, heading) = (turned(from.yaw, to.yaw), turned(from.heading, to.heading));
        let pitch = flight.pitch.value_at(t);
        let toe_pitch =
            pitch * quintic(PieceEnd::at_rest(0.0), PieceEnd::at_rest(1.0), TOES, (since / duration).min(TOES));
        let (left, angle, length) =
            (flight.left.value_at(t), flight.angle.value_at(t), self.leg.reach(flight.knee.value_at(t)));
        let (sin, cos) = angle.sin_cos();
        let along = (length * length - left * left).max(0.0).sqrt();
        let seen = self.drive.to_body_frame(t, ground_position(hip));
        let on_ground = self.drive.point_at(t, seen.x + left, seen.y + along * sin);
        let height = hip.y - along * cos + flight.clear * passing(since / duration);
        self.shape.pose_at_ankle(over_ground(on_ground, height), yaw, heading, pitch, toe_pitch)
    }
}

/// Bump over a flight, highest at its middle, as the leg passes the standing one.
fn passing(u: f64) -> f64 {
    early_bump(1.0 - u)
}

/// The flight from one contact to the next.
fn flight(side: LateralSide, shape: &FootShape, from: &Footfall, to: &Footfall, swing: &RunnerSwing) -> RunnerFlight {
    let (start, end) = (from.lift, to.land);
    let keys = swing.keys.map(|key| (start + key.at * (end - start), key.channels(side, swing)));
    let seen = |fall: &Footfall, t: f64| {
        let (foot, hip) = (standing(shape, fall, t), (swing.hip)(side, t));
        let away = foot.ankle - hip;
        let ground = |p: DVec3| swing.drive.to_body_frame(t, ground_position(p));
        let from_hip = ground(foot.ankle) - ground(hip);
        [from_hip.x, from_hip.y.atan2(-away.y), swing.leg.flexion(away.length()), foot.pitch]
    };
    let curve = |channel: usize, most: f64| {
        let [first, last] =
            [(from, start), (to, end)].map(|(fall, t)| PieceEnd::from_function(|t| seen(fall, t)[channel], t));
        let inner = keys.iter().map(|(t, values)| (*t, values[channel]));
        let knots = std::iter::once((start, first.value)).chain(inner).chain([(end, last.value)]).collect();
        Spline::new(knots, first.rate.clamp(-most, most), last.rate.clamp(-most, most))
    };
    let [left, angle, pitch] = [0, 1, 3].map(|channel| curve(channel, f64::INFINITY));
    RunnerFlight { left, angle, knee: curve(2, KNEE_RATE), pitch, clear: 0.0 }
}

impl LegKey {
    /// Left, angle, knee and pitch, as channels of a flight.
    fn channels(&self, side: LateralSide, swing: &RunnerSwing) -> [f64; 4] {
        let shank = self.thigh - self.knee;
        let ahead = swing.leg.thigh * self.thigh.sin() + swing.leg.shin * shank.sin();
        let down = swing.leg.thigh * self.thigh.cos() + swing.leg.shin * shank.cos();
        let left = -INWARD * side.sign() - down * swing.bank.tan();
        [left, ahead.atan2(down), self.knee, self.ankle - shank]
    }
}

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
    use throng_core::Skeleton;

    const DRIVE: Drive = Drive { left: 0.0, ahead: 3.5, gyration: 0.0 };

    fn fall(land: f64) -> Footfall {
        let (flat, heel_off, lift) = (land + 0.05, land + 0.09, land + 0.22);
        let ankle = DRIVE.point_at(land + 0.11, 0.05, -0.16);
        Footfall { land, flat, heel_off, lift, ankle, ground: 0.0, heading: 0.0, yaw: 0.1, strike: 0.12, push: 1.1 }
    }

    /// A left hip that goes along evenly.
    fn hip(t: f64) -> DVec3 {
        let p = DRIVE.point_at(t, 0.092, 0.0);
        DVec3::new(p.x, 0.84, p.y)
    }

    fn foot() -> RunnerFoot {
        let keys = [(0.26, -0.16, 1.4, 0.2), (0.48, 0.3, 1.7, 0.0), (0.74, 0.6, 1.3, 0.0)];
        let skeleton = Skeleton::default();
        let swing = RunnerSwing {
            drive: DRIVE,
            keys: keys.map(|(at, thigh, knee, ankle)| LegKey { at, thigh, knee, ankle }),
            hip: &|_, t| hip(t),
            bank: 0.0,
            leg: LegShape::from_skeleton(&skeleton),
        };
        RunnerFoot::new(LateralSide::Left, FootShape::from_skeleton(&skeleton), vec![fall(0.0), fall(0.7)], &swing)
    }

    #[test]
    fn a_swing_begins_and_ends_where_the_foot_stands() {
        let foot = foot();
        for (t, fall) in [(0.22, fall(0.0)), (0.7, fall(0.7))] {
            let (stands, before) = (standing(&foot.shape, &fall, t), foot.pose(t - 1e-6, hip(t)));
            let after = foot.pose(t + 1e-6, hip(t));
            for flying in [before, after] {
                assert!((flying.ankle - stands.ankle).length() < 1e-4, "{} {}", flying.ankle, stands.ankle);
                assert!((flying.pitch - stands.pitch).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn the_leg_folds_and_stays_off_the_ground() {
        let foot = foot();
        let flexion = |t: f64| foot.leg.flexion((foot.pose(t, hip(t)).ankle - hip(t)).length());
        assert!(flexion(0.22) < 0.9 && flexion(0.45) > 1.6 && flexion(0.7) < 0.9);
        for k in 1..100 {
            let t = 0.22 + 0.0048 * f64::from(k);
            let sole = foot.shape.sole(&foot.pose(t, hip(t)), |_| 0.0);
            let least = if (0.4..0.6).contains(&t) { TOE_CLEARANCE_M_F64 - 1e-3 } else { -0.004 };
            assert!(sole > least, "at {t}: {sole}");
        }
    }

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
