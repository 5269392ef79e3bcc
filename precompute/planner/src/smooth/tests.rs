use super::*;
use crate::driven::DrivenMotion;
use crate::planner::{Budget, LimbPlanner, PlanConfig};
use crate::rotation::{angle_between, rotation_about};
use crate::setup::ProblemSpec;
use crate::testing::TestCharacter;
use glam::{DQuat, DVec3};
use throng_core::{Joint, NUM_JOINTS};

#[test]
fn roughness_of_an_even_turn_is_its_speed() {
    let frames: Vec<LimbPose> = (0..20)
        .map(|f| {
            let mut p = LimbPose::REST;
            p.0[1] = rotation_about(DVec3::Y, 0.1 * f64::from(f));
            p
        })
        .collect();
    let r = roughness(&frames, 0.05);
    assert!((r.length_rad - 1.9).abs() < 1e-9 && (r.speed_max - 2.0).abs() < 1e-9);
    assert!(r.acceleration_max < 1e-6 && r.jerk_rms < 1e-4);
}

/// The arm swings in the clip; a plan that begins and ends in it goes along with it there.
#[test]
fn ends_have_the_velocity_of_the_motion_around_them() {
    let s = TestCharacter::standing();
    let root = s.skeleton.offsets[0].as_dvec3();
    let first = s.pose(0.2, -0.3, 0.6);
    let swinging = |t: f64| {
        let mut turns = [DQuat::IDENTITY; NUM_JOINTS];
        let swing = rotation_about(DVec3::X, 0.5 * t * 2.0) * first.0[0];
        turns[Joint::LeftUpperArm.index()] = swing;
        turns[Joint::LeftForearm.index()] = first.0[1];
        (root, turns)
    };
    let motion = DrivenMotion::from_function(0.0, 1.0 / 120.0, 181, &s.skeleton, swinging);
    let limb = s.limb;
    let ends = [0.0, 1.0].map(|t| (motion.limb_pose(limb, t), t));
    let states = ends.map(|(pose, time_s)| crate::problem::LimbState { pose, time_s });
    let spec = ProblemSpec::new(&s.skeleton, limb, &s.limits, &motion, &s.shape, states);
    // Something in the way, so that there is a way with corners.
    let middle = motion.limb_pose(limb, 0.5);
    let free = Problem::new(&spec).expect("a problem");
    let hand = free.place_chain(&crate::problem::LimbState { pose: middle, time_s: 0.5 })[2].position;
    let solids = [crate::testing::solid("lamp", throng_geometry::SolidShape::ball(0.06), hand)];
    let problem = Problem::new(&ProblemSpec { solids: &solids, ..spec }).expect("a problem");
    for seed in 0..5 {
        let mut planner = LimbPlanner::new();
        let budget = Budget { seed, rate_hz: 60.0, ..Budget::default() };
        let outcome = planner.plan(&problem, &PlanConfig::default(), &budget);
        assert!(outcome.is_solved() && outcome.blended.iter().all(|n| *n > 2), "{outcome:?}");
        let m = planner.motion().expect("a motion");
        let last = m.frames.len() - 1;
        for (a, b) in [(0, 1), (last - 1, last)] {
            let at = |f: usize| m.start_s + f as f64 * m.step_s;
            let [from, to] = [at(a), at(b)].map(|t| motion.limb_pose(limb, t).0[0]);
            let own = angle_between(m.frames[a].0[0], m.frames[b].0[0]) / m.step_s;
            let clip = angle_between(from, to) / m.step_s;
            assert!((own - clip).abs() < 0.05 * clip, "seed {seed}: {own} {clip}");
        }
    }
}

#[test]
fn rounding_spreads_a_jump_of_velocity_over_its_window() {
    let s = TestCharacter::standing();
    let problem = s.problem([(s.pose(0.0, 0.4, 0.5), 0.0), (s.pose(0.0, 0.4, 0.5), 1.0)], &[]).expect("a problem");
    let grid = TimeGrid::new(0.0, 1.0, 60.0);
    let mut checker = Checker::default();
    let mut smoother = Smoother { problem: &problem, grid, checker: &mut checker };
    let corner = LimbState { pose: s.pose(0.0, -0.4, 0.5), time_s: 0.5 };
    let path = [problem.init, corner, problem.goal];
    let (mut frames, mut out, mut windows) = (Vec::new(), Vec::new(), Vec::new());
    smoother.fill_frames(&path, &mut frames);
    let before = roughness(&frames, grid.step_s());
    smoother.round_corners(&frames, 12, &mut out, &mut windows);
    let after = roughness(&out, grid.step_s());
    // 1.6 rad/s to and fro: a jump of 3.2 rad/s, spread over thirteen frames, less evenly where windows still grow.
    assert!((before.acceleration_max - 3.2 * 60.0).abs() < 1.0, "{before:?}");
    assert!(after.acceleration_max < 3.2 * 60.0 / 8.0, "{after:?}");
    assert!(after.jerk_rms < 0.3 * before.jerk_rms);
    assert!(angle_between(out[0].0[0], frames[0].0[0]) < 1e-12 && angle_between(out[60].0[0], frames[60].0[0]) < 1e-12);
}
