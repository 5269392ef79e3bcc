use super::*;
use crate::problem::{MovingSolid, Problem};
use crate::rotation::Rigid;
use crate::testing::{TestCharacter, solid};
use crate::track::RigidPath;
use glam::DVec3;
use throng_geometry::{Segment, SolidShape};

fn somebody() -> (TestCharacter, [(crate::linkage::LimbPose, f64); 2]) {
    let s = TestCharacter::standing();
    let ends = [(s.pose(0.3, 0.3, 0.6), 0.0), (s.pose(-0.3, -0.3, 0.9), 1.0)];
    (s, ends)
}

#[test]
fn an_empty_world_is_no_problem() {
    let (s, ends) = somebody();
    let problem = s.problem(ends, &[]).expect("a problem");
    assert_eq!((problem.init.time_s, problem.goal.time_s), (0.0, 1.0));
}

#[test]
fn a_driven_part_in_a_solid_is_said_before_any_search() {
    let (s, ends) = somebody();
    let cut = SolidShape::cuboid(DVec3::new(0.2, 0.2, 0.2));
    let wall = solid("low wall", cut.clone(), DVec3::new(-0.1, 0.5, 0.0));
    let e = s.problem(ends, &[wall]).unwrap_err();
    assert!(
        matches!(&e, ProblemError::DrivenCollides { part, with, .. } if part.starts_with("right_") && with == "low wall")
    );
    // It comes at 0.7 s only.
    let [far, near] = [5.0, 0.0].map(|z| Rigid::from_position(DVec3::new(-0.1, 0.5, z)));
    let keys = [(0.5, far), (0.7, near), (0.9, far)];
    let gate = MovingSolid { name: "gate".into(), shape: cut, path: RigidPath::from_keys(&keys) };
    let e = s.problem(ends, std::slice::from_ref(&gate)).unwrap_err();
    assert!(matches!(e, ProblemError::DrivenCollides { time_s, .. } if (time_s - 0.7).abs() < 0.02), "{e}");
    assert!(e.to_string().contains("where the motion itself has it"), "{e}");
    let allowed = [AllowedContact { part: None, other: "gate".into(), window_s: None }];
    assert!(Problem::new(&ProblemSpec { solids: &[gate], allowed: &allowed, ..s.spec(ends) }).is_ok());
}

#[test]
fn ends_that_collide_name_the_pair_and_how_deep() {
    let (s, ends) = somebody();
    let free = s.problem(ends, &[]).expect("a problem");
    let hand = free.place_chain(&free.goal)[2].position;
    let ball = solid("lamp", SolidShape::ball(0.05), hand);
    let e = s.problem(ends, &[ball]).unwrap_err();
    let ProblemError::EndCollides { end, with, depth_m, .. } = &e else { panic!("{e}") };
    assert_eq!((*end, with.as_str()), ("goal", "lamp"));
    assert!((0.05..0.1).contains(depth_m), "{depth_m}");
    // The same as the start, with a little slack from the hand that may touch.
    let backwards = [(ends[1].0, 0.0), (ends[0].0, 1.0)];
    let e = s.problem(backwards, &[solid("lamp", SolidShape::ball(0.05), hand)]).unwrap_err();
    assert!(e.to_string().starts_with("the start collides: left_"), "{e}");
}

#[test]
fn too_little_time_says_the_least() {
    let (s, mut ends) = somebody();
    ends[1].1 = 0.01;
    let e = s.problem(ends, &[]).unwrap_err();
    let ProblemError::TooLittleTime { joint, least_s, .. } = &e else { panic!("{e}") };
    assert_eq!(joint, "left_upper_arm");
    ends[1].1 = least_s + 1e-9;
    assert!(s.problem(ends, &[]).is_ok());
}

#[test]
fn ends_outside_limits_are_refused_unless_admitted() {
    let (s, mut ends) = somebody();
    ends[0].0 = s.pose(0.0, 0.0, 0.5);
    ends[0].0.0[1] = crate::rotation::rotation_about(DVec3::Y, 0.4);
    let spec = s.spec(ends);
    let e = Problem::new(&spec).unwrap_err();
    assert!(
        matches!(&e, ProblemError::EndOutOfLimits { joint, by_rad, .. } if joint == "left_forearm" && (by_rad - 0.4).abs() < 1e-6)
    );
    assert!(Problem::new(&ProblemSpec { admit_ends: true, ..spec }).is_ok());
}

#[test]
fn numbers_that_are_none_are_refused() {
    let (s, ends) = somebody();
    let with = |solid: MovingSolid| s.problem(ends, &[solid]).unwrap_err().to_string();
    let good = solid("ball", SolidShape::ball(0.1), DVec3::splat(5.0));
    assert!(with(MovingSolid { shape: SolidShape::ball(f64::NAN), ..good.clone() }).contains("shape of `ball`"));
    assert!(
        with(MovingSolid { path: RigidPath::Still(Rigid::from_position(DVec3::NAN)), ..good.clone() })
            .contains("path of `ball`")
    );
    assert!(with(MovingSolid { path: RigidPath::from_keys(&[]), ..good.clone() }).contains("path of `ball`"));
    let spec = s.spec([(ends[0].0, 0.0), (ends[1].0, f64::NAN)]);
    assert!(Problem::new(&spec).unwrap_err().to_string().contains("the start before the goal"));
    let spec = s.spec([(ends[0].0, 1.0), (ends[1].0, 1.0)]);
    assert!(Problem::new(&spec).is_err());
    let held = [HeldCapsule { name: "stick".into(), core: Segment::new(DVec3::ZERO, DVec3::INFINITY), radius: 0.1 }];
    assert!(Problem::new(&ProblemSpec { held: &held, ..s.spec(ends) }).is_err());
    assert!(Problem::new(&ProblemSpec { clearance_m: -1.0, ..s.spec(ends) }).is_err());
    let mut nan = ends;
    nan[0].0.0[1] = glam::DQuat::from_xyzw(0.0, 0.0, f64::NAN, 1.0);
    assert!(Problem::new(&s.spec(nan)).is_err());
}

#[test]
fn allowances_name_what_there_is() {
    let (s, ends) = somebody();
    let solids = [solid("box", SolidShape::ball(0.1), DVec3::splat(5.0))];
    let allow = |part: Option<&str>, with: &str| {
        let allowed = [AllowedContact { part: part.map(Into::into), other: with.into(), window_s: None }];
        Problem::new(&ProblemSpec { solids: &solids, allowed: &allowed, ..s.spec(ends) }).map(|p| p.pairs.len())
    };
    let e = allow(Some("left_hnd"), "box").unwrap_err();
    assert!(e.to_string().contains("Did you mean `left_hand`?"), "{e}");
    assert!(allow(None, "bx").is_err());
    let all = s.problem(ends, &solids).expect("a problem").pairs.len();
    assert_eq!((allow(Some("left_hand"), "box"), allow(None, "box")), (Ok(all - 1), Ok(all - 3)));
}

#[test]
fn others_and_what_is_held_count() {
    let (s, ends) = somebody();
    let there = s.problem(ends, &[]).expect("a problem");
    let hand = there.place_chain(&there.init)[2];
    // A stick that reaches into somebody who stands two metres away, along the hand.
    let along = hand.rotation * DVec3::X;
    let mut away =
        crate::driven::DrivenMotion::from_pose(&s.skeleton, hand.position + along * 2.0, [glam::DQuat::IDENTITY; 22]);
    let held = [HeldCapsule { name: "stick".into(), core: Segment::new(DVec3::ZERO, DVec3::X * 2.0), radius: 0.02 }];
    let others = [OtherCharacter { name: "Bo", motion: &away, shape: &s.shape }];
    assert!(Problem::new(&ProblemSpec { others: &others, ..s.spec(ends) }).is_ok());
    let e = Problem::new(&ProblemSpec { others: &others, held: &held, ..s.spec(ends) }).unwrap_err();
    assert!(
        matches!(&e, ProblemError::EndCollides { part, with, .. } if part == "stick" && with.starts_with("Bo's ")),
        "{e}"
    );
    // Somebody in the same place.
    away = s.motion.clone();
    let others = [OtherCharacter { name: "Bo", motion: &away, shape: &s.shape }];
    let e = Problem::new(&ProblemSpec { others: &others, ..s.spec(ends) }).unwrap_err();
    assert!(matches!(e, ProblemError::DrivenCollides { .. }), "{e}");
}
