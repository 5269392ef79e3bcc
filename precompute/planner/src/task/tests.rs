use super::*;
use crate::testing::Somebody;
use glam::Quat;
use proptest::prelude::*;
use std::path::Path;
use throng_core::NUM_JOINTS;
use throng_motion::Clip;

/// A cup that moves past, and a ball that flies through the arm later.
const TASK: &str = r#"
clip = "stand.bvh"

[[scene.obstacles]]
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

fn parse(text: &str) -> Result<Task, String> {
    Task::parse(text, Path::new("folder/t.toml")).map_err(|e| e.to_string())
}

fn stand(s: &Somebody) -> Clip {
    let arm = s.pose(0.0, -0.7, 0.6);
    let mut row = vec![Quat::IDENTITY; NUM_JOINTS];
    for (i, j) in s.linkage.limb.joints().into_iter().enumerate() {
        row[j.index()] = arm.0[i].as_quat();
    }
    Clip::new("stand", 30.0, vec![s.skeleton.offsets[0]; 151], row.repeat(151))
}

#[test]
fn a_task_is_done_in_its_order() {
    let s = Somebody::standing();
    let task = parse(TASK).expect("a task");
    assert_eq!(task.clip, Path::new("folder/stand.bvh"));
    let clip = stand(&s);
    let outcome = task.run(&clip, &s.skeleton);
    assert!(outcome.is_solved(), "{:?}", outcome.done);
    let [(_, Done::Reached(reached)), (_, Done::Corrected(spans))] = &outcome.done[..] else {
        panic!("{:?}", outcome.done)
    };
    assert!(reached.attachment.is_some() && spans.len() == 1 && spans[0].span.with == "ball");
    assert_ne!(outcome.clip.frame_rotations(40), clip.frame_rotations(40));
    assert_eq!(outcome.clip.frame_rotations(80), clip.frame_rotations(80));
    assert_eq!(outcome.clip, task.run(&clip, &s.skeleton).clip);
}

#[test]
fn what_cannot_be_done_is_said_and_leaves_the_clip() {
    let s = Somebody::standing();
    let clip = stand(&s);
    let far = parse(&TASK.replace("0.42] }", "0.9] }")).expect("a task").run(&clip, &s.skeleton);
    assert!(matches!(&far.done[0].1, Done::Not(why) if why.contains("out of reach by 0.")), "{:?}", far.done);
    assert!(!far.is_solved());
    let late = parse(&TASK.replace("at_s = 1.4", "at_s = 7.4").replace("[0.5, 2.3]", "[7.0, 8.0]")).expect("a task");
    assert!(
        matches!(&late.run(&clip, &s.skeleton).done[0].1, Done::Not(why) if why.contains("within the clip's 0 to 5.00 s"))
    );
    let grab = &TASK[TASK.find("[[tasks]]").expect("tasks")..TASK.rfind("[[tasks]]").expect("tasks")];
    let twice = parse(&format!("{TASK}\n").replace("[planner]", &format!("{}\n[planner]", grab.replace("1.4", "1.5"))));
    let twice = twice.expect("a task").run(&clip, &s.skeleton);
    assert!(matches!(&twice.done[2].1, Done::Not(why) if why.contains("held already")), "{:?}", twice.done);
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
        ("name = \"ball\"", "name = \"cup\"", "two obstacles `cup`"),
        ("{ ball = { radius = 0.06 } }", "{ mesh = { file = \"a.obj\" } }", "a.obj"),
        ("{ ball = { radius = 0.06 } }", "{ mesh = { file = \"a.stl\" } }", "expected a mesh as OBJ"),
        ("seed = 3", "epsilon_m = 0.0", "expected 0.01 to 10"),
        ("seed = 3", "sed = 3", "Did you mean `seed`?"),
        ("grips = [{ at = [0.0, 0.0, -0.09], turn_deg = [0.0, -83.0, 0.0] }]", "", "expected `object` and `grips`"),
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

proptest! {
    #[test]
    fn damaged_tasks_and_objects_do_no_harm(cut in 0usize..1000, with in "[\\[\\]{}=\\-0-9a-z./ \"\\n]{0,4}", skip in 0usize..8) {
        let cut = cut % TASK.len();
        let text = format!("{}{with}{}", &TASK[..cut], &TASK[(cut + skip).min(TASK.len())..]);
        if let Ok(task) = parse(&text) {
            prop_assert!(task.solids.iter().all(|s| s.shape.is_valid()));
        }
        let _ = obj::triangles(&text);
        let _ = obj::triangles(&format!("v 0 0 0\nv 1 {with} 0\nf {with} {cut} -{skip}\n"));
    }
}
