use super::distance::{BoundedSolid, RecheckCapsule, capsule_distance, solid_distance};
use super::*;
use crate::clips::with_motion;
use crate::driven::DrivenMotion;
use crate::linkage::LimbPose;
use crate::planner::{Budget, LimbPlanner, PlanConfig};
use crate::problem::{LimbState, Problem};
use crate::rotation::{Rigid, exp};
use crate::setup::ProblemSpec;
use crate::testing::{TestCharacter, solid};
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use std::sync::Arc;
use throng_geometry::{Segment, SolidShape};

/// A still clip of 60 frames with the arm somewhere.
fn clip(s: &TestCharacter, arm: &LimbPose) -> Clip {
    let mut row = vec![Quat::IDENTITY; NUM_JOINTS];
    for (i, j) in s.limb.joints().into_iter().enumerate() {
        row[j.index()] = arm.0[i].as_quat();
    }
    Clip::new("still", 30.0, vec![s.skeleton.offsets[0]; 60], row.repeat(60))
}

/// The hand gives way to a ball that comes by, and a table is in the way.
fn planned(s: &TestCharacter) -> (Clip, Clip, Vec<MovingSolid>, Problem) {
    let arm = s.pose(0.0, -0.2, 0.4);
    let before = clip(s, &arm);
    let motion = DrivenMotion::from_clip(&before, &s.skeleton, 0.0, 2.0);
    let ends = [0.5, 1.5].map(|t| LimbState { pose: motion.limb_pose(s.limb, t), time_s: t });
    let spec = ProblemSpec::new(&s.skeleton, s.limb, &s.limits, &motion, &s.shape, ends);
    let free = Problem::new(&spec).expect("a problem");
    let hand = free.place_chain(&ends[0])[2].position;
    let keys = [(0.6, 2.0), (1.0, 0.0), (1.4, 2.0)].map(|(t, z)| (t, Rigid::from_position(hand + DVec3::Z * z)));
    let ball = MovingSolid {
        name: "ball".into(),
        shape: SolidShape::ball(0.08),
        path: crate::track::RigidPath::from_keys(&keys),
    };
    let hills = SolidShape::Mesh(Arc::new(crate::testing::hills(30)));
    let solids = vec![ball, solid("hills", hills, hand - DVec3::Y * 0.45 + DVec3::Z * 1.1)];
    let problem = Problem::new(&ProblemSpec { solids: &solids, ..spec }).expect("a problem");
    let mut planner = LimbPlanner::new();
    let outcome = planner.plan(&problem, &PlanConfig::default(), &Budget::default());
    assert!(outcome.is_solved(), "{outcome:?}");
    let after = with_motion(&before, 0.0, s.limb, &planner.motion().expect("a motion")).expect("it fits");
    (before, after, solids, problem)
}

fn check<'a>(
    s: &'a TestCharacter,
    clips: [&'a Clip; 2],
    solids: &'a [MovingSolid],
    planned: &'a [(Joint, JointLimits)],
) -> Recheck<'a> {
    Recheck {
        skeleton: &s.skeleton,
        before: clips[0],
        after: clips[1],
        span_s: [0.5, 1.5],
        planned,
        capsules: &s.shape.capsules,
        held: &[],
        solids,
        others: &[],
        allowed: &[],
        penetration_m: 1e-3,
        self_press_m: crate::setup::SELF_PRESS_M,
    }
}

#[test]
fn a_plan_passes_and_what_is_damaged_does_not() {
    let s = TestCharacter::standing();
    let (before, after, solids, problem) = planned(&s);
    let joints = s.limb.joints();
    let planned: Vec<_> = (0..3).map(|i| (joints[i], problem.limits[i])).collect();
    let report = check(&s, [&before, &after], &solids, &planned).run();
    assert_eq!(report.violations, []);
    assert!(report.samples == 1001 && report.clearance_min_m > 0.003 && report.penetration_max_m == 0.0, "{report:?}");
    // The clip as it was has the ball in its hand.
    let report = check(&s, [&before, &before], &solids, &planned).run();
    assert!(report.penetration_max_m > 0.05 && report.violations.iter().any(|v| v.what.contains("deep in ball")));
    // Allowed, nothing is wrong.
    let allowed = [AllowedContact { part: None, other: "ball".into(), window_s: None }];
    let touching = Recheck { allowed: &allowed, ..check(&s, [&before, &before], &solids, &planned) };
    assert_eq!(touching.run().violations, []);
    // Something else moved; a joint jumps; another is bent backwards.
    let damaged = |frame: usize, joint: Joint, by: Quat| {
        let mut clip = after.clone();
        clip.rotations[frame * NUM_JOINTS + joint.index()] *= by;
        check(&s, [&before, &clip], &solids, &planned).run().violations
    };
    let turn = Quat::from_rotation_y(0.7);
    assert!(damaged(20, Joint::Head, turn)[0].what.contains("head changed outside of the plan"));
    assert!(damaged(50, joints[0], turn)[0].what.contains("left_upper_arm changed"));
    assert!(damaged(30, joints[0], turn).iter().any(|v| v.what.contains("turns at")));
    let back = Quat::from_rotation_y(1.5);
    assert!(damaged(30, joints[1], back).iter().any(|v| v.what.contains("out of limits")));
}

#[test]
fn limits_are_those_of_the_planner_by_another_way() {
    let s = TestCharacter::standing();
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    for limb in crate::linkage::Limb::ALL {
        let limits = s.limits.limb_limits(limb).expect("limits");
        for _ in 0..300 {
            let v: [f64; 3] = std::array::from_fn(|_| rand::RngExt::random_range(&mut rng, -1.2..1.2));
            let q = exp(DVec3::from(v));
            for l in &limits {
                let [a, b] = [limit_excess(l, q.as_quat()), l.excess(q.as_quat().as_dquat().normalize())];
                assert!((a - b).abs() < 1e-5, "{a} {b}");
            }
        }
    }
}

proptest! {
    #[test]
    fn distances_agree_with_the_planners(v in prop::array::uniform9(-0.6f64..0.6), turn in prop::array::uniform3(-1.0f64..1.0)) {
        let p = |i: usize| DVec3::new(v[i], v[i + 1], v[i + 2]);
        let core = RecheckCapsule { a: p(0), b: p(3), radius: 0.04 };
        let s = Segment::new(core.a, core.b);
        let other = RecheckCapsule { a: p(6), b: p(2), radius: 0.03 };
        let gap = s.distance(&Segment::new(other.a, other.b)) - 0.07;
        prop_assert!((capsule_distance(&core, &other) - gap).abs() < 1e-6);
        let place = Rigid { position: p(6), rotation: exp(DVec3::from(turn)) };
        let local = s.map(|x| place.local_point(x));
        let hills = SolidShape::Mesh(Arc::new(crate::testing::hills(8)));
        for shape in [SolidShape::ball(0.1), SolidShape::cuboid(DVec3::new(0.2, 0.3, 0.1)), hills] {
            let gap = shape.distance(&local, 9.0) - 0.04;
            let solid = MovingSolid { name: String::new(), shape, path: crate::track::RigidPath::Still(place) };
            prop_assert!((solid_distance(&core, &BoundedSolid::new(&solid), 0.0, 9.0) - gap).abs() < 1e-5);
        }
    }
}

#[test]
fn a_stick_in_the_hand_counts_and_so_does_somebody_else() {
    let s = TestCharacter::standing();
    let arm = s.pose(0.0, -0.2, 0.4);
    let before = clip(&s, &arm);
    let planned: Vec<_> = s.limb.joints().into_iter().zip(s.limits.limb_limits(s.limb).expect("limits")).collect();
    let hand = crate::driven::place_joints(&s.skeleton, s.skeleton.offsets[0].as_dvec3(), &{
        let mut turns = [DQuat::IDENTITY; NUM_JOINTS];
        for (i, j) in s.limb.joints().into_iter().enumerate() {
            turns[j.index()] = arm.0[i];
        }
        turns
    })[Joint::LeftHand.index()];
    let solids = [solid("lamp", SolidShape::ball(0.05), hand.transform_point(DVec3::X * 0.8))];
    let held = [HeldCapsule { name: "stick".into(), core: Segment::new(DVec3::ZERO, DVec3::X), radius: 0.01 }];
    let with = Recheck { held: &held, ..check(&s, [&before, &before], &solids, &planned) }.run();
    assert!(with.violations.iter().all(|v| v.what.contains("stick is")) && with.violations.len() == 1001);
    assert_eq!(check(&s, [&before, &before], &solids, &planned).run().violations, []);
    let mut there = before.clone();
    for p in &mut there.root_positions {
        *p += hand.position.as_vec3() - Vec3::Y;
    }
    let others = [OtherClip { name: "Bo", clip: &there, skeleton: &s.skeleton, capsules: &s.shape.capsules }];
    let with = Recheck { others: &others, ..check(&s, [&before, &before], &[], &planned) }.run();
    assert!(with.violations.iter().any(|v| v.what.contains("deep in Bo")));
}
