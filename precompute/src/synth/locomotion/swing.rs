//! The foot of a runner over time: its contacts, and the swing that folds the leg, lifts the knee and reaches out.

use super::super::foot::{FootPose, FootShape};
use super::super::leg::LegShape;
use super::super::side::Side;
use super::super::signal::{End, quintic};
use super::super::walk::roll::{Footfall, standing};
use super::drive::Drive;
use super::spline::Spline;
use glam::{DQuat, DVec2, DVec3};

/// The leg at a moment of the swing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Share of the swing that is over.
    pub at: f64,
    /// The thigh swings forward from the vertical. [Unit: rad]
    pub thigh: f64,
    /// The knee bends. [Unit: rad]
    pub knee: f64,
    /// The foot points down from a right angle with the shank. [Unit: rad]
    pub ankle: f64,
}

/// What the swings of a runner have in common.
pub struct Swing<'a> {
    /// The way of the body.
    pub drive: Drive,
    /// The leg at moments between lift and landing, in order.
    pub keys: [Key; 3],
    /// Height of the hip joints at a time. [Unit: m]
    pub hips: &'a dyn Fn(f64) -> f64,
    /// Distance of the swinging ankle from the middle of the body. [Unit: m]
    pub aside: f64,
    /// Where the ankle of a folded leg that hangs from a leaning body is seen: to the left, ahead. [Unit: m]
    pub outward: DVec2,
    /// Lengths of the leg.
    pub leg: LegShape,
}

/// One flight: where the ankle is seen from the body that moves along, and how the foot is tilted.
struct Flight {
    left: Spline,
    ahead: Spline,
    height: Spline,
    pitch: Spline,
}

/// All contacts of one foot, in order, and the flights between them.
pub struct RunnerFoot {
    drive: Drive,
    shape: FootShape,
    falls: Vec<Footfall>,
    flights: Vec<Flight>,
}

/// Share of a flight after which the toes are in line with the foot.
const TOES: f64 = 0.45;

impl RunnerFoot {
    /// A foot that stands on `falls` in turn.
    pub fn new(side: Side, shape: FootShape, falls: Vec<Footfall>, swing: &Swing) -> Self {
        let flights = falls.windows(2).map(|w| flight(side, &shape, &w[0], &w[1], swing)).collect();
        Self { drive: swing.drive, shape, falls, flights }
    }

    /// The foot at `t` seconds.
    pub fn pose(&self, t: f64) -> FootPose {
        let i = self.falls.partition_point(|f| f.land <= t).saturating_sub(1);
        let fall = &self.falls[i];
        match (self.falls.get(i + 1), self.flights.get(i)) {
            (Some(next), Some(flight)) if t > fall.lift => self.flying(fall, next, flight, t),
            _ => standing(&self.shape, fall, t),
        }
    }

    fn flying(&self, from: &Footfall, to: &Footfall, flight: &Flight, t: f64) -> FootPose {
        let (since, duration) = (t - from.lift, to.land - from.lift);
        let turned = |a: f64, b: f64| quintic(End::still(a), End::still(b), duration, since);
        let (yaw, heading) = (turned(from.yaw, to.yaw), turned(from.heading, to.heading));
        let pitch = flight.pitch.at(t);
        let toe_pitch = pitch * quintic(End::still(0.0), End::still(1.0), TOES, (since / duration).min(TOES));
        let on_ground = self.drive.place(t, flight.left.at(t), flight.ahead.at(t));
        let ankle = DVec3::new(on_ground.x, flight.height.at(t), on_ground.y);
        let rotation = DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(pitch);
        let ball =
            ankle - rotation * DVec3::new(0.0, self.shape.ankle_height - self.shape.ball_height, -self.shape.ball);
        self.shape.posed(ball, yaw, heading, pitch, toe_pitch)
    }
}

/// The flight from one contact to the next.
fn flight(side: Side, shape: &FootShape, from: &Footfall, to: &Footfall, swing: &Swing) -> Flight {
    let (start, end) = (from.lift, to.land);
    let keys = swing.keys.map(|key| {
        let t = start + key.at * (end - start);
        let shank = key.thigh - key.knee;
        let leg = swing.leg;
        let ahead = leg.thigh * key.thigh.sin() + leg.shin * shank.sin();
        let down = leg.thigh * key.thigh.cos() + leg.shin * shank.cos();
        let left = swing.aside * side.sign() + swing.outward.x;
        (t, [left, ahead + swing.outward.y, (swing.hips)(t) - down, key.ankle - shank])
    });
    let curve = |value: &dyn Fn(f64, &FootPose) -> f64, channel: usize| {
        let first = End::of(|t| value(t, &standing(shape, from, t)), start);
        let last = End::of(|t| value(t, &standing(shape, to, t)), end);
        let inner = keys.iter().map(|(t, values)| (*t, values[channel]));
        let knots = std::iter::once((start, first.value)).chain(inner).chain([(end, last.value)]).collect();
        Spline::new(knots, first.rate, last.rate)
    };
    let seen = |t: f64, p: &FootPose| swing.drive.seen(t, DVec2::new(p.ankle.x, p.ankle.z));
    Flight {
        left: curve(&|t, p| seen(t, p).x, 0),
        ahead: curve(&|t, p| seen(t, p).y, 1),
        height: curve(&|_, p| p.ankle.y, 2),
        pitch: curve(&|_, p| p.pitch, 3),
    }
}
