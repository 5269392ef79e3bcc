use super::*;
use crate::linkage::LimbPose;
use crate::problem::{LimbState, MovingSolid, Problem};
use crate::rotation::{Rigid, exp};
use crate::testing::{TestCharacter, solid};
use crate::track::RigidPath;
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::sync::Arc;
use throng_base::maths::slerp;
use throng_geometry::{SolidShape, TriangleMesh};

fn between(a: &LimbState, b: &LimbState, share: f64) -> LimbState {
    let mut pose = LimbPose::REST;
    for i in 0..3 {
        pose.0[i] = slerp(a.pose.0[i], b.pose.0[i], share);
    }
    LimbState { pose, time_s: a.time_s + share * (b.time_s - a.time_s) }
}

/// Balls, boxes and a sheet around the left arm, still and moving.
fn things(rng: &mut Pcg64Mcg) -> Vec<MovingSolid> {
    let sheet = Arc::new(crate::testing::hills(10));
    (0..4)
        .map(|i| {
            let mut v = |most: f64| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-most..most)));
            let size = v(0.1).abs() + DVec3::splat(0.02);
            let shape = match i {
                0 => SolidShape::ball(size.x),
                1 => SolidShape::cuboid(2.0 * size),
                2 => SolidShape::Mesh(sheet.clone()),
                _ => SolidShape::Round { core: throng_geometry::Segment::new(v(0.3), v(0.3)), radius: 0.01 },
            };
            let middle = DVec3::new(0.9, 1.4, 0.4);
            let mut place = || Rigid { position: middle + v(0.6), rotation: exp(v(1.2)) };
            let path = match i % 2 {
                0 => RigidPath::Still(place()),
                _ => RigidPath::from_keys(&[(0.0, place()), (0.3, place()), (0.6, place()), (1.0, place())]),
            };
            MovingSolid { name: format!("thing {i}"), shape, path }
        })
        .collect()
}

/// A problem whose ends, if they are free, are an edge.
fn edge(seed: u64) -> Option<(Problem, LimbState, LimbState)> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let s = TestCharacter::standing();
    let a = LimbState { pose: s.any_pose(&mut rng), time_s: rng.random_range(0.0..0.5) };
    let b = LimbState { pose: s.any_pose(&mut rng), time_s: a.time_s + rng.random_range(0.2..0.5) };
    // Part of the way: that is free more often.
    let b = between(&a, &b, rng.random_range(0.05..1.0));
    // The body is no matter here: only the arm moves among these things.
    let things = things(&mut rng);
    let allowed: Vec<_> = throng_core::Joint::ALL
        .into_iter()
        .filter(|j| !s.limb.joints().contains(j))
        .flat_map(|j| {
            let part = Some(j.name().to_owned());
            things.iter().map(move |t| crate::setup::AllowedContact {
                part: part.clone(),
                other: t.name.clone(),
                window_s: None,
            })
        })
        .collect();
    let ends = [(a.pose, a.time_s), (b.pose, b.time_s)];
    let spec = crate::setup::ProblemSpec { solids: &things, allowed: &allowed, ..s.spec(ends) };
    Problem::new(&spec).ok().map(|p| (p, a, b))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn what_is_proved_free_is_free_wherever_one_looks(seed in any::<u64>()) {
        let Some((problem, a, b)) = edge(seed) else { return Ok(()) };
        let mut checker = Checker::default();
        if checker.is_edge_free(&problem, &a, &b) {
            for i in 0..=300 {
                let at = between(&a, &b, f64::from(i) / 300.0);
                let hit = checker.deepest_hit(&problem, &at);
                prop_assert!(hit.is_none_or(|h| h.depth_m < 1e-9), "{hit:?} {}", at.time_s);
                for j in 0..3 {
                    prop_assert!(problem.limits[j].excess(at.pose.0[j]) < 2e-3);
                }
            }
        }
    }
}

#[test]
fn ways_that_are_clearly_free_are_proved() {
    let (mut free, mut proved, mut blocked) = (0, 0, 0);
    let mut checker = Checker::default();
    for seed in 0..600 {
        let Some((problem, a, b)) = edge(seed) else { continue };
        let samples = (0..=200).map(|i| between(&a, &b, f64::from(i) / 200.0));
        let mut least = f64::INFINITY;
        for at in samples {
            least = least.min(checker.clearance(&problem, &at, 0.1));
            // Even turns may lead out of an ellipse for a while.
            let outside = (0..3).map(|j| problem.limits[j].excess(at.pose.0[j])).fold(-1.0, f64::max);
            least = least.min(if outside > 0.0 { 0.0 } else { 0.1 });
            if checker.deepest_hit(&problem, &at).is_some_and(|h| h.depth_m > 1e-9) {
                least = -1.0;
                break;
            }
        }
        let is_free = checker.is_edge_free(&problem, &a, &b);
        if least > 0.008 && problem.least_time(&a.pose, &b.pose).0 <= b.time_s - a.time_s {
            free += 1;
            proved += u32::from(is_free);
        } else if least < -0.5 {
            blocked += 1;
            assert!(!is_free);
        }
    }
    assert!(free > 30 && blocked > 10, "{free} {blocked}");
    assert_eq!(proved, free);
}

fn plate(thickness: f64) -> MovingSolid {
    let shape = SolidShape::cuboid(DVec3::new(thickness, 0.1, 0.1));
    solid("plate", shape, DVec3::new(0.0, 0.0, 0.0))
}

/// A stick of a hair's width swings through a plate as thin between two looks.
#[test]
fn a_thin_plate_between_two_looks_is_found_by_the_proof() {
    let mut s = TestCharacter::standing();
    for c in &mut s.shape.capsules {
        c.radius = if s.limb.joints().contains(&c.joint) { 5e-4 } else { c.radius };
    }
    let ends = [(s.pose(0.2, 0.0, 0.0), 0.0), (s.pose(-0.2, 0.0, 0.0), 1.0)];
    let open = s.problem(ends, &[]).expect("a problem");
    let (a, b) = (open.init, open.goal);
    let at = open.place_chain(&between(&a, &b, 0.5234));
    let along = at[2].rotation * DVec3::X;
    let mut wall = plate(1e-4);
    let normal = along.cross(DVec3::Y).normalize();
    let rotation = crate::rotation::rotation_between(DVec3::X, normal);
    wall.path = RigidPath::Still(Rigid { position: at[2].position, rotation });
    let spec = crate::setup::ProblemSpec { clearance_m: 0.0, solids: &[wall], ..s.spec(ends) };
    let problem = Problem::new(&spec).expect("ends are free");
    let mut checker = Checker::default();
    assert!(!checker.is_edge_free(&problem, &a, &b));
    assert!(checker.is_edge_free(&open, &a, &b));
}

/// What flies by between two looks is found, too.
#[test]
fn a_fast_ball_is_found_by_the_proof() {
    let s = TestCharacter::standing();
    let ends = [(s.pose(0.0, 0.0, 0.5), 0.0), (s.pose(0.0, 0.01, 0.5), 1.0)];
    let open = s.problem(ends, &[]).expect("a problem");
    let (a, b) = (open.init, open.goal);
    let hand = open.place_chain(&a)[2].position;
    let (from, to) = (hand + DVec3::new(0.0, 0.0, 3.0), hand + DVec3::new(0.0, 0.0, 6.0));
    let keys = [(0.30, from), (0.305, hand), (0.31, to)].map(|(t, p)| (t, Rigid::from_position(p)));
    let ball = MovingSolid { name: "ball".into(), shape: SolidShape::ball(0.02), path: RigidPath::from_keys(&keys) };
    let problem = s.problem(ends, &[ball]).expect("ends are free");
    let mut checker = Checker::default();
    assert!(!checker.is_edge_free(&problem, &a, &b));
}

#[test]
fn time_grows_and_joints_keep_their_speed() {
    let s = TestCharacter::standing();
    let problem = s.problem([(s.pose(0.0, 0.5, 0.5), 0.0), (s.pose(0.0, -0.5, 0.5), 1.0)], &[]).expect("a problem");
    let (a, b) = (problem.init, problem.goal);
    let mut checker = Checker::default();
    assert!(checker.is_edge_free(&problem, &a, &b));
    assert!(!checker.is_edge_free(&problem, &b, &a));
    let soon = LimbState { time_s: 0.9 * problem.least_time(&a.pose, &b.pose).0, ..b };
    assert!(!checker.is_edge_free(&problem, &a, &soon));
}

#[test]
fn a_contact_is_allowed_in_its_window_alone() {
    let s = TestCharacter::standing();
    let pose = s.pose(0.0, 0.0, 0.5);
    let ends = [(pose, 0.0), (s.pose(0.0, 0.001, 0.5), 1.0)];
    let hand = s.problem(ends, &[]).map(|p| p.place_chain(&p.init)[2].position).expect("a problem");
    let far = hand + DVec3::Y * 2.0;
    let keys = [(0.3, far), (0.4, hand), (0.6, hand), (0.7, far)].map(|(t, p)| (t, Rigid::from_position(p)));
    let cube = MovingSolid { name: "cube".into(), shape: SolidShape::ball(0.03), path: RigidPath::from_keys(&keys) };
    let free_in = |window: [f64; 2]| {
        let allowed = [crate::setup::AllowedContact { part: None, other: "cube".into(), window_s: Some(window) }];
        let solids = [cube.clone()];
        let spec = crate::setup::ProblemSpec { solids: &solids, allowed: &allowed, ..s.spec(ends) };
        let problem = Problem::new(&spec).expect("a problem");
        Checker::default().is_edge_free(&problem, &problem.init, &problem.goal)
    };
    assert!(free_in([0.3, 0.7]) && !free_in([0.5, 0.7]) && !free_in([0.8, 0.9]));
}

/// Distances of meshes and of the box that they draw agree where the arm is outside.
#[test]
fn a_mesh_of_a_box_is_as_far_as_the_box() {
    let s = TestCharacter::standing();
    let half = DVec3::new(0.1, 0.15, 0.05);
    let corner = |k: usize| {
        let sign = |bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
        (half * DVec3::new(sign(0), sign(1), sign(2))).as_vec3()
    };
    let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles: Vec<[Vec3; 3]> =
        faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|t| t.map(corner)).collect();
    let mesh = SolidShape::Mesh(Arc::new(TriangleMesh::new(triangles).expect("a mesh")));
    let at = DVec3::new(0.5, 1.3, 0.6);
    let ends = [(s.pose(0.5, 0.5, 0.2), 0.0), (s.pose(0.4, 0.4, 0.2), 1.0)];
    let both =
        [mesh, SolidShape::cuboid(2.0 * half)].map(|shape| s.problem(ends, &[solid("box", shape, at)]).expect("free"));
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let mut checkers = [Checker::default(), Checker::default()];
    for _ in 0..300 {
        let state = LimbState { pose: s.any_pose(&mut rng), time_s: 0.5 };
        let [a, b] = std::array::from_fn(|i| checkers[i].clearance(&both[i], &state, 0.5));
        assert!((a - b).abs() < 1e-6 || b <= 0.0 && a <= 0.005, "{a} {b}");
    }
}
