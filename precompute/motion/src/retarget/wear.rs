//! Motion of the database skeleton on a body of another make: the way back of retargeting, one pose at a time.

use super::align::{self, Alignment};
use super::body::{Body, Source};
use super::legs::Legs;
use super::proportions;
use super::transfer::{SHOULDERS, shoulder};
use super::{check, check_legs};
use crate::error::BuildError;
use crate::import::Imported;
use glam::{Quat, Vec3};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS, Skeleton};

/// A body that wears motion.
pub struct Fit {
    alignment: Alignment,
    /// Its own proportions (m).
    skeleton: Skeleton,
    has_toes: [bool; 2],
}

/// A pose of the body that wears it.
pub struct Worn {
    /// Where its hips are, where it is as tall as the wish was (m).
    pub hips: Vec3,
    /// How each role's joint is turned against its rest in the world (NUM_JOINTS).
    pub joints: [Quat; NUM_JOINTS],
    /// How each joint of the database skeleton is turned in the world (NUM_JOINTS).
    pub model: [Quat; NUM_JOINTS],
}

impl Fit {
    /// Measures a body by its rest pose.
    ///
    /// # Errors
    /// [`BuildError::Stage`] for a body without hips, thighs, shins or feet, or without legs to measure.
    pub fn new(body: &Imported) -> Result<Self, BuildError> {
        let source: Source = body.into();
        check(&source)?;
        let body = Body::measure(&[source]);
        check_legs(&source, &body)?;
        let alignment = align::align(&body);
        let skeleton = proportions::own(&body, &alignment);
        Ok(Self { alignment, skeleton, has_toes: [Joint::LeftToe, Joint::RightToe].map(|j| body.has(j)) })
    }

    /// A body like the database skeleton, with proportions of its own.
    pub fn of(skeleton: Skeleton) -> Self {
        Self { alignment: [Quat::IDENTITY; NUM_JOINTS], skeleton, has_toes: [true; 2] }
    }

    /// How long its legs are (m).
    pub fn leg_length(&self) -> f32 {
        self.skeleton.leg_length()
    }

    /// The body, so much larger.
    pub fn scaled(&self, by: f32) -> Self {
        let mut skeleton = self.skeleton.clone();
        skeleton.offsets.iter_mut().chain(&mut skeleton.tips).for_each(|o| *o *= by);
        Self { alignment: self.alignment, skeleton, has_toes: self.has_toes }
    }

    /// Lays a pose on the body: every joint turns as it does, but clavicles, which move shoulders as far, and legs, which
    /// put feet where they were.
    ///
    /// - `own`: the skeleton whose pose it is, with legs as long; `pose`: its joints in the world.
    pub fn wear(&self, own: &Skeleton, pose: &[(Vec3, Quat); NUM_JOINTS]) -> Worn {
        let target = &self.skeleton;
        let mut model = pose.map(|(_, r)| r);
        for (clavicle, arm) in SHOULDERS {
            let (i, chest) = (clavicle.index(), model[Joint::UpperChest.index()]);
            let local = maths::compose(chest.inverse(), model[i]);
            model[i] =
                maths::compose(chest, shoulder(local, own.offsets[arm.index()], target.offsets[arm.index()], 1.0));
        }
        let thighs = [Joint::LeftThigh.index(), Joint::RightThigh.index()];
        let middle = (target.offsets[thighs[0]] + target.offsets[thighs[1]]) * 0.5;
        let legs = Legs::new(own, target, 1.0, self.has_toes);
        let hips = (pose[thighs[0]].0 + pose[thighs[1]].0) * 0.5 + legs.rise() - model[0] * middle;
        legs.reach(&mut model, hips, pose);
        let joints = std::array::from_fn(|j| maths::compose(model[j], self.alignment[j].inverse()).normalize());
        Worn { hips, joints, model }
    }

    /// The way from a joint to another one below it in a T-pose (m).
    pub fn way(&self, from: Joint, to: Joint) -> Vec3 {
        let rest = self.skeleton.rest_positions();
        rest[to.index()] - rest[from.index()]
    }
}
