use super::*;
use crate::driven::Driven;
use crate::problem::Solid;
use crate::rotation::{about, angle};
use crate::setup::{Allowed, Held};
use crate::shape::Shape;
use crate::testing::Somebody;
use crate::track::Path;
use glam::{DVec3, Quat};
use throng_core::{Joint, NUM_JOINTS};

/// Two seconds of somebody who stands, arm before the body.
fn still(s: &Somebody) -> (Clip, Driven) {
    let arm = s.pose(0.0, -0.7, 0.6);
    let mut row = vec![Quat::IDENTITY; NUM_JOINTS];
    for (i, j) in s.linkage.limb.joints().into_iter().enumerate() {
        row[j.index()] = arm.0[i].as_quat();
    }
    let clip = Clip::new("still", 30.0, vec![s.skeleton.offsets[0]; 91], row.repeat(91));
    let motion = Driven::of_clip(&clip, &s.skeleton, 0.0, 3.0);
    (clip, motion)
}

/// A cup on a plank, moved past.
fn cup() -> Path {
    let [from, to] = [0.1, 0.4].map(|x| Rigid { position: DVec3::new(x, 1.35, 0.42), rotation: glam::DQuat::IDENTITY });
    Path::keys(&[(0.0, from), (3.0, to)])
}

fn grip() -> Rigid {
    // The hand behind the cup, fingers ahead.
    Rigid { position: DVec3::new(0.0, 0.0, -0.09), rotation: about(DVec3::Y, -1.45) }
}

#[test]
fn a_moving_cup_is_grasped_in_its_moment_and_carried_away() {
    let s = Somebody::standing();
    let (clip, motion) = still(&s);
    let object = cup();
    let solids = [Solid { name: "cup".into(), shape: Shape::ball(0.04), path: object.clone() }];
    let allowed = [Allowed { part: Some("left_hand".into()), with: "cup".into(), window_s: Some([1.2, 1.5]) }];
    let state = State { pose: motion.limb_pose(s.linkage, 0.0), time_s: 0.0 };
    let spec = ProblemSpec::new(&s.skeleton, s.linkage, &s.limits, &motion, &s.shape, [state; 2]);
    let spec = ProblemSpec { solids: &solids, allowed: &allowed, ..spec };
    let unreachable = Rigid::at(DVec3::new(0.0, 0.0, 5.0));
    let targets = [unreachable, object.at(1.4).then(grip())];
    let held = [Held {
        name: "cup in hand".into(),
        core: crate::shape::Segment::new(DVec3::X * 0.1, DVec3::X * 0.1),
        radius: 0.04,
    }];
    // What was grasped is in the hand.
    let back = ProblemSpec { solids: &[], allowed: &[], held: &held, ..spec.clone() };
    let task = Reach { targets: &targets, times_s: [0.5, 1.4, 2.3], hold_s: 0.2, back: Some(&back) };
    let (out, reached) = reach(&clip, &spec, &task, &CorrectConfig::default()).expect("reached");
    assert_eq!(reached.target, 1);
    let frame = (reached.times_s[1] * 30.0).round() as usize;
    let (at, turn) = out.joint_transforms(&s.skeleton, frame)[Joint::LeftHand.index()];
    let wanted = object.at(reached.times_s[1]).then(grip());
    assert!((at.as_dvec3() - wanted.position).length() < 1e-5);
    assert!(angle(turn.as_dquat().normalize(), wanted.rotation) < 1e-4);
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
    let s = Somebody::standing();
    let (clip, motion) = still(&s);
    let state = State { pose: motion.limb_pose(s.linkage, 0.0), time_s: 0.0 };
    let spec = ProblemSpec::new(&s.skeleton, s.linkage, &s.limits, &motion, &s.shape, [state; 2]);
    let tried = |object: &Path, times_s: [f64; 3]| {
        let targets = [object.at(times_s[1]).then(grip())];
        let task = Reach { targets: &targets, times_s, hold_s: 0.0, back: None };
        reach(&clip, &spec, &task, &CorrectConfig::default()).unwrap_err()
    };
    let far = Path::Still(Rigid::at(DVec3::new(0.2, 1.4, 0.8)));
    let e = tried(&far, [0.5, 1.4, 2.3]).to_string();
    assert!(e.starts_with("not reached at 1.40 s: out of reach by 0."), "{e}");
    for times in [[0.5, 0.5, 2.0], [1.0, 0.5, 2.0], [0.5, 1.0, 9.0], [-1.0, 1.0, 2.0], [f64::NAN, 1.0, 2.0]] {
        assert!(matches!(tried(&cup(), times), NotReached::Times { .. }), "{times:?}");
    }
    let e = tried(&cup(), [1.3, 1.34, 2.0]);
    assert!(matches!(e, NotReached::Problem(ProblemError::TooLittleTime { least_s, .. }) if least_s > 0.03), "{e}");
    let none = Reach { targets: &[], times_s: [0.5, 1.0, 2.0], hold_s: 0.0, back: None };
    let asked = |task: &Reach<'_>| reach(&clip, &spec, task, &CorrectConfig::default());
    assert!(matches!(asked(&none), Err(NotReached::Target { .. })));
    for hold_s in [1.0, f64::NAN, -1.0] {
        assert!(matches!(asked(&Reach { hold_s, ..none }), Err(NotReached::Hold { .. })), "{hold_s}");
    }
}
