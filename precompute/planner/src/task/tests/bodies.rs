//! The own body and what walks into things by itself.

use super::*;

#[test]
fn an_upper_arm_that_the_clip_presses_into_the_chest_is_left_alone() {
    let s = TestCharacter::standing();
    let task = parse(TASK).expect("a task");
    let mut clip = stand(&s);
    // The arm hangs so steeply that it is in the trunk.
    for frame in 0..clip.num_frames() {
        clip.rotations[frame * NUM_JOINTS + throng_core::Joint::LeftUpperArm.index()] = Quat::from_rotation_z(-1.85);
    }
    let found = |pressed: bool| {
        let clips = [ActorClip { clip: clip.clone(), skeleton: s.skeleton.clone() }];
        let mut stage = stage::TaskStage::new(&task, &clips);
        if !pressed {
            stage.actors[0].pressed.clear();
        }
        let limb = crate::linkage::Limb::LeftArm;
        let around = stage.surroundings_of_limb(0, limb, [0.0, 5.0]);
        let problem = crate::problem::Problem::prepare(&stage.limb_spec(0, limb, &around, &[])).expect("a problem");
        crate::correct::find_collisions(&problem).iter().filter(|c| c.part == "left_upper_arm").count()
    };
    assert!(found(false) > 0 && found(true) == 0);
}

/// Where the left arm is in the own body and a correction mends it, of a clip that lays the forearm across the belly, deep in it, at
/// some frames.
fn in_the_body(is_in: impl Fn(usize) -> bool) -> Vec<crate::correct::CollisionStretch> {
    let s = TestCharacter::standing();
    let task = parse(TASK).expect("a task");
    let mut clip = stand(&s);
    for frame in (0..clip.num_frames()).filter(|f| is_in(*f)) {
        let joint = |j: throng_core::Joint| frame * NUM_JOINTS + j.index();
        clip.rotations[joint(throng_core::Joint::LeftUpperArm)] = Quat::from_rotation_z(-1.2);
        clip.rotations[joint(throng_core::Joint::LeftForearm)] = Quat::from_rotation_z(-2.0);
    }
    let clips = [ActorClip { clip, skeleton: s.skeleton.clone() }];
    let stage = stage::TaskStage::new(&task, &clips);
    let limb = crate::linkage::Limb::LeftArm;
    let around = stage.surroundings_of_limb(0, limb, [0.0, 5.0]);
    let problem = crate::problem::Problem::prepare(&stage.limb_spec(0, limb, &around, &[])).expect("a problem");
    let own = |s: &crate::correct::CollisionStretch| throng_core::Joint::ALL.iter().any(|j| j.name() == s.with);
    crate::correct::find_collisions(&problem).into_iter().filter(own).collect()
}

#[test]
fn a_forearm_in_the_body_from_the_beginning_stays_there_until_the_clip_takes_it_out() {
    let late = in_the_body(|f| (60..90).contains(&f));
    assert!(matches!(&late[..], [s] if s.from_s > 1.9 && s.to_s < 3.1), "{late:?}");
    assert_eq!(in_the_body(|f| f < 30), []);
    assert_eq!(in_the_body(|f| f > 120), []);
    let both = in_the_body(|f| f < 30 || (60..90).contains(&f));
    assert!(!both.is_empty() && both.iter().all(|s| s.from_s > 1.9), "{both:?}");
}

#[test]
fn collisions_of_a_clip_name_limb_part_and_obstacle() {
    let s = TestCharacter::standing();
    let task = parse(TASK).expect("a task");
    let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
    let found = task.collisions(&clips, 0).expect("a scene");
    let [(limb, span)] = &found[..] else { panic!("{found:?}") };
    assert_eq!((*limb, span.with.as_str()), (crate::linkage::Limb::LeftArm, "ball"));
    // The ball is nearest at 3.8 s.
    assert!(span.from_s < 3.8 && 3.8 < span.to_s && span.to_s - span.from_s < 0.4 && span.depth_m > 0.01, "{span:?}");
}

/// A lamp that a chest walks through while the arm beside it does, too.
#[test]
fn a_limb_gives_way_where_the_body_itself_cannot_and_both_is_said() {
    let s = TestCharacter::standing();
    let text = TASK[..TASK.find("[[tasks]]").expect("tasks")]
        .replace("0.38, 1.2, 0.28", "0.36, 1.05, 0.2")
        .replace("radius = 0.06", "radius = 0.3");
    let only_arm = format!("{text}[[tasks]]\nlimb = \"left_arm\"\ndo = \"correct\"\n[planner]\nseed = 3\n");
    let free =
        run(&only_arm.replace("0.36, 1.05, 0.2", "0.38, 1.2, 0.28").replace("radius = 0.3", "radius = 0.06"), &s);
    assert!(free.is_solved() && free.done[0].unresolved.is_empty(), "{:?}", free.done);
    let outcome = run(&only_arm, &s);
    let done = &outcome.done[0];
    // The arm is out of the way, the chest is where the clip has it: that is no solution, and says so.
    assert!(!outcome.is_solved() && !done.plans.is_empty() && !done.unresolved.is_empty(), "{done:?}");
    assert!(done.unresolved.iter().all(|l| l.is_driven && l.span.with == "ball"), "{done:?}");
    assert!(why(&outcome, 0).contains("no motion of left_arm helps"), "{}", why(&outcome, 0));
    assert_ne!(outcome.clips[0][0], outcome.clips[0][1]);
    assert_eq!(outcome.recheck.violations, []);
}
