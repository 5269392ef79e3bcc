//! `throng plan`, `throng inspect --scene`, `throng bench plan` and the schema of tasks.

use super::{at, done, folder, json, text, throng};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn tasks() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tasks");
    let files = std::fs::read_dir(folder).expect("tasks").map(|e| e.expect("an entry").path());
    let mut all: Vec<PathBuf> = files.filter(|p| p.extension().is_some_and(|e| e == "toml")).collect();
    all.sort();
    all
}

/// Plans a task file of the project.
fn planned(task: &Path, out: &str) -> Value {
    let keys = ["solved", "tasks", "first_solution_s", "recheck_violations", "files", "clearance_min_m"];
    json(&["plan", &task.to_string_lossy(), "--out", out, "--json"], &keys)
}

#[test]
#[ignore = "takes long; scripts/nightly.sh runs it"]
fn every_task_of_the_project_is_done_and_checked() {
    let folder = folder();
    let all = tasks();
    assert!(all.len() > 9, "{all:?}");
    std::thread::scope(|scope| {
        for part in all.chunks(all.len().div_ceil(2)) {
            let folder = &folder;
            scope.spawn(move || {
                for task in part {
                    let stem = task.file_stem().expect("a name").to_string_lossy();
                    let report = planned(task, &at(folder, &format!("{stem}.bvh")));
                    assert_eq!(report["solved"], true, "{stem}: {report}");
                    assert_eq!(report["recheck_violations"], 0, "{stem}: {report}");
                    assert!(report["penetration_max_m"].as_f64() < Some(1e-3), "{stem}: {report}");
                    for file in report["files"].as_array().expect("a list") {
                        assert!(Path::new(file.as_str().expect("a name")).exists(), "{stem}: {file}");
                    }
                }
            });
        }
    });
}

/// A walk, a post beside it, and what the left arm does about it.
fn walk_past(folder: &tempfile::TempDir, post: &str) -> String {
    let clip = at(folder, "walk.bvh");
    if !Path::new(&clip).exists() {
        done(&["synth", "--set", "locomotion", "--out", &at(folder, "set"), "--minutes", "0.1"]);
        let first = std::fs::read_dir(at(folder, "set")).expect("clips").map(|e| e.expect("an entry").path());
        let walk = first.filter(|p| p.extension().is_some_and(|e| e == "bvh")).min().expect("a clip");
        std::fs::copy(walk, &clip).expect("a copy");
    }
    let task = at(folder, "task.toml");
    let text = format!(
        "clip = \"walk.bvh\"\n[[scene.obstacles]]\nname = \"post\"\nshape = {{ capsule = {{ from = [0.0, 0.0, 0.0], \
         to = [0.0, 1.05, 0.0], radius = 0.03 }} }}\n{post}\n[[tasks]]\nlimb = \"left_arm\"\ndo = \"correct\"\n"
    );
    std::fs::write(&task, text).expect("a task");
    task
}

/// Where the left hand is at a time, as an application reads the clip (m).
fn hand(folder: &tempfile::TempDir, frame: usize) -> [f64; 3] {
    let csv = done(&["export", &at(folder, "walk.bvh"), "--format", "positions-csv", "--retargeted"]);
    let wanted = format!("{frame},left_hand,");
    let line = csv.lines().find_map(|l| l.strip_prefix(&wanted)).expect("a hand");
    let numbers: Vec<f64> = line.split(',').map(|n| n.parse().expect("a number")).collect();
    [numbers[0], numbers[1], numbers[2]]
}

#[test]
fn outside_of_the_plan_the_clip_is_the_same_line_by_line() {
    let folder = folder();
    walk_past(&folder, "");
    let [x, _, z] = hand(&folder, 60);
    let task = walk_past(&folder, &format!("at = [{:.3}, 0.0, {z:.3}]", x + 0.05));
    let (clip, out) = (at(&folder, "walk.bvh"), at(&folder, "out.bvh"));
    let found = json(&["inspect", &clip, "--scene", &task, "--json"], &["collisions"]);
    let first = &found["collisions"][0];
    assert_eq!((&first["limb"], &first["obstacle"]), (&"left_arm".into(), &"post".into()), "{found}");
    let [from, to] = ["from_s", "to_s"].map(|k| first[k].as_f64().expect("a time"));
    assert!(from < 2.1 && to > 1.9 && first["depth_m"].as_f64() > Some(0.005), "{found}");
    assert_eq!(planned(Path::new(&task), &out)["solved"], true);
    let before = done(&["export", &clip, "--format", "bvh", "--retargeted"]);
    let after = std::fs::read_to_string(&out).expect("a clip");
    let pairs: Vec<(&str, &str)> = before.lines().zip(after.lines()).collect();
    assert_eq!(before.lines().count(), after.lines().count());
    let header = before.lines().position(|l| l.starts_with("Frame Time")).expect("motion") + 1;
    let changed: Vec<usize> = (0..pairs.len()).filter(|i| pairs[*i].0 != pairs[*i].1).collect();
    let window = changed.first().copied().zip(changed.last().copied()).expect("something changed");
    assert!(window.0 > header + 20 && window.1 < pairs.len() - 10 && window.1 - window.0 < 60, "{window:?}");
    let clear = json(&["inspect", &out, "--scene", &task, "--json"], &["collisions"]);
    assert_eq!(clear["collisions"], serde_json::json!([]), "{clear}");
}

#[test]
fn what_is_not_done_is_told_and_nothing_is_written() {
    let folder = folder();
    let task = walk_past(&folder, "");
    let text_of = std::fs::read_to_string(&task).expect("a task");
    let far = "[[scene.objects]]\nname = \"cup\"\nshape = { ball = { radius = 0.03 } }\nat = [9.0, 1.0, 0.0]\n[[tasks]]\nlimb = \
               \"left_arm\"\ndo = \"grab\"\nobject = \"cup\"\nat_s = 2.0\nwindow_s = [1.0, 3.0]\ngrips = [{}]\n";
    std::fs::write(&task, format!("{text_of}{far}")).expect("a task");
    let (out, png) = (at(&folder, "out.bvh"), at(&folder, "out.png"));
    let run = throng(&["plan", &task, "--out", &out, "--png", &png, "--json"]);
    let (report, message) = (text(&run.stdout), text(&run.stderr));
    assert_eq!(run.status.code(), Some(1), "{message}");
    assert!(message.contains("out of reach by 8.") && message.contains("nothing was written"), "{message}");
    let report: Value = serde_json::from_str(&report).expect("a report");
    assert_eq!((&report["solved"], &report["tasks"][0]["solved"]), (&false.into(), &true.into()), "{report}");
    assert!(report["tasks"][1]["nearest_m"].as_f64() > Some(7.0), "{report}");
    assert!(Path::new(&png).exists() && !Path::new(&out).exists());
    for (change, why) in [
        ("walk.bvh", "none.bvh"),
        ("clip = \"walk.bvh\"", "clip = { synth = \"dance\" }"),
        ("clip = \"walk.bvh\"", "clip = { synth = \"people\", clip = \"people_queue\" }"),
        ("clip = \"walk.bvh\"", "clip = { file = \"walk.bvh\", to_s = 99.0 }"),
        ("radius = 0.03", "radius = -1.0"),
    ] {
        std::fs::write(&task, text_of.replacen(change, why, 1)).expect("a task");
        let run = throng(&["plan", &task, "--out", &out]);
        let message = text(&run.stderr);
        assert_eq!(run.status.code(), Some(1), "{why}: {message}");
        assert!(run.stdout.is_empty() && !Path::new(&out).exists() && message.contains("error: "), "{why}: {message}");
    }
    let wrong = text(&throng(&["plan", &task, "--out", "a.glb"]).stderr);
    assert!(wrong.contains("ends with .bvh"), "{wrong}");
}

#[test]
fn what_can_be_mended_is_and_what_cannot_is_told() {
    let folder = folder();
    walk_past(&folder, "");
    let [x, _, z] = hand(&folder, 60);
    let task = walk_past(&folder, &format!("at = [{:.3}, 0.0, {z:.3}]", x - 0.1));
    // Thick enough for hand and hips.
    let text_of = std::fs::read_to_string(&task).expect("a task").replace("radius = 0.03", "radius = 0.15");
    std::fs::write(&task, &text_of).expect("a task");
    let out = at(&folder, "out.bvh");
    let plain = throng(&["plan", &task, "--out", &out]);
    assert!(plain.status.code() == Some(1) && !Path::new(&out).exists());
    let run = throng(&["plan", &task, "--out", &out, "--partial", "--json"]);
    let report: Value = serde_json::from_str(&text(&run.stdout)).expect("a report");
    assert_eq!((run.status.code(), &report["solved"]), (Some(1), &false.into()), "{report}");
    assert_eq!(report["recheck_violations"], 0, "{report}");
    let collisions = report["tasks"][0]["collisions"].as_array().expect("a list");
    let why = |c: &Value| c["why"].as_str().map(str::to_owned);
    assert!(collisions.iter().any(|c| why(c).is_some()), "{report}");
    assert!(Path::new(&out).exists() && text(&run.stderr).contains("the rest was written"));
}

#[test]
fn a_task_is_checked_before_any_search() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let good = root.join("data/tasks/errands.toml");
    let report = json(&["check", &good.to_string_lossy(), "--json"], &["tasks", "meshes", "faults"]);
    assert_eq!(report["faults"], 0, "{report}");
    assert_eq!((&report["meshes"][0]["triangles"], &report["meshes"][0]["open_edges"]), (&2552.into(), &0.into()));
    assert!(report["tasks"][0]["least_s"][0].as_f64() < report["tasks"][0]["given_s"][0].as_f64(), "{report}");
    let folder = folder();
    let task = walk_past(&folder, "");
    let far = "[[scene.objects]]\nname = \"cup\"\nshape = { ball = { radius = 0.03 } }\nat = [9.0, 1.0, 0.0]\n[[tasks]]\nlimb = \
               \"left_arm\"\ndo = \"grab\"\nobject = \"cup\"\nat_s = 2.0\nwindow_s = [1.0, 3.0]\ngrips = [{}]\n";
    let whole = std::fs::read_to_string(&task).expect("a task") + far;
    std::fs::write(&task, whole).expect("a task");
    let run = throng(&["check", &task]);
    assert!(run.status.code() == Some(1) && text(&run.stderr).contains("out of reach by 8."), "{}", text(&run.stderr));
    assert!(text(&run.stdout).contains("0 of 70 hands reach"), "{}", text(&run.stdout));
}

#[test]
fn variants_are_different_motions_and_one_seed_is_one_motion() {
    let folder = folder();
    let task = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tasks/ring.toml");
    let task = task.to_string_lossy();
    let [a, b] = ["a.bvh", "b.bvh"].map(|n| at(&folder, n));
    let report = json(&["plan", &task, "--out", &a, "--variants", "3", "--seed", "5", "--json"], &["variants"]);
    let variants = report["variants"].as_array().expect("a list");
    assert!(variants.len() == 3 && variants.iter().all(|v| v["distance_rad"].as_f64() > Some(0.02)), "{report}");
    done(&["plan", &task, "--out", &b, "--seed", "5"]);
    let read = |path: &str| std::fs::read_to_string(path).expect("a clip");
    assert_eq!(read(&a), read(&b));
    assert_ne!(read(&a), read(&at(&folder, "a-2.bvh")));
    // What was taken stands beside each.
    let objects: Value = serde_json::from_str(&read(&at(&folder, "a-2.objects.json"))).expect("objects");
    assert_eq!(objects["attachments"][1]["joint"], "left_hand", "{objects}");
}

#[test]
fn schema_and_figures_are_printed() {
    let schema: Value = serde_json::from_str(&done(&["schema", "--of", "task"])).expect("a schema");
    for key in ["clip", "characters", "scene", "tasks", "planner"] {
        assert!(schema["properties"][key].is_object(), "no key `{key}` in {schema}");
    }
    let report =
        json(&["bench", "plan", "--scene", "table,spheres", "--seeds", "2", "--poses", "200", "--json"], &["results"]);
    let results = report["results"].as_array().expect("a list");
    assert_eq!((&results[0]["scene"], &results[1]["scene"]), (&"table".into(), &"spheres".into()), "{report}");
    for r in results {
        assert_eq!((&r["success_rate"], &r["recheck_violations"]), (&1.0.into(), &0.into()), "{r}");
        assert!(r["ik_error_max_m"].as_f64() < Some(1e-5) && r["ik_solved_fraction"].as_f64() > Some(0.99), "{r}");
    }
    let unknown = text(&throng(&["bench", "plan", "--scene", "tabel"]).stderr);
    assert!(unknown.contains("there is no scene `tabel`") && unknown.contains("arm-static"), "{unknown}");
    // A folder stands for the tasks in it.
    let folder = folder();
    let path = at(&folder, "");
    let command = ["bench", "plan", "--seeds", "1", "--poses", "10", "--json", "--scene", &path];
    let empty = text(&throng(&command).stderr);
    assert!(empty.contains("expected task files"), "{empty}");
    let task = tasks().into_iter().find(|t| t.ends_with("arm-low.toml")).expect("a task");
    std::fs::copy(task, at(&folder, "arm.toml")).expect("a copy");
    std::fs::write(at(&folder, "other.toml"), "name = \"no task\"\n").expect("a file");
    let report = json(&command, &["results"]);
    let results = report["results"].as_array().expect("a list");
    assert!(results.len() == 1 && results[0]["scene"].as_str().is_some_and(|s| s.ends_with("arm.toml")), "{report}");
}
