//! `throng-mpi` as processes that `mpirun` starts.

use std::path::Path;
use std::process::{Command, Output};
use std::sync::Mutex;
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::pipeline;
use throng_precompute::progress::Silent;
use throng_precompute::synth::{self, SynthConfig, SynthSet};

/// The program in so many processes.
fn command(ranks: usize, words: &[&str]) -> Command {
    let mut run = Command::new("mpirun");
    run.args(["--oversubscribe", "--allow-run-as-root", "-n", &ranks.to_string(), env!("CARGO_BIN_EXE_throng-mpi")]);
    run.args(words);
    run
}

/// Runs it, one at a time: all processes of a run are busy even while they wait.
fn mpirun(ranks: usize, words: &[&str]) -> Output {
    static ALONE: Mutex<()> = Mutex::new(());
    let _alone = ALONE.lock();
    command(ranks, words).output().expect("mpirun is there where MPI is")
}

fn json(output: &Output) -> serde_json::Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

#[test]
fn crowd_of_several_processes_is_that_of_one() {
    let words = ["crowd", "lanes", "--agents", "300", "--seconds", "10", "--json"];
    let alone = json(&mpirun(1, &words));
    assert_eq!((alone["ranks"].as_u64(), alone["bytes_moved"].as_u64()), (Some(1), Some(0)));
    for ranks in [2, 3] {
        let shared = json(&mpirun(ranks, &words));
        assert_eq!(shared["state_hash"], alone["state_hash"], "{ranks} ranks");
        assert_eq!(shared["agents"], 300);
        assert_eq!(shared["overlaps"], 0);
        assert!(shared["handed_over"].as_u64() > Some(0) && shared["bytes_moved"].as_u64() > Some(0));
        assert!(shared["us_per_agent_second"].as_f64() > Some(0.0));
    }
}

/// A folder with clips, and a config of them.
fn motion(minutes: f64) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = SynthConfig { minutes, clip_seconds: 8.0, ..SynthConfig::default() };
    synth::write_set(SynthSet::Walk, &settings, &folder.path().join("clips")).expect("synthetic clips can be written");
    let config = folder.path().join("walk.toml");
    std::fs::write(&config, "name = \"walk\"\ninputs = [\"clips\"]\n").expect("a config");
    let config = config.to_str().expect("a readable path").to_owned();
    (folder, config)
}

#[test]
fn bundle_of_several_processes_is_that_of_one() {
    let (folder, config) = motion(0.5);
    let at = |name: &str| folder.path().join(name).to_str().expect("a readable path").to_owned();
    let (alone, shared, cache) = (at("alone.throng"), at("shared.throng"), at("cache"));
    let of = BuildConfig::load(Path::new(&config)).expect("a config");
    pipeline::build(&of, Path::new(&alone), &Cache::disabled(), &Silent).expect("it builds");
    let bytes = |path: &str| std::fs::read(path).expect("a bundle");
    for ranks in [1, 2, 4] {
        let told = json(&mpirun(ranks, &["build", &config, "--out", &shared, "--no-cache", "--json"]));
        assert!(bytes(&shared) == bytes(&alone), "{ranks} ranks");
        assert_eq!(told["ranks"], ranks);
        assert!(told["of_ranks"].as_array().is_some_and(|all| all.iter().all(|r| r["peak_bytes"].as_u64() > Some(0))));
    }
    // The graph of captured motion says what is missing.
    for cached in [serde_json::json!([]), serde_json::json!(["graph", "make", "graph", "policy"])] {
        let told = json(&mpirun(2, &["build", &config, "--out", &shared, "--cache", &cache, "--json"]));
        assert!(bytes(&shared) == bytes(&alone));
        assert_eq!(told["cached"], cached);
    }
}

/// Processes that a process has started.
#[cfg(target_os = "linux")]
fn children(parent: u32) -> Vec<u32> {
    let all = std::fs::read_dir("/proc").expect("processes are listed").flatten();
    let pids = all.filter_map(|e| e.file_name().to_str()?.parse::<u32>().ok());
    let parent_of = |pid: u32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        stat.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse::<u32>().ok()
    };
    pids.filter(|&pid| parent_of(pid) == Some(parent)).collect()
}

#[test]
#[cfg(target_os = "linux")]
fn killed_process_ends_all_and_the_next_build_goes_on() {
    use std::process::Stdio;
    let (folder, config) = motion(3.0);
    let at = |name: &str| folder.path().join(name).to_str().expect("a readable path").to_owned();
    let (out, cache) = (at("walk.throng"), at("cache"));
    let words = ["build", &config, "--out", &out, "--cache", &cache, "--json"];
    let mut running = command(3, &words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("mpirun starts");
    let has_graph = || {
        let entries = std::fs::read_dir(&cache).into_iter().flatten().flatten();
        entries.map(|e| e.file_name()).any(|name| name.to_string_lossy().starts_with("graph-"))
    };
    while !has_graph() && running.try_wait().expect("it can be asked").is_none() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let last = children(running.id()).into_iter().max().expect("processes run");
    let killed = Command::new("kill").args(["-9", &last.to_string()]).status().expect("`kill` is there");
    assert!(killed.success());
    let ended = running.wait_with_output().expect("mpirun ends");
    let told = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(!ended.status.success() && told.contains("signal 9"), "{:?}: {told}", ended.status);
    assert!(!Path::new(&out).exists(), "no bundle is half written");
    let told = json(&mpirun(2, &words));
    assert!(told["cached"].as_array().is_some_and(|all| all.iter().any(|stage| stage == "graph")), "{told}");
    let alone = at("alone.throng");
    let of = BuildConfig::load(Path::new(&config)).expect("a config");
    pipeline::build(&of, Path::new(&alone), &Cache::disabled(), &Silent).expect("it builds");
    assert!(std::fs::read(&out).expect("a bundle") == std::fs::read(&alone).expect("a bundle"));
}

#[test]
fn threads_stand_for_processes() {
    let run = |words: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_throng-mpi")).args(words).args(["--local", "3"]).output().expect("it starts")
    };
    let figures = json(&run(&["crowd", "circle", "--seconds", "5", "--json"]));
    assert_eq!((figures["ranks"].as_u64(), figures["overlaps"].as_u64()), (Some(3), Some(0)));
    let failed = run(&["crowd", "square"]);
    let told = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert_eq!(failed.status.code(), Some(1), "{told}");
    assert_eq!(told.matches("error:").count(), 1, "{told}");
}

#[test]
fn what_goes_wrong_ends_all_processes_with_one_message() {
    let failed = mpirun(2, &["crowd", "square"]);
    let told = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert_eq!(failed.status.code(), Some(1), "{told}");
    assert_eq!(told.matches("only one process can move such").count(), 1, "{told}");
}
