//! A foot on the ground: rolling over the heel, standing flat, rolling over the ball.

use super::super::foot::{FootPose, FootShape};
use super::super::side::forward;
use super::super::signal::{PieceEnd, quintic};
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

/// Pose of the foot during a contact, continued smoothly for a moment before and after it.
pub fn standing(shape: &FootShape, fall: &Footfall, t: f64) -> FootPose {
    let (pitch, toe_pitch) = if t < fall.flat {
        let p = strike_pitch(fall, t);
        (p, p.min(0.0))
    } else if t > fall.heel_off {
        (push_pitch(fall, t), 0.0)
    } else {
        (0.0, 0.0)
    };
    let ball = if t < fall.flat { ball_landing(shape, fall, t) } else { ball_flat(shape, fall) };
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
    DVec3::new(heel.x, fall.ground, heel.y) + rotation * DVec3::new(0.0, shape.ball_height, shape.heel + shape.ball)
}

/// Ball of the standing foot.
pub fn ball_flat(shape: &FootShape, fall: &Footfall) -> DVec3 {
    let p = fall.ankle + forward(fall.yaw) * shape.ball;
    DVec3::new(p.x, fall.ground + shape.ball_height, p.y)
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
    quintic(
        PieceEnd::at_rest(0.0),
        PieceEnd::moving(fall.push, 2.2 * fall.push / duration),
        duration,
        t - fall.heel_off,
    )
}
