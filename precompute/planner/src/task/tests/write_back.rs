//! Text of a task with moved things.

use super::*;
use glam::DVec3;
use throng_base::text::TomlSource;

const TEXT: &str = r#"clip = "stand.bvh" # its motion

[[scene.obstacles]]
name = "post" # of wood
shape = { capsule = { from = [0.0, 0.0, 0.0], to = [0.0, 1.1, 0.0], radius = 0.03 } }
at = [ 0.33, 0, 2.2 ]   # beside the path

[[scene.obstacles]]
name = "swing"
shape = { ball = { radius = 0.1 } }
keys = [{ t_s = 0.0, at = [1.0, 2.0, 3.0] }, { t_s = 1.0, at = [1.5, 2.0, 3.0] }]

[[scene.objects]]
# lies in the middle
name = "cup"
shape = { ball = { radius = 0.04 } }

[[tasks]]
limb = "left_arm"
do = "grab"
object = "cup"
grips = [{}]
at_s = 1.0
window_s = [0.1, 2.0]

[[tasks]]
limb = "left_arm"
do = "drop"
object = "cup"
to = { on = "post" } # stays upright
at_s = 3.0
window_s = [2.0, 4.0]
"#;

#[test]
fn numbers_that_changed_are_written_and_nothing_else() {
    let s = TestCharacter::standing();
    let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
    let source = TomlSource::new(TEXT, std::path::Path::new("folder/t.toml"));
    let parse = |text: &str| Task::parse(text, source.path()).expect("a task");
    let mut task = parse(TEXT);
    assert_eq!(task.write_back(&source).expect("a text"), TEXT);
    let (scenery, _) = task.scenery(&clips).expect("clips");
    let moves = [
        (Handle::Thing(0), DVec3::new(0.02, 0.0, -0.1), ("[ 0.33, 0, 2.2 ]", "[ 0.35, 0, 2.1 ]")),
        (
            Handle::Thing(1),
            DVec3::new(0.0, 0.5, 0.0),
            (
                "at = [1.0, 2.0, 3.0] }, { t_s = 1.0, at = [1.5, 2.0",
                "at = [1.0, 2.5, 3.0] }, { t_s = 1.0, at = [1.5, 2.5",
            ),
        ),
        (Handle::Thing(2), DVec3::new(0.1, 0.2, -0.00004), ("name = \"cup\"", "at = [0.1, 0.2, 0.0]\nname = \"cup\"")),
        (Handle::Place(1), DVec3::Y * 0.123456, ("{ on =", "{ at = [0.0, 0.1235, 0.0], on =")),
    ];
    let mut expected = TEXT.to_owned();
    for (handle, by, (old, new)) in moves {
        task.move_by(handle, by, &scenery);
        expected = expected.replace(old, new);
        let written = task.write_back(&source).expect("a text");
        assert_eq!(written, expected);
        let read = parse(&written);
        for h in task.handles() {
            assert!(read.written_position(h).distance(task.written_position(h)) < 1e-4, "{}", task.handle_name(h));
        }
    }
    // About another scene by now.
    let other = TomlSource::new(
        &TEXT[TEXT.find("[[scene.objects]]").expect("objects")..].replace("\"post\"", "\"cup\""),
        source.path(),
    );
    assert!(task.write_back(&other).is_err());
    let other = TEXT.replace(
        "[[scene.objects]]",
        "[[scene.obstacles]]\nname = \"new\"\nshape = { ball = { radius = 1.0 } }\n[[scene.objects]]",
    );
    let why = task.write_back(&TomlSource::new(&other, source.path())).unwrap_err().to_string();
    assert!(why.contains("open it again"), "{why}");
}
