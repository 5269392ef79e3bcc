//! Folders, archives and patterns of motion, as people have them: inspected, built and run without a config.

use super::{BundleFolder, at, done, failed, folder, has_keys, json, text, throng};
use serde_json::Value;
use std::path::Path;
use throng_checks::damage::seeds;

/// A folder with the clips of the shared place in folders of their own, under names that people give, and other files.
fn lying_around(place: &BundleFolder) -> tempfile::TempDir {
    let folder = folder();
    let clips = place.clips();
    let [first, second] = &clips[..] else { panic!("expected two clips, found {clips:?}") };
    copy(first, &folder, "Day 1/take 1.BVH");
    copy(second, &folder, "Day 2/morning/walk.bvh");
    put(&folder, "Day 2/evening/walk.Bvh", &shortened(second, 100));
    put(&folder, "more/3.bvh", &shortened(first, 50));
    put(&folder, "Day 1/notes.txt", "not motion");
    put(&folder, ".hidden/broken.bvh", "not motion");
    folder
}

/// A clip without its last frames.
fn shortened(clip: &Path, by: usize) -> String {
    let text = std::fs::read_to_string(clip).expect("a clip");
    let lines: Vec<&str> = text.lines().collect();
    let count = lines.iter().find_map(|l| l.strip_prefix("Frames:")).expect("a number of frames");
    let left = count.trim().parse::<usize>().expect("a number") - by;
    lines[..lines.len() - by].join("\n").replace(&format!("Frames:{count}"), &format!("Frames: {left}"))
}

fn put(folder: &tempfile::TempDir, name: &str, content: &str) {
    let path = folder.path().join(name);
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    std::fs::write(path, content).expect("a file");
}

fn copy(from: &Path, folder: &tempfile::TempDir, to: &str) {
    put(folder, to, &std::fs::read_to_string(from).expect("a clip"));
}

/// Puts the files of a folder into an archive.
fn pack(folder: &Path, archive: &str) {
    let mut zip = zip::ZipWriter::new(std::fs::File::create(archive).expect("a file"));
    let mut left = vec![folder.to_path_buf()];
    while let Some(next) = left.pop() {
        for entry in std::fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                left.push(path);
                continue;
            }
            let name = path.strip_prefix(folder).expect("within").to_str().expect("a readable name").replace('\\', "/");
            let packed = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
            zip.start_file(name, packed).expect("a member");
            std::io::copy(&mut std::fs::File::open(&path).expect("a file"), &mut zip).expect("a copy");
        }
    }
    zip.finish().expect("an archive");
}

/// Builds motion without keeping anything; the report and what was told.
fn build(what: &[&str], out: &str) -> (Value, String) {
    let args = [&["build"], what, &["--out", out, "--no-cache", "--json"]].concat();
    let built = throng(&args);
    assert_eq!(built.status.code(), Some(0), "{args:?}: {}", text(&built.stderr));
    (serde_json::from_str(&text(&built.stdout)).expect("a report"), text(&built.stderr))
}

#[test]
#[ignore = "takes long; scripts/nightly.sh runs it"]
fn a_folder_and_an_archive_of_it_give_the_same_people() {
    let (place, elsewhere) = (BundleFolder::shared(), folder());
    let folder = lying_around(&place);
    let (a, b, zip) = (at(&elsewhere, "a.throng"), at(&elsewhere, "b.throng"), at(&elsewhere, "clips.zip"));
    pack(folder.path(), &zip);
    let (report, _) = build(&[folder.path().to_str().expect("a name")], &a);
    let policies: Vec<&str> =
        report["policies"].as_array().expect("a list").iter().filter_map(|p| p["name"].as_str()).collect();
    assert_eq!(policies, ["approach", "approach-coarse"]);
    // A walk strikes nothing: that is told, and nothing else is worse for it.
    let not_made = report["not_made"].as_array().expect("a list");
    let blows = not_made.iter().find(|n| n["part"] == "policy throw-punches").expect("told");
    assert!(blows["why"].as_str().is_some_and(|why| why.contains("Add clips with punches")), "{blows}");
    assert_eq!(report["skipped"], serde_json::json!([]));
    assert_eq!(report["performers"].as_array().map(Vec::len), Some(1));
    let names = |report: &Value| report["performers"][0]["clips"].clone();
    let shown = names(&report).to_string();
    for name in ["Day 1/take 1", "Day 2/morning/walk", "Day 2/evening/walk", "more/3"] {
        assert!(shown.contains(&format!("\"{name}\"")), "{shown}");
    }
    has_keys(&report["verdict"], &["word", "sentences", "advice", "motion", "source_slip_mean_mps"]);
    assert!(report["trial"]["reached_fraction"].as_f64() > Some(0.5), "{}", report["trial"]);

    let (packed, _) = build(&[&zip], &b);
    assert_eq!(names(&packed), names(&report));
    assert_eq!(
        (&packed["graph"], &packed["trial"]["reached_fraction"]),
        (&report["graph"], &report["trial"]["reached_fraction"])
    );
    let pattern = at(&folder, "Day*/**/*alk.*");
    let (some, _) = build(&[&pattern, &at(&folder, "more")], &b);
    assert!(names(&some).to_string().contains("Day 2/evening/walk"), "{some}");
}

#[test]
fn what_is_wrong_in_a_folder_is_told_and_the_rest_is_built() {
    let (place, elsewhere) = (BundleFolder::shared(), folder());
    let folder = lying_around(&place);
    copy(&place.clips()[0], &folder, "copies/once more.bvh");
    put(&folder, "broken.bvh", "HIERARCHY\nROOT\n");
    put(&folder, "torn.zip", "not an archive");
    put(&folder, "lonely.amc", ":FULLY-SPECIFIED\n1\n");
    let root = folder.path().to_str().expect("a name").to_owned();
    let out = at(&elsewhere, "a.throng");
    let (report, told) = build(&[&root], &out);
    let skipped = report["skipped"].to_string();
    for (file, why) in [
        ("broken.bvh", "expected"),
        ("torn.zip", "no archive"),
        ("lonely.amc", "ASF"),
        ("once more.bvh", "the same motion as"),
    ] {
        assert!(skipped.contains(file) && skipped.contains(why), "{skipped}");
    }
    assert!(told.contains("4 file(s) skipped"), "{told}");

    let seen = json(&["inspect", &root, "--json"], &["files", "performers", "repeated", "motion", "missing"]);
    let line = |name: &str| {
        let files = seen["files"].as_array().expect("a list");
        files
            .iter()
            .find(|f| f["file"].as_str().is_some_and(|f| f.ends_with(name)))
            .unwrap_or_else(|| panic!("{name}"))
            .clone()
    };
    assert_eq!(
        (line("take 1.BVH")["verdict"].as_str(), line("once more.bvh")["verdict"].as_str()),
        (Some("good"), Some("odd"))
    );
    assert_eq!(
        (line("broken.bvh")["verdict"].as_str(), line("torn.zip")["verdict"].as_str()),
        (Some("skipped"), Some("skipped"))
    );
    assert_eq!(seen["repeated"].as_array().map(Vec::len), Some(1));
    let printed = done(&["inspect", &root]);
    for part in ["performer   ", "turns       ", "30.0 Hz", "Y up", "skipped: ", "missing     no blows", "twice       "]
    {
        assert!(printed.contains(part), "no `{part}` in {printed}");
    }
}

#[test]
fn folders_without_motion_are_refused_with_the_way_out() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("empty")).expect("a folder");
    put(&folder, "texts/a.txt", "not motion");
    put(&folder, "bad/a.bvh", "not motion");
    let out = at(&folder, "a.throng");
    for (name, say) in [
        ("empty", "no motion file is there"),
        ("texts", ".bvh, .amc, .npz, .glb, .gltf or .fbx"),
        ("bad", "a.bvh"),
        ("absent", "absent"),
    ] {
        let path = at(&folder, name);
        let commands: [&[&str]; 3] =
            [&["build", &path, "--out", &out, "--no-cache"], &["run", &path, "--no-cache"], &["inspect", &path]];
        for args in commands.into_iter().filter(|a| !(name == "bad" && a[0] == "inspect")) {
            let e = failed(args);
            assert!(e.contains(name) && e.contains(say), "{args:?}: {e}");
        }
    }
    // The lines are printed, and programs are told that there is nothing to build.
    let bad = throng(&["inspect", &at(&folder, "bad")]);
    let [printed, told] = [bad.stdout, bad.stderr].map(|s| text(&s));
    assert!(!bad.status.success() && printed.contains("0 good, 0 odd, 1 skipped"), "{printed}");
    assert!(told.contains("none of 1 file(s) can be read"), "{told}");
    let (place, mixed) = (BundleFolder::shared(), at(&folder, "texts"));
    assert!(failed(&["build", &place.path("little.toml"), &mixed]).contains("one config alone"));
    assert!(failed(&["build", &mixed, "--input", &mixed]).contains("--input is for a config"));
    assert!(failed(&["run", &mixed, &place.bundle()]).contains("motion alone"));
}

/// A clip whose rows of numbers were edited.
fn edited(clip: &Path, edit: impl Fn(usize, Vec<&str>) -> String) -> String {
    let text = std::fs::read_to_string(clip).expect("a clip");
    let head = text.find("Frame Time").map(|i| i + text[i..].find('\n').expect("a line") + 1).expect("a rate");
    let rows = text[head..].lines().enumerate().map(|(f, l)| edit(f, l.split_whitespace().collect()) + "\n");
    text[..head].to_owned() + &rows.collect::<String>()
}

#[test]
fn folders_in_which_nobody_goes_anywhere_are_told_as_such() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let clip = &place.clips()[0];
    // Exported "in place".
    let on_the_spot = edited(clip, |_, mut row| {
        (row[0], row[2]) = ("0", "0");
        row.join(" ")
    });
    put(&folder, "treadmill/walk.bvh", &on_the_spot);
    // Stands still, and stands and sways.
    let first = std::fs::read_to_string(clip).expect("a clip");
    let first = first.lines().skip_while(|l| !l.starts_with("Frame Time")).nth(1).expect("a frame").to_owned();
    put(&folder, "statue/stand.bvh", &edited(clip, |_, _| first.clone()));
    let sway = |f: usize| {
        let value = |(c, v): (usize, &str)| {
            let by = if c < 6 { 0.0 } else { 4.0 * (0.15 * f as f64 + c as f64).sin() };
            (v.parse::<f64>().expect("a number") + by).to_string()
        };
        first.split_whitespace().enumerate().map(value).collect::<Vec<_>>().join(" ")
    };
    put(&folder, "idle/idle.bvh", &edited(clip, |f, _| sway(f)));

    let (out, treadmill) = (at(&folder, "a.throng"), at(&folder, "treadmill"));
    let printed = done(&["inspect", &treadmill]);
    assert!(
        printed.contains("walks on the spot") && printed.contains("It got root motion from its planted feet"),
        "{printed}"
    );
    assert!(!printed.contains("no walking"), "{printed}");
    put(&folder, "still.toml", "inputs = [\"treadmill\"]\n[import]\nroot_motion = false\n");
    let printed = done(&["inspect", &treadmill, "--config", &at(&folder, "still.toml")]);
    assert!(
        printed.contains("odd: walks on the spot") || printed.contains("Characters will stand and slide"),
        "{printed}"
    );
    assert!(printed.contains("no walking"), "{printed}");

    // Classes, and clips that are chosen by their names.
    let all = folder.path().display().to_string();
    let chosen = done(&["inspect", &all, "--leave", "stand"]);
    assert!(chosen.contains("1 left out by name") && chosen.contains("classes     "), "{chosen}");
    let one = done(&["inspect", &at(&folder, "treadmill/walk.bvh")]);
    assert!(one.contains("  class    0.0 to ") && one.contains(": walk, "), "{one}");
    let e = failed(&["inspect", &all, "--use", "jog*"]);
    assert!(e.contains("no clip is named `jog*`; there are "), "{e}");

    let (report, _) = build(&[&at(&folder, "idle")], &out);
    assert_eq!(report["policies"].as_array().map(Vec::len), Some(0), "{report}");
    assert!(report["verdict"].is_null(), "{report}");
    let not_made = report["not_made"].to_string();
    assert!(not_made.contains("policy approach") && not_made.contains("nobody walks in this motion"), "{not_made}");
    let e = failed(&["run", &out]);
    assert!(e.contains("nobody walks in") && e.contains(&format!("`throng view {out}` plays it")), "{e}");
    let built = done(&["build", &at(&folder, "idle"), "--out", &out]);
    assert!(built.contains(&format!("next: throng view {out}")), "{built}");
    let e = failed(&["build", &at(&folder, "statue"), "--out", &out, "--no-cache"]);
    for part in ["nothing can be made of this motion", "left out: still", "nobody walks in it: add walks"] {
        assert!(e.contains(part), "{e}");
    }
}

#[test]
fn scene_files_are_read_as_other_motion_is() {
    let folder = folder();
    let all = [
        ("gltf", seeds::gltf_motion()),
        #[cfg(feature = "fbx")]
        ("fbx", seeds::fbx()),
    ];
    for (format, files) in all {
        let path = at(&folder, &format!("walk.{format}"));
        std::fs::write(&path, files.last().expect("a text")).expect("a file");
        assert_eq!(json(&["inspect", &path, "--json"], &["format"])["format"], format);
        assert!(done(&["export", &path, "--format", "bvh"]).starts_with("HIERARCHY"));
    }
}

#[test]
#[ignore = "takes long; scripts/nightly.sh runs it"]
fn one_more_file_costs_one_file() {
    let (place, elsewhere) = (BundleFolder::shared(), folder());
    let folder = lying_around(&place);
    let (out, cache) = (at(&elsewhere, "a.throng"), at(&elsewhere, "cache"));
    let root = folder.path().to_str().expect("a name").to_owned();
    let args = ["build", &root, "--out", &out, "--cache", &cache, "--json"];
    assert_eq!(json(&args, &[])["files_kept"], 0);
    put(&folder, "new.bvh", &shortened(&place.clips()[0], 2));
    let more = json(&args, &["files_kept"]);
    assert_eq!(
        (more["files_kept"].as_u64(), &more["skipped"]),
        (Some(4), &serde_json::json!([])),
        "{}",
        more["skipped"]
    );
    let again = at(&elsewhere, "b.throng");
    build(&[&root], &again);
    assert!(
        std::fs::read(&out).expect("a bundle") == std::fs::read(&again).expect("a bundle"),
        "the cache changes nothing"
    );
}

#[test]
fn running_a_folder_builds_it_once() {
    let (place, elsewhere) = (BundleFolder::shared(), folder());
    let folder = lying_around(&place);
    let (root, cache) = (folder.path().to_str().expect("a name"), at(&elsewhere, "cache"));
    let args = ["run", root, "--characters", "5", "--seconds", "2", "--cache", &cache, "--json"];
    let told = |args: &[&str]| {
        let out = throng(args);
        assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
        let report: Value = serde_json::from_str(&text(&out.stdout)).expect("a report");
        has_keys(&report, &["reached_fraction", "reached_by_direction", "longest_wait_s", "verdict"]);
        text(&out.stderr)
    };
    assert!(told(&args).contains("building "));
    assert!(!told(&args).contains("building "), "it is there already");
    assert!(json(&["cache", "--cache", &cache, "--json"], &[])["stages"]["bundle"]["entries"] == 1);
    done(&["cache", "clear", "--cache", &cache]);
    assert!(told(&args).contains("building "));
    let printed = done(&["run", root, "--characters", "5", "--seconds", "2", "--no-cache"]);
    assert!(printed.contains("verdict  "), "{printed}");
}

#[test]
fn a_config_says_nothing_of_clips_that_were_replaced() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let config = at(&folder, "theirs.toml");
    let text = "name = \"theirs\"\ninputs = [\"theirs\"]\n[policy]\ncompare_samples = 100\n[clips.their_walk]\nexclude = [[0, 1]]\n\
        [blend.gaits]\naxes = [{ kind = \"speed\" }]\nexamples = [{ clip = \"their_*\" }]\n\
        [[behaviours]]\nname = \"box\"\nkind = \"throw_punches\"\n[[behaviours]]\nname = \"go\"\n\
        grid = { rings = 6, angles = 8, radius = 6.0, inner_spacing = 0.5 }\n";
    std::fs::write(&config, text).expect("a config");
    let (report, told) = build(&[&config, "--input", &place.path("clips")], &at(&folder, "a.throng"));
    assert_eq!(report["replaced"].as_array().map(Vec::len), Some(2), "{}", report["replaced"]);
    assert!(
        told.contains("config: what it says of 1 clip(s)") && told.contains("config: blend.gaits: steady"),
        "{told}"
    );
    assert_eq!(report["policies"].as_array().map(Vec::len), Some(1));
    assert_eq!(report["not_made"][0]["part"], "policy box");
    let e = failed(&["build", &config, "--input", &place.path("clips"), "--strict", "--no-cache"]);
    assert!(e.contains("theirs.toml") && e.contains("behaviours[0]"), "{e}");
}

#[cfg(unix)]
#[test]
fn who_interrupts_a_build_is_told_how_to_go_on() {
    use std::process::{Command, Stdio};
    let (place, elsewhere) = (BundleFolder::shared(), folder());
    let folder = lying_around(&place);
    let (out, cache) = (at(&elsewhere, "a.throng"), elsewhere.path().join("cache"));
    let args =
        ["build", folder.path().to_str().expect("a name"), "--out", &out, "--cache", cache.to_str().expect("a name")];
    let mut command = Command::new(env!("CARGO_BIN_EXE_throng"));
    let mut child = command.args(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    // The graph is kept, the policies are not yet.
    let is_kept = || {
        std::fs::read_dir(&cache)
            .is_ok_and(|all| all.flatten().any(|e| e.file_name().to_string_lossy().starts_with("graph-")))
    };
    while !is_kept() && child.try_wait().expect("a child").is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.is_ok_and(|s| s.success()), "the build ended before it could be interrupted");
    let ended = child.wait_with_output().expect("it ends");
    let told = text(&ended.stderr);
    assert_eq!(ended.status.code(), Some(130), "{told}");
    assert!(
        told.contains("interrupted in stage") && told.contains("graph") && told.contains("the same command goes on"),
        "{told}"
    );
    assert!(!Path::new(&out).exists());
    let report = json(&[&args[..], &["--json"]].concat(), &["cached"]);
    assert!(report["cached"].to_string().contains("\"graph\""), "{report}");
}
