//! Tasks that are done again after something was moved a little.

use super::*;
use crate::planner::Planners;
use glam::DVec3;

#[test]
fn a_run_goes_on_with_the_trees_of_the_last_one() {
    let s = TestCharacter::standing();
    let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
    let run = |task: &Task, planners: Option<&Planners>| {
        task.run_watched(&clips, &RunOptions { planners, ..RunOptions::default() }).expect("clips")
    };
    let mut task = parse(TASK).expect("a task");
    let (scenery, _) = task.scenery(&clips).expect("clips");
    // Without a last one it is the same as ever.
    let mut planners = Planners::default();
    let first = run(&task, Some(&planners));
    assert_eq!(first.clips, run(&task, None).clips);
    for _ in 0..4 {
        task.move_by(Handle::Thing(0), DVec3::new(0.0, 0.001, 0.002), &scenery);
        planners = planners.for_next_run();
        let again = run(&task, Some(&planners));
        assert!(again.is_solved() && again.recheck.violations.is_empty(), "{:?}", again.recheck);
        let anew = run(&task, None);
        // Near the last motion.
        assert!(again.distance_rad(&first) <= anew.distance_rad(&first) + 0.02);
    }
    // The last one's trees are those of another task: nothing of them holds, and nothing goes wrong.
    let other = parse(&TASK.replace("at_s = 1.4", "at_s = 1.5").replace("seed = 3", "seed = 4")).expect("a task");
    let outcome = run(&other, Some(&planners.for_next_run()));
    assert!(outcome.is_solved() && outcome.recheck.violations.is_empty());
}
