//! `throng run` on scenes: what it prints, and what it says where a scene cannot be run.

use super::{at, done, failed, folder, json};
use std::path::Path;
use std::sync::LazyLock;

/// Half a minute of shadow-boxing, small grids.
const CONFIG: &str = "[synth]\nset = \"boxing\"\nminutes = 0.5\n\n[policy]\ncompare_samples = 50\n\n\
    [[behaviours]]\nname = \"approach\"\ncentre = \"hits\"\n\
    grid = { rings = 5, angles = 9, radius = 2.0, inner_spacing = 0.5 }\n\n\
    [[behaviours]]\nname = \"throw-punches\"\nkind = \"throw_punches\"\n\
    grid = { rings = 5, angles = 5, heights = 3 }\n\n\
    [[behaviours]]\nname = \"evade\"\nkind = \"evade\"\ngrid = { rings = 4, angles = 8, times = 5 }\n";

const NAMES: [&str; 3] = ["approach", "throw-punches", "evade"];

/// A folder with a config and scenes; the bundle is built by the first run.
static PLACE: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let place = folder();
    write(&at(&place, "fight.toml"), CONFIG);
    write(&at(&place, "pair.toml"), &scene("sparring", 2, ""));
    place
});

fn write(path: &str, text: &str) {
    std::fs::write(path, text).expect("a file");
}

fn scene(motion: &str, count: usize, more: &str) -> String {
    // Targets do not strike: there is nothing to evade.
    let names: &[&str] = if motion == "policy" { &NAMES[..2] } else { &NAMES };
    let behaviours: String = names.iter().map(|b| format!("[[groups.behaviours]]\nname = \"{b}\"\n")).collect();
    let head = "bundle = \"fight.throng\"\nconfig = \"fight.toml\"\n";
    format!("{head}[[groups]]\nmotion = \"{motion}\"\ncount = {count}\n{behaviours}{more}")
}

/// The bundle, built where it is not there yet.
fn bundle() -> String {
    static BUILT: LazyLock<String> = LazyLock::new(|| {
        let bundle = at(&PLACE, "fight.throng");
        done(&["run", &at(&PLACE, "pair.toml"), "--seconds", "1", "--no-cache"]);
        assert!(Path::new(&bundle).exists(), "the run has built the scene's bundle");
        bundle
    });
    BUILT.clone()
}

#[test]
fn queries_ask_for_the_height_of_a_target_and_the_moment_of_a_blow() {
    let bundle = bundle();
    let ask = |behaviour, more: &[&str]| {
        let words = ["query", "action", &bundle, "--behaviour", behaviour, "--state", "0", "--target", "0,0.6"];
        words.into_iter().chain(more.iter().copied()).map(str::to_owned).collect::<Vec<_>>()
    };
    let words = |all: &[String]| json(&all.iter().map(String::as_str).collect::<Vec<_>>(), &["value", "height_m"]);
    let refused = |all: &[String]| failed(&all.iter().map(String::as_str).collect::<Vec<_>>());

    let [low, high] = ["0.2", "1.4"].map(|m| words(&ask("throw-punches", &["--height", m, "--json"])));
    assert!(low["height_m"].as_f64().is_some_and(|m| (m - 0.2).abs() < 1e-6) && low["time_left_s"].is_null(), "{low}");
    assert!(high["value"].as_f64() > low["value"].as_f64(), "nobody strikes at shins: {low} {high}");
    let middle = words(&ask("throw-punches", &["--json"]))["height_m"].as_f64().unwrap_or(0.0);
    assert!((0.8..1.8).contains(&middle), "{middle}");

    let soon = words(&ask("evade", &["--time-left", "0.3", "--json"]));
    assert!(soon["time_left_s"].as_f64().is_some_and(|s| (s - 0.3).abs() < 1e-6), "{soon}");
    let e = refused(&ask("evade", &[]));
    assert!(e.contains("policy `evade`") && e.contains("Add --time-left S, from 0 to"), "{e}");
    assert!(refused(&ask("approach", &["--height", "1"])).contains("knows no height"));
    assert!(refused(&ask("throw-punches", &["--time-left", "1"])).contains("not about a moment"));
}

#[test]
fn pairs_spar_and_are_measured_and_drawn() {
    let bundle = bundle();
    let (scene, png) = (at(&PLACE, "pair.toml"), at(&PLACE, "pair.png"));
    let keys = [
        "characters",
        "steps_per_second",
        "hits_per_minute",
        "landed_fraction",
        "blocked_fraction",
        "foot_slip_p95_mps",
        "max_penetration_m",
        "distance_mean_m",
    ];
    let args = ["run", &scene, "--bundle", &bundle, "--characters", "6", "--seconds", "20", "--json", "--png", &png];
    let report = json(&args, &keys);
    assert_eq!(report["characters"], 6);
    assert!(report["thrown"].as_u64() > Some(0), "{report}");
    let number = |key: &str| report[key].as_f64().expect("a number");
    assert!((0.0..=1.0).contains(&number("landed_fraction")) && number("distance_mean_m") < 2.0, "{report}");
    assert!(std::fs::read(&png).is_ok_and(|b| b.starts_with(b"\x89PNG")));
    // Everything but the time it took repeats.
    let again = json(&args, &keys);
    assert!(keys.iter().filter(|k| **k != "steps_per_second").all(|k| report[k] == again[k]), "{report} {again}");
}

#[test]
fn targets_are_struck() {
    let (bundle, scene_file) = (bundle(), at(&PLACE, "bags.toml"));
    write(&scene_file, &scene("policy", 4, "[groups.target]\nheight_m = 1.5\ndrag = [{ time_s = 4.0, x_m = 0.5 }]\n"));
    let report = json(&["run", &scene_file, "--bundle", &bundle, "--seconds", "20", "--json"], &["landed_fraction"]);
    assert!(report["landed_fraction"].as_f64() > Some(0.0), "{report}");
    assert!(report["distance_max_m"].as_f64() > Some(0.0), "{report}");
    let short = json(&["run", &scene_file, "--bundle", &bundle, "--seconds", "1", "--json"], &["distance_mean_m"]);
    assert!(short["distance_max_m"].is_null(), "{short}");
}

#[test]
fn scenes_that_cannot_be_run_say_what_to_change() {
    let bundle = bundle();
    let fails = |text: &str, parts: &[&str]| {
        let file = at(&PLACE, &format!("bad{}.toml", text.len()));
        write(&file, text);
        let message = failed(&["run", &file, "--bundle", &bundle, "--seconds", "1"]);
        assert!(parts.iter().all(|p| message.contains(p)), "{parts:?}: {message}");
    };
    fails(&scene("policy", 1, "[groups.target]\nheight_m = 3.0\n"), &["nobody can reach", "3.00 m", "target.height_m"]);
    fails(&scene("sparring", 3, ""), &["`groups[0].count`", "even"]);
    fails(&scene("trios", 3, ""), &[":4:10", "sparring"]);
    fails(&scene("sparring", 2, "[[groups.behaviours]]\nname = \"dance\"\n"), &["dance", "throw-punches"]);
    let evade = "[[groups.behaviours]]\nname = \"evade\"\n";
    fails(&scene("policy", 1, evade), &["behaviours[2]", "targets do not strike", "leave it out"]);
    fails(&scene("sparring", 2, evade), &["`groups[0].behaviours[3].name`", "\"evade\""]);
    fails(&scene("sparring", 2, "[groups.target]\nheight_m = 1.2\n"), &["`target`", "\"sparring\""]);
    let lost = at(&PLACE, "lost.toml");
    write(&lost, &scene("sparring", 2, "").replace("fight.t", "gone.t").replace("config = \"gone.toml\"\n", ""));
    assert!(failed(&["run", &lost]).contains("gone.throng"));
}

#[test]
fn builds_without_hits_or_out_of_reach_say_what_to_change() {
    let place = folder();
    let fails = |config: String, parts: &[&str]| {
        let file = at(&place, "c.toml");
        write(&file, &config);
        let message = failed(&["build", &file, "--out", &at(&place, "c.throng"), "--no-cache"]);
        assert!(parts.iter().all(|p| message.contains(p)), "{parts:?}: {message}");
        assert!(!Path::new(&at(&place, "c.throng")).exists());
    };
    fails(CONFIG.replace("set = \"boxing\"", "set = \"walk\""), &["no effective hit", "annotate.hits"]);
    let far = "grid = { rings = 5, angles = 5, heights = 3, bounds = { distance_m = [5.0, 6.0] } }";
    let near = "grid = { rings = 5, angles = 5, heights = 3 }";
    fails(CONFIG.replace(near, far), &["no hit comes near", "grid.bounds"]);
    fails(CONFIG.replace("[synth]", "inputs = [\"x\"]\n[synth]"), &["`inputs` or `[synth]`", "both"]);
}

#[test]
fn a_scene_runs_without_one_of_its_behaviours() {
    let (bundle, scene) = (bundle(), at(&PLACE, "pair.toml"));
    let plain = ["run", &scene, "--bundle", &bundle, "--seconds", "10", "--json"];
    let without = |name| [&plain[..], &["--without", name]].concat();
    let all = json(&plain, &["thrown"]);
    let tame = json(&without("throw-punches"), &["thrown"]);
    assert_ne!(all["distance_mean_m"], tame["distance_mean_m"]);
    let message = failed(&without("dance"));
    assert!(message.contains("dance") && message.contains("throw-punches"), "{message}");
}
