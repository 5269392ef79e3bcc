//! What is done with clips: inspect and export.

use super::{BundleFolder, at, done, failed, folder, has_keys, json};
use serde_json::Value;
use std::collections::BTreeMap;

#[test]
fn inspect_finds_out_about_a_clip() {
    let place = BundleFolder::shared();
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
fn settings_of_reading_hold_for_what_is_inspected_and_exported() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let (clip, config) = (place.first_clip(), at(&folder, "double.toml"));
    std::fs::write(&config, "inputs = [\"a\"]\n[import]\nmetres_per_unit = 0.015\n").expect("a config");
    let height = |args: &[&str]| {
        let report = json(&[&["inspect", &clip, "--json"], args].concat(), &["height_m"]);
        report["height_m"].as_f64().expect("a height")
    };
    assert!((height(&["--config", &config]) - 1.5 * height(&[])).abs() < 1e-3);
    let highest = |args: &[&str]| {
        let csv = done(&[&["export", &clip, "--format", "positions-csv"], args].concat());
        positions(&csv).values().map(|p| p[1]).fold(0.0, f64::max)
    };
    assert!((highest(&["--config", &config]) - 1.5 * highest(&[])).abs() < 1e-3);
    for command in [&["inspect", &clip][..], &["export", &clip, "--format", "bvh"], &["inspect", &place.path("clips")]]
    {
        let absent = at(&folder, "absent.toml");
        assert!(failed(&[command, &["--profile", &absent]].concat()).contains("absent.toml"));
        assert!(failed(&[command, &["--config", &absent]].concat()).contains("absent.toml"));
    }
    assert!(failed(&["inspect", &clip, "--profile", "nobody"]).contains("nobody"));
}

#[test]
fn a_config_names_the_class_of_a_clip() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let (clip, config) = (place.first_clip(), at(&folder, "shy.toml"));
    let name = std::path::Path::new(&clip).file_stem().and_then(|s| s.to_str()).expect("a name");
    let write = |class: &str| {
        let text = format!("inputs = [\"a\"]\n[clips.\"{name}\"]\nclass = {class}\n");
        std::fs::write(&config, text).expect("a config");
    };
    write("{ gait = \"jog\", manner = \"shy\" }");
    for files in [clip.clone(), place.path("clips")] {
        let report = json(&["inspect", &files, "--config", &config, "--json"], &["classes"]);
        let classes = report["classes"].as_array().expect("a list");
        assert!(classes.iter().any(|c| c["manner"] == "shy" && c["gait"] != "walk"), "{files}: {classes:?}");
    }
    write("{ gait = \"wlak\" }");
    let told = failed(&["inspect", &clip, "--config", &config]);
    assert!(told.contains("shy.toml:3:") && told.contains("expected one of `stand`, `walk`, `jog`"), "{told}");
}

#[test]
fn hits_are_reported_exported_and_drawn() {
    let (place, folder) = (BundleFolder::shared(), folder());
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
    let (place, folder) = (BundleFolder::shared(), folder());
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
    let place = BundleFolder::shared();
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
