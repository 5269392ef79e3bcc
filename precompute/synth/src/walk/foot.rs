//! A foot over time: its footfalls, and its swings between them.

use super::roll::{Footfall, ball_flat, ball_landing, push_pitch, standing, strike_pitch};
use crate::foot::{FootPose, FootShape};
use crate::side::{LateralSide, forward, ground_position, leftward};
use crate::signal::{PieceEnd, bump, cruise, early_bump, quintic};
use glam::{DVec2, DVec3};
use throng_base::thresholds::WALK_CLEARANCE_M_F64;

/// The flight between two footfalls, beyond the data of its ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct StepFlight {
    /// Height to which the foot is drawn up, early in the flight (m).
    raise: f64,
    /// Extra height at half of the flight, to clear the ground (m).
    clear: f64,
    /// Detour at half of the flight, around the standing foot (m).
    detour: DVec2,
}

/// All footfalls of one foot, in order, and the flights between them.
pub struct FootTrack {
    side: LateralSide,
    shape: FootShape,
    /// The footfalls.
    pub falls: Vec<Footfall>,
    flights: Vec<StepFlight>,
}

/// Droop of the toes at half of a flight, as a share of the heel's rise at toe-off: the foot follows the shank rather
/// than the ground.
const HANG: f64 = 0.38;
/// Share of a flight in which the foot speeds up, and slows down.
const RAMP: f64 = 0.36;
/// Largest difference in height that is uneven ground rather than stairs (m).
const STAIR: f64 = 0.05;
/// Least distance of a swinging ankle or ball from the standing one (m).
const PASSING: f64 = 0.105;

impl FootTrack {
    /// Both feet, each of which stands on its `falls` in turn and swings around the other one's.
    ///
    /// - `ground`: height anywhere on the path (m).
    pub fn pair(shape: FootShape, falls: [Vec<Footfall>; 2], ground: impl Fn(DVec2) -> f64) -> [Self; 2] {
        LateralSide::BOTH.map(|side| {
            let (own, other) = (falls[side.index()].clone(), &falls[side.other().index()]);
            let flights = vec![StepFlight::default(); own.len().saturating_sub(1)];
            let mut track = Self { side, shape, falls: own, flights };
            for i in 0..track.flights.len() {
                let (lift, land) = (track.falls[i].lift, track.falls[i + 1].land);
                let standing = other.iter().rev().find(|f| f.land <= 0.5 * (lift + land));
                track.flights[i].detour = standing.map_or(DVec2::ZERO, |s| track.sidestep(i, s));
                track.flights[i].raise = track.lift_height(i);
                track.flights[i].clear = track.clearance_height(i, &ground);
            }
            track
        })
    }

    /// The foot at `t` seconds.
    pub fn pose(&self, t: f64) -> FootPose {
        let i = self.falls.partition_point(|f| f.land <= t).saturating_sub(1);
        let fall = &self.falls[i];
        if t <= fall.lift || i + 1 == self.falls.len() {
            standing(&self.shape, fall, t)
        } else {
            self.pose_in_flight(i, t)
        }
    }

    fn pose_in_flight(&self, i: usize, t: f64) -> FootPose {
        let (a, b) = (&self.falls[i], &self.falls[i + 1]);
        let (t, duration) = (t - a.lift, b.land - a.lift);
        let u = t / duration;
        let (across, up) = stair_pace(b.ground - a.ground, u);
        let start = ball_flat(&self.shape, a);
        let piece = |from: f64, u: f64, axis: fn(DVec3) -> f64| {
            let to = PieceEnd::from_function(|t| axis(ball_landing(&self.shape, b, t)), b.land);
            let arrival = quintic(PieceEnd::default(), PieceEnd { value: 0.0, ..to }, duration, t);
            from + (to.value - from) * cruise(RAMP, u) + arrival
        };
        let flight = &self.flights[i];
        let ball = DVec3::new(
            piece(start.x, across, |p| p.x) + flight.detour.x * bump(u),
            piece(start.y, up, |p| p.y) + flight.raise * early_bump(u) + flight.clear * bump(u),
            piece(start.z, across, |p| p.z) + flight.detour.y * bump(u),
        );
        let angle = |from: f64, to: f64| quintic(PieceEnd::at_rest(from), PieceEnd::at_rest(to), duration, t);
        let landing = PieceEnd::from_function(|t| strike_pitch(b, t), b.land);
        let pitch = quintic(PieceEnd::from_function(|t| push_pitch(a, t), a.lift), landing, duration, t)
            + HANG * a.push * bump(u);
        let toes = PieceEnd::from_function(|t| strike_pitch(b, t).min(0.0), b.land);
        let toe_pitch = quintic(PieceEnd::at_rest(0.0), toes, duration, t) + 0.25 * a.push * bump(u);
        let posed = self.shape.contact_pose(ball, angle(a.yaw, b.yaw), angle(a.heading, b.heading), pitch, toe_pitch);
        FootPose { ground: angle(a.ground, b.ground), ..posed }
    }

    /// Times spread over flight `i`, with their bumps.
    fn flight_moments(&self, i: usize) -> impl Iterator<Item = (f64, f64)> + use<> {
        let (lift, land) = (self.falls[i].lift, self.falls[i + 1].land);
        (1..40).map(move |k| f64::from(k) / 40.0).map(move |u| (lift + u * (land - lift), bump(u)))
    }

    /// Height to which the foot is drawn up in flight `i`: more in longer flights (m).
    fn lift_height(&self, i: usize) -> f64 {
        let travel = (self.falls[i + 1].ankle - self.falls[i].ankle).length();
        0.015 + 0.016 * (travel / 1.4).min(1.0)
    }

    /// Extra height that flight `i` needs for its sole to clear the ground (m).
    fn clearance_height(&self, i: usize, ground: &impl Fn(DVec2) -> f64) -> f64 {
        let missing = |t: f64| WALK_CLEARANCE_M_F64 - self.shape.sole(&self.pose_in_flight(i, t), ground);
        self.flight_moments(i).filter(|m| m.1 > 0.3).map(|(t, b)| missing(t) / b).fold(0.0, f64::max)
    }

    /// Sideways detour of flight `i` around the standing foot (m).
    fn sidestep(&self, i: usize, standing: &Footfall) -> DVec2 {
        let (a, b) = (&self.falls[i], &self.falls[i + 1]);
        let heading = 0.5 * (a.heading + b.heading);
        let away = leftward(heading) * self.side.sign();
        let obstacles = [standing.ankle, standing.ankle + forward(standing.yaw) * self.shape.ball];
        let mut need: f64 = 0.0;
        for (t, b) in self.flight_moments(i).filter(|m| m.1 > 0.2) {
            let p = self.pose_in_flight(i, t);
            for part in [p.ankle, p.ball] {
                for o in obstacles {
                    let from = ground_position(part) - o;
                    let along = (from - away * from.dot(away)).length();
                    let wanted = (PASSING * PASSING - along * along).max(0.0).sqrt();
                    if wanted > 0.0 {
                        need = need.max((wanted - from.dot(away)) / b);
                    }
                }
            }
        }
        away * need.min(0.2)
    }
}

/// Progress of a flight across and up: upstairs it first clears the step and then moves over it, downstairs the
/// reverse.
fn stair_pace(rise: f64, u: f64) -> (f64, f64) {
    let early = |power: f64| 1.0 - (1.0 - u).max(0.0).powf(power);
    let late = |power: f64| u.max(0.0).powf(power);
    if rise.abs() < STAIR {
        (u, u)
    } else if rise > 0.0 {
        (late(1.5), early(1.4))
    } else {
        (early(1.7), late(1.5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::Skeleton;

    fn fall(land: f64, lift: f64, ankle: DVec2, yaw: f64) -> Footfall {
        let (flat, heel_off) = (land + 0.1, lift - 0.25);
        Footfall { land, flat, heel_off, lift, ankle, ground: 0.0, heading: yaw, yaw, strike: 0.35, push: 0.7 }
    }

    /// A left foot that takes one long step past a right foot in its way.
    fn track() -> FootTrack {
        let falls = vec![fall(0.0, 0.7, DVec2::ZERO, 0.1), fall(1.1, 2.0, DVec2::new(-0.05, 1.3), 0.4)];
        let standing = fall(0.6, 1.2, DVec2::new(-0.02, 0.65), 0.0);
        let [left, _] =
            FootTrack::pair(FootShape::from_skeleton(&Skeleton::default()), [falls, vec![standing]], |_| 0.0);
        left
    }

    #[test]
    fn heel_then_ankle_then_ball_stay_where_they_are() {
        let (track, shape) = (track(), FootShape::from_skeleton(&Skeleton::default()));
        let heel = |p: &FootPose| p.ankle + p.rotation() * DVec3::new(0.0, -shape.ankle_height, -shape.heel);
        let spread = |from: f64, to: f64, point: &dyn Fn(&FootPose) -> DVec3| {
            let at = |k: u32| point(&track.pose(from + (to - from) * f64::from(k) / 50.0));
            (0..=50).map(|k| (at(k) - at(0)).length()).fold(0.0, f64::max)
        };
        assert!(spread(1.1, 1.2, &heel) < 1e-9 && spread(1.1, 1.2, &|p| p.ankle) > 0.02);
        assert!(spread(1.2, 1.75, &|p| p.ankle) < 1e-9);
        assert!(spread(1.2, 2.0, &|p| p.ball) < 1e-9 && spread(1.75, 2.0, &|p| p.ankle) > 0.05);
    }

    #[test]
    fn the_ankle_moves_without_a_jump_in_speed() {
        let (track, h) = (track(), 1e-4);
        let speed = |t: f64| (track.pose(t + h).ankle - track.pose(t).ankle) / h;
        for k in 0..20_000 {
            let t = f64::from(k) * h;
            assert!((speed(t + h) - speed(t)).length() < 200.0 * h, "at {t}");
        }
    }

    #[test]
    fn a_flight_clears_the_ground_and_the_standing_foot() {
        let track = track();
        for k in 0..=100 {
            let u = f64::from(k) / 100.0;
            let p = track.pose(0.7 + 0.4 * u);
            let least = if (0.3..0.7).contains(&u) { WALK_CLEARANCE_M_F64 - 1e-3 } else { -1e-9 };
            assert!(track.shape.sole(&p, |_| 0.0) >= least, "at {u}: {}", track.shape.sole(&p, |_| 0.0));
            assert!((DVec2::new(p.ankle.x, p.ankle.z) - DVec2::new(-0.02, 0.65)).length() > PASSING - 5e-3);
        }
    }
}
