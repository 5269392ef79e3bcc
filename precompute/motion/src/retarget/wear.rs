//! Motion of the database skeleton on a body of another make: the inverse of retargeting, one pose at a time.

use super::{align::Alignment, legs::LegTransfer, plan::SkeletonGroup, transfer::move_shoulders};
use crate::{error::Result, import::ImportedClip};
use glam::{Quat, Vec3};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS, Skeleton};

/// Share of the length of the motion's legs below which those of a body are short: its hips are lower then.
const SHORT_LEGS: f32 = 0.98;

/// A body that wears motion.
pub struct BodyFit {
    alignment: Alignment,
    /// Its own proportions; its hips are above the ground that it stands on (m).
    pub skeleton: Skeleton,
    has_toes: [bool; 2],
}

/// A pose of the body that wears the motion.
pub struct WornPose {
    /// Position of its hips, where it is as tall as asked for (m).
    pub hips: Vec3,
    /// World rotation of each role's joint relative to its rest (NUM_JOINTS).
    pub joints: [Quat; NUM_JOINTS],
    /// World rotation of each joint of the database skeleton (NUM_JOINTS).
    pub model: [Quat; NUM_JOINTS],
}

impl BodyFit {
    /// Measures a body by its rest pose.
    ///
    /// # Errors
    /// [`crate::error::BuildError::Stage`] for a body without hips, thighs, shins or feet, or without legs to measure.
    pub fn new(body: &ImportedClip) -> Result<Self> {
        let SkeletonGroup { body, alignment, own, .. } = SkeletonGroup::measure_one(body.into())?;
        let has_toes = [Joint::LeftToe, Joint::RightToe].map(|j| body.has(j));
        Ok(Self { alignment, skeleton: own, has_toes })
    }

    /// A body like the database skeleton, with proportions of its own.
    pub fn from_skeleton(skeleton: Skeleton) -> Self {
        Self { alignment: [Quat::IDENTITY; NUM_JOINTS], skeleton, has_toes: [true; 2] }
    }

    /// The body, scaled by a factor.
    pub fn scaled(&self, by: f32) -> Self {
        let mut skeleton = self.skeleton.clone();
        skeleton.offsets.iter_mut().chain(&mut skeleton.tips).for_each(|o| *o *= by);
        Self { alignment: self.alignment, skeleton, has_toes: self.has_toes }
    }

    /// Puts a pose on the body: every joint turns as in the pose, but clavicles, which move shoulders as far, and legs, which
    /// put the feet at the same places.
    ///
    /// - `source_skeleton`: skeleton of the pose, with legs of equal length; `pose`: world transforms of its joints.
    pub fn wear_pose(&self, own: &Skeleton, pose: &[(Vec3, Quat); NUM_JOINTS]) -> WornPose {
        let target = &self.skeleton;
        let mut model = pose.map(|(_, r)| r);
        move_shoulders(&mut model, own, target, 1.0);
        let legs = LegTransfer::new(own, target, 1.0, self.has_toes);
        let mut hips = legs.hips(model[0], pose);
        if target.leg_length() < SHORT_LEGS * own.leg_length() {
            hips.y -= legs.shortfall(&model, hips, pose);
        }
        legs.reach_feet(&mut model, hips, pose);
        let joints = std::array::from_fn(|j| maths::compose(model[j], self.alignment[j].inverse()).normalize());
        WornPose { hips, joints, model }
    }

    /// The offset of a joint from another one above it in a T-pose (m).
    pub fn t_pose_offset(&self, from: Joint, to: Joint) -> Vec3 {
        let rest = self.skeleton.rest_positions();
        rest[to.index()] - rest[from.index()]
    }
}
