//! Linkages: the planned joints of a limb, and their places in a pose.

use crate::rotation::Rigid;
use glam::{DQuat, DVec3};
use throng_base::maths::slerp;
use throng_core::{Contacts, Joint, Skeleton};

/// Most joints of a linkage.
pub const MAX_JOINTS: usize = 4;

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
    pub const fn joints(self) -> [Joint; 3] {
        match self {
            Self::LeftArm => [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand],
            Self::RightArm => [Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand],
            Self::LeftLeg => [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot],
            Self::RightLeg => [Joint::RightThigh, Joint::RightShin, Joint::RightFoot],
        }
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
        match self {
            Self::LeftArm => "left_arm",
            Self::RightArm => "right_arm",
            Self::LeftLeg => "left_leg",
            Self::RightLeg => "right_leg",
        }
    }
}

/// The joints that are planned (c^P in the paper): a limb, an arm's clavicle too if wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Linkage {
    /// The limb.
    pub limb: Limb,
    /// True where the clavicle moves along; arms only.
    pub with_clavicle: bool,
}

impl Linkage {
    /// A limb alone.
    pub const fn limb(limb: Limb) -> Self {
        Self { limb, with_clavicle: false }
    }

    /// Number of joints (3 or 4).
    pub const fn len(self) -> usize {
        3 + self.first() as usize
    }

    /// Always false.
    pub const fn is_empty(self) -> bool {
        false
    }

    const fn first(self) -> bool {
        self.with_clavicle && self.limb.is_arm()
    }

    /// The joints, from the trunk outwards; the last one is repeated to fill the array.
    pub fn joints(self) -> [Joint; MAX_JOINTS] {
        let [a, b, c] = self.limb.joints();
        match a.parent() {
            Some(clavicle) if self.first() => [clavicle, a, b, c],
            _ => [a, b, c, c],
        }
    }

    /// Index of a joint in the linkage.
    pub fn index_of(self, joint: Joint) -> Option<usize> {
        self.joints()[..self.len()].iter().position(|j| *j == joint)
    }

    /// The joint that carries the linkage, which an external motion drives.
    pub fn base(self) -> Joint {
        self.joints()[0].parent().unwrap_or(Joint::Hips)
    }
}

/// Rotation of each joint of a linkage relative to its parent; identity behind the last one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbPose(pub [DQuat; MAX_JOINTS]);

impl LimbPose {
    /// No joint is turned.
    pub const REST: Self = Self([DQuat::IDENTITY; MAX_JOINTS]);

    /// The pose at a share of the shortest arcs of the first `len` joints to another pose.
    pub(crate) fn slerp(&self, to: &Self, share: f64, len: usize) -> Self {
        Self(std::array::from_fn(|i| if i < len { slerp(self.0[i], to.0[i], share) } else { self.0[i] }))
    }
}

/// A linkage with lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain {
    /// The joints.
    pub linkage: Linkage,
    /// Offset of each joint from its parent, the first one's from the base (m).
    pub offsets: [DVec3; MAX_JOINTS],
    /// End of the hand or foot in the frame of the last joint (m).
    pub tip: DVec3,
}

/// Distance from the wrist to the end of the hand, as a share of the forearm.
const HAND: f64 = 0.4;

impl Chain {
    /// The chain of a linkage of a skeleton.
    pub fn new(linkage: Linkage, skeleton: &Skeleton) -> Self {
        let offset = |j: Joint| skeleton.offsets[j.index()].as_dvec3();
        let offsets = linkage.joints().map(offset);
        let tip = match linkage.limb {
            Limb::LeftLeg => offset(Joint::LeftToe),
            Limb::RightLeg => offset(Joint::RightToe),
            Limb::LeftArm | Limb::RightArm => HAND * offsets[linkage.len() - 1],
        };
        Self { linkage, offsets, tip }
    }

    /// Number of joints (3 or 4).
    pub const fn len(&self) -> usize {
        self.linkage.len()
    }

    /// Always false.
    pub const fn is_empty(&self) -> bool {
        false
    }

    /// World transforms of the joints (len), followed by that of the base.
    pub fn place_joints(&self, base: &Rigid, pose: &LimbPose) -> [Rigid; MAX_JOINTS] {
        let mut out = [*base; MAX_JOINTS];
        let mut at = *base;
        for i in 0..self.len() {
            at = Rigid { position: at.transform_point(self.offsets[i]), rotation: at.rotation * pose.0[i] };
            out[i] = at;
        }
        out
    }

    /// Ends of the joints' segments: the points that each rotation moves (len) (m).
    pub fn segment_ends(&self, placed: &[Rigid; MAX_JOINTS]) -> [DVec3; MAX_JOINTS] {
        let last = self.len() - 1;
        std::array::from_fn(|i| match i.cmp(&last) {
            std::cmp::Ordering::Less => placed[i + 1].position,
            std::cmp::Ordering::Equal => placed[last].transform_point(self.tip),
            std::cmp::Ordering::Greater => DVec3::ZERO,
        })
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
        let chain = Chain::new(Linkage::limb(Limb::LeftArm), &s);
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
    fn a_clavicle_comes_first_and_legs_have_none() {
        let with = |limb| Linkage { limb, with_clavicle: true };
        let arm = with(Limb::RightArm);
        assert_eq!((arm.len(), arm.joints()[0], arm.base()), (4, Joint::RightClavicle, Joint::UpperChest));
        assert_eq!((with(Limb::LeftLeg).len(), with(Limb::LeftLeg).base()), (3, Joint::Hips));
        assert_eq!(arm.index_of(Joint::RightHand), Some(3));
        assert_eq!(Linkage::limb(Limb::LeftArm).index_of(Joint::LeftClavicle), None);
    }
}
