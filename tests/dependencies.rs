//! Promise: the runtime stays small, and dependencies point one way.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// All that the runtime may ever depend on.
const RUNTIME_MAY_USE: [&str; 7] = ["bincode", "bytemuck", "glam", "memmap2", "rayon", "serde", "thiserror"];
/// What belongs into the command line alone.
const COMMAND_LINE_ONLY: [&str; 4] = ["clap", "clap_complete", "indicatif", "miette"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn manifest(folder: &str) -> toml::Table {
    let path = root().join(folder).join("Cargo.toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.parse().unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Names in every dependency table of that kind, those of single targets included.
fn names(manifest: &toml::Table, kind: &str) -> BTreeSet<String> {
    let of = |t: &toml::Table| t.get(kind).and_then(|v| v.as_table()).cloned().unwrap_or_default();
    let targets = manifest.get("target").and_then(|v| v.as_table()).cloned().unwrap_or_default();
    let by_target = targets.values().filter_map(|v| v.as_table()).flat_map(of);
    of(manifest).into_iter().chain(by_target).map(|(name, _)| name).collect()
}

/// Dependencies and build dependencies.
fn built_with(folder: &str) -> BTreeSet<String> {
    let manifest = manifest(folder);
    names(&manifest, "dependencies").into_iter().chain(names(&manifest, "build-dependencies")).collect()
}

fn workspace_crates(of: &BTreeSet<String>) -> Vec<&str> {
    of.iter().map(String::as_str).filter(|n| n.starts_with("throng")).collect()
}

#[test]
fn the_runtime_depends_on_no_more_than_its_list() {
    let found = built_with("runtime");
    let allowed: BTreeSet<String> = RUNTIME_MAY_USE.map(String::from).into();
    let extra: Vec<_> = found.difference(&allowed).collect();
    assert!(extra.is_empty(), "runtime/Cargo.toml grew by {extra:?}; put what needs it into precompute");
    assert!(found.contains("memmap2") && found.contains("glam"), "the list was read: {found:?}");
}

#[test]
fn the_runtime_runs_without_rayon() {
    let manifest = manifest("runtime");
    let rayon = &manifest["dependencies"]["rayon"];
    assert_eq!(rayon.get("optional").and_then(toml::Value::as_bool), Some(true), "rayon must stay optional: {rayon}");
    let default = manifest.get("features").and_then(|f| f.get("default")).and_then(|d| d.as_array());
    assert!(default.is_none_or(|d| d.is_empty()), "default features of the runtime: {default:?}");
}

#[test]
fn dependencies_point_one_way() {
    assert_eq!(workspace_crates(&built_with("runtime")), [""; 0]);
    assert_eq!(workspace_crates(&built_with("precompute")), ["throng-runtime"]);
    for folder in ["runtime", "precompute", "viewer"] {
        let tests = names(&manifest(folder), "dev-dependencies");
        assert!(!tests.contains("throng"), "{folder} tests with the command line");
    }
}

#[test]
fn arguments_and_progress_bars_stay_in_the_command_line() {
    for folder in ["runtime", "precompute"] {
        let found = built_with(folder);
        let wrong: Vec<_> = COMMAND_LINE_ONLY.iter().filter(|n| found.contains(**n)).collect();
        assert!(wrong.is_empty(), "{folder}/Cargo.toml has {wrong:?}");
    }
}

#[test]
fn libraries_print_nothing() {
    for folder in ["runtime/src", "precompute/src"] {
        for file in sources(&root().join(folder)) {
            let text = std::fs::read_to_string(&file).expect("a source file reads");
            // Unit tests end their file and may print.
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            let printing = ["println!", "print!(", "eprint!(", "dbg!("].into_iter().find(|m| code.contains(m));
            assert_eq!(printing, None, "{} prints; return it or report it through Progress", file.display());
        }
    }
}

/// All Rust files below a folder, test modules in files of their own left out.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut out = Vec::new();
    for path in entries.map(|e| e.expect("a folder lists").path()) {
        if path.is_dir() {
            out.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") && path.file_stem().is_some_and(|s| s != "tests") {
            out.push(path);
        }
    }
    out
}
