//! Postures in an office, as channels that can be keyed: all zero in a neutral stand.

use crate::attitude::Attitude;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Posture of hips and chest, in addition to balance and walking.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct KeyedPosture {
    /// Turn of the hips.
    pub hips: Attitude,
    /// Turn of the upper chest in the world, which the spine shares evenly.
    pub chest: Attitude,
    /// Shift of the hips over the feet: to the left and forward (m).
    pub shift: [f64; 2],
    /// Lowering of the hips (m).
    pub dip: f64,
}

impl KeyedPosture {
    /// Upright posture but for the turn and the lean of the chest.
    pub fn with_chest(yaw: f64, pitch: f64) -> Self {
        Self { chest: Attitude { yaw, pitch, list: 0.0 }, ..Self::default() }
    }
}

/// Pose of one hand: hanging as in walking, held before the body, or placed in the room.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct KeyedHandPose {
    /// Share of being held: 0 hangs and swings, 1 is held.
    pub held: f64,
    /// Wrist relative to the neck, in a frame that turns with the chest (m).
    pub body: DVec3,
    /// Wrist in the room (m).
    pub room: DVec3,
    /// Share of the room: 0 follows `body`, 1 follows `room`.
    pub placed: f64,
    /// Direction of the elbow, in the frame that turns with the chest.
    pub pole: DVec3,
    /// Twist of the forearm: 0 thumb up, positive palm down (rad).
    pub twist: f64,
    /// Flexion of the hand towards its palm (rad).
    pub flex: f64,
    /// Forward turn of the shoulder (rad).
    pub reach: f64,
    /// Upward turn of the shoulder (rad).
    pub shrug: f64,
}

impl KeyedHandPose {
    /// A hanging hand; its held position is in front of the belly.
    pub const HANGING: Self = Self {
        held: 0.0,
        body: DVec3::new(0.16, -0.42, 0.2),
        room: DVec3::new(0.15, 0.66, 0.26),
        placed: 0.0,
        pole: DVec3::new(0.5, -1.0, -0.4),
        twist: 0.5,
        flex: 0.0,
        reach: 0.0,
        shrug: 0.0,
    };

    /// Equal pose of the other hand.
    pub fn mirrored(self) -> Self {
        let flip = |v: DVec3| DVec3::new(-v.x, v.y, v.z);
        Self { body: flip(self.body), room: flip(self.room), pole: flip(self.pole), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_and_back() {
        let body: [f64; 9] = std::array::from_fn(|i| i as f64);
        assert_eq!(bytemuck::cast::<KeyedPosture, [f64; 9]>(bytemuck::cast(body)), body);
        let hand: KeyedHandPose = bytemuck::cast(std::array::from_fn::<f64, 15, _>(|i| i as f64));
        assert_eq!((hand.body.x, hand.placed, hand.shrug), (1.0, 7.0, 14.0));
        assert_eq!(hand.mirrored().mirrored(), hand);
    }
}
