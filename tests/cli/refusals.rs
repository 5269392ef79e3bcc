//! What cannot be done is refused with the file, the place and the way out.

use super::{BundleFolder, CONFIG, at, failed, folder, text, throng};
use serde_json::Value;
use std::path::Path;

#[test]
fn files_that_are_no_bundles_are_refused_by_name() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let cut = at(&folder, "cut.throng");
    std::fs::write(&cut, &std::fs::read(place.bundle()).expect("the bundle")[..5000]).expect("a file");
    let text = at(&folder, "text.throng");
    std::fs::write(&text, "HIERARCHY\nROOT hips\n{\n").expect("a file");
    let absent = at(&folder, "absent.throng");
    for (file, say) in [(&cut, "5000 bytes"), (&text, "not a Throng bundle"), (&absent, "cannot be opened")] {
        let cases: [&[&str]; 7] = [
            &["verify", file, "--json"],
            &["query", "action", file, "--state", "0", "--target", "1,1", "--json"],
            &["run", file, "--characters", "2", "--seconds", "1", "--json"],
            &["bench", "bundle", file, "--json"],
            &["export", file, "--format", "graph-json"],
            &["export", file, "--format", "hits-csv"],
            &["inspect", file],
        ];
        for args in cases {
            let e = failed(args);
            assert!(e.contains(file.as_str()) && e.contains(say) && e.contains("throng build"), "{args:?}: {e}");
        }
    }
    let e = failed(&["inspect", &at(&folder, "absent.bvh")]);
    assert!(e.contains("absent.bvh"), "{e}");
    let e = failed(&["export", &place.bundle(), "--format", "positions-csv"]);
    assert!(e.contains("little.throng") && e.contains("graph-json"), "{e}");
    let e = failed(&["export", &place.bundle(), "--format", "bvh"]);
    assert!(e.contains("little.throng") && e.contains("--out"), "{e}");
    let e = failed(&["export", &at(&folder, "absent.bvh"), "--format", "bvh"]);
    assert!(e.contains("absent.bvh"), "{e}");
    let e = failed(&["build", &at(&folder, "absent.toml"), "--out", &at(&folder, "a.throng")]);
    assert!(e.contains("absent.toml"), "{e}");
    let e = failed(&["synth", "--set", "swim", "--out", &at(&folder, "clips")]);
    assert!(e.contains("swim") && e.contains("walk"), "{e}");
}

#[test]
fn wrong_configs_name_the_place_and_the_nearest_key() {
    let folder = folder();
    let (config, out) = (at(&folder, "bad.toml"), at(&folder, "a.throng"));
    for (text, place, way_out) in [
        ("inputs = [\"a\"]\n\n[graph]\nbranshing = 3.0\n", "bad.toml:4:1:", "`branching`"),
        ("inputs = [\"a\"]\n[policy]\nepsilom = 1\n", "bad.toml:3:1:", "`epsilon`"),
        ("inputs = 3\n", "bad.toml:1:10:", "throng schema"),
        ("inputs = [\"a\"\n", "bad.toml:", "throng schema"),
        ("inputs = [\"nowhere/*.bvh\"]\n", "nowhere", "nowhere"),
    ] {
        std::fs::write(&config, text).expect("a config");
        let e = failed(&["build", &config, "--out", &out, "--no-cache", "--json"]);
        assert!(e.contains(place) && e.contains(way_out), "{e}");
        assert!(!Path::new(&out).exists(), "a failed build left a bundle");
    }
}

#[test]
fn a_bad_clip_is_skipped_and_counted_or_stops_a_strict_build() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let clips = folder.path().join("clips");
    std::fs::create_dir(&clips).expect("a folder");
    for from in place.clips() {
        std::fs::copy(&from, clips.join(from.file_name().expect("a name"))).expect("a copy");
    }
    let good = std::fs::read_to_string(place.first_clip()).expect("a clip");
    let bad_line = good.lines().count() - 5;
    let mut lines: Vec<&str> = good.lines().collect();
    lines[bad_line - 1] = "1.0 2.0 three";
    std::fs::write(clips.join("bad.bvh"), lines.join("\n")).expect("a clip");
    let (config, out) = (at(&folder, "little.toml"), at(&folder, "a.throng"));
    std::fs::write(&config, CONFIG).expect("a config");

    let e = failed(&["build", &config, "--out", &out, "--no-cache", "--strict", "--json"]);
    assert!(e.contains(&format!("bad.bvh:{bad_line}:")), "expected line {bad_line}: {e}");
    let left: Vec<_> =
        std::fs::read_dir(folder.path()).expect("the folder").map(|e| e.expect("an entry").file_name()).collect();
    assert_eq!(left.len(), 2, "a failed build left {left:?}");

    let built = throng(&["build", &config, "--out", &out, "--no-cache", "--json"]);
    let (report, told) = (text(&built.stdout), text(&built.stderr));
    let report: Value = serde_json::from_str(&report).unwrap_or_else(|e| panic!("{e}: {told}"));
    assert_eq!(report["skipped"].as_array().map(Vec::len), Some(1));
    assert!(told.contains("skipped: ") && told.contains("bad.bvh") && told.contains("1 file(s) skipped"), "{told}");

    std::fs::write(&config, CONFIG.replace("clips", "clips/bad.bvh")).expect("a config");
    let before = std::fs::read(&out).expect("the bundle");
    failed(&["build", &config, "--out", &out, "--no-cache"]);
    assert!(std::fs::read(&out).expect("the bundle") == before, "a failed build changed the old bundle");
}

#[test]
fn places_that_cannot_be_written_are_named() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let nowhere = at(&folder, "no/such/folder/a.throng");
    let e = failed(&["build", &place.path("little.toml"), "--out", &nowhere, "--no-cache"]);
    assert!(e.contains("no/such/folder"), "{e}");
    let e = failed(&["export", &place.bundle(), "--format", "graph-json", "--out", &nowhere]);
    assert!(e.contains("no/such/folder"), "{e}");
}

#[test]
fn a_skeleton_for_files_that_take_none_is_refused() {
    let place = BundleFolder::shared();
    let clip = place.first_clip();
    for args in [
        vec!["inspect", &clip, "--asf", "some.asf"],
        vec!["inspect", &clip, &clip, "--asf", "some.asf"],
        vec!["export", &clip, "--format", "bvh", "--asf", "some.asf"],
    ] {
        let e = failed(&args);
        assert!(e.contains("--asf gives AMC files a skeleton (some.asf), and here is none"), "{args:?}: {e}");
    }
}

#[test]
fn nothing_is_written_over_what_is_read() {
    let folder = folder();
    let (world, scene, clip) = (at(&folder, "square.toml"), at(&folder, "scene.toml"), at(&folder, "walk.bvh"));
    for file in [&world, &scene, &clip] {
        let text = "bundle = \"absent.throng\"\n[[place]]\nunit = \"ground\"\nat = [0, 0, 0]\n";
        std::fs::write(file, text).expect("a file");
    }
    let e = failed(&["stitch", &world, "--out", &clip]);
    assert!(e.contains("walk.bvh") && e.contains("is not a world"), "{e}");
    let png = at(&folder, "a.png");
    for args in [
        vec!["export", &clip, "--format", "bvh", "--out", &clip],
        vec!["run", &scene, "--record", &scene],
        vec!["run", &scene, "--png", &scene],
        vec!["run", &scene, "--png", &png, "--record", &png],
        vec!["inspect", &clip, "--environment-out", &clip],
        vec!["inspect", &clip, "--hits-png", &clip],
        vec!["plan", &scene, "--out", &clip, "--png", &clip],
    ] {
        let e = failed(&args);
        assert!(e.contains("is read or written by the same command. Write elsewhere"), "{args:?}: {e}");
    }
    assert_eq!(std::fs::read(&clip).expect("a file"), std::fs::read(&world).expect("a file"), "all are as they were");
}

#[test]
fn worlds_that_cannot_be_are_refused_with_the_way_out() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let world = at(&folder, "square.toml");
    let ground = "[[place]]\nunit = \"ground\"\nat = [0.0, 0.0, 0.0]\n";
    let write = |text: &str| std::fs::write(&world, text).expect("a file");
    write(&format!("bundle = \"{}\"\n{ground}", place.bundle().replace('\\', "/")));
    let e = failed(&["stitch", &world, "--json"]);
    assert!(e.contains("no motion patches") && e.contains("data/playground.toml"), "{e}");
    write(&format!("bundle = \"absent.throng\"\n{ground}"));
    let e = failed(&["stitch", &world]);
    assert!(e.contains("absent.throng") && e.contains("throng build"), "{e}");
    write("bundle = \"a.throng\"\nplce = []\n");
    let e = failed(&["stitch", &world]);
    assert!(e.contains("square.toml:2") && e.contains("`place`"), "{e}");
    let scene = at(&folder, "scene.toml");
    std::fs::write(&scene, "world = \"square.toml\"\n").expect("a file");
    let e = failed(&["run", &scene]);
    assert!(e.contains("scene.toml:1:1: unknown field `world`"), "{e}");
}
