//! A foot: how long its parts are, and where they are.

use super::side::{Side, forward};
use glam::{DQuat, DVec2, DVec3};
use throng_core::{Contacts, Joint, Skeleton};

/// Lengths of a foot that stands flat (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootShape {
    /// Height of the ankle.
    pub ankle_height: f64,
    /// Height of the ball (the toe joint).
    pub ball_height: f64,
    /// Distance of the ball in front of the ankle.
    pub ball: f64,
    /// Distance of the heel behind the ankle.
    pub heel: f64,
    /// Distance of the toe tip in front of the ball.
    pub tip: f64,
}

impl FootShape {
    /// The left foot of a skeleton; the heel stands out by a third of the distance to the ball.
    pub fn of(skeleton: &Skeleton) -> Self {
        let rest = skeleton.rest_positions();
        let toe = skeleton.offsets[Joint::LeftToe.index()];
        let ball = f64::from(toe.z);
        Self {
            ankle_height: rest[Joint::LeftFoot.index()].y.into(),
            ball_height: rest[Joint::LeftToe.index()].y.into(),
            ball,
            heel: ball / 3.0,
            tip: skeleton.tips[1].z.into(),
        }
    }

    /// The foot over a ball and the directions of its parts; neither part carries yet.
    pub fn posed(&self, ball: DVec3, yaw: f64, heading: f64, pitch: f64, toe_pitch: f64) -> FootPose {
        let rotation = DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(pitch);
        let ankle = ball + rotation * DVec3::new(0.0, self.ankle_height - self.ball_height, -self.ball);
        FootPose { ankle, ball, yaw, heading, pitch, toe_pitch, ground: 0.0, heel_down: false, toe_down: false }
    }

    /// Height of the lowest point of the sole over the ground beneath it (m).
    pub fn sole(&self, p: &FootPose, ground: impl Fn(DVec2) -> f64) -> f64 {
        let over = |pitch: f64, y: f64, z: f64| {
            let at = DVec2::new(p.ball.x, p.ball.z) + forward(p.yaw) * (pitch.sin() * y + pitch.cos() * z);
            p.ball.y + (pitch.cos() * y - pitch.sin() * z) - ground(at)
        };
        let heel = over(p.pitch, -self.ball_height, -self.ball - self.heel);
        let tip = over(p.toe_pitch, -self.ball_height, self.tip);
        heel.min(over(0.0, -self.ball_height, 0.0)).min(tip)
    }
}

/// Where a foot is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootPose {
    /// Ankle (m).
    pub ankle: DVec3,
    /// Ball (m).
    pub ball: DVec3,
    /// Heading of the foot (rad).
    pub yaw: f64,
    /// Heading of the path it belongs to (rad).
    pub heading: f64,
    /// Heel up (positive) or toes up (negative) (rad).
    pub pitch: f64,
    /// Pitch of the toes against the ground, positive down (rad).
    pub toe_pitch: f64,
    /// Height of the ground that it stands on, or between the grounds that it flies from and to (m).
    pub ground: f64,
    /// The heel carries (the foot is flat).
    pub heel_down: bool,
    /// The ball carries.
    pub toe_down: bool,
}

impl FootPose {
    /// World rotation of the foot.
    pub fn rotation(&self) -> DQuat {
        DQuat::from_rotation_y(self.yaw) * DQuat::from_rotation_x(self.pitch)
    }

    /// The contact bits of this foot.
    pub fn contacts(&self, side: Side) -> Contacts {
        let (heel, toe) = match side {
            Side::Left => (Contacts::LEFT_HEEL, Contacts::LEFT_TOE),
            Side::Right => (Contacts::RIGHT_HEEL, Contacts::RIGHT_TOE),
        };
        let mut out = Contacts::NONE;
        if self.heel_down {
            out.insert(heel);
        }
        if self.toe_down {
            out.insert(toe);
        }
        out
    }
}
