//! Feet in space: where the ball of a foot is, and how the foot is turned.

use glam::{Quat, Vec2, Vec3};
use throng_base::maths;
use throng_core::{Planar, Skeleton};
use throng_motion::{Clip, retarget::LEGS};

/// A foot: its ball, and the rotation of the foot and of the toes on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct MadeFoot {
    /// Position of the toe joint, the ball of the foot (m).
    pub toe: Vec3,
    /// Rotation of the foot.
    pub turn: Quat,
    /// Rotation of the toes relative to the foot.
    pub toes: Quat,
}

/// The foot of a clip at a frame, in the world.
pub(super) fn foot_point(clip: &Clip, skeleton: &Skeleton, frame: usize, foot: usize) -> MadeFoot {
    let [_, _, ankle, toe] = LEGS[foot].map(throng_core::Joint::index);
    let joints = clip.joint_transforms(skeleton, frame);
    MadeFoot { toe: joints[toe].0, turn: joints[ankle].1, toes: clip.frame_rotations(frame)[toe] }
}

impl MadeFoot {
    /// Place of the ball on the ground, and direction of the foot.
    pub fn planar(&self) -> Planar {
        let ahead = self.turn * Vec3::Z;
        Planar::new(self.toe.x, self.toe.z, maths::atan2(ahead.x, ahead.z))
    }

    /// This foot as seen from a place.
    pub fn seen_from(&self, place: Planar) -> Self {
        let at = place.inverse_transform_point(Vec2::new(self.toe.x, self.toe.z));
        let turn = maths::compose(maths::rotation_y(-place.heading), self.turn);
        Self { toe: Vec3::new(at.x, self.toe.y, at.y), turn, toes: self.toes }
    }

    /// This foot, seen from a place, in the world.
    pub fn laid_at(&self, place: Planar) -> Self {
        let at = place.transform_point(Vec2::new(self.toe.x, self.toe.z));
        let turn = maths::compose(maths::rotation_y(place.heading), self.turn);
        Self { toe: Vec3::new(at.x, self.toe.y, at.y), turn, toes: self.toes }
    }

    /// Between two feet.
    pub fn lerp(&self, other: &Self, share: f32) -> Self {
        Self {
            toe: self.toe.lerp(other.toe, share),
            turn: maths::slerp_f32(self.turn, other.turn, share),
            toes: maths::slerp_f32(self.toes, other.toes, share),
        }
    }
}
