//! Tests of scenes as documents.

use super::*;
use crate::document::OpenDocument;
use crate::fixtures::boxing::Boxing;
use crate::fixtures::meeting::Meeting;
use crate::fixtures::paces::Paces;
use crate::fixtures::quietly;

const GROUPS: &str = r#"
bundle = "boxing.throng"
[[groups]]
name = "boxers"
motion = "sparring"
count = 4
place = { grid = { centre = [20.0, 0.0], distance_m = 1.2 } }
behaviours = [{ name = "approach" }, { name = "throw-punches", weight = 2.0 }]
[[groups]]
name = "crossing"
motion = "none"
count = 6
place = { block = { from = [-6.0, -2.0], to = [-3.0, 2.0] } }
goal = { shift = { by = [8.0, 0.0] } }
at_end = "leave"
[[environment.obstacles]]
disc = { centre = [0.0, 0.0], radius_m = 0.5 }
"#;

fn open(folder: &Path, text: &str) -> Result<SceneDocument, String> {
    let path = folder.join("both.toml");
    std::fs::write(&path, text).unwrap();
    quietly(|with| SceneDocument::open(&path, with))
}

/// Places of all characters and joints of all bodies, as bits.
fn seen(document: &SceneDocument) -> Vec<u32> {
    let (run, all) = (&document.run, 0..document.run.simulation().num_characters());
    let joints = |who| run.simulation().joint_positions(who).into_iter().flatten();
    let points = all.flat_map(|who| run.place(who).into_iter().chain(joints(who)));
    points.flat_map(|p| p.to_array()).map(f32::to_bits).collect()
}

#[test]
fn groups_of_all_kinds_are_played_rewound_and_restarted() {
    let boxing = Boxing::new();
    let folder = boxing.bundle().parent().unwrap().to_path_buf();
    let mut document = open(&folder, GROUPS).unwrap();
    assert!(document.bundle().is_some() && document.surroundings.obstacles.len() == 1);
    let mut frames = vec![seen(&document)];
    for _ in 0..200 {
        document.run.step().unwrap();
        frames.push(seen(&document));
    }
    assert!(frames[0] != frames[200] && document.run.trail(5, 1.0).count() > 8);
    for step in [199, 60, 59, 130, 0, 200] {
        document.run.seek(step).unwrap();
        assert_eq!(document.run.head.shown_step(), step);
        assert!(seen(&document) == frames[step as usize], "step {step} looks as it did");
    }
    document.run.seek(150).unwrap();
    let now_s = document.run.simulation().time_s();
    assert!((now_s - 2.5).abs() < 1e-9 && document.run.events().all(|e| e.time_s <= now_s));
    let choice = SceneChoice { characters: 20, seed: 9, ..document.choice };
    document.restart(choice, None, || {}).unwrap();
    assert_eq!(document.restarting(), Some(choice));
    assert!(document.adopt_restart(true).unwrap());
    assert_eq!((document.choice, document.run.simulation().num_characters()), (choice, 20));
    assert_eq!(document.run.head.shown_step(), 0);
    assert!(
        document.restart(SceneChoice { characters: 0, ..choice }, None, || {}).unwrap_err().contains("1 to 100000")
    );
    std::fs::remove_file(boxing.bundle()).unwrap();
    let e = open(&folder, GROUPS).map(|_| ()).unwrap_err();
    assert!(e.contains("both.toml") && e.contains("boxing.throng"), "{e}");
}

#[test]
fn a_saved_state_is_restored_and_anything_else_refused() {
    let meeting = Meeting::new();
    let mut document = quietly(|with| SceneDocument::open(&meeting.scene(12), with)).unwrap();
    assert!(document.bundle().is_none());
    let file = meeting.folder().join("a.state");
    (0..90).for_each(|_| document.run.step().unwrap());
    document.save(&file).unwrap();
    let at = seen(&document);
    document.restart(SceneChoice { characters: 8, ..document.choice }, None, || {}).unwrap();
    assert!(document.adopt_restart(true).unwrap());
    assert_eq!(document.run.simulation().num_characters(), 8);
    document.restore(&file, || {}).unwrap();
    assert!(document.adopt_restart(true).unwrap());
    assert_eq!((document.choice.characters, document.run.head.shown_step(), document.num_runs), (24, 90, 2));
    assert!(seen(&document) == at);
    std::fs::write(&file, "something else").unwrap();
    let e = document.restore(&file, || {}).unwrap_err();
    assert!(e.contains("a.state") && e.contains("not a saved state"), "{e}");
}

#[test]
fn a_missing_bundle_of_bodies_is_built() {
    let paces = Paces::new();
    let path = paces.crowd(2);
    std::fs::remove_file(paces.bundle()).unwrap();
    let document = quietly(|with| SceneDocument::open(&path, with)).unwrap();
    assert!(paces.bundle().exists() && document.run.simulation().pose(0).is_some());
    std::fs::write(paces.bundle(), "no bundle").unwrap();
    let e = quietly(|with| SceneDocument::open(&path, with)).map(|_| ()).unwrap_err();
    assert!(e.contains("people.toml") && e.contains("paces.throng"), "{e}");
    std::fs::remove_file(paces.bundle()).unwrap();
    std::fs::remove_file(paces.folder().join("paces.toml")).unwrap();
    let e = quietly(|with| SceneDocument::open(&path, with)).map(|_| ()).unwrap_err();
    assert!(e.contains("people.toml") && e.contains("paces.throng") && e.contains("paces.toml"), "{e}");
}

#[test]
fn untrusted_files_read_nothing_elsewhere_and_nothing_is_built_for_them() {
    let paces = Paces::new();
    let path = paces.crowd(2);
    let read = |file: &Path| quietly(|with| OpenDocument::read(&[file.to_path_buf()], true, with)).map(|_| ());
    read(&path).unwrap();
    std::fs::remove_file(paces.bundle()).unwrap();
    let e = read(&path).unwrap_err();
    assert!(e.contains("no such bundle") && !paces.bundle().exists(), "{e}");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("\"paces.throng\"", "\"../paces.throng\"")).unwrap();
    let e = read(&path).unwrap_err();
    assert!(e.contains("outside of the folder"), "{e}");
    let e = read(paces.folder()).unwrap_err();
    assert!(e.contains("--untrusted builds nothing"), "{e}");
}

#[test]
fn impossible_scenes_are_refused_by_name() {
    let meeting = Meeting::new();
    let path = meeting.scene(12);
    let text = std::fs::read_to_string(&path).unwrap();
    for (from, to, say) in [("count = 12", "count = 0", "count"), ("[-9.0, -3.0]", "[-2.2, -3.0]", "overlap")] {
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let e = quietly(|with| SceneDocument::open(&path, with)).map(|_| ()).unwrap_err();
        assert!(e.contains("meeting") && e.contains(say), "{e}");
    }
    for (text, say) in [
        ("name = \"walk\"\ninputs = [\"clips\"]\n", "config of a build"),
        ("colour = 3\n", "colour"),
        (
            "bundle = \"no.throng\"\nconfig = \"nowhere.toml\"\n[[groups]]\nmotion = \"sparring\"\ncount = 2\n\
          behaviours = [{ name = \"approach\" }]\n",
            "nowhere.toml",
        ),
    ] {
        std::fs::write(&path, text).unwrap();
        let e = quietly(|with| SceneDocument::open(&path, with)).map(|_| ()).unwrap_err();
        assert!(e.contains("meeting.toml") && e.contains(say), "{e}");
    }
}
