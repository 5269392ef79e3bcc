//! Every command does what its help says: output, JSON keys, exit codes, and errors that show the way out.

mod crowd;
mod files;
mod keys;
mod numbers;
mod refusals;
mod scene;
mod view;

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Every subcommand.
const COMMANDS: [&str; 16] = [
    "demo",
    "synth",
    "build",
    "inspect",
    "verify",
    "query",
    "stitch",
    "run",
    "bench",
    "export",
    "view",
    "schema",
    "soak",
    "selftest",
    "cache",
    "completions",
];

/// What is refused is refused within this time, on a busy machine too.
const SOON: Duration = Duration::from_secs(60);

fn throng(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_throng")).args(args).output().expect("the command line starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("output is text")
}

/// As [`throng`], of a run that is to end soon; one that does not is ended, and fails.
fn throng_soon(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_throng"));
    command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the command line starts");
    let begin = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if begin.elapsed() > SOON {
            child.kill().expect("it can be ended");
            panic!("{args:?} still runs after {SOON:?}");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().expect("output")
}

/// Standard output of a run that succeeds.
fn done(args: &[&str]) -> String {
    let out = throng(args);
    assert_eq!(out.status.code(), Some(0), "{args:?}: {}", text(&out.stderr));
    text(&out.stdout)
}

/// The JSON object that is all of standard output, with these keys at least.
fn json(args: &[&str], keys: &[&str]) -> Value {
    let printed = done(args);
    let value: Value = serde_json::from_str(&printed).unwrap_or_else(|e| panic!("{args:?}: {e}: {printed}"));
    has_keys(&value, keys);
    value
}

fn has_keys(value: &Value, keys: &[&str]) {
    let object = value.as_object().unwrap_or_else(|| panic!("not an object: {value}"));
    for key in keys {
        assert!(object.contains_key(*key), "no key `{key}` in {value}");
    }
}

/// Standard error of a run that fails with exit code 1 and prints nothing else.
fn failed(args: &[&str]) -> String {
    let out = throng(args);
    let message = text(&out.stderr);
    assert_eq!(out.status.code(), Some(1), "{args:?}: {message}");
    assert!(out.stdout.is_empty(), "{args:?} printed {}", text(&out.stdout));
    assert!(message.contains("error: "), "{args:?}: {message}");
    message
}

/// Standard error of a run that is refused as wrong usage (exit code 2).
fn refused(args: &[&str]) -> String {
    let out = throng(args);
    assert_eq!(out.status.code(), Some(2), "{args:?}: {}", text(&out.stderr));
    text(&out.stderr)
}

/// A config whose target grid is small.
const CONFIG: &str = "name = \"little\"\ninputs = [\"clips\"]\n\n[policy]\ncompare_samples = 100\n\n[[behaviours]]\n\
    grid = { rings = 6, angles = 8, radius = 6.0, inner_spacing = 0.5 }\n";

/// A folder with clips, a config and a bundle, all made by the command line.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    /// The place of all tests, as long as one of them holds it.
    fn shared() -> Arc<Self> {
        static SHARED: Mutex<Weak<Place>> = Mutex::new(Weak::new());
        let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
        shared.upgrade().unwrap_or_else(|| {
            let place = Arc::new(Self::new());
            *shared = Arc::downgrade(&place);
            place
        })
    }

    fn new() -> Self {
        let place = Self { folder: folder() };
        let made = json(
            &["synth", "--out", &place.path("clips"), "--minutes", "1", "--seed", "1", "--json"],
            &["set", "clips", "frames", "seconds", "out"],
        );
        assert!(made["frames"].as_u64() >= Some(1800), "{made}");
        std::fs::write(place.path("little.toml"), CONFIG).expect("a config");
        done(&["build", &place.path("little.toml"), "--out", &place.bundle(), "--no-cache"]);
        place
    }

    fn path(&self, name: &str) -> String {
        at(&self.folder, name)
    }

    fn bundle(&self) -> String {
        self.path("little.throng")
    }

    fn clips(&self) -> Vec<PathBuf> {
        let clips = std::fs::read_dir(self.path("clips")).expect("clips");
        let mut all: Vec<PathBuf> = clips.map(|e| e.expect("a clip").path()).collect();
        all.sort();
        all
    }

    fn first_clip(&self) -> String {
        self.clips()[0].to_str().expect("a readable name").to_owned()
    }
}

/// A folder for one test.
fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn at(folder: &tempfile::TempDir, name: &str) -> String {
    folder.path().join(name).to_str().expect("temporary folders have readable names").to_owned()
}

#[test]
fn every_command_helps() {
    let all = done(&["--help"]);
    assert!(all.contains("Exit codes"), "{all}");
    for command in COMMANDS {
        let line = |l: &str| l.trim_start().starts_with(&format!("{command} "));
        assert!(all.lines().any(line), "{command} is not in {all}");
        let help = done(&[command, "--help"]);
        assert!(help.contains("Usage: throng") && help.contains(command), "{help}");
        if help.contains("--json") {
            assert!(help.contains("JSON keys"), "{command} does not document its keys: {help}");
        }
    }
    assert!(done(&["--version"]).starts_with("throng "));
    let listed = all.lines().filter(|l| l.starts_with("  ") && l.len() > 2 && !l[2..].starts_with([' ', '-'])).count();
    assert_eq!(listed, COMMANDS.len() + 1, "commands this test does not know (`help` is one more): {all}");
}

#[test]
fn wrong_usage_ends_with_2() {
    let cases: [&[&str]; 9] = [
        &[],
        &["fly"],
        &["verify"],
        &["build"],
        &["query", "action", "a.throng", "--state", "0", "--target", "3"],
        &["query", "action", "a.throng", "--state", "0", "--target", "nan,1"],
        &["query", "action", "a.throng", "--state", "-1", "--target", "1,1"],
        &["export", "a.bvh", "--format", "fbx"],
        &["verify", "a.throng", "--fast"],
    ];
    for args in cases {
        let out = throng(args);
        assert_eq!(out.status.code(), Some(2), "{args:?}");
        assert!(out.stdout.is_empty() && !out.stderr.is_empty(), "{args:?}");
    }
}

#[test]
fn build_reports_what_it_did() {
    let place = Place::shared();
    let folder = folder();
    let (out, cache) = (at(&folder, "a.throng"), at(&folder, "cache"));
    let args = ["build", &place.path("little.toml"), "--out", &out, "--cache", &cache, "--json"];
    let keys = [
        "clips",
        "frames_in",
        "frames_kept",
        "states",
        "actions",
        "seconds_total",
        "stage_s",
        "policies",
        "bundle_bytes",
    ];
    let report = json(&args, &keys);
    has_keys(&report["policies"][0], &["name", "cells", "sweeps", "residual", "bytes", "seconds"]);
    has_keys(
        &report["stage_s"],
        &["import", "retarget", "resample", "annotate", "features", "graph", "policy", "write"],
    );
    assert_eq!(report["name"], "little");
    assert_eq!(report["policies"][0]["cells"], 48);
    assert_eq!(report["bundle_bytes"].as_u64(), Some(std::fs::metadata(&out).expect("the bundle").len()));
    assert!(report["policies"][0]["residual"].as_f64() < Some(1e-4), "{report}");
    let same = std::fs::read(&out).expect("the bundle") == std::fs::read(place.bundle()).expect("the bundle");
    assert!(same, "a build with a cache differs from one without");
    let again = json(&args, &keys);
    assert_eq!(again["cached"], serde_json::json!(["motion", "examples", "graph", "policy"]));
    let told = done(&args[..args.len() - 1]);
    assert!(told.contains("states") && told.contains("residual") && told.contains("a.throng"), "{told}");
}

#[test]
fn the_cache_is_used_listed_and_cleared() {
    let (place, folder) = (Place::shared(), folder());
    let (cache, out) = (at(&folder, "cache"), at(&folder, "a.throng"));
    let (none, keys) = (json(&["cache", "--cache", &cache, "--json"], &[]), ["folder", "entries", "bytes", "stages"]);
    assert_eq!((&none["entries"], &none["bytes"]), (&0.into(), &0.into()), "a cache that is not there is empty");
    let build = ["build", &place.path("little.toml"), "--out", &out, "--cache", &cache, "--json"];
    assert!(json(&build, &["cached"])["cached"].as_array().expect("a list").is_empty());
    let kept = json(&["cache", "--cache", &cache, "--json"], &keys);
    assert!(kept["entries"].as_u64() > Some(2) && kept["stages"]["motion"]["bytes"].as_u64() > Some(1000), "{kept}");
    assert!(!json(&build, &["cached"])["cached"].as_array().expect("a list").is_empty());
    let printed = done(&["cache", "--cache", &cache]);
    assert!(printed.contains("1 motion") && printed.contains("s ago"), "{printed}");
    let gone = json(&["cache", "clear", "--cache", &cache, "--json"], &keys);
    assert_eq!((&gone["entries"], &gone["bytes"], &gone["cleared"]), (&kept["entries"], &kept["bytes"], &true.into()));
    assert!(done(&["cache", "--cache", &cache]).contains("0 entries, 0 bytes"));
    let little = [&build[..], &["--cache-limit", "0.00000001"]].concat();
    json(&little, &[]);
    assert!(done(&["cache", "--cache", &cache]).contains("0 entries, 0 bytes"), "none fits");
    assert!(done(&["build", "--help"]).contains("[default: 5]"));
    for bad in ["-1", "nan", "much"] {
        assert_eq!(throng(&["build", "a.toml", "--cache-limit", bad]).status.code(), Some(2), "{bad}");
    }
}

#[test]
fn verify_says_what_a_bundle_holds() {
    let place = Place::shared();
    let bundle = place.bundle();
    let keys =
        ["file", "name", "version", "bundle_bytes", "frames", "clips", "states", "actions", "policies", "sections"];
    let report = json(&["verify", &bundle, "--json"], &keys);
    assert_eq!((&report["name"], &report["version"]), (&Value::from("little"), &Value::from(4)));
    assert_eq!(report["policies"], serde_json::json!(["approach"]));
    assert_eq!(report["sections"]["FRAM"].as_u64(), report["frames"].as_u64().map(|n| 192 * n));
    assert!(done(&["verify", &bundle]).contains("is whole"));
}

#[test]
fn query_answers_with_an_action_and_a_value() {
    let place = Place::shared();
    let bundle = place.bundle();
    let ask = |target: &str| {
        let args =
            ["query", "action", &bundle, "--behaviour", "approach", "--state", "0", "--target", target, "--json"];
        json(&args, &["behaviour", "state", "target_m", "action", "value", "score", "single_load_action", "best"])
    };
    let (near, far) = (ask("0.1,0.2"), ask("-1.5,5"));
    assert!(near["value"].as_f64() > far["value"].as_f64(), "near {near}, far {far}");
    assert_eq!(far["action"], far["best"][0]["action"]);
    let negative =
        json(&["query", "action", &bundle, "--state", "1", "--target=-3,-2", "--json"], &["action", "value"]);
    assert_eq!(negative["target_m"], serde_json::json!([-3.0, -2.0]));
    assert!(done(&["query", "action", &bundle, "--state", "0", "--target", "1,1"]).contains("action"));

    let e =
        failed(&["query", "action", &bundle, "--behaviour", "aproach", "--state", "0", "--target", "1,1", "--json"]);
    assert!(e.contains("\"aproach\"") && e.contains("there is approach") && e.contains("little.throng"), "{e}");
    let e = failed(&["query", "action", &bundle, "--state", "999999", "--target", "1,1"]);
    assert!(e.contains("little.throng: no state 999999") && e.contains("count from 0 to"), "{e}");
}

#[test]
fn run_measures_a_crowd_and_draws_it() {
    let (place, folder) = (Place::shared(), folder());
    let bundle = place.bundle();
    let png = at(&folder, "crowd.png");
    let keys = ["characters", "reached_fraction", "foot_slip_p95_mps", "steps_per_second", "simulated_s"];
    let report = json(&["run", &bundle, "--characters", "10", "--seconds", "3", "--single-load", "--json"], &keys);
    assert_eq!(report["characters"], 10);
    assert!((0.0..=1.0).contains(&report["reached_fraction"].as_f64().expect("a share")));
    let args = ["run", &bundle, "--characters", "6", "--seconds", "2", "--temperature", "0.1", "--png", &png];
    assert!(done(&args).contains("reached"));
    assert_eq!(std::fs::read(&png).expect("a picture")[..8], *b"\x89PNG\r\n\x1a\n");
    assert!(failed(&["run", &bundle, "--characters", "3", "--follow", "3"]).contains("to follow"));
    assert!(refused(&["bench", "bundle", &bundle, "--seconds", "nan"]).contains("--seconds"));
    let absent = at(&folder, "absent/a.throng");
    let e = failed(&["build", &place.path("little.toml"), "--out", &absent, "--no-cache"]);
    assert!(e.contains("there is no folder"), "{e}");
}

#[test]
fn the_demo_goes_the_whole_way() {
    let folder = folder();
    let (png, bundle) = (at(&folder, "demo.png"), at(&folder, "demo.throng"));
    let args = ["demo", "--characters", "12", "--seconds", "2", "--out", &png, "--bundle", &bundle, "--json"];
    let report = json(&args, &["characters", "reached_fraction", "foot_slip_p95_mps", "steps_per_second", "build"]);
    assert_eq!(report["characters"], 12);
    has_keys(&report["build"], &["states", "actions", "policies", "bundle_bytes"]);
    assert_eq!(std::fs::read(&png).expect("a picture")[..8], *b"\x89PNG\r\n\x1a\n");
    done(&["verify", &bundle]);
}

#[test]
fn bench_reports_every_figure() {
    let place = Place::shared();
    let args =
        ["bench", "bundle", &place.bundle(), "--characters", "8", "--threads", "1", "--seconds", "0.01", "--json"];
    let report = json(&args, &["results", "value_iteration"]);
    let keys = [
        "characters",
        "threads",
        "control_ns_per_query",
        "lookahead_ns_per_query",
        "sample_ns_per_joint",
        "step_ns_per_character",
        "memcpy_ns_per_character",
    ];
    has_keys(&report["results"][0], &keys);
    assert_eq!(report["results"].as_array().map(Vec::len), Some(1));
    for key in &keys[2..] {
        assert!(report["results"][0][key].as_f64() > Some(0.0), "{key}: {report}");
    }
    has_keys(&report["value_iteration"], &["pairs", "sweeps", "seconds", "residual", "bytes_per_sweep"]);
    assert!(report["value_iteration"]["residual"].as_f64() < Some(1e-4), "{report}");
}

#[test]
fn bench_sets_policies_against_search_and_matching() {
    let place = Place::shared();
    let sizes = ["--characters", "8", "--threads", "1", "--seconds", "0.001"];
    let bundle = place.bundle();
    let args = [&["bench", "bundle", &bundle, "--quality", "--pairs", "20", "--json"], &sizes[..]].concat();
    let report = json(&args, &["quality", "matching"]);
    let quality = &report["quality"][0];
    for key in ["ratio_mean", "ratio_p05", "near_best_fraction", "single_load_ratio_mean", "realised_ratio_mean"] {
        assert!(quality[key].as_f64().is_some_and(|v| v > 0.5 && v < 1.5), "{key}: {quality}");
    }
    assert_eq!((quality["asked"].as_u64(), quality["pairs"].as_u64()), (Some(20), Some(20)));
    has_keys(&quality["temperatures"][5], &["temperature", "ratio_mean"]);
    let matching = &report["matching"];
    for key in
        ["frames", "query_ns", "lookahead_ns", "single_load_ns", "query_over_lookahead", "query_over_single_load"]
    {
        assert!(matching[key].as_f64() > Some(0.0), "{key}: {matching}");
    }
    assert!(matching["policy_time_to_reach_s"].as_f64() > Some(0.5), "{matching}");
    assert!(matching["policy_hits_per_minute"].is_null(), "{matching}");
    assert!(
        refused(&["bench", "bundle", &bundle, "--quality", "--pairs", "0", "--seconds", "0.001"]).contains("--pairs")
    );
}

#[test]
fn inspect_finds_out_about_a_clip() {
    let place = Place::shared();
    let clip = place.first_clip();
    let keys = ["format", "joints", "frames", "rate_hz", "metres_per_unit", "up", "height_m", "roles", "warnings"];
    let report = json(&["inspect", &clip, "--json"], &keys);
    assert_eq!((&report["format"], &report["up"]), (&Value::from("bvh"), &Value::from("Y")));
    assert_eq!(report["metres_per_unit"], 0.01);
    assert!((1.5..2.0).contains(&report["height_m"].as_f64().expect("a height")), "{report}");
    assert_eq!(report["roles"].as_object().map(serde_json::Map::len), Some(22));
    assert!(done(&["inspect", &clip]).contains("bvh"));
    assert_eq!(report["hits"]["count"], 0);
}

#[test]
fn hits_are_reported_exported_and_drawn() {
    let (place, folder) = (Place::shared(), folder());
    // A walker's fist, marked by hand: the only hit, and its mirror image.
    let clip = at(&folder, "walker.bvh");
    std::fs::copy(place.first_clip(), &clip).expect("a copy");
    let sidecar = "[[hits]]\nname = \"tap\"\njoint = \"left_hand\"\nstart = 2\nend = 6\n";
    std::fs::write(at(&folder, "walker.toml"), sidecar).expect("a sidecar");
    let (bundle, png) = (at(&folder, "a.throng"), at(&folder, "hits.png"));
    let args = ["build", &place.path("little.toml"), "--input", &clip, "--out", &bundle, "--no-cache", "--json"];
    let hits = json(&args, &["hits"])["hits"].clone();
    has_keys(&hits, &["count", "angle_rad", "distance_m", "height_m", "kinds"]);
    assert_eq!((hits["count"].as_u64(), hits["kinds"]["tap"].as_u64()), (Some(2), Some(2)));
    let range = |key: &str| [0, 1].map(|i| hits[key][i].as_f64().expect("a number"));
    let [right, left] = range("angle_rad");
    assert!((right + left).abs() < 1e-3 && left >= 0.0, "a mirrored copy hits to the other side: {hits}");
    assert!(range("height_m").iter().all(|h| (0.5..1.5).contains(h)), "{hits}");

    let keys = ["file", "name", "clips", "frames", "rate_hz", "states", "actions", "behaviours", "hits", "clip_hits"];
    let report = json(&["inspect", &bundle, "--hits-png", &png, "--json"], &keys);
    assert_eq!(report["hits"], hits);
    assert_eq!(report["clip_hits"]["walker~mirror"]["tap"], 1);
    assert!(std::fs::read(&png).expect("a picture").starts_with(b"\x89PNG"));
    let printed = done(&["inspect", &bundle]);
    assert!(printed.contains("2 effective hitting points (tap 2)") && printed.contains("walker~mirror"), "{printed}");
    let csv = done(&["export", &bundle, "--format", "hits-csv"]);
    assert!(csv.starts_with("clip,frame,time_s,kind,joint,x_m,y_m,z_m,") && csv.lines().count() == 3, "{csv}");
    assert!(csv.contains(",tap,left_hand,") && csv.contains(",tap,right_hand,"), "{csv}");

    let none = json(&["inspect", &place.bundle(), "--json"], &["hits"])["hits"].clone();
    assert_eq!((none["count"].as_u64(), &none["angle_rad"]), (Some(0), &Value::Null));
    let csv = done(&["export", &place.first_clip(), "--format", "hits-csv"]);
    assert_eq!(csv.lines().count(), 1, "a walk strikes nothing");
}

#[test]
fn export_writes_positions_and_bvh() {
    let (place, folder) = (Place::shared(), folder());
    let clip = place.first_clip();
    let frames = json(&["inspect", &clip, "--json"], &["frames"])["frames"].as_u64().expect("a count") as usize;
    for retargeted in [false, true] {
        let extra: &[&str] = if retargeted { &["--retargeted"] } else { &[] };
        let csv = done(&[&["export", &clip, "--format", "positions-csv"], extra].concat());
        assert_eq!(csv.lines().next(), Some("frame,joint,x,y,z"));
        let rows = positions(&csv);
        assert_eq!(rows.len(), csv.lines().count() - 1, "a joint stands there twice");
        let heads: Vec<_> = rows.iter().filter(|(key, _)| key.1.eq_ignore_ascii_case("head")).collect();
        assert_eq!((heads.len(), heads[frames - 1].0.0), (frames, frames - 1));
        assert!(heads.iter().all(|(_, at)| (1.2..1.9).contains(&at[1])), "heads of a walker in metres, Y up");

        let bvh = at(&folder, "copy.bvh");
        done(&[&["export", &clip, "--format", "bvh", "--out", &bvh], extra].concat());
        let report = json(&["inspect", &bvh, "--json"], &["frames", "rate_hz"]);
        assert_eq!(report["frames"].as_u64(), Some(frames as u64));
        assert!((report["rate_hz"].as_f64().expect("a rate") - 30.0).abs() < 0.01);
        let copied = done(&["export", &bvh, "--format", "positions-csv"]);
        // BVH ends every chain, so the copy may have more joints.
        let copied = positions(&copied);
        for (key, at) in positions(&csv) {
            let other = copied.get(&key).unwrap_or_else(|| panic!("{key:?} is lost"));
            let apart = at.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-3, "{key:?}: {at:?} became {other:?}");
        }
    }
}

/// Rows of exported positions by frame and joint.
fn positions(csv: &str) -> BTreeMap<(usize, &str), [f64; 3]> {
    let row = |line| {
        let fields: Vec<&str> = str::split(line, ',').collect();
        let [frame, joint, x, y, z] = fields[..] else { panic!("not five fields: {line}") };
        let number = |v: &str| v.parse::<f64>().unwrap_or_else(|e| panic!("{line}: {e}"));
        ((frame.parse().unwrap_or_else(|e| panic!("{line}: {e}")), joint), [x, y, z].map(number))
    };
    csv.lines().skip(1).map(row).collect()
}

#[test]
fn export_writes_graphs_and_policies() {
    let place = Place::shared();
    let bundle = place.bundle();
    let counts = json(&["verify", &bundle, "--json"], &["states", "actions"]);
    let graph = json(&["export", &bundle, "--format", "graph-json"], &["states", "actions"]);
    let (states, actions) =
        (graph["states"].as_array().expect("states"), graph["actions"].as_array().expect("actions"));
    assert_eq!(
        (Some(states.len() as u64), Some(actions.len() as u64)),
        (counts["states"].as_u64(), counts["actions"].as_u64())
    );
    for action in actions {
        has_keys(action, &["from", "to", "frames"]);
        for end in ["from", "to"] {
            assert!(action[end].as_u64() < counts["states"].as_u64(), "{action}");
        }
    }
    let csv = done(&["export", &bundle, "--format", "policy-csv", "--behaviour", "approach"]);
    assert_eq!(csv.lines().count(), 1 + states.len() * 48, "{:?}", csv.lines().next());
    let e = failed(&["export", &bundle, "--format", "policy-csv", "--behaviour", "flee"]);
    assert!(e.contains("approach"), "{e}");
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_is_no_failure() {
    use std::process::Stdio;
    let place = Place::shared();
    for args in [["inspect", &place.first_clip()], ["verify", &place.bundle()], ["inspect", &place.bundle()]] {
        let mut throng = Command::new(env!("CARGO_BIN_EXE_throng"));
        let mut child = throng.args(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        drop(child.stdout.take());
        let out = child.wait_with_output().expect("it ends");
        assert_eq!((out.status.code(), text(&out.stderr).as_str()), (Some(0), ""), "{args:?}");
    }
}

#[test]
fn completions_and_schema_are_printed() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = done(&["completions", shell]);
        assert!(script.contains("throng") && script.contains("inspect"), "{shell}");
    }
    let printed = done(&["schema"]);
    let schema: Value = serde_json::from_str(&printed).expect("a JSON object");
    has_keys(&schema["properties"], &["inputs", "graph", "behaviours", "clips"]);
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/throng-config.schema.json");
    let kept = std::fs::read_to_string(&kept).expect("the published schema");
    // A checkout may have changed the ends of lines.
    assert!(
        kept.replace("\r\n", "\n") == printed,
        "write it anew with `cargo run -- schema > data/throng-config.schema.json`"
    );
}
