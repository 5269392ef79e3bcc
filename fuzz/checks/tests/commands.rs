//! Promise: the program soaks scenes and writes the seeds of every fuzz target.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn throng_checks(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_throng-checks")).args(args).output().expect("the program starts")
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn a_soak_of_a_scene_prints_what_was_checked() {
    let (scene, cache) = (root().join("data/scenes/circle.toml"), tempfile::tempdir().expect("a folder"));
    let [scene, cache] = [&scene, cache.path()].map(|path| path.to_str().expect("a readable path"));
    let args = ["soak", scene, "--seconds", "0", "--run-seconds", "0.5", "--cache", cache];
    let out = throng_checks(&[&args[..], &["--json"]].concat());
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let report: serde_json::Value = serde_json::from_slice(&out.stdout).expect("one JSON object");
    assert!(report["runs"] == 1 && report["failed"] == 0 && report["checks"].as_u64() > Some(100), "{report}");
    let out = throng_checks(&args);
    let text = String::from_utf8_lossy(&out.stdout);
    assert!(text.contains("1 runs, ") && text.contains(", 0 failed"), "{text}");
    for wrong in [["--seconds", "-1"], ["--hours", "nan"], ["--run-seconds", "0"]] {
        assert_eq!(throng_checks(&[&["soak", scene], &wrong[..]].concat()).status.code(), Some(2), "{wrong:?}");
    }
}

#[test]
fn every_fuzz_target_gets_its_seeds() {
    let out = tempfile::tempdir().expect("a folder");
    let written = throng_checks(&["seeds", "--out", out.path().to_str().expect("a readable path")]);
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let manifest = std::fs::read_to_string(root().join("fuzz/Cargo.toml")).expect("the manifest of the fuzz targets");
    let manifest: toml::Table = manifest.parse().expect("a manifest");
    for target in manifest["bin"].as_array().expect("targets") {
        let name = target["name"].as_str().expect("a name");
        assert!(out.path().join(name).join("seed_0").is_file(), "{name} has no seeds");
    }
}
