//! Every command does what its help says: output, JSON keys, exit codes, and errors that show the way out.

mod bake;
mod build;
mod bundle;
mod clips;
mod crowd;
mod export;
mod files;
mod folders;
mod help;
mod keys;
mod level;
mod live;
mod numbers;
mod plan;
mod refusals;
mod scenario;
mod scene;
mod view;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Every subcommand.
const COMMANDS: [&str; 20] = [
    "demo",
    "synth",
    "build",
    "bake",
    "inspect",
    "verify",
    "query",
    "stitch",
    "level",
    "check",
    "run",
    "explain",
    "plan",
    "bench",
    "export",
    "view",
    "schema",
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
struct BundleFolder {
    folder: tempfile::TempDir,
}

impl BundleFolder {
    /// The place of all tests, as long as one of them holds it.
    fn shared() -> Arc<Self> {
        static SHARED: Mutex<Weak<BundleFolder>> = Mutex::new(Weak::new());
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
            let keys = done(&["help", "keys", command]);
            assert!(keys.starts_with("JSON keys"), "{command} does not document its keys: {keys}");
        }
    }
    assert!(done(&["--version"]).starts_with("throng "));
    let listed = all.lines().filter(|l| l.starts_with("  ") && l.len() > 2 && !l[2..].starts_with([' ', '-'])).count();
    assert_eq!(listed, COMMANDS.len() + 1, "commands this test does not know (`help` is one more): {all}");
}

#[test]
fn without_arguments_the_commands_that_matter_are_printed() {
    let told = done(&[]);
    for command in ["throng inspect FOLDER", "throng build FOLDER", "throng run FOLDER --png"] {
        assert!(told.contains(command), "{told}");
    }
    assert!(told.lines().count() < 12, "{told}");
}

#[test]
fn wrong_usage_ends_with_2() {
    let cases: [&[&str]; 8] = [
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

#[cfg(unix)]
#[test]
fn a_reader_that_goes_is_no_failure() {
    use std::process::Stdio;
    let place = BundleFolder::shared();
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
