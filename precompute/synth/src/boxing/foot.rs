//! A boxer's foot: stands on its ball, lifts its heel, turns on the spot, and glides low to the next place.

use crate::foot::{FootPose, FootShape};
use crate::side::{forward, over_ground};
use crate::signal::{bump, cruise};
use crate::{frame::Samples, track::KeyTrack};
use glam::DVec2;

/// Contact of the ball of a foot with the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallContact {
    /// The ball meets the ground (s).
    pub land: f64,
    /// The ball leaves the ground (s).
    pub lift: f64,
    /// Position of the ball on the ground plane (x, z) (m).
    pub ball: DVec2,
}

/// All contacts of one foot, in order, and its heading.
pub struct BoxerFoot {
    shape: FootShape,
    stays: Vec<BallContact>,
    yaw: KeyTrack<f64>,
}

/// Heading and heel of a foot at an instant, as given by the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesiredFoot {
    /// Heading of the foot (rad).
    pub yaw: f64,
    /// Lift of the heel (rad).
    pub heel: f64,
}

/// Share of a flight in which the foot speeds up, and slows down.
const RAMP: f64 = 0.42;
/// Time by which the heel leaves the ground before the ball does (s).
const PEEL: f64 = 0.09;
/// Heel angle below which the heel carries weight (rad).
const HEEL_DOWN: f64 = 0.006;

impl BoxerFoot {
    /// A foot standing with its ankle at `ankle` and heading `yaw`.
    pub fn new(shape: FootShape, ankle: DVec2, yaw: f64) -> Self {
        let ball = ankle + forward(yaw) * shape.ball;
        let stays = vec![BallContact { land: f64::NEG_INFINITY, lift: f64::INFINITY, ball }];
        Self { shape, stays, yaw: KeyTrack::new(yaw) }
    }

    /// Steps to an ankle and a heading. Steps come in order and do not overlap.
    pub fn step(&mut self, lift: f64, land: f64, ankle: DVec2, yaw: f64) {
        if let Some(last) = self.stays.last_mut() {
            last.lift = lift;
        }
        self.turn(lift, land, yaw);
        let ball = ankle + forward(yaw) * self.shape.ball;
        self.stays.push(BallContact { land, lift: f64::INFINITY, ball });
    }

    /// Turns on the ball to a heading.
    pub fn turn(&mut self, from: f64, to: f64, yaw: f64) {
        self.yaw.hold(from);
        self.yaw.push(to, yaw);
    }

    /// Ankle of the flat foot and heading, after the last step.
    pub fn last(&self) -> (DVec2, f64) {
        let yaw = self.yaw.last().1;
        (self.stays.last().map_or(DVec2::ZERO, |s| s.ball) - forward(yaw) * self.shape.ball, yaw)
    }

    /// Headings at the samples (rad).
    pub fn yaws(&self, samples: &Samples) -> Vec<f64> {
        self.yaw.sample(samples, &[], 0.012)
    }

    /// Ratio of the current flight at `t`; `None` while the foot stands.
    pub fn flight(&self, t: f64) -> Option<f64> {
        let (a, b) = self.stays_around(t);
        let b = b.filter(|_| t > a.lift)?;
        Some((t - a.lift) / (b.land - a.lift))
    }

    /// Pose of the foot at `t` seconds.
    pub fn pose(&self, t: f64, stance: DesiredFoot) -> FootPose {
        let (a, next) = self.stays_around(t);
        let (mut ball, mut pitch, mut toe_pitch) = (a.ball, stance.heel, 0.0);
        let mut up = self.shape.ball_height;
        if let Some(b) = next.filter(|_| t > a.lift - PEEL) {
            let travel = (b.ball - a.ball).length();
            let peel = bump((t - a.lift + PEEL) / (b.land - a.lift + PEEL));
            pitch += peel * (0.1 + 0.5 * travel).min(0.3);
            if t > a.lift {
                let u = (t - a.lift) / (b.land - a.lift);
                ball += (b.ball - a.ball) * cruise(RAMP, u);
                up += (0.022 + 0.03 * travel) * bump(u);
                toe_pitch = 0.12 * bump(u);
            }
        }
        let planted = next.is_none_or(|_| t <= a.lift);
        let posed = self.shape.contact_pose(over_ground(ball, up), stance.yaw, stance.yaw, pitch, toe_pitch);
        FootPose { toe_down: planted, heel_down: planted && pitch < HEEL_DOWN, ..posed }
    }

    /// Contact at or before `t`, and the next one.
    fn stays_around(&self, t: f64) -> (&BallContact, Option<&BallContact>) {
        let i = self.stays.partition_point(|s| s.land <= t).saturating_sub(1);
        (&self.stays[i], self.stays.get(i + 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::Skeleton;

    fn foot() -> BoxerFoot {
        let mut foot = BoxerFoot::new(FootShape::from_skeleton(&Skeleton::default()), DVec2::ZERO, 0.2);
        foot.step(1.0, 1.25, DVec2::new(0.1, 0.3), -0.2);
        foot
    }

    #[test]
    fn the_ball_stays_while_the_heel_lifts_and_turns() {
        let foot = foot();
        for k in 0..20 {
            let k = f64::from(k);
            let p = foot.pose(0.05 * k, DesiredFoot { yaw: 0.03 * k, heel: 0.02 * k });
            assert!((p.ball - foot.pose(0.0, DesiredFoot { yaw: 0.2, heel: 0.0 }).ball).length() < 1e-12);
            assert!(p.toe_down && p.heel_down == (k == 0.0));
        }
    }

    #[test]
    fn a_flight_is_smooth_and_clears_the_ground() {
        let (foot, h) = (foot(), 1e-3);
        let at = |t: f64| foot.pose(t, DesiredFoot { yaw: 0.0, heel: 0.1 });
        for k in 0..1500 {
            let t = f64::from(k) * h;
            let (a, b, c) = (at(t).ankle, at(t + h).ankle, at(t + 2.0 * h).ankle);
            assert!(((c - b) - (b - a)).length() / (h * h) < 60.0, "at {t}");
            assert!(at(t).ball.y >= foot.shape.ball_height);
        }
        assert!((at(1.3).ball - at(2.0).ball).length() < 1e-12 && !at(1.1).toe_down && at(1.25).toe_down);
    }
}
