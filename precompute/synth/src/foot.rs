//! Dimensions and poses of a foot.

use super::side::{LateralSide, forward, ground_position};
use glam::{DQuat, DVec2, DVec3};
use throng_core::{Contacts, Joint, Skeleton};

/// Dimensions of a flat foot (m).
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
    /// Dimensions of a skeleton's left foot; the heel extends behind the ankle by a third of the distance to the ball.
    pub fn from_skeleton(skeleton: &Skeleton) -> Self {
        let rest = skeleton.rest_positions();
        let toe = skeleton.offsets[Joint::LeftToe.index()];
        let ball = f64::from(toe.z);
        let [ankle_height, ball_height] = [Joint::LeftFoot, Joint::LeftToe].map(|j| rest[j.index()].y.into());
        Self { ankle_height, ball_height, ball, heel: ball / 3.0, tip: skeleton.tips[1].z.into() }
    }

    /// Pose of the foot with a given ball and directions of its parts; no part carries weight yet.
    pub fn contact_pose(&self, ball: DVec3, yaw: f64, heading: f64, pitch: f64, toe_pitch: f64) -> FootPose {
        let rotation = DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(pitch);
        let ankle = ball + rotation * DVec3::new(0.0, self.ankle_height - self.ball_height, -self.ball);
        FootPose { ankle, ball, yaw, heading, pitch, toe_pitch, ground: 0.0, heel_down: false, toe_down: false }
    }

    /// Pose of the foot with a given ankle, otherwise as [`Self::contact_pose`].
    pub fn pose_at_ankle(&self, ankle: DVec3, yaw: f64, heading: f64, pitch: f64, toe_pitch: f64) -> FootPose {
        let rotation = DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(pitch);
        let ball = ankle - rotation * DVec3::new(0.0, self.ankle_height - self.ball_height, -self.ball);
        self.contact_pose(ball, yaw, heading, pitch, toe_pitch)
    }

    /// Height of the lowest point of the sole over the ground beneath it (m).
    pub fn sole(&self, p: &FootPose, ground: impl Fn(DVec2) -> f64) -> f64 {
        let over = |pitch: f64, y: f64, z: f64| {
            let at = ground_position(p.ball) + forward(p.yaw) * (pitch.sin() * y + pitch.cos() * z);
            p.ball.y + (pitch.cos() * y - pitch.sin() * z) - ground(at)
        };
        let heel = over(p.pitch, -self.ball_height, -self.ball - self.heel);
        let tip = over(p.toe_pitch, -self.ball_height, self.tip);
        heel.min(over(0.0, -self.ball_height, 0.0)).min(tip)
    }
}

/// Pose of a foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootPose {
    /// Position of the ankle (m).
    pub ankle: DVec3,
    /// Position of the ball (m).
    pub ball: DVec3,
    /// Heading of the foot (rad).
    pub yaw: f64,
    /// Heading of the path it belongs to (rad).
    pub heading: f64,
    /// Heel up (positive) or toes up (negative) (rad).
    pub pitch: f64,
    /// Pitch of the toes against the ground, positive down (rad).
    pub toe_pitch: f64,
    /// Height of the ground under the foot, or between those of lift and landing (m).
    pub ground: f64,
    /// True if the heel carries weight (the foot is flat).
    pub heel_down: bool,
    /// True if the ball carries weight.
    pub toe_down: bool,
}

impl FootPose {
    /// World rotation of the foot.
    pub fn rotation(&self) -> DQuat {
        DQuat::from_rotation_y(self.yaw) * DQuat::from_rotation_x(self.pitch)
    }

    /// The contact bits of this foot.
    pub fn contacts(&self, side: LateralSide) -> Contacts {
        let (heel, toe) = match side {
            LateralSide::Left => (Contacts::LEFT_HEEL, Contacts::LEFT_TOE),
            LateralSide::Right => (Contacts::RIGHT_HEEL, Contacts::RIGHT_TOE),
        };
        let bits = |down: bool, part: Contacts| if down { part.0 } else { 0 };
        Contacts(bits(self.heel_down, heel) | bits(self.toe_down, toe))
    }
}
