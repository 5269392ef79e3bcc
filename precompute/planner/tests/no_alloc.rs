//! A plan allocates nothing after the first one of its size.
#![allow(unsafe_code, reason = "an allocator that counts is an unsafe trait")]

#[path = "../../../tests/common/counting.rs"]
mod counting;

use counting::allocations;
use glam::{DQuat, DVec3};
use throng_core::{NUM_JOINTS, Skeleton};
use throng_geometry::SolidShape;
use throng_planner::body::BodyCapsules;
use throng_planner::driven::DrivenMotion;
use throng_planner::limits::{BodyLimits, Coordinates};
use throng_planner::linkage::{Limb, LimbPose};
use throng_planner::planner::{Budget, LimbPlanner, PlanConfig};
use throng_planner::problem::{LimbState, MovingSolid, Problem};
use throng_planner::rotation::Rigid;
use throng_planner::setup::ProblemSpec;
use throng_planner::track::RigidPath;

fn table() -> Problem {
    let skeleton = Skeleton::default();
    let limits = BodyLimits::built_in(&skeleton);
    let limb = Limb::LeftArm;
    let joints = limits.limb_limits(limb).expect("limits");
    let pose = |up: f64, flexion: f64| {
        let mut pose = LimbPose::REST;
        pose.0[0] = joints[0].rotation(Coordinates { swing: [0.0, up], twist: 0.0 });
        pose.0[1] = joints[1].rotation(Coordinates { swing: [flexion, 0.0], twist: 0.0 });
        pose
    };
    let motion = DrivenMotion::from_pose(&skeleton, skeleton.offsets[0].as_dvec3(), [DQuat::IDENTITY; NUM_JOINTS]);
    let shape = BodyCapsules::fitted(&skeleton);
    let ends = [LimbState { pose: pose(-1.2, 0.2), time_s: 0.0 }, LimbState { pose: pose(0.1, 0.3), time_s: 1.5 }];
    let plate = SolidShape::cuboid(DVec3::new(0.9, 0.03, 0.6));
    let path = RigidPath::Still(Rigid::from_position(DVec3::new(0.65, 1.2, 0.55)));
    let solids = [MovingSolid { name: "table".into(), shape: plate, path }];
    let spec = ProblemSpec::new(&skeleton, limb, &limits, &motion, &shape, ends);
    Problem::new(&ProblemSpec { solids: &solids, ..spec }).expect("a problem")
}

#[test]
fn a_plan_allocates_nothing_after_the_first_of_its_size() {
    let problem = table();
    let mut planner = LimbPlanner::new();
    let mut plan = |seed: u64| {
        allocations(|| {
            let outcome = planner.plan(&problem, &PlanConfig::default(), &Budget { seed, ..Budget::default() });
            assert!(outcome.is_solved());
        })
    };
    assert!(plan(3) > 0);
    for _ in 0..3 {
        assert_eq!(plan(3), 0);
    }
    // Others, as far as they are no larger than the largest before.
    let first: u64 = (0..40).map(&mut plan).sum();
    let later: u64 = (0..40).map(&mut plan).sum();
    assert!(first < 40 && later == 0, "{first} {later}");
}
