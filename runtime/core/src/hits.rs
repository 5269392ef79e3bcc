//! Effective hits: moments at which a fist, foot or other joint could deliver a blow (Lee and Lee 2004, section 6, annotation).

use crate::skeleton::{Joint, Skeleton};
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};
use throng_base::maths;
pub use throng_base::thresholds::FIST_PER_FOREARM;

/// Names of the kinds of [`HitRecord::kind`] that every bundle has; those of tags follow.
pub const KIND_NAMES: [&str; 2] = ["punch", "kick"];

/// Effective hit. Positions are relative to the planar root of its frame: +X left, Y above the ground, +Z ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct HitRecord {
    /// Frame row of the hit.
    pub frame: u32,
    /// Number of the kind: one of [`KIND_NAMES`], or a tag in [`crate::format::Meta::hit_kinds`].
    pub kind: u32,
    /// The joint that strikes, by index: a hand, a foot, or what a tag names.
    pub joint: u32,
    /// Speed over that of the fastest hit of its kind (> 0, <= 1).
    pub force: f32,
    /// Effective hitting point: the tip of the fist or foot (m).
    pub position: [f32; 3],
    /// Speed of that point (m/s, >= 0).
    pub speed_mps: f32,
    /// Direction in which it moves, of unit length.
    pub direction: [f32; 3],
    /// Zero.
    pub reserved: u32,
}

const _: () = assert!(size_of::<HitRecord>() == 48);

impl HitRecord {
    /// Effective hitting point, as seen from the planar root (m).
    pub fn position(&self) -> Vec3 {
        self.position.into()
    }

    /// Direction of the blow, as seen from the planar root, of unit length.
    pub fn direction(&self) -> Vec3 {
        self.direction.into()
    }
}

/// The point of a joint that strikes, in the joint's own frame: the tip of the fist for a hand, the ball of the foot
/// for a foot, the joint itself for any other (m).
pub fn striking_offset(skeleton: &Skeleton, joint: Joint) -> Vec3 {
    match joint {
        Joint::LeftHand | Joint::RightHand => skeleton.offsets[joint.index()] * FIST_PER_FOREARM,
        Joint::LeftFoot => skeleton.offsets[Joint::LeftToe.index()],
        Joint::RightFoot => skeleton.offsets[Joint::RightToe.index()],
        _ => Vec3::ZERO,
    }
}

/// World position of the striking point of a joint (m).
pub fn striking_point(skeleton: &Skeleton, joint: Joint, position: Vec3, rotation: Quat) -> Vec3 {
    position + maths::rotate(rotation, striking_offset(skeleton, joint))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fists_reach_beyond_the_wrist_along_the_forearm() {
        let s = Skeleton::default();
        let (left, right) = (striking_offset(&s, Joint::LeftHand), striking_offset(&s, Joint::RightHand));
        assert!(left.x > 0.05 && left.x < 0.13, "{left}");
        assert!((left * Vec3::new(-1.0, 1.0, 1.0)).distance(right) < 1e-6);
        assert_eq!(striking_offset(&s, Joint::Head), Vec3::ZERO);
        let turned = striking_point(&s, Joint::LeftHand, Vec3::Y, Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2));
        assert!(turned.distance(Vec3::new(0.0, 1.0, left.x)) < 1e-6, "{turned}");
    }
}
