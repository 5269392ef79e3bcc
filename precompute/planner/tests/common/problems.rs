//! Fixtures of tests: a standing character, and solids around it.

use crate::body::BodyCapsules;
use crate::driven::DrivenMotion;
use crate::limits::{BodyLimits, Coordinates, PoseSampler, Style};
use crate::linkage::{Limb, LimbPose};
use crate::problem::{LimbState, MovingSolid, Problem};
use crate::rotation::Rigid;
use crate::setup::{ProblemError, ProblemSpec};
use crate::track::RigidPath;
use glam::{DQuat, DVec3, Vec3};
use rand_pcg::Pcg64Mcg;
use throng_core::{NUM_JOINTS, Skeleton};
use throng_geometry::{SolidShape, TriangleMesh};

/// A character that stands at the origin and looks along +Z.
pub struct TestCharacter {
    pub skeleton: Skeleton,
    pub limits: BodyLimits,
    pub motion: DrivenMotion,
    pub shape: BodyCapsules,
    pub limb: Limb,
}

impl TestCharacter {
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

    /// Arm pose: shoulder by its swing, elbow by its flexion (rad).
    pub fn pose(&self, across: f64, up: f64, flexion: f64) -> LimbPose {
        let limits = self.limits.limb_limits(self.limb).expect("limits");
        let mut pose = LimbPose::REST;
        pose.0[0] = limits[0].rotation(Coordinates { swing: [across, up], twist: 0.0 });
        pose.0[1] = limits[1].rotation(Coordinates { swing: [flexion, 0.0], twist: 0.0 });
        pose
    }

    pub fn any_pose(&self, rng: &mut Pcg64Mcg) -> LimbPose {
        let limits = self.limits.limb_limits(self.limb).expect("limits");
        PoseSampler::new(limits, &LimbPose::REST, Style::default(), 1).draw_pose(rng, 1)
    }

    pub fn spec(&self, ends: [(LimbPose, f64); 2]) -> ProblemSpec<'_> {
        let ends = ends.map(|(pose, time_s)| LimbState { pose, time_s });
        ProblemSpec::new(&self.skeleton, self.limb, &self.limits, &self.motion, &self.shape, ends)
    }

    pub fn problem(&self, ends: [(LimbPose, f64); 2], solids: &[MovingSolid]) -> Result<Problem, ProblemError> {
        Problem::new(&ProblemSpec { solids, ..self.spec(ends) })
    }
}

pub fn solid(name: &str, shape: SolidShape, at: DVec3) -> MovingSolid {
    MovingSolid { name: name.into(), shape, path: RigidPath::Still(Rigid::from_position(at)) }
}

/// Problem without a solution: an arm that hangs through a hole in a floor of plates is to come above it.
pub fn stuck(s: &TestCharacter) -> Problem {
    let mut hanging = LimbPose::REST;
    hanging.0[0] = crate::rotation::rotation_about(DVec3::Z, -1.5);
    hanging.0[1] = crate::rotation::rotation_about(DVec3::NEG_Y, 0.05);
    let ends = [(hanging, 0.0), (s.pose(0.0, 0.2, 0.3), 1.5)];
    let plate = |name: &str, [x, z]: [f64; 2], [wide, deep]: [f64; 2]| {
        solid(name, SolidShape::cuboid(DVec3::new(wide, 0.02, deep)), DVec3::new(x, 1.13, z))
    };
    let left = plate("left", [1.28, 0.0], [2.0, 4.0]);
    let [front, back] =
        [("front", 1.0), ("back", -1.0)].map(|(name, side)| plate(name, [0.0, side * 1.16], [4.0, 2.0]));
    s.problem(ends, &[left, front, back]).expect("a problem")
}

/// A hilly sheet, `n` by `n` squares of two triangles, 2 m wide.
pub fn hills(n: usize) -> TriangleMesh {
    let at = |i: usize, j: usize| {
        let (x, z) = (2.0 * i as f32 / n as f32 - 1.0, 2.0 * j as f32 / n as f32 - 1.0);
        Vec3::new(x, 0.2 * (3.0 * x).sin() * (4.0 * z).cos(), z)
    };
    let squares = (0..n * n).map(|k| (k % n, k / n));
    let corners = squares.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriangleMesh::new(corners.collect()).expect("a mesh")
}
