mod again;
mod bodies;
mod both;
mod heads;
mod read;
mod worn;
mod write_back;

use super::*;
use crate::search::LoggedTrees;
use crate::testing::TestCharacter;
use glam::Quat;
use proptest::prelude::*;
use std::cell::Cell;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use throng_core::NUM_JOINTS;
use throng_motion::Clip;

/// A cup that moves past, and a ball that flies through the arm later.
pub const TASK: &str = r#"
clip = "stand.bvh"

[[scene.objects]]
name = "cup"
shape = { ball = { radius = 0.04 } }
keys = [{ t_s = 0.0, at = [0.1, 1.35, 0.42] }, { t_s = 3.0, at = [0.4, 1.35, 0.42] }]

[[scene.obstacles]]
name = "ball"
shape = { ball = { radius = 0.06 } }
keys = [
    { t_s = 3.4, at = [0.38, 1.2, 3.0] },
    { t_s = 3.8, at = [0.38, 1.2, 0.28] },
    { t_s = 4.2, at = [0.38, 1.2, 3.0] },
]

[[tasks]]
limb = "left_arm"
do = "grab"
object = "cup"
at_s = 1.4
window_s = [0.5, 2.3]
grips = [{ at = [0.0, 0.0, -0.09], turn_deg = [0.0, -83.0, 0.0] }]

[[tasks]]
limb = "left_arm"
do = "correct"

[planner]
seed = 3
"#;

pub fn parse(text: &str) -> Result<Task, String> {
    Task::parse(text, Path::new("folder/t.toml")).map_err(|e| e.to_string())
}

pub fn stand(s: &TestCharacter) -> Clip {
    let arm = s.pose(0.0, -0.7, 0.6);
    let mut row = vec![Quat::IDENTITY; NUM_JOINTS];
    for (i, j) in s.limb.joints().into_iter().enumerate() {
        row[j.index()] = arm.0[i].as_quat();
    }
    Clip::new("stand", 30.0, vec![s.skeleton.offsets[0]; 151], row.repeat(151))
}

fn run(text: &str, s: &TestCharacter) -> TaskOutcome {
    let task = parse(text).unwrap_or_else(|e| panic!("{e}"));
    let clips = vec![ActorClip { clip: stand(s), skeleton: s.skeleton.clone() }; task.characters.len()];
    task.run(&clips, None).unwrap_or_else(|e| panic!("{e}"))
}

fn why(outcome: &TaskOutcome, i: usize) -> &str {
    outcome.done[i].reason.as_deref().unwrap_or("it was done")
}

#[test]
fn a_task_is_done_in_its_order() {
    let s = TestCharacter::standing();
    let task = parse(TASK).expect("a task");
    assert_eq!(task.characters[0].clip.file.as_deref(), Some(Path::new("folder/stand.bvh")));
    let clip = stand(&s);
    let outcome = run(TASK, &s);
    assert!(outcome.is_solved(), "{:?}", outcome.done);
    assert_eq!(outcome.recheck.violations, []);
    assert_eq!(outcome.done[1].spans.len(), 1);
    assert_eq!(outcome.done[1].spans[0].with, "ball");
    let [cup_lay, held] = &outcome.attachments[..] else { panic!("{:?}", outcome.attachments) };
    assert_eq!((cup_lay.to_s, held.from_s), (1.4, 1.4));
    assert_eq!((held.character.as_deref(), held.joint.as_deref()), (Some("main"), Some("left_hand")));
    let after = &outcome.clips[0][1];
    assert_ne!(after.frame_rotations(40), clip.frame_rotations(40));
    assert_eq!(after.frame_rotations(80), clip.frame_rotations(80));
    assert_eq!(*after, run(TASK, &s).clips[0][1]);
}

#[test]
fn what_is_cancelled_is_as_it_was() {
    let s = TestCharacter::standing();
    let task = parse(TASK).expect("a task");
    let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
    let whole = run(TASK, &s);
    for stop in 0..3 {
        let cancel = AtomicBool::new(stop == 0);
        let told = Cell::new(0);
        let tell = |n: usize| {
            told.set(n);
            cancel.fetch_or(n >= stop, Ordering::Relaxed);
        };
        let watch =
            RunOptions { cancel: Some(&cancel), on_progress: Some(&tell), keeps_trees: true, ..RunOptions::default() };
        let outcome = task.run_watched(&clips, &watch).expect("clips");
        for (i, done) in outcome.done.iter().enumerate() {
            assert_eq!(done.reason.as_deref().is_some_and(|why| why.contains("cancelled")), i >= stop, "{stop} {i}");
            // There and back, or one correction.
            assert_eq!(done.trees.len(), if i < stop { done.plans.len() } else { 0 });
        }
        assert!(told.get() >= 2 && outcome.recheck.violations.is_empty());
        let same_as = if stop == 2 { &whole.clips[0][1] } else { &whole.clips[0][0] };
        assert_eq!(outcome.clips[0][1] == *same_as, stop != 1);
    }
}

#[test]
fn the_trees_of_a_task_begin_and_end_where_the_hand_is() {
    let s = TestCharacter::standing();
    let task = parse(TASK).expect("a task");
    let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
    let outcome = task.run_watched(&clips, &RunOptions { keeps_trees: true, ..RunOptions::default() }).expect("clips");
    let [there, back] = &outcome.done[0].trees[..] else { panic!("{:?}", outcome.done[0].trees.len()) };
    assert_eq!((there.window_s, back.window_s), ([0.5, 1.4], [1.4, 2.3]));
    let roots = |g: &LoggedTrees| g.trees.each_ref().map(|t| (t[0].tip, t[0].time_s, t[0].parent));
    assert_eq!(roots(there)[1].0, roots(back)[0].0);
    assert!(
        there.is_solved && roots(there).iter().all(|r| r.2 == 0) && roots(there)[0].0.distance(roots(back)[1].0) < 1e-6
    );
    for (tree, sign) in there.trees.iter().zip([1.0, -1.0]) {
        assert!(tree[1..].iter().all(|n| sign * (n.time_s - tree[n.parent].time_s) >= 0.0));
    }
    assert!(run(TASK, &s).done.iter().all(|d| d.trees.is_empty()));
}

#[test]
fn what_cannot_be_done_is_said_and_leaves_the_clip() {
    let s = TestCharacter::standing();
    let far = run(&TASK.replace("0.42] }", "0.9] }"), &s);
    assert!(why(&far, 0).contains("out of reach by 0.") && far.done[0].nearest_m.is_some_and(|m| m > 0.1));
    assert!(!far.is_solved() && far.recheck.violations.is_empty() && far.attachments.is_empty());
    let late = run(&TASK.replace("at_s = 1.4", "at_s = 7.4").replace("[0.5, 2.3]", "[7.0, 8.0]"), &s);
    assert!(why(&late, 0).contains("within the clip's 0 to 5.00 s"), "{}", why(&late, 0));
    let grab = &TASK[TASK.find("[[tasks]]").expect("tasks")..TASK.rfind("[[tasks]]").expect("tasks")];
    let again = grab.replace("at_s = 1.4", "at_s = 3.0").replace("[0.5, 2.3]", "[2.6, 3.3]");
    let twice = run(&TASK.replace("[planner]", &format!("{again}\n[planner]")), &s);
    assert!(why(&twice, 2).contains("held by main's left arm already"), "{}", why(&twice, 2));
    let drop =
        "[[tasks]]\nlimb = \"left_arm\"\ndo = \"drop\"\nobject = \"cup\"\nat_s = 1.0\nwindow_s = [0.5, 1.5]\nto = {}\n";
    let empty = run(&format!("{}{drop}[planner]\n", &TASK[..TASK.find("[[tasks]]").expect("tasks")]), &s);
    assert!(why(&empty, 0).contains("does not hold `cup`"), "{}", why(&empty, 0));
}

/// A cup that is taken, laid down, taken by the other hand and handed back.
pub const ERRANDS: &str = r#"
clip = "stand.bvh"

[[scene.obstacles]]
name = "table"
shape = { box = { size = [1.2, 0.02, 0.2] } }
at = [0.0, 0.98, 0.5]

[[scene.objects]]
name = "cup"
shape = { capsule = { from = [0.0, -0.07, 0.0], to = [0.0, 0.07, 0.0], radius = 0.03 } }
at = [0.3, 1.09, 0.45]

[[tasks]]
limb = "left_arm"
do = "grab"
object = "cup"
at_s = 0.8
window_s = [0.1, 1.4]
grips = [{ at = [0.0, -0.04, 0.0] }]

[[tasks]]
limb = "left_arm"
do = "hand_over"
object = "cup"
to = { at = [0.0, 1.4, 0.45] }
receiver = { limb = "right_arm", grips = [{ at = [0.0, 0.05, 0.0] }] }
at_s = 2.0
window_s = [1.4, 2.8]

[[tasks]]
limb = "right_arm"
do = "drop"
object = "cup"
to = { on = "table", at = [-0.3, 0.11, -0.05] }
at_s = 3.6
window_s = [2.8, 4.4]
"#;

#[test]
fn a_cup_goes_from_hand_to_hand_and_is_laid_down() {
    let s = TestCharacter::standing();
    let outcome = run(ERRANDS, &s);
    assert!(outcome.is_solved(), "{:?}", outcome.done);
    assert_eq!(outcome.recheck.violations, []);
    let who: Vec<_> = outcome.attachments.iter().map(|a| (a.joint.as_deref(), a.on.as_deref(), a.from_s)).collect();
    let expected = [
        (None, None, 0.0),
        (Some("left_hand"), None, 0.8),
        (Some("right_hand"), None, 2.0),
        (None, Some("table"), 3.6),
    ];
    assert_eq!(who, expected);
    // Where the cup is, hand by hand, it is where it was brought.
    let at = |t: f64| outcome.scenery[1].paths[1].place_at(t).position;
    assert!(at(2.0).distance(glam::DVec3::new(0.0, 1.4, 0.45)) < 1e-4, "{}", at(2.0));
    assert!(at(4.9).distance(glam::DVec3::new(-0.3, 1.09, 0.45)) < 1e-9, "{}", at(4.9));
    // What was planned earlier is not undone by what comes later.
    let busy = run(&ERRANDS.replace("[1.4, 2.8]", "[0.5, 2.8]"), &s);
    assert!(why(&busy, 1).contains("has to be elsewhere at 0.80 s"), "{}", why(&busy, 1));
}

#[test]
fn a_failed_task_is_tried_again_after_the_others() {
    let s = TestCharacter::standing();
    // The second task of the file comes first, and needs what the first one does.
    let text = ERRANDS.replace("do = \"grab\"", "do = \"grab\"\npriority = 1");
    let outcome = run(&text, &s);
    assert!(outcome.is_solved(), "{:?}", outcome.done);
    assert_eq!(outcome.done[0].name, "left_arm grab cup");
}

#[test]
fn seeds_differ_and_one_seed_does_not() {
    let s = TestCharacter::standing();
    let task = parse(TASK).expect("a task");
    let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
    let of = |seed: u64| task.run(&clips, Some(seed)).expect("clips");
    let (a, b) = (of(1), of(2));
    assert_eq!(a.distance_rad(&of(1)), 0.0);
    assert!(a.distance_rad(&b) > 0.0 && (a.distance_rad(&b) - b.distance_rad(&a)).abs() < 1e-12);
}

#[test]
fn clips_that_do_not_fit_are_refused() {
    let s = TestCharacter::standing();
    let task = parse(&format!("{TASK}\n[[characters]]\nname = \"Bo\"\nclip = \"b.bvh\"\n")).expect("a task");
    let one = ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() };
    let fast = ActorClip { clip: Clip { rate_hz: 60.0, ..one.clip.clone() }, ..one.clone() };
    let refused = |clips: &[ActorClip]| task.run(clips, None).unwrap_err().to_string();
    assert!(refused(std::slice::from_ref(&one)).starts_with("expected 2 clips, one for each character, found 1"));
    assert!(refused(&[one.clone(), fast]).contains("expected 30 frames a second, as the first clip has, found 60"));
    let short = Clip::new("s", 30.0, vec![glam::Vec3::Y], vec![Quat::IDENTITY; NUM_JOINTS]);
    let short = ActorClip { clip: short, ..one.clone() };
    assert!(refused(&[one, short]).contains("expected a clip of two frames at least, found 1"));
}

#[test]
fn what_no_search_can_mend_is_known_before() {
    let s = TestCharacter::standing();
    let ahead = |text: &str| {
        let task = parse(text).unwrap_or_else(|e| panic!("{e}"));
        task.preview_steps(&[ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }]).expect("clips")
    };
    let good = ahead(TASK);
    assert!(good.iter().all(|a| a.faults.is_empty()), "{good:?}");
    assert_eq!((good[0].reached, good[0].at_s, good[1].collisions.len()), (Some([1, 1]), Some(1.4), 1));
    let [there, back] = good[0].least_s.expect("times");
    assert!(there > 0.02 && there < 0.9 && back > 0.02 && back < 0.9);
    for (from, to, why) in [
        ("0.42] }", "0.9] }", "out of reach by 0."),
        ("[0.5, 2.3]", "[1.39, 2.3]", "needs at least"),
        ("[0.5, 2.3]", "[0.5, 9.3]", "within the clip's 0 to 5.00 s"),
    ] {
        let bad = ahead(&TASK.replace(from, to));
        assert!(bad[0].faults.iter().any(|f| f.contains(why)), "{why}: {bad:?}");
    }
}

#[test]
fn who_walks_needs_no_times_and_says_so_where_it_was_not_walked() {
    let walk = "clip = { walk = { bundle = \"w.throng\", config = \"w.toml\", from = [1.0, -2.0] } }";
    let text = TASK.replace("clip = \"stand.bvh\"", walk).replace("at_s = 1.4\nwindow_s = [0.5, 2.3]\n", "");
    let task = parse(&text).expect("a task");
    assert!(task.needs_walking());
    let entry = task.characters[0].clip.walk.as_ref().expect("it walks");
    assert_eq!((entry.bundle.as_path(), entry.speed_mps), (Path::new("folder/w.throng"), 1.2));
    assert_eq!(task.times_s(), [None, None]);
    let s = TestCharacter::standing();
    let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
    assert!(task.run(&clips, None).unwrap_err().to_string().starts_with("`main` walks up to what it does"));
    for (from, to, why) in [
        ("from = [1.0, -2.0]", "from = [nan, 0.0]", "expected `from` within"),
        ("from = [1.0, -2.0]", "speed_mps = 9.0", "expected 0.3 to 4, found 9"),
        ("from = [1.0, -2.0]", "pace = [{ t_s = 0.0, speed_mps = 1.0 }]", "two times at least"),
        ("from = [1.0, -2.0]", "pace = [{ t_s = 0.0, speed_mps = 1.0 }, { t_s = 0.0, speed_mps = 1.0 }]", "ascending"),
        ("from = [1.0, -2.0]", "pace = [{ t_s = 0.0, speed_mps = 1.0 }, { t_s = 2.0, speed_mps = nan }]", "0 to 8 m/s"),
        (
            "from = [1.0, -2.0]",
            "pace = [{ t_s = 0.0, speed_mps = 1.0 }, { t_s = 2.0, speed_mps = 3.0 }]",
            "expected `at_s`",
        ),
        ("} }\n", "}, to_s = 3.0 }\n", "expected no `from_s` and no `to_s`"),
        ("clip = { walk", "clip = { synth = \"walk\", walk", "or `walk`"),
    ] {
        let e = parse(&text.replacen(from, to, 1)).expect_err(why);
        assert!(e.contains(why), "{why}: {e}");
    }
}
