//! What is done with bundles: verify, query, run, bench.

use super::{BundleFolder, at, done, failed, folder, has_keys, json, refused};
use serde_json::Value;

#[test]
fn verify_says_what_a_bundle_holds() {
    let place = BundleFolder::shared();
    let bundle = place.bundle();
    let keys =
        ["file", "name", "version", "bundle_bytes", "frames", "clips", "states", "actions", "policies", "sections"];
    let report = json(&["verify", &bundle, "--json"], &keys);
    assert_eq!((&report["name"], &report["version"]), (&Value::from("little"), &Value::from(8)));
    assert_eq!(report["policies"], serde_json::json!(["approach"]));
    assert_eq!(report["sections"]["FRAM"].as_u64(), report["frames"].as_u64().map(|n| 96 * n));
    assert!(done(&["verify", &bundle]).contains("is whole"));
}

#[test]
fn query_answers_with_an_action_and_a_value() {
    let place = BundleFolder::shared();
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
    let (place, folder) = (BundleFolder::shared(), folder());
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
fn bench_reports_every_figure() {
    let place = BundleFolder::shared();
    let args =
        ["bench", "bundle", &place.bundle(), "--characters", "8", "--threads", "1", "--seconds", "0.01", "--json"];
    let report = json(&args, &["results"]);
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
}
