//! Posture of a boxer, as channels that can be keyed: the body over the feet, and each hand.
//!
//! The boxer is orthodox: the left foot and hand lead. Angles and directions are in the *facing* frame, which stands on
//! the ground and faces the opponent: X left, Z towards the opponent.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Posture of the body over the feet.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BoxingPosture {
    /// Heading of the hips (rad).
    pub hips: f64,
    /// Heading of the upper chest (rad).
    pub chest: f64,
    /// Forward lean of the trunk (rad).
    pub pitch: f64,
    /// Lean of the trunk to the right (left side up) (rad).
    pub list: f64,
    /// Flexion of the straighter knee: larger is lower (rad).
    pub flexion: f64,
    /// Share of the weight on the lead foot.
    pub weight: f64,
    /// Shift of the hips from the balance over the feet: to the left and forward (m).
    pub shift: [f64; 2],
    /// Forward nod of the head (rad).
    pub chin: f64,
    /// Lift of the heels, left and right (rad).
    pub heels: [f64; 2],
    /// Turn of each foot on its ball, left and right (rad).
    pub pivots: [f64; 2],
}

impl BoxingPosture {
    /// On guard: bladed, chin down, knees soft, a little more weight behind, the rear heel off the ground.
    pub const GUARD: Self = Self {
        hips: -0.52,
        chest: -0.44,
        pitch: 0.17,
        list: 0.0,
        flexion: 0.5,
        weight: 0.46,
        shift: [0.0; 2],
        chin: 0.2,
        heels: [0.0, 0.24],
        pivots: [0.0; 2],
    };

    /// Time by which each channel precedes the hands: a blow begins at the ground (s).
    pub const AHEAD: [f64; 13] = [0.055, 0.02, 0.03, 0.03, 0.05, 0.1, 0.04, 0.04, 0.0, 0.065, 0.065, 0.065, 0.065];
}

/// Pose of a hand that does not strike, and of its arm.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BoxingHandPose {
    /// Wrist relative to the neck, in a frame that turns with the head and chest (m).
    pub guard: DVec3,
    /// Direction of the elbow.
    pub pole: DVec3,
    /// Twist of the forearm, palm down positive (rad).
    pub twist: f64,
    /// Forward turn of the shoulder (rad).
    pub reach: f64,
    /// Upward turn of the shoulder (rad).
    pub shrug: f64,
}

impl BoxingHandPose {
    /// Hands on guard, left and right: the lead one in front of the cheek, the rear one at the chin, elbows in.
    pub const GUARD: [Self; 2] = [
        Self {
            guard: DVec3::new(0.1, -0.01, 0.29),
            pole: DVec3::new(0.3, -1.0, -0.1),
            twist: 0.2,
            reach: 0.25,
            shrug: 0.1,
        },
        Self {
            guard: DVec3::new(-0.085, -0.02, 0.2),
            pole: DVec3::new(-0.4, -1.0, -0.15),
            twist: 0.15,
            reach: 0.3,
            shrug: 0.08,
        },
    ];

    /// Time by which each channel precedes its keys: the elbow and the shoulder lead the fist (s).
    pub const AHEAD: [f64; 9] = [0.0, 0.0, 0.0, 0.03, 0.03, 0.03, 0.0, 0.02, 0.03];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_and_back() {
        let body: BoxingPosture = bytemuck::cast(std::array::from_fn::<f64, 13, _>(|i| i as f64));
        assert_eq!((body.hips, body.shift, body.chin, body.pivots), (0.0, [6.0, 7.0], 8.0, [11.0, 12.0]));
        let hand: BoxingHandPose = bytemuck::cast(std::array::from_fn::<f64, 9, _>(|i| i as f64));
        assert_eq!((hand.guard.x, hand.pole.x, hand.twist, hand.shrug), (0.0, 3.0, 6.0, 8.0));
    }
}
