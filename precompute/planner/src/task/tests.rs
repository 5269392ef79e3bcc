mod both;
mod worn;

use super::*;
use crate::search::Grown;
use crate::testing::Somebody;
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

pub fn stand(s: &Somebody) -> Clip {
    let arm = s.pose(0.0, -0.7, 0.6);
    let mut row = vec![Quat::IDENTITY; NUM_JOINTS];
    for (i, j) in s.linkage.limb.joints().into_iter().enumerate() {
        row[j.index()] = arm.0[i].as_quat();
    }
    Clip::new("stand", 30.0, vec![s.skeleton.offsets[0]; 151], row.repeat(151))
}

fn run(text: &str, s: &Somebody) -> TaskOutcome {
    let task = parse(text).unwrap_or_else(|e| panic!("{e}"));
    let clips = vec![ActorClip { clip: stand(s), skeleton: s.skeleton.clone() }; task.characters.len()];
    task.run(&clips, None).unwrap_or_else(|e| panic!("{e}"))
}

fn why(outcome: &TaskOutcome, i: usize) -> &str {
    outcome.done[i].why.as_deref().unwrap_or("it was done")
}

#[test]
fn a_task_is_done_in_its_order() {
    let s = Somebody::standing();
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
    let s = Somebody::standing();
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
        let watch = Watch { cancel: Some(&cancel), tell: Some(&tell), keeps_trees: true, ..Watch::default() };
        let outcome = task.run_watched(&clips, &watch).expect("clips");
        for (i, done) in outcome.done.iter().enumerate() {
            assert_eq!(done.why.as_deref().is_some_and(|why| why.contains("cancelled")), i >= stop, "{stop} {i}");
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
    let s = Somebody::standing();
    let task = parse(TASK).expect("a task");
    let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
    let outcome = task.run_watched(&clips, &Watch { keeps_trees: true, ..Watch::default() }).expect("clips");
    let [there, back] = &outcome.done[0].trees[..] else { panic!("{:?}", outcome.done[0].trees.len()) };
    assert_eq!((there.window_s, back.window_s), ([0.5, 1.4], [1.4, 2.3]));
    let roots = |g: &Grown| g.trees.each_ref().map(|t| (t[0].at, t[0].time_s, t[0].parent));
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
    let s = Somebody::standing();
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
    let s = Somebody::standing();
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
    let at = |t: f64| outcome.scenery[1].paths[1].at(t).position;
    assert!(at(2.0).distance(glam::DVec3::new(0.0, 1.4, 0.45)) < 1e-4, "{}", at(2.0));
    assert!(at(4.9).distance(glam::DVec3::new(-0.3, 1.09, 0.45)) < 1e-9, "{}", at(4.9));
    // What was planned earlier is not undone by what comes later.
    let busy = run(&ERRANDS.replace("[1.4, 2.8]", "[0.5, 2.8]"), &s);
    assert!(why(&busy, 1).contains("has to be elsewhere at 0.80 s"), "{}", why(&busy, 1));
}

#[test]
fn a_failed_task_is_tried_again_after_the_others() {
    let s = Somebody::standing();
    // The second task of the file comes first, and needs what the first one does.
    let text = ERRANDS.replace("do = \"grab\"", "do = \"grab\"\npriority = 1");
    let outcome = run(&text, &s);
    assert!(outcome.is_solved(), "{:?}", outcome.done);
    assert_eq!(outcome.done[0].name, "left_arm grab cup");
}

#[test]
fn seeds_differ_and_one_seed_does_not() {
    let s = Somebody::standing();
    let task = parse(TASK).expect("a task");
    let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
    let of = |seed: u64| task.run(&clips, Some(seed)).expect("clips");
    let (a, b) = (of(1), of(2));
    assert_eq!(a.distance_rad(&of(1)), 0.0);
    assert!(a.distance_rad(&b) > 0.0 && (a.distance_rad(&b) - b.distance_rad(&a)).abs() < 1e-12);
}

#[test]
fn clips_that_do_not_fit_are_refused() {
    let s = Somebody::standing();
    let task = parse(&format!("{TASK}\n[[characters]]\nname = \"Bo\"\nclip = \"b.bvh\"\n")).expect("a task");
    let one = ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() };
    let fast = ActorClip { clip: Clip { rate_hz: 60.0, ..one.clip.clone() }, ..one.clone() };
    assert!(matches!(task.run(std::slice::from_ref(&one), None), Err(NoClips::Number { expected: 2, found: 1 })));
    assert!(matches!(task.run(&[one.clone(), fast], None), Err(NoClips::Rate { .. })));
    let short = Clip::new("s", 30.0, vec![glam::Vec3::Y], vec![Quat::IDENTITY; NUM_JOINTS]);
    let short = ActorClip { clip: short, ..one.clone() };
    assert!(matches!(task.run(&[one, short], None), Err(NoClips::Short { .. })));
}

#[test]
fn an_upper_arm_that_the_clip_presses_into_the_chest_is_left_alone() {
    let s = Somebody::standing();
    let task = parse(TASK).expect("a task");
    let mut clip = stand(&s);
    // The arm hangs so steeply that it is in the trunk.
    for frame in 0..clip.num_frames() {
        clip.rotations[frame * NUM_JOINTS + throng_core::Joint::LeftUpperArm.index()] = Quat::from_rotation_z(-1.75);
    }
    let found = |pressed: bool| {
        let clips = [ActorClip { clip: clip.clone(), skeleton: s.skeleton.clone() }];
        let mut stage = stage::Stage::new(&task, &clips);
        if !pressed {
            stage.actors[0].pressed.clear();
        }
        let limb = crate::linkage::Limb::LeftArm;
        let around = stage.around(0, limb, [0.0, 5.0]);
        let problem = crate::problem::Problem::prepare(&stage.spec(0, limb, &around, &[])).expect("a problem");
        crate::correct::collisions(&problem).iter().filter(|c| c.part == "left_upper_arm").count()
    };
    assert!(found(false) > 0 && found(true) == 0);
}

/// Where the left arm is in the own body and a correction mends it, of a clip that lays the forearm across the belly, deep in it, at
/// some frames.
fn in_the_body(is_in: impl Fn(usize) -> bool) -> Vec<crate::correct::Span> {
    let s = Somebody::standing();
    let task = parse(TASK).expect("a task");
    let mut clip = stand(&s);
    for frame in (0..clip.num_frames()).filter(|f| is_in(*f)) {
        let joint = |j: throng_core::Joint| frame * NUM_JOINTS + j.index();
        clip.rotations[joint(throng_core::Joint::LeftUpperArm)] = Quat::from_rotation_z(-1.2);
        clip.rotations[joint(throng_core::Joint::LeftForearm)] = Quat::from_rotation_z(-2.0);
    }
    let clips = [ActorClip { clip, skeleton: s.skeleton.clone() }];
    let stage = stage::Stage::new(&task, &clips);
    let limb = crate::linkage::Limb::LeftArm;
    let around = stage.around(0, limb, [0.0, 5.0]);
    let problem = crate::problem::Problem::prepare(&stage.spec(0, limb, &around, &[])).expect("a problem");
    let own = |s: &crate::correct::Span| throng_core::Joint::ALL.iter().any(|j| j.name() == s.with);
    crate::correct::collisions(&problem).into_iter().filter(own).collect()
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
    let s = Somebody::standing();
    let task = parse(TASK).expect("a task");
    let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
    let found = task.collisions(&clips, 0).expect("a scene");
    let [(limb, span)] = &found[..] else { panic!("{found:?}") };
    assert_eq!((*limb, span.with.as_str()), (crate::linkage::Limb::LeftArm, "ball"));
    // The ball is nearest at 3.8 s.
    assert!(span.from_s < 3.8 && 3.8 < span.to_s && span.to_s - span.from_s < 0.4 && span.depth_m > 0.01, "{span:?}");
}

#[test]
fn faults_name_their_line() {
    let cases = [
        ("object = \"cup\"", "object = \"cap\"", "Did you mean `cup`?"),
        ("at_s = 1.4", "at_s = 9.4", "expected `at_s` within `window_s`"),
        ("do = \"correct\"", "do = \"correct\"\nat_s = 1.0", "finds collisions by itself"),
        ("do = \"correct\"", "do = \"corect\"", "Did you mean `correct`?"),
        ("radius = 0.06", "radius = -0.06", "positive sizes"),
        ("radius = 0.06", "radius = nan", "positive sizes"),
        ("t_s = 3.8", "t_s = 3.1", "times ascend"),
        ("name = \"ball\"", "name = \"cup\"", "two of `cup`"),
        ("{ ball = { radius = 0.06 } }", "{ mesh = { file = \"a.obj\" } }", "a.obj"),
        ("{ ball = { radius = 0.06 } }", "{ mesh = { file = \"a.stl\" } }", "expected a mesh as OBJ, glTF or GLB"),
        ("seed = 3", "epsilon_m = 0.0", "expected 0.01 to 10"),
        ("seed = 3", "sed = 3", "Did you mean `seed`?"),
        ("clip = \"stand.bvh\"", "clip = {}", "expected `file`, or `synth`"),
        ("clip = \"stand.bvh\"", "clip = { synth = \"walk\", from_s = 2.0, to_s = 1.0 }", "0 <= from_s < to_s"),
        ("clip = \"stand.bvh\"", "clip = 3", "expected a motion file, or a table"),
        ("limb = \"left_arm\"", "limb = \"left_leg\"", "feet hold nothing"),
        ("limb = \"left_arm\"", "character = \"Bo\"\nlimb = \"left_arm\"", "no character `Bo`"),
        ("object = \"cup\"", "object = \"ball\"", "is an obstacle, which stays"),
        ("object = \"cup\"", "object = \"cup\"\nto = {}", "needs no `to`"),
        ("do = \"grab\"", "do = \"drop\"", "expected `to`"),
        ("do = \"grab\"", "do = \"grab\"\ncontacts = [\"cap\"]", "Did you mean `cup`?"),
        ("do = \"grab\"", "do = \"grab\"\nstyle = { left_shin = {} }", "has no joint `left_shin`"),
        ("name = \"ball\"", "name = \"ball\"\nattached_to = \"main.head\"", "list it in `objects`"),
        ("name = \"cup\"", "name = \"cup\"\nattached_to = \"main.hat\"", "expected `keys` or `attached_to`"),
        ("grips = [{ at = [0.0, 0.0, -0.09], turn_deg = [0.0, -83.0, 0.0] }]", "", "expected `grips`"),
    ];
    for (from, to, why) in cases {
        let e = parse(&TASK.replacen(from, to, 1)).expect_err(why);
        assert!(e.contains("t.toml:") && e.contains(why), "{why}: {e}");
    }
}

#[test]
fn objects_are_read_as_their_format_says() {
    let text = "# a quad and a triangle\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1/1/1 2//1 3 4\nf -1 -2 -3\n";
    let found = obj::triangles(text).expect("triangles");
    assert_eq!(found.len(), 3);
    assert_eq!(found[2][0], glam::Vec3::Y);
    for (text, line, why) in [
        ("v 0 0\n", 1, "expected `v x y z`"),
        ("v 0 0 nan\n", 1, "finite numbers"),
        ("v 0 0 0\nf 1 1\n", 2, "three corners"),
        ("v 0 0 0\n\nf 1 2 1\n", 3, "from 1 to 1, found `2`"),
        ("f 0 0 0\n", 1, "found `0`"),
        ("v 0 0 0\nf -2 1 1\n", 2, "found `-2`"),
    ] {
        let e = obj::triangles(text).expect_err(why);
        assert!(e.0 == line && e.1.contains(why), "{e:?}");
    }
}

/// A cube of twelve triangles as OBJ.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

#[test]
fn meshes_are_closed_or_said_to_be_open() {
    let cube = obj::triangles(CUBE).expect("triangles");
    assert_eq!((cube.len(), mesh::open_edges(&cube)), (12, 0));
    assert_eq!(mesh::open_edges(&cube[1..]), 3);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cube.obj");
    let read = |text: &str, unit_m: f64, open: bool| {
        std::fs::write(&path, text).expect("a file");
        mesh::read(&path, unit_m, open)
    };
    let size = |shape: crate::shape::Shape| shape.ball_around().1 * 2.0;
    let diagonal = size(read(CUBE, 0.01, false).expect("a mesh"));
    assert!((diagonal - 0.03f64.sqrt() * 0.1).abs() < 1e-6, "{diagonal}");
    let holed = CUBE.replace("f 4 1 5 8\n", "");
    let e = read(&holed, 1.0, false).unwrap_err();
    assert!(e.contains("cube.obj: 4 edges") && e.contains("open = true"), "{e}");
    assert!(read(&holed, 1.0, true).is_ok());
    for (text, unit_m, why) in [
        ("", 1.0, "no triangles"),
        (CUBE, 0.0, "positive `unit_m`"),
        (CUBE, f64::NAN, "positive `unit_m`"),
        ("v 0 0 nan\n", 1.0, "cube.obj:1: expected `v x y z`"),
    ] {
        let e = read(text, unit_m, true).unwrap_err();
        assert!(e.contains(why), "{e}");
    }
}

proptest! {
    #[test]
    fn damaged_tasks_and_objects_do_no_harm(cut in 0usize..1000, with in "[\\[\\]{}=\\-0-9a-z./ \"\\n]{0,4}", skip in 0usize..8) {
        let cut = cut % TASK.len();
        let text = format!("{}{with}{}", &TASK[..cut], &TASK[(cut + skip).min(TASK.len())..]);
        if let Ok(task) = parse(&text) {
            prop_assert!(task.things.iter().flat_map(|t| &t.shapes).all(|s| s.is_valid()));
        }
        let _ = obj::triangles(&text);
        let _ = obj::triangles(&format!("v 0 0 0\nv 1 {with} 0\nf {with} {cut} -{skip}\n"));
    }
}

/// A lamp that a chest walks through while the arm beside it does, too.
#[test]
fn a_limb_gives_way_where_the_body_itself_cannot_and_both_is_said() {
    let s = Somebody::standing();
    let text = TASK[..TASK.find("[[tasks]]").expect("tasks")]
        .replace("0.38, 1.2, 0.28", "0.36, 1.05, 0.2")
        .replace("radius = 0.06", "radius = 0.3");
    let only_arm = format!("{text}[[tasks]]\nlimb = \"left_arm\"\ndo = \"correct\"\n[planner]\nseed = 3\n");
    let free =
        run(&only_arm.replace("0.36, 1.05, 0.2", "0.38, 1.2, 0.28").replace("radius = 0.3", "radius = 0.06"), &s);
    assert!(free.is_solved() && free.done[0].left.is_empty(), "{:?}", free.done);
    let outcome = run(&only_arm, &s);
    let done = &outcome.done[0];
    // The arm is out of the way, the chest is where the clip has it: that is no solution, and says so.
    assert!(!outcome.is_solved() && !done.plans.is_empty() && !done.left.is_empty(), "{done:?}");
    assert!(done.left.iter().all(|l| l.is_driven && l.span.with == "ball"), "{done:?}");
    assert!(why(&outcome, 0).contains("no motion of left_arm helps"), "{}", why(&outcome, 0));
    assert_ne!(outcome.clips[0][0], outcome.clips[0][1]);
    assert_eq!(outcome.recheck.violations, []);
}

#[test]
fn heads_turn_to_what_is_taken_and_back_and_nothing_else_does() {
    let s = Somebody::standing();
    let outcome = run(&TASK.replace("seed = 3", "seed = 3\ngaze = true"), &s);
    assert!(outcome.is_solved(), "{:?}", outcome.done);
    assert_eq!(outcome.recheck.violations, []);
    assert!(outcome.recheck.gaze_off_rad < 0.1, "{}", outcome.recheck.gaze_off_rad);
    let [before, after] = &outcome.clips[0];
    // How far the face is from the cup, at 1.4 s.
    let off = |clip: &Clip| {
        let (at, turn) = clip.joint_transforms(&s.skeleton, 42)[throng_core::Joint::Head.index()];
        let cup = outcome.scenery[1].paths[1].at(1.4).position.as_vec3();
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
    let s = Somebody::standing();
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
    let skeleton = Somebody::standing().skeleton;
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
    let s = Somebody::standing();
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

#[test]
fn what_no_search_can_mend_is_known_before() {
    let s = Somebody::standing();
    let ahead = |text: &str| {
        let task = parse(text).unwrap_or_else(|e| panic!("{e}"));
        task.ahead(&[ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }]).expect("clips")
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
    assert!(task.walks());
    let entry = task.characters[0].clip.walk.as_ref().expect("it walks");
    assert_eq!((entry.bundle.as_path(), entry.speed_mps), (Path::new("folder/w.throng"), 1.2));
    assert_eq!(task.times_s(), [None, None]);
    let s = Somebody::standing();
    let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
    assert!(matches!(task.run(&clips, None), Err(NoClips::NotWalked { name }) if name == "main"));
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
