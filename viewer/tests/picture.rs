//! `throng-viewer --png`: pictures without a screen, the same every time, and messages that show the way out.

use crate::common;
use crate::common::boxing::Boxing;
use crate::common::{adapter, bvh, golden};
use std::path::Path;
use std::process::{Command, Output};

fn viewer(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_throng-viewer"));
    command.args(args).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command
}

fn run(args: &[&str]) -> Output {
    viewer(args).output().expect("the viewer starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn done(args: &[&str]) -> String {
    let out = run(args);
    assert_eq!(out.status.code(), Some(0), "{args:?}: {}", text(&out.stderr));
    text(&out.stdout)
}

/// Standard error of a run that ends with a code and prints nothing else.
fn ended_with(code: i32, args: &[&str]) -> String {
    let out = run(args);
    let message = text(&out.stderr);
    assert_eq!(out.status.code(), Some(code), "{args:?}: {message}");
    assert!(out.stdout.is_empty() && message.contains("error: ") && !message.contains("panicked"), "{message}");
    message
}

fn utf8(path: &Path) -> &str {
    path.to_str().expect("a readable path")
}

/// Width, height and pixels of a picture.
fn pixels(path: &Path) -> (u32, u32, Vec<[u8; 3]>) {
    let picture = image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).into_rgb8();
    (picture.width(), picture.height(), picture.pixels().map(|p| p.0).collect())
}

/// Different colours within the middle of a picture.
fn colours_in_the_middle(path: &Path) -> usize {
    let (width, height, all) = pixels(path);
    let rows = (height / 4..height * 3 / 4).flat_map(|y| (width / 4..width * 3 / 4).map(move |x| y * width + x));
    rows.map(|i| all[i as usize]).collect::<std::collections::HashSet<_>>().len()
}

#[test]
fn a_folder_is_built_before_it_is_drawn() {
    if adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("clips")).expect("a folder in it");
    common::walk(&folder.path().join("clips"), 1.0);
    let mut command = viewer(&["clips", "--png", "a.png", "--size", "320x200", "--frames", "2"]);
    let mut run = || command.current_dir(folder.path()).output().expect("the viewer starts");
    let (first, again) = (run(), run());
    let told = text(&first.stderr);
    assert!(first.status.success() && told.contains("building clips ...") && told.contains("made: "), "{told}");
    assert!(again.status.success() && !text(&again.stderr).contains("made: "), "{}", text(&again.stderr));
    let kept = std::fs::read_dir(folder.path().join(".throng-cache")).expect("a cache");
    let bundles = kept.filter(|e| e.as_ref().is_ok_and(|e| e.path().extension().is_some_and(|x| x == "throng")));
    assert_eq!(bundles.count(), 1);
}

#[test]
fn a_bundle_and_a_motion_file_are_drawn_the_same_every_time() {
    if adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    for file in [golden(), bvh(folder.path())] {
        let (a, b) = (folder.path().join("a.png"), folder.path().join("b.png"));
        for out in [&a, &b] {
            let args = [utf8(&file), "--png", utf8(out), "--size", "320x200", "--frames", "20", "--panel", "none"];
            assert!(done(&args).is_empty());
        }
        assert_eq!((pixels(&a).0, pixels(&a).1), (320, 200));
        assert!(colours_in_the_middle(&a) > 40, "{} is blank", file.display());
        assert!(
            std::fs::read(&a).expect("a picture") == std::fs::read(&b).expect("a picture"),
            "two pictures of {} differ",
            file.display()
        );
    }
}

#[test]
fn arguments_change_the_picture() {
    if adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let file = golden();
    let plain = ["--size", "640x400", "--frames", "5", "--characters", "4"];
    let draw = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let args = [&[utf8(&file), "--png", utf8(&out)], &plain[..], more].concat();
        done(&args);
        pixels(&out).2
    };
    let before = draw("plain.png", &[]);
    for more in [
        &["--theme", "light"][..],
        &["--camera", "top"],
        &["--panel", "none"],
        &["--seed", "2"],
        &["--stage", "clip"],
        &["--frame", "9"],
        &["--character", "2"],
        &["--scale", "2"],
    ] {
        assert!(before != draw("other.png", more), "{more:?} changes nothing");
    }
    // From far away all bodies are alike.
    let near = ["--stage", "clip", "--camera", "distance=3"];
    let other = [&near[..], &["--body", "mannequin"]].concat();
    assert!(draw("near.png", &near) != draw("other.png", &other), "bodies look the same");
}

#[test]
fn times_are_reported() {
    if adapter().is_none() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (file, out) = (golden(), folder.path().join("a.png"));
    let printed = done(&[utf8(&file), "--png", utf8(&out), "--size", "160x100", "--frames", "8", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&printed).expect("a JSON object");
    assert_eq!((&report["characters"], &report["frames"]), (&100.into(), &6.into()), "{report}");
    assert_eq!((&report["width"], &report["height"]), (&160.into(), &100.into()), "{report}");
    let parts = ["simulation", "layout", "upload", "drawing", "interface", "frame"];
    for key in parts.iter().flat_map(|p| [format!("{p}_ms"), format!("{p}_p95_ms")]) {
        assert!(report[&key].as_f64().is_some_and(|ms| ms > 0.0), "{key}: {report}");
    }
}

#[test]
fn scenes_are_drawn_and_measured() {
    if adapter().is_none() {
        return;
    }
    let boxing = Boxing::new();
    let (pairs, targets) = (boxing.pairs(4), boxing.targets(2));
    for scene in [&pairs, &targets] {
        let (a, b) = (boxing.bundle().with_file_name("a.png"), boxing.bundle().with_file_name("b.png"));
        for out in [&a, &b] {
            done(&[utf8(scene), "--png", utf8(out), "--size", "320x200", "--frames", "90", "--panel", "none"]);
        }
        assert!(colours_in_the_middle(&a) > 40, "{} is blank", scene.display());
        assert!(std::fs::read(&a).expect("a picture") == std::fs::read(&b).expect("a picture"), "two pictures differ");
    }
    let out = boxing.bundle().with_file_name("c.png");
    let ten = [utf8(&pairs), "--png", utf8(&out), "--size", "160x100", "--frames", "4", "--characters", "10", "--json"];
    let report: serde_json::Value = serde_json::from_str(&done(&ten)).expect("a JSON object");
    assert!(report["characters"] == 10 && report["frame_ms"].as_f64().is_some_and(|ms| ms > 0.0), "{report}");
    let odd = ended_with(1, &[utf8(&pairs), "--png", utf8(&out), "--characters", "3"]);
    assert!(odd.contains("even"), "{odd}");
    let lost = boxing.bundle().with_file_name("lost.toml");
    let text = std::fs::read_to_string(&pairs).expect("a scene").replace("boxing.throng", "no.throng");
    std::fs::write(&lost, text).expect("a scene");
    let lost = ended_with(1, &[utf8(&lost), "--png", utf8(&out)]);
    assert!(lost.contains("no.throng") && lost.contains("bundle"), "{lost}");
}

#[test]
fn failures_name_the_thing_and_leave_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let file = golden();
    std::fs::write(at("cut.throng"), &std::fs::read(&file).expect("the bundle")[..5000]).expect("a file");
    std::fs::write(at("bad.bvh"), "HIERARCHY\nROOT hips\n{\n").expect("a file");
    let out = at("a.png");
    let png = ["--png", utf8(&out), "--size", "160x100"];
    let unwritable = at("no/such/a.png");
    let has_adapter = adapter().is_some();
    let mut cases = vec![(utf8(&file).to_owned(), vec!["--png", utf8(&unwritable)], "no/such")];
    if has_adapter {
        cases.extend([
            (utf8(&at("absent.throng")).to_owned(), png.to_vec(), "absent.throng"),
            (utf8(&at("cut.throng")).to_owned(), png.to_vec(), "cut.throng"),
            (utf8(&at("bad.bvh")).to_owned(), png.to_vec(), "bad.bvh"),
            (utf8(&file).to_owned(), [&png[..], &["--clip", "moonwalk"]].concat(), "moonwalk"),
            (utf8(&file).to_owned(), [&png[..], &["--character", "100"]].concat(), "100 characters"),
            (utf8(&file).to_owned(), [&png[..], &["--frame", "999999"]].concat(), "--frame 999999"),
        ]);
    }
    for (file, args, say) in cases {
        let message = ended_with(1, &[&[file.as_str()], &args[..]].concat());
        assert!(message.contains(say), "{args:?}: {message}");
        assert!(!out.exists(), "{args:?} left a picture");
    }
    for (args, say) in
        [(["--size", "640"], "640x400"), (["--panel", "kitchen"], "control"), (["--camera", "up"], "three-quarter")]
    {
        let message = ended_with(2, &[utf8(&file), "--png", utf8(&out), args[0], args[1]]);
        assert!(message.contains(say), "{message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 2, "a failure left a file");
}

#[cfg(target_os = "linux")]
#[test]
fn without_an_adapter_or_a_display_the_message_shows_the_way_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, out) = (golden(), folder.path().join("a.png"));
    // An interface that this system does not have.
    let drawn = viewer(&[utf8(&file), "--png", utf8(&out)]).env("WGPU_BACKEND", "dx12").output().expect("it starts");
    assert_eq!(drawn.status.code(), Some(1));
    assert!(text(&drawn.stderr).contains("mesa-vulkan-drivers"), "{}", text(&drawn.stderr));
    assert!(!out.exists());
    let message = ended_with(1, &[utf8(&file)]);
    assert!(message.contains("display") && message.contains("--png"), "{message}");
    // A display that is not there.
    let shown = viewer(&[utf8(&file)]).env("DISPLAY", ":4242").output().expect("it starts");
    assert_eq!(shown.status.code(), Some(1));
    assert!(text(&shown.stderr).contains("--png"), "{}", text(&shown.stderr));
}
