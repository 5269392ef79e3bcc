//! Levels: made of plans and meshes, inspected, and named in scenes.

use super::{at, done, failed, folder, json};
use std::fs;

const PLAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/level.geojson");

#[test]
fn a_level_says_which_places_are_cut_off() {
    let folder = folder();
    let (level, png) = (at(&folder, "a.level"), at(&folder, "a.png"));
    let printed = done(&["level", PLAN, "--out", &level, "--png", &png]);
    assert!(printed.contains("\"exit\" reached from door") && printed.contains("CUT OFF"), "{printed}");
    assert!(fs::metadata(&png).is_ok_and(|m| m.len() > 1000));
    let report = json(&["inspect", &level, "--json"], &["polygons", "places", "path_us"]);
    let cut_off: Vec<&str> = report["places"]
        .as_array()
        .expect("places")
        .iter()
        .filter(|p| p["is_cut_off"] == true)
        .filter_map(|p| p["name"].as_str())
        .collect();
    assert_eq!(cut_off, ["island"]);
    let path = done(&["level", &level, "--path", "door", "exit"]);
    assert!(path.contains(" m from \"door\" to \"exit\""), "{path}");
    assert!(failed(&["level", &level, "--path", "door", "moon"]).contains("island"));
    assert!(failed(&["level", "absent.glb", "--out", &level]).contains("absent.glb"));
}

#[test]
fn people_walk_within_the_level_of_a_scene() {
    let folder = folder();
    let (level, scene) = (at(&folder, "a.level"), at(&folder, "a.toml"));
    done(&["level", PLAN, "--out", &level]);
    let text = |file: &str, goal: &str| {
        format!(
            "seconds = 60.0\nlevel = {{ file = \"{file}\" }}\n[[groups]]\nmotion = \"none\"\ncount = 8\n\
             place = {{ block = {{ from = [1.5, 1.5], to = [6.0, 4.0] }} }}\ngoal = {{ place = {{ name = \"{goal}\" }} }}\n\
             arrival_m = 2.0\n"
        )
    };
    fs::write(&scene, text("a.level", "exit")).expect("a scene");
    let report = json(&["run", &scene, "--json"], &[]).to_string();
    assert!(report.contains("\"stuck\":0"), "{report}");
    fs::write(&scene, text("a.level", "moon")).expect("a scene");
    assert!(failed(&["check", &scene]).contains("there is no place \"moon\""));
    fs::write(&scene, text("b.level", "exit")).expect("a scene");
    assert!(failed(&["check", &scene]).contains("throng level"));
}
