//! Heads that turn and trunks that bend.

use super::*;

#[test]
fn heads_turn_to_what_is_taken_and_back_and_nothing_else_does() {
    let s = TestCharacter::standing();
    let outcome = run(&TASK.replace("seed = 3", "seed = 3\ngaze = true"), &s);
    assert!(outcome.is_solved(), "{:?}", outcome.done);
    assert_eq!(outcome.recheck.violations, []);
    assert!(outcome.recheck.gaze_off_rad < 0.1, "{}", outcome.recheck.gaze_off_rad);
    let [before, after] = &outcome.clips[0];
    // How far the face is from the cup, at 1.4 s.
    let off = |clip: &Clip| {
        let (at, turn) = clip.joint_transforms(&s.skeleton, 42)[throng_core::Joint::Head.index()];
        let cup = outcome.scenery[1].paths[1].place_at(1.4).position.as_vec3();
        (turn * glam::Vec3::Z).angle_between(cup - at)
    };
    assert!(off(before) > 0.5 && off(after) < 0.15, "{} {}", off(before), off(after));
    let head = |clip: &Clip, f: usize| clip.frame_rotations(f)[throng_core::Joint::Head.index()];
    for frame in [0, 15, 69, 100] {
        assert_eq!(head(before, frame), head(after, frame), "{frame}");
    }
    // Without the switch heads stay as they are.
    let without = run(TASK, &s);
    assert!((0..150).all(|f| head(&without.clips[0][1], f) == head(before, f)));
}

/// A cup on nothing, before somebody who stands: an arm alone does not reach it.
fn far_cup(at: &str, planner: &str) -> TaskOutcome {
    let s = TestCharacter::standing();
    let text = format!(
        "clip = \"stand.bvh\"\n[[scene.objects]]\nname = \"cup\"\nshape = {{ ball = {{ radius = 0.04 }} }}\nat = {at}\n\
         [[tasks]]\nlimb = \"left_arm\"\ndo = \"grab\"\nobject = \"cup\"\ngrips = [{{ at = [0.0, 0.0, -0.07] }}]\nat_s = 2.0\nwindow_s = [0.8, 3.4]\n\
         [planner]\n{planner}\n"
    );
    let task = parse(&text).expect("a task");
    let mut clip = stand(&s);
    clip.contacts = vec![throng_core::Contacts(15); clip.num_frames()];
    task.run(&[ActorClip { clip, skeleton: s.skeleton.clone() }], None).expect("clips")
}

#[test]
fn trunks_bend_for_what_arms_do_not_reach_and_hips_keep_the_balance() {
    let skeleton = TestCharacter::standing().skeleton;
    for at in ["[0.2, 1.1, 0.75]", "[0.25, 0.9, 0.6]"] {
        let stiff = far_cup(at, "");
        assert!(why(&stiff, 0).contains("out of reach"), "{at}: {}", why(&stiff, 0));
        let [alone, balanced] = ["lean = true", "lean = true\nbalance = true"].map(|planner| far_cup(at, planner));
        for outcome in [&alone, &balanced] {
            assert!(outcome.is_solved(), "{at}: {}", why(outcome, 0));
            assert_eq!(outcome.recheck.violations, [], "{at}");
            let [before, after] = &outcome.clips[0];
            for f in [0, 20, 23, 103, 150] {
                assert_eq!(before.frame_rotations(f), after.frame_rotations(f), "{at} {f}");
                assert_eq!(before.root_positions[f], after.root_positions[f]);
            }
        }
        let hips = |o: &TaskOutcome| o.clips[0][1].root_positions[60] - o.clips[0][0].root_positions[60];
        assert_eq!(hips(&alone).length(), 0.0);
        // Back, away from the cup; feet stay where they are.
        assert!(hips(&balanced).z < -0.02 && hips(&balanced).length() < 0.2, "{at}: {}", hips(&balanced));
        let feet = [throng_core::Joint::LeftFoot, throng_core::Joint::RightToe].map(|j| {
            let [a, b] = balanced.clips[0].each_ref().map(|c| c.joint_transforms(&skeleton, 60)[j.index()].0);
            a.distance(b)
        });
        assert!(feet.iter().all(|m| *m < 1e-4), "{feet:?}");
        assert!(balanced.recheck.off_balance_m < 0.01, "{}", balanced.recheck.off_balance_m);
    }
    // Too far for anybody.
    let far = far_cup("[0.2, 1.1, 1.6]", "lean = true");
    assert!(why(&far, 0).contains("out of reach") && far.clips[0][0] == far.clips[0][1]);
}

/// Two cups, one to either side, one after the other.
#[test]
fn heads_look_at_one_thing_after_the_other() {
    let s = TestCharacter::standing();
    let grab = |cup: &str, limb: &str, at_s: f64| {
        let window_s = [at_s - 0.8, at_s + 0.8];
        format!(
            "[[tasks]]\nlimb = \"{limb}\"\ndo = \"touch\"\nobject = \"{cup}\"\ngrips = [{{ at = [0.0, 0.0, -0.07] }}]\nat_s = {at_s}\nwindow_s = {window_s:?}\n"
        )
    };
    let cup = |name: &str, x: f64| {
        format!(
            "[[scene.objects]]\nname = \"{name}\"\nshape = {{ ball = {{ radius = 0.04 }} }}\nat = [{x}, 1.3, 0.3]\n"
        )
    };
    // At one moment only one of them is looked at.
    for apart_s in [2.0, 0.9, 0.6, 0.3, 0.0] {
        let tasks = [grab("a", "left_arm", 1.4), grab("b", "right_arm", 1.4 + apart_s)].concat();
        let text =
            ["clip = \"stand.bvh\"\n", &cup("a", 0.4), &cup("b", -0.4), &tasks, "[planner]\ngaze = true\n"].concat();
        let outcome = run(&text, &s);
        assert!(outcome.is_solved(), "{apart_s}: {} {}", why(&outcome, 0), why(&outcome, 1));
        assert_eq!(outcome.recheck.violations, [], "{apart_s}");
        let moved = (0..150).filter(|f| {
            let head = |c: &Clip| c.frame_rotations(*f)[throng_core::Joint::Head.index()];
            head(&outcome.clips[0][0]) != head(&outcome.clips[0][1])
        });
        assert!(moved.count() > 20, "{apart_s}");
    }
}
