//! Limbs: their planned joints (c^P in the paper), and the places of these in a pose.

use crate::rotation::Rigid;
use glam::{DQuat, DVec3};
use throng_base::maths::slerp;
use throng_core::{Contacts, Joint, Skeleton};

/// Joints of a limb.
pub const LIMB_JOINTS: usize = 3;

/// An arm or a leg.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Limb {
    /// Shoulder, elbow, wrist.
    LeftArm,
    /// Shoulder, elbow, wrist.
    RightArm,
    /// Hip, knee, ankle.
    LeftLeg,
    /// Hip, knee, ankle.
    RightLeg,
}

impl Limb {
    /// All four.
    pub const ALL: [Self; 4] = [Self::LeftArm, Self::RightArm, Self::LeftLeg, Self::RightLeg];

    /// Its joints, from the trunk outwards.
    pub const fn joints(self) -> [Joint; LIMB_JOINTS] {
        match self {
            Self::LeftArm => [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand],
            Self::RightArm => [Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand],
            Self::LeftLeg => [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot],
            Self::RightLeg => [Joint::RightThigh, Joint::RightShin, Joint::RightFoot],
        }
    }

    /// Index of a joint in the limb.
    pub fn index_of(self, joint: Joint) -> Option<usize> {
        self.joints().iter().position(|j| *j == joint)
    }

    /// The joint that carries the limb, which an external motion drives.
    pub fn base(self) -> Joint {
        self.joints()[0].parent().unwrap_or(Joint::Hips)
    }

    /// True for the arms.
    pub const fn is_arm(self) -> bool {
        matches!(self, Self::LeftArm | Self::RightArm)
    }

    /// True for joints that move with the limb: its own, and fingers and toes behind them.
    pub fn moves_joint(self, joint: Joint) -> bool {
        std::iter::successors(Some(joint), |j| j.parent()).any(|j| self.joints().contains(&j))
    }

    /// The name in everyday words.
    pub(crate) fn words(self) -> String {
        self.name().replace('_', " ")
    }

    /// True where the foot of the limb, if it is a leg, is planted on a frame.
    pub(crate) fn is_planted(self, contacts: &[Contacts], frame: usize) -> bool {
        let foot = match self {
            Self::LeftLeg => Contacts::LEFT,
            Self::RightLeg => Contacts::RIGHT,
            Self::LeftArm | Self::RightArm => return false,
        };
        contacts.get(frame).is_some_and(|c| c.any(foot))
    }

    /// The name in snake_case, as tasks write it.
    pub const fn name(self) -> &'static str {
        ["left_arm", "right_arm", "left_leg", "right_leg"][self as usize]
    }
}

/// Rotation of each joint of a limb relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbPose(pub [DQuat; LIMB_JOINTS]);

impl LimbPose {
    /// No joint is turned.
    pub const REST: Self = Self([DQuat::IDENTITY; LIMB_JOINTS]);

    /// The pose at a share of the shortest arcs to another pose.
    pub(crate) fn slerp(&self, to: &Self, share: f64) -> Self {
        Self(std::array::from_fn(|i| slerp(self.0[i], to.0[i], share)))
    }
}

/// A limb with lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain {
    /// The limb.
    pub limb: Limb,
    /// Offset of each joint from its parent, the first one's from the base (m).
    pub offsets: [DVec3; LIMB_JOINTS],
    /// End of the hand or foot in the frame of the last joint (m).
    pub tip: DVec3,
}

/// Distance from the wrist to the end of the hand, as a share of the forearm.
const HAND: f64 = 0.4;

impl Chain {
    /// The chain of a limb of a skeleton.
    pub fn new(limb: Limb, skeleton: &Skeleton) -> Self {
        let offset = |j: Joint| skeleton.offsets[j.index()].as_dvec3();
        let offsets = limb.joints().map(offset);
        let tip = match limb {
            Limb::LeftLeg => offset(Joint::LeftToe),
            Limb::RightLeg => offset(Joint::RightToe),
            Limb::LeftArm | Limb::RightArm => HAND * offsets[LIMB_JOINTS - 1],
        };
        Self { limb, offsets, tip }
    }

    /// World transforms of the joints.
    pub fn place_joints(&self, base: &Rigid, pose: &LimbPose) -> [Rigid; LIMB_JOINTS] {
        let mut at = *base;
        std::array::from_fn(|i| {
            at = Rigid { position: at.transform_point(self.offsets[i]), rotation: at.rotation * pose.0[i] };
            at
        })
    }

    /// Ends of the joints' segments: the points that each rotation moves (m).
    pub fn segment_ends(&self, placed: &[Rigid; LIMB_JOINTS]) -> [DVec3; LIMB_JOINTS] {
        [placed[1].position, placed[2].position, placed[2].transform_point(self.tip)]
    }

    /// Longest distance from joint `from` to the origin of joint `to`, over all poses between them (m).
    pub fn longest_span(&self, from: usize, to: usize) -> f64 {
        self.offsets[from + 1..=to].iter().map(|o| o.length()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::rotation_about;

    #[test]
    fn a_bent_arm_is_where_it_is_worked_out_to_be() {
        let s = Skeleton::default();
        let chain = Chain::new(Limb::LeftArm, &s);
        let mut pose = LimbPose::REST;
        // The elbow bends forwards by a right angle: from +X to +Z.
        pose.0[1] = rotation_about(DVec3::NEG_Y, std::f64::consts::FRAC_PI_2);
        let placed = chain.place_joints(&Rigid::from_position(DVec3::new(0.03, 1.5, 0.0)), &pose);
        let elbow = DVec3::new(0.03 + f64::from(0.155f32) + f64::from(0.29f32), 1.5, 0.0);
        assert!((placed[1].position - elbow).length() < 1e-12);
        assert!((placed[2].position - elbow - DVec3::Z * f64::from(0.255f32)).length() < 1e-12);
        assert_eq!(chain.segment_ends(&placed)[0], placed[1].position);
    }

    #[test]
    fn limbs_hang_on_the_trunk() {
        assert_eq!((Limb::RightArm.joints()[0], Limb::RightArm.base()), (Joint::RightUpperArm, Joint::RightClavicle));
        assert_eq!(Limb::LeftLeg.base(), Joint::Hips);
        assert_eq!(Limb::RightArm.index_of(Joint::RightHand), Some(2));
        assert_eq!(Limb::LeftArm.index_of(Joint::LeftClavicle), None);
    }
}
