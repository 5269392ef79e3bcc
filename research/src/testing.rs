//! What tests of plans need: somebody who stands, and things around.

use glam::{DQuat, DVec3};
use throng_core::{NUM_JOINTS, Skeleton};
use throng_geometry::SolidShape;
use throng_planner::body::BodyCapsules;
use throng_planner::driven::DrivenMotion;
use throng_planner::limits::{BodyLimits, Coordinates};
use throng_planner::linkage::{Limb, LimbPose};
use throng_planner::problem::{LimbState, MovingSolid};
use throng_planner::rotation::Rigid;
use throng_planner::setup::ProblemSpec;
use throng_planner::track::RigidPath;

/// Somebody who stands at the origin and looks along +Z.
pub struct Somebody {
    pub skeleton: Skeleton,
    pub limits: BodyLimits,
    pub motion: DrivenMotion,
    pub shape: BodyCapsules,
    pub limb: Limb,
}

impl Somebody {
    pub fn standing() -> Self {
        let skeleton = Skeleton::default();
        let motion = DrivenMotion::from_pose(&skeleton, skeleton.offsets[0].as_dvec3(), [DQuat::IDENTITY; NUM_JOINTS]);
        Self {
            limits: BodyLimits::built_in(&skeleton),
            shape: BodyCapsules::fitted(&skeleton),
            motion,
            skeleton,
            limb: Limb::LeftArm,
        }
    }

    /// Shoulder by its swing, elbow by its flexion (rad).
    pub fn pose(&self, across: f64, up: f64, flexion: f64) -> LimbPose {
        let limits = self.limits.limb_limits(self.limb).expect("limits");
        let mut pose = LimbPose::REST;
        pose.0[0] = limits[0].rotation(Coordinates { swing: [across, up], twist: 0.0 });
        pose.0[1] = limits[1].rotation(Coordinates { swing: [flexion, 0.0], twist: 0.0 });
        pose
    }

    pub fn spec(&self, ends: [(LimbPose, f64); 2]) -> ProblemSpec<'_> {
        let ends = ends.map(|(pose, time_s)| LimbState { pose, time_s });
        ProblemSpec::new(&self.skeleton, self.limb, &self.limits, &self.motion, &self.shape, ends)
    }
}

pub fn solid(name: &str, shape: SolidShape, at: DVec3) -> MovingSolid {
    MovingSolid { name: name.into(), shape, path: RigidPath::Still(Rigid::from_position(at)) }
}
