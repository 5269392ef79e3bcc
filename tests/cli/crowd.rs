//! `throng run` and `throng bench` of crowds.

use super::{at, done, failed, folder, json, refused};

/// Keys of the figures of every crowd.
const KEYS: [&str; 11] = [
    "agents",
    "engine",
    "wall_s_per_simulated_s",
    "us_per_agent_second",
    "events_per_agent_second",
    "overlap_over_1mm_fraction",
    "overlap_over_1cm_fraction",
    "max_overlap_m",
    "progress_mps",
    "stuck",
    "state_hash",
];

#[test]
fn bench_measures_a_crowd_with_the_engine_that_is_named() {
    let ask = |engine| {
        json(
            &["bench", "crowd", "--scene", "lanes", "--agents", "40", "--engine", engine, "--seconds", "2", "--json"],
            &KEYS,
        )
    };
    for engine in ["events", "occupancy"] {
        let report = ask(engine);
        assert_eq!((&report["agents"], &report["engine"]), (&40.into(), &engine.into()));
        assert!(report["progress_mps"].as_f64() > Some(0.5), "{report}");
        assert!(report["us_per_agent_second"].as_f64() > Some(0.0), "{report}");
        assert_eq!(report["state_hash"], ask(engine)["state_hash"], "it repeats");
    }
}

#[test]
fn bench_sweeps_over_numbers_and_engines() {
    let args = [
        "bench",
        "crowd",
        "--scene",
        "flock",
        "--agents",
        "20,40",
        "--engine",
        "events,occupancy",
        "--repeats",
        "2",
        "--seconds",
        "1",
        "--json",
    ];
    let report = json(&args, &["runs"]);
    let runs = report["runs"].as_array().expect("runs");
    let of = |i: usize| (runs[i]["engine"].as_str(), runs[i]["agents"].as_u64());
    assert_eq!(
        (0..4).map(of).collect::<Vec<_>>(),
        [
            (Some("events"), Some(20)),
            (Some("events"), Some(40)),
            (Some("occupancy"), Some(20)),
            (Some("occupancy"), Some(40)),
        ]
    );
}

#[test]
fn bench_sweeps_over_scenes_a_line_a_run() {
    let text = done(&["bench", "crowd", "--scene", "ring,square", "--agents", "30,300", "--seconds", "0.5"]);
    let runs: Vec<Vec<&str>> = text.lines().map(|l| l.split_whitespace().take(3).collect()).collect();
    // Two hundred are at home on the square, which does not grow.
    let want = [
        ["scene", "agents", "engine"],
        ["ring", "30", "events"],
        ["ring", "300", "events"],
        ["square", "30", "events"],
    ];
    assert_eq!(runs, want, "{text}");
    let all = json(&["bench", "crowd", "--scene", "all", "--agents", "20", "--seconds", "0.2", "--json"], &["runs"]);
    assert_eq!(all["runs"].as_array().map(Vec::len), Some(7));
}

#[test]
fn run_measures_and_draws_a_scene_file() {
    let folder = folder();
    let (file, png) = (at(&folder, "door.toml"), at(&folder, "door.png"));
    let text = "seconds = 5.0\nmeasure.gate = { from = [0.0, -1.0], to = [0.0, 1.0] }\n\
        [[groups]]\nmotion = \"none\"\ncount = 12\nplace = { block = { from = [-5.0, -2.0], to = [-1.0, 2.0] } }\n\
        goal = { shift = { by = [8.0, 0.0] } }\n";
    std::fs::write(&file, text).expect("a scene");
    let report = json(&["run", &file, "--png", &png, "--json"], &[&KEYS[..], &["crossed", "flow_per_m_s"]].concat());
    assert_eq!((&report["scene"], &report["simulated_s"]), (&"door".into(), &5.0.into()));
    assert!(std::fs::read(&png).is_ok_and(|b| b.starts_with(b"\x89PNG")));
    let more = json(&["run", &file, "--characters", "20", "--seconds", "1", "--seed", "3", "--json"], &KEYS);
    assert_eq!((&more["agents"], &more["simulated_s"]), (&20.into(), &1.0.into()));
    let other = json(&["run", &file, "--engine", "occupancy", "--seconds", "1", "--json"], &KEYS);
    assert_eq!(other["engine"], "occupancy");
}

#[test]
fn what_cannot_be_run_says_what_to_change() {
    let folder = folder();
    let file = at(&folder, "bad.toml");
    std::fs::write(&file, "[[groups]]\nmotion = \"none\"\ncount = 3\nplase = 1\n").expect("a scene");
    let message = failed(&["run", &file]);
    assert!(message.contains("bad.toml:4:1") && message.contains("`place`"), "{message}");
    let cases: [(&[&str], &[&str]); 5] = [
        (&["bench", "crowd", "--scene", "moon"], &["moon", "corridor", "square"]),
        (&["bench", "crowd", "--engine", "magic"], &["magic", "occupancy"]),
        (&["run", "data/scenes/circle.toml", "--engine", "magic"], &["magic", "occupancy"]),
        (&["run", "data/scenes/blend-walkers.toml", "--engine", "occupancy"], &["--engine", "scenes with agents"]),
        (&["run", "data/scenes/circle.toml", "--bundle", "a.throng"], &["--bundle", "no group"]),
    ];
    for (args, parts) in cases {
        let message = failed(args);
        assert!(parts.iter().all(|p| message.contains(p)), "{args:?}: {message}");
    }
    let message = refused(&["bench", "crowd", "--agents", "0"]);
    assert!(message.contains("--agents") && message.contains("expected 1 to"), "{message}");
}
