//! `throng build`, its cache, and the demo.

use super::{BundleFolder, at, done, folder, has_keys, json, throng};

#[test]
fn build_reports_what_it_did() {
    let place = BundleFolder::shared();
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
    has_keys(&report["stage_s"], &["import", "retarget", "clips", "graph", "policy", "write"]);
    assert_eq!(report["name"], "little");
    assert_eq!(report["policies"][0]["cells"], 48);
    assert_eq!(report["bundle_bytes"].as_u64(), Some(std::fs::metadata(&out).expect("the bundle").len()));
    assert!(report["policies"][0]["residual"].as_f64() < Some(1e-4), "{report}");
    let same = std::fs::read(&out).expect("the bundle") == std::fs::read(place.bundle()).expect("the bundle");
    assert!(same, "a build with a cache differs from one without");
    let again = json(&args, &keys);
    assert_eq!(again["cached"], serde_json::json!(["motion", "graph", "make", "graph", "policy"]));
    let told = done(&args[..args.len() - 1]);
    assert!(told.contains("states") && told.contains("residual") && told.contains("a.throng"), "{told}");
}

#[test]
fn the_cache_is_used_listed_and_cleared() {
    let (place, folder) = (BundleFolder::shared(), folder());
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
