//! The subcommands print what their help says, and refuse what cannot be.

#[path = "../../tests/common/mod.rs"]
mod common;

use serde_json::Value;
use std::process::{Command, Output};

fn research(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_throng-research")).args(args).output().expect("the program starts")
}

fn json(args: &[&str]) -> Value {
    let out = research(args);
    assert!(out.status.success(), "{args:?}: {}", String::from_utf8_lossy(&out.stderr));
    serde_json::from_slice(&out.stdout).expect("one JSON object")
}

fn refused(args: &[&str]) -> String {
    let out = research(args);
    assert!(!out.status.success(), "{args:?}");
    String::from_utf8_lossy(&out.stderr).into_owned()
}

/// A bundle of a walk, in a folder of its own.
fn bundle() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("small.throng");
    std::fs::write(&file, common::bundle()).expect("a file");
    let file = file.to_string_lossy().into_owned();
    (folder, file)
}

#[test]
fn quality_sets_policies_against_search_and_matching() {
    let (_folder, bundle) = bundle();
    let report = json(&["quality", &bundle, "--pairs", "20", "--seconds", "0.001", "--json"]);
    let quality = &report["quality"][0];
    for key in ["ratio_mean", "ratio_p05", "near_best_fraction", "single_load_ratio_mean", "realised_ratio_mean"] {
        assert!(quality[key].as_f64().is_some_and(|v| v > 0.5 && v < 1.5), "{key}: {quality}");
    }
    assert_eq!((quality["asked"].as_u64(), quality["pairs"].as_u64()), (Some(20), Some(20)));
    assert!(
        quality["temperatures"][5]["temperature"].is_number() && quality["temperatures"][5]["ratio_mean"].is_number()
    );
    let matching = &report["matching"];
    for key in
        ["frames", "query_ns", "lookahead_ns", "single_load_ns", "query_over_lookahead", "query_over_single_load"]
    {
        assert!(matching[key].as_f64() > Some(0.0), "{key}: {matching}");
    }
    assert!(matching["policy_time_to_reach_s"].as_f64() > Some(0.5), "{matching}");
    assert!(matching["policy_hits_per_minute"].is_null(), "{matching}");
    assert!(refused(&["quality", &bundle, "--pairs", "0", "--seconds", "0.001"]).contains("--pairs"));
    assert!(refused(&["blend", &bundle]).contains("has no blend space"));
}

#[test]
fn crowds_run_on_every_engine_and_are_plotted() {
    let ask =
        |engine| json(&["crowd", "--scene", "lanes", "--agents", "40", "--engine", engine, "--seconds", "2", "--json"]);
    for engine in ["events", "occupancy", "fixed", "pairs"] {
        let report = ask(engine);
        assert_eq!((&report["agents"], &report["engine"]), (&40.into(), &engine.into()));
        assert!(report["progress_mps"].as_f64() > Some(0.5), "{report}");
        assert_eq!(report["state_hash"], ask(engine)["state_hash"], "it repeats");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let svg = folder.path().join("flock.svg");
    let svg = svg.to_string_lossy();
    let sizes = ["--agents", "20,40", "--engine", "events,fixed", "--seconds", "1", "--svg", &svg, "--json"];
    let report = json(&[&["crowd", "--scene", "flock"][..], &sizes].concat());
    assert_eq!(report["runs"].as_array().map(Vec::len), Some(4));
    let drawn = std::fs::read_to_string(&*svg).expect("a plot");
    assert_eq!(drawn.matches("<polyline").count(), 2, "a line for each engine");
    assert!(refused(&["crowd", "--engine", "magic"]).contains("fixed"));
}

#[test]
fn steering_changes_one_constant() {
    let few = ["steering", "--scene", "t", "--seconds", "2", "--json"];
    let (plain, changed) = (json(&few), json(&[&few[..], &["--set", "jam_share=0"]].concat()));
    assert_eq!((&plain["results"][0]["scene"], &changed["results"][0]["scene"]), (&"t".into(), &"t".into()));
    assert!(refused(&["steering", "--set", "magic=1"]).contains("jam_share"));
    assert!(refused(&["steering", "--scene", "moon"]).contains("held_out"));
}

/// Three boards and triangles stand around the arm.
#[test]
fn scenes_are_written_for_other_planners_and_reaches_are_measured() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("arm.json");
    let out = research(&["plan", "--scene", "arm-static", "--plain", &file.to_string_lossy()]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let plain: Value = serde_json::from_str(&std::fs::read_to_string(file).expect("a file")).expect("a scene");
    assert_eq!(plain["obstacles"][3]["mesh"]["triangles"].as_array().map(Vec::len), Some(26_244));
    let several = refused(&["plan", "--scene", "table,spheres", "--plain", "x.json"]);
    assert!(several.contains("expected one scene for --plain"), "{several}");
    let report = json(&["plan", "--scene", "table", "--seeds", "2", "--json"]);
    assert_eq!(report["results"][0]["success_rate"].as_f64(), Some(1.0));
    assert!(report["results"][0]["natural"]["reaches"].as_u64() > Some(0), "{report}");
}

#[test]
fn a_world_without_patches_is_refused() {
    let (folder, bundle) = bundle();
    let world = folder.path().join("square.toml");
    let bundle = bundle.replace('\\', "/");
    let text = format!("bundle = \"{bundle}\"\n[[place]]\nunit = \"ground\"\nat = [0.0, 0.0, 0.0]\n");
    std::fs::write(&world, text).expect("a file");
    let e = refused(&["world", &world.to_string_lossy()]);
    assert!(e.contains("no motion patches") && e.contains("data/playground.toml"), "{e}");
}
