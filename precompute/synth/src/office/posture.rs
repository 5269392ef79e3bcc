//! Postures in an office, as channels that can be keyed: all zero in a neutral stand.

use super::super::attitude::Attitude;
use glam::DVec3;

/// Number of channels of a [`KeyedPosture`].
pub const BODY: usize = 9;
/// Number of channels of an [`Attitude`] of the head.
pub const HEAD: usize = 3;
/// Number of channels of a [`KeyedHandPose`].
pub const HAND: usize = 15;

/// Posture of hips and chest, in addition to balance and walking.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
    /// Values of the channels.
    pub fn channels(self) -> [f64; BODY] {
        let Self { hips: h, chest: c, shift: [x, z], dip } = self;
        [h.yaw, h.pitch, h.list, c.yaw, c.pitch, c.list, x, z, dip]
    }

    /// Posture with given channels.
    pub fn from_channels([hy, hp, hl, cy, cp, cl, x, z, dip]: [f64; BODY]) -> Self {
        let hips = Attitude { yaw: hy, pitch: hp, list: hl };
        Self { hips, chest: Attitude { yaw: cy, pitch: cp, list: cl }, shift: [x, z], dip }
    }
}

/// Pose of one hand: hanging as in walking, held before the body, or placed in the room.
#[derive(Clone, Copy, Debug, PartialEq)]
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

    /// Values of the channels.
    pub fn channels(self) -> [f64; HAND] {
        let Self { held, body: b, room: r, placed, pole: p, twist, flex, reach, shrug } = self;
        [held, b.x, b.y, b.z, r.x, r.y, r.z, placed, p.x, p.y, p.z, twist, flex, reach, shrug]
    }

    /// Pose with given channels.
    pub fn from_channels(c: [f64; HAND]) -> Self {
        let [held, bx, by, bz, rx, ry, rz, placed, px, py, pz, twist, flex, reach, shrug] = c;
        let (body, room, pole) = (DVec3::new(bx, by, bz), DVec3::new(rx, ry, rz), DVec3::new(px, py, pz));
        Self { held, body, room, placed, pole, twist, flex, reach, shrug }
    }

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
        let body: [f64; BODY] = std::array::from_fn(|i| i as f64);
        assert_eq!(KeyedPosture::from_channels(body).channels(), body);
        let hand: [f64; HAND] = std::array::from_fn(|i| i as f64);
        assert_eq!(KeyedHandPose::from_channels(hand).channels(), hand);
        assert_eq!(KeyedHandPose::from_channels(hand).mirrored().mirrored(), KeyedHandPose::from_channels(hand));
    }
}
