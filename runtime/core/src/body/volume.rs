//! The volume of a body: one capsule for each joint, which pictures, blows, plans, reports and tests of clearance share.

use crate::skeleton::{Joint, NUM_JOINTS, Skeleton};
use glam::Vec3;
use throng_base::thresholds::{FIST_PER_FOREARM, REFERENCE_LEG_M};
use throng_geometry::{Capsule, overlap_depth};

/// Capsule of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointCapsule {
    /// Joint that carries it.
    pub joint: Joint,
    /// Ends of its axis in the joint's frame (m).
    pub ends: [Vec3; 2],
    /// Radius (m).
    pub radius: f32,
    /// Joint at the second end, where the axis follows a bone.
    pub next: Option<Joint>,
}

/// Capsules of a body, by the index of their joint.
///
/// Trunk, head and thighs are as wide and deep as those of an adult of 1.75 m; limbs are of the mean thickness of their
/// length. Other bodies are scaled by the length of their legs.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyVolume {
    /// (NUM_JOINTS)
    pub capsules: [JointCapsule; NUM_JOINTS],
}

impl BodyVolume {
    /// Joints whose capsules are trunk, neck and head.
    pub const CORE: [Joint; 6] = [Joint::Head, Joint::Neck, Joint::UpperChest, Joint::Chest, Joint::Spine, Joint::Hips];

    /// Volume of a body with a skeleton's proportions.
    pub fn new(skeleton: &Skeleton) -> Self {
        let scale = Self::scale(skeleton);
        Self { capsules: Joint::ALL.map(|joint| fit_capsule(skeleton, joint, scale)) }
    }

    /// Size of a body over that of the default skeleton, by the length of its legs (1).
    pub fn scale(skeleton: &Skeleton) -> f32 {
        skeleton.leg_length() / REFERENCE_LEG_M
    }

    /// Radius of a joint's capsule on the default skeleton (m).
    ///
    /// Radii are chosen: those of the trunk are half of its depth, those of limbs are between the radii of their two ends.
    pub const fn radius_m(joint: Joint) -> f32 {
        use Joint::*;
        match joint {
            Hips | Spine | Chest | UpperChest => 0.12,
            Head => 0.1,
            LeftThigh | RightThigh => 0.08,
            Neck => 0.06,
            LeftShin | RightShin => 0.055,
            LeftClavicle | RightClavicle | LeftUpperArm | RightUpperArm => 0.05,
            LeftForearm | RightForearm | LeftHand | RightHand => 0.042,
            LeftFoot | RightFoot => 0.033,
            LeftToe | RightToe => 0.022,
        }
    }

    /// Capsules of [`Self::CORE`] in a pose.
    ///
    /// - `place`: a point in a joint's frame, put where the pose has it (m).
    pub fn place_core(&self, place: impl Fn(Joint, Vec3) -> Vec3) -> [Capsule; Self::CORE.len()] {
        Self::CORE.map(|joint| self.capsules[joint.index()].placed(&place))
    }

    /// Deepest overlap of any capsule of one body with any of another; `least` where that is lower (m).
    pub fn overlap_depth(a: &[Capsule], b: &[Capsule], least: f32) -> f32 {
        let mut deepest = least;
        for p in a {
            for q in b {
                // Spheres around the capsules first: most pairs are far apart.
                if p.bounding_gap(q) < -deepest {
                    deepest = deepest.max(overlap_depth(p, q));
                }
            }
        }
        deepest
    }
}

impl JointCapsule {
    /// The capsule in a pose.
    ///
    /// - `place`: a point in a joint's frame, put where the pose has it (m).
    #[inline]
    pub fn placed(&self, place: impl Fn(Joint, Vec3) -> Vec3) -> Capsule {
        Capsule { ends: self.ends.map(|end| place(self.joint, end)), radius: self.radius }
    }
}

fn fit_capsule(skeleton: &Skeleton, joint: Joint, scale: f32) -> JointCapsule {
    use Joint::*;
    let to = |j: Joint| skeleton.offsets[j.index()];
    // Flat parts are capsules from side to side, shorter than the body is wide by about their radius.
    let aside = |x: f32, up: Vec3| [up + Vec3::X * x.abs(), up - Vec3::X * x.abs()];
    let [head, left_toe, right_toe] = skeleton.tips;
    let (ends, next) = match joint {
        Hips => (aside(0.5 * to(LeftThigh).x, Vec3::ZERO), None),
        UpperChest => (aside(0.4 * (to(LeftClavicle) + to(LeftUpperArm)).x, 0.3 * to(Neck)), None),
        Head => ([0.35 * head, 0.55 * head], None),
        LeftHand | RightHand => ([Vec3::ZERO, FIST_PER_FOREARM * to(joint)], None),
        LeftFoot => ([Vec3::ZERO, 0.9 * to(LeftToe)], Some(LeftToe)),
        RightFoot => ([Vec3::ZERO, 0.9 * to(RightToe)], Some(RightToe)),
        LeftToe => ([Vec3::ZERO, 0.7 * left_toe], None),
        RightToe => ([Vec3::ZERO, 0.7 * right_toe], None),
        bone => {
            let next = Joint::ALL[bone.index() + 1];
            ([Vec3::ZERO, to(next)], Some(next))
        }
    };
    JointCapsule { joint, ends, radius: BodyVolume::radius_m(joint) * scale, next }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_joint_is_in_the_volume_which_stands_on_the_ground() {
        let skeleton = Skeleton::default();
        let rest = skeleton.rest_positions();
        let volume = BodyVolume::new(&skeleton);
        for (joint, capsule) in Joint::ALL.into_iter().zip(&volume.capsules) {
            assert_eq!(capsule.joint, joint);
            assert!(capsule.next.is_none_or(|next| next.parent() == Some(joint)), "{}", joint.name());
        }
        let placed = volume.capsules.map(|c| c.placed(|joint, p| rest[joint.index()] + p));
        for at in rest {
            let gap = |c: &Capsule| throng_geometry::distance_to_segment(at, c.ends) - c.radius;
            assert!(placed.iter().map(gap).fold(f32::INFINITY, f32::min) < 0.0);
        }
        let ends = || placed.iter().flat_map(|c| c.ends.map(|end| (end.y - c.radius, end.y + c.radius)));
        assert!(ends().map(|e| e.0).fold(f32::INFINITY, f32::min).abs() < 0.01);
        let top = rest[Joint::Head.index()].y + skeleton.tips[0].y;
        assert!((ends().map(|e| e.1).fold(0.0, f32::max) - top).abs() < 0.02);
    }

    #[test]
    fn both_sides_are_alike_and_children_are_thinner() {
        let mut skeleton = Skeleton::default();
        skeleton.offsets.iter_mut().chain(&mut skeleton.tips).for_each(|o| *o *= 0.5);
        let (adult, child) = (BodyVolume::new(&Skeleton::default()), BodyVolume::new(&skeleton));
        for (adult, child) in adult.capsules.iter().zip(&child.capsules) {
            assert!((child.radius - 0.5 * adult.radius).abs() < 1e-6);
            let other = child.joint.mirrored();
            if other != child.joint {
                let other = &BodyVolume::new(&skeleton).capsules[other.index()];
                assert_eq!(other.ends, child.ends.map(|end| end * Vec3::new(-1.0, 1.0, 1.0)));
            }
        }
    }
}
