//! Files of tasks and meshes: what is refused, and where.

use super::*;
use throng_motion::import::obj;

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
        ("at = [0.1, 1.35, 0.42]", "at = [1e7, 1.35, 0.42]", "places within 10000 m"),
        ("name = \"cup\"\n", "name = \"cup\"\nat = [0.0, nan, 0.0]\n", "places within 10000 m"),
        ("at_s = 1.4", "at_s = 1.4\nhold_s = 1e12", "hold_s: expected 0 to 600, found 1000000000000"),
        ("at_s = 1.4", "at_s = 1.4\nhold_s = nan", "hold_s: expected 0 to 600, found NaN"),
        ("name = \"ball\"", "name = \"cup\"", "two of `cup`"),
        ("{ ball = { radius = 0.06 } }", "{ mesh = { file = \"a.obj\" } }", "a.obj"),
        ("{ ball = { radius = 0.06 } }", "{ mesh = { file = \"a.stl\" } }", "expected a mesh as OBJ, glTF or GLB"),
        ("seed = 3", "epsilon_m = 0.0", "planner.epsilon_m: expected 0.01 to 10"),
        ("seed = 3", "draws = 4294967295", "planner.draws: expected 0 to 1000000"),
        ("seed = 3", "straighten = 4294967295", "planner.straighten: expected 0 to 10000"),
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
    let dropped = TASK.replacen("do = \"grab\"", "do = \"drop\"\nto = { at = [0.0, -2e4, 0.0] }", 1);
    let e = parse(&dropped.replace("grips = [", "level_deg = 9.0 # [")).expect_err("far down");
    assert!(e.contains("to: expected a finite place within 10000 m"), "{e}");
    let lists = [
        ("grips = [", format!("grips = [{}", "{}, ".repeat(1000)), "grips: expected 1000 at most, found 1001"),
        (
            "at_s = 1.4",
            format!("at_s = 1.4\ncontacts = [{}]", "\"cup\", ".repeat(1001)),
            "contacts: expected 1000 at most, found 1001",
        ),
    ];
    for (from, to, why) in lists {
        let e = parse(&TASK.replacen(from, &to, 1)).expect_err(why);
        assert!(e.contains(why), "{why}: {e}");
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
        mesh::read_mesh(&path, unit_m, open)
    };
    let size = |shape: throng_geometry::SolidShape| shape.ball_around().1 * 2.0;
    let diagonal = size(read(CUBE, 0.01, false).expect("a mesh"));
    assert!((diagonal - 0.03f64.sqrt() * 0.1).abs() < 1e-6, "{diagonal}");
    let holed = CUBE.replace("f 4 1 5 8\n", "");
    let e = read(&holed, 1.0, false).unwrap_err();
    assert!(e.contains("cube.obj: 4 edges") && e.contains("open = true"), "{e}");
    assert!(read(&holed, 1.0, true).is_ok());
    // Faces that stand there again, from whichever corner on, neither hide holes nor cost time.
    let again =
        holed.replace("f 1 2 3 4\n", "f 1 2 3\nf 2 3 1\nf 3 1 2\nf 3 4 1\n") + &holed[holed.find('f').unwrap_or(0)..];
    assert_eq!(read(&again, 1.0, false).unwrap_err(), e);
    let mut corners = obj::triangles(&again).expect("triangles");
    mesh::remove_duplicates(&mut corners);
    assert_eq!(corners.len(), 10);
    for (text, unit_m, why) in [
        ("", 1.0, "no triangles"),
        (CUBE, 0.0, "positive `unit_m`"),
        (CUBE, f64::NAN, "positive `unit_m`"),
        (CUBE, 1e-50, "0.000001 to 1000000, found"),
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
