use super::*;
use crate::driven::DrivenMotion;
use crate::problem::MovingSolid;
use crate::rotation::{angle_between, rotation_about};
use crate::setup::{AllowedContact, HeldCapsule};
use crate::testing::TestCharacter;
use crate::track::RigidPath;
use glam::{DVec3, Quat};
use throng_core::{Joint, NUM_JOINTS};
use throng_geometry::SolidShape;

/// Two seconds of somebody who stands, arm before the body.
fn still(s: &TestCharacter) -> (Clip, DrivenMotion) {
    let arm = s.pose(0.0, -0.7, 0.6);
    let mut row = vec![Quat::IDENTITY; NUM_JOINTS];
    for (i, j) in s.limb.joints().into_iter().enumerate() {
        row[j.index()] = arm.0[i].as_quat();
    }
    let clip = Clip::new("still", 30.0, vec![s.skeleton.offsets[0]; 91], row.repeat(91));
    let motion = DrivenMotion::from_clip(&clip, &s.skeleton, 0.0, 3.0);
    (clip, motion)
}

/// A cup on a plank, moved past.
fn cup() -> RigidPath {
    let [from, to] = [0.1, 0.4].map(|x| Rigid { position: DVec3::new(x, 1.35, 0.42), rotation: glam::DQuat::IDENTITY });
    RigidPath::from_keys(&[(0.0, from), (3.0, to)])
}

fn grip() -> Rigid {
    // The hand behind the cup, fingers ahead.
    Rigid { position: DVec3::new(0.0, 0.0, -0.09), rotation: rotation_about(DVec3::Y, -1.45) }
}

#[test]
fn a_moving_cup_is_grasped_in_its_moment_and_carried_away() {
    let s = TestCharacter::standing();
    let (clip, motion) = still(&s);
    let object = cup();
    let solids = [MovingSolid { name: "cup".into(), shape: SolidShape::ball(0.04), path: object.clone() }];
    let allowed = [AllowedContact { part: Some("left_hand".into()), other: "cup".into(), window_s: Some([1.2, 1.5]) }];
    let state = LimbState { pose: motion.limb_pose(s.limb, 0.0), time_s: 0.0 };
    let spec = ProblemSpec::new(&s.skeleton, s.limb, &s.limits, &motion, &s.shape, [state; 2]);
    let spec = ProblemSpec { solids: &solids, allowed: &allowed, ..spec };
    let target = object.place_at(1.4).compose(grip());
    let held = [HeldCapsule {
        name: "cup in hand".into(),
        core: throng_geometry::Segment::new(DVec3::X * 0.1, DVec3::X * 0.1),
        radius: 0.04,
    }];
    // What was grasped is in the hand.
    let back = ProblemSpec { solids: &[], allowed: &[], held: &held, ..spec.clone() };
    let task = ReachTask { target, times_s: [0.5, 1.4, 2.3], hold_s: 0.2, return_spec: &back };
    let (out, _) = reach_target(&clip, &spec, &task, &CorrectConfig::default()).expect("reached");
    let frame = 42;
    let (at, turn) = out.joint_transforms(&s.skeleton, frame)[Joint::LeftHand.index()];
    let wanted = target;
    assert!((at.as_dvec3() - wanted.position).length() < 1e-5);
    assert!(angle_between(turn.as_dquat().normalize(), wanted.rotation) < 1e-4);
    // It is kept for a while.
    for f in frame..=frame + 6 {
        assert_eq!(out.frame_rotations(f), out.frame_rotations(frame));
    }
    assert_ne!(out.frame_rotations(frame + 9), out.frame_rotations(frame));
    for f in (0..=15).chain(69..91) {
        assert_eq!(out.frame_rotations(f), clip.frame_rotations(f));
    }
    assert_ne!(out.frame_rotations(30), clip.frame_rotations(30));
}

#[test]
fn what_is_out_of_reach_or_out_of_time_says_so() {
    let s = TestCharacter::standing();
    let (clip, motion) = still(&s);
    let state = LimbState { pose: motion.limb_pose(s.limb, 0.0), time_s: 0.0 };
    let spec = ProblemSpec::new(&s.skeleton, s.limb, &s.limits, &motion, &s.shape, [state; 2]);
    let tried = |object: &RigidPath, times_s: [f64; 3]| {
        let target = object.place_at(times_s[1]).compose(grip());
        let task = ReachTask { target, times_s, hold_s: 0.0, return_spec: &spec };
        reach_target(&clip, &spec, &task, &CorrectConfig::default()).unwrap_err()
    };
    let far = RigidPath::Still(Rigid::from_position(DVec3::new(0.2, 1.4, 0.8)));
    let e = tried(&far, [0.5, 1.4, 2.3]).to_string();
    assert!(e.starts_with("not reached at 1.40 s: out of reach by 0."), "{e}");
    for times in [[0.5, 0.5, 2.0], [1.0, 0.5, 2.0], [0.5, 1.0, 9.0], [-1.0, 1.0, 2.0], [f64::NAN, 1.0, 2.0]] {
        assert!(tried(&cup(), times).to_string().starts_with("expected three ascending times"), "{times:?}");
    }
    let e = tried(&cup(), [1.3, 1.34, 2.0]);
    assert!(matches!(e, ReachError::Problem(ProblemError::TooLittleTime { least_s, .. }) if least_s > 0.03), "{e}");
    let far = ReachTask { target: far.place_at(1.0), times_s: [0.5, 1.0, 2.0], hold_s: 0.0, return_spec: &spec };
    let asked = |task: &ReachTask<'_>| reach_target(&clip, &spec, task, &CorrectConfig::default());
    assert!(matches!(asked(&far), Err(ReachError::Target { .. })));
    for hold_s in [1.0, f64::NAN, -1.0] {
        let e = asked(&ReachTask { hold_s, ..far }).unwrap_err().to_string();
        assert!(e.starts_with("expected to hold for less than"), "{hold_s}: {e}");
    }
}
