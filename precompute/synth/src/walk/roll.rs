//! A foot on the ground: rolling over the heel, standing flat, rolling over the ball.

use crate::foot::{FootPose, FootShape};
use crate::side::{forward, over_ground};
use crate::signal::{PieceEnd, quintic};
use glam::{DQuat, DVec2, DVec3};

/// Contact of a foot with the ground, from heel strike to toe-off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footfall {
    /// Time of heel strike (s).
    pub land: f64,
    /// Time from which the foot is flat (s).
    pub flat: f64,
    /// Time at which the heel leaves the ground (s).
    pub heel_off: f64,
    /// Time of toe-off (s).
    pub lift: f64,
    /// Ankle of the flat foot on the ground plane (x, z) (m).
    pub ankle: DVec2,
    /// Height of the ground here (m).
    pub ground: f64,
    /// Heading of the path here (rad).
    pub heading: f64,
    /// Heading of the foot (rad).
    pub yaw: f64,
    /// Pitch at heel strike, toes up; if negative the ball lands first, with the heel up (rad).
    pub strike: f64,
    /// Pitch at toe-off, heel up (rad).
    pub push: f64,
}

impl Footfall {
    /// Contact of a foot that stands flat on level ground from before `start` on, for ever.
    pub fn standing(start: f64, ankle: DVec2, heading: f64, yaw: f64) -> Self {
        let (land, flat) = (start - 2.0, start - 1.9);
        let (heel_off, lift) = (f64::INFINITY, f64::INFINITY);
        Self { land, flat, heel_off, lift, ankle, ground: 0.0, heading, yaw, strike: 0.0, push: 0.0 }
    }
}

/// Pose of the foot during a contact, continued smoothly for a moment before and after it.
pub fn standing(shape: &FootShape, fall: &Footfall, t: f64) -> FootPose {
    let (ball, pitch, toe_pitch) = if t < fall.flat {
        let p = strike_pitch(fall, t);
        (ball_landing(shape, fall, t), p, p.min(0.0))
    } else {
        (ball_flat(shape, fall), if t > fall.heel_off { push_pitch(fall, t) } else { 0.0 }, 0.0)
    };
    FootPose {
        heel_down: t >= fall.flat && t <= fall.heel_off,
        toe_down: t >= if fall.strike < 0.0 { fall.land } else { fall.flat },
        ground: fall.ground,
        ..shape.contact_pose(ball, fall.yaw, fall.heading, pitch, toe_pitch)
    }
}

/// Ball of the foot while it rolls over its heel onto a footfall, or stands already.
pub fn ball_landing(shape: &FootShape, fall: &Footfall, t: f64) -> DVec3 {
    if fall.strike < 0.0 {
        return ball_flat(shape, fall);
    }
    let heel = fall.ankle - forward(fall.yaw) * shape.heel;
    let rotation = DQuat::from_rotation_y(fall.yaw) * DQuat::from_rotation_x(strike_pitch(fall, t));
    over_ground(heel, fall.ground) + rotation * DVec3::new(0.0, shape.ball_height, shape.heel + shape.ball)
}

/// Ball of the standing foot.
pub fn ball_flat(shape: &FootShape, fall: &Footfall) -> DVec3 {
    over_ground(fall.ankle + forward(fall.yaw) * shape.ball, fall.ground + shape.ball_height)
}

/// Pitch while the foot rolls over its heel: begins turning down, ends flat and at rest (rad).
pub fn strike_pitch(fall: &Footfall, t: f64) -> f64 {
    let duration = fall.flat - fall.land;
    let from = PieceEnd::moving(-fall.strike, 1.1 * fall.strike / duration);
    quintic(from, PieceEnd::at_rest(0.0), duration, t - fall.land)
}

/// Pitch while the foot rolls over its ball: begins at rest, ends turning (rad).
pub fn push_pitch(fall: &Footfall, t: f64) -> f64 {
    let duration = fall.lift - fall.heel_off;
    let to = PieceEnd::moving(fall.push, 2.2 * fall.push / duration);
    quintic(PieceEnd::at_rest(0.0), to, duration, t - fall.heel_off)
}
