//! Promise: the runtime stays small, and dependencies point one way.

use super::workspace::{Crate, code, crates, sources};
use std::collections::BTreeSet;

/// All that the crates of the runtime may ever depend on, besides one another.
const RUNTIME_MAY_USE: [&str; 7] = ["bincode", "bytemuck", "glam", "memmap2", "rayon", "serde", "thiserror"];
/// What single crates need beside these. Scenes are files of text, whose placements draw from the generators that the
/// heavy tools use, so that they are the same; the schema of these files is an optional feature.
const ALSO: [(&str, &[&str]); 2] =
    [("throng-base", &["libm", "strsim", "toml"]), ("throng-simulation", &["rand", "rand_pcg", "schemars", "toml"])];
/// What is built only where a feature asks for it, in all crates of the runtime: threads, and the texts of scenes.
const OPTIONAL: [(&str, &str); 4] =
    [("rayon", ""), ("schemars", ""), ("strsim", "throng-base"), ("toml", "throng-base")];
/// What belongs into the command line alone.
const COMMAND_LINE_ONLY: [&str; 4] = ["clap", "clap_complete", "indicatif", "miette"];
/// Top-level folders of the workspace, each with those it may build on; what applications link comes first.
const FAMILIES: [(&str, &[&str]); 8] = [
    ("runtime", &["runtime"]),
    ("capi", &["runtime"]),
    ("precompute", &["runtime", "precompute"]),
    ("viewer", &["runtime", "precompute"]),
    ("python", &["runtime", "precompute"]),
    ("web", &["runtime"]),
    ("mpi", &["runtime", "precompute"]),
    ("fuzz", &["runtime", "precompute"]),
];
/// Agents without bodies know nothing of bundles, worlds and scenes: they may need these at most.
const CROWD_MAY_USE: [&str; 3] = ["throng-base", "throng-geometry", "throng-level"];

fn is_ours(name: &str) -> bool {
    name.starts_with("throng")
}

#[test]
fn the_runtime_depends_on_no_more_than_its_list() {
    let mut seen = BTreeSet::new();
    for c in crates().iter().filter(|c| c.is_in("runtime")) {
        let found: BTreeSet<String> = c.built_with().into_iter().filter(|n| !is_ours(n)).collect();
        let also = ALSO.iter().find(|(name, _)| *name == c.name).map_or(&[][..], |(_, also)| also);
        let may_use = |n: &str| RUNTIME_MAY_USE.contains(&n) || also.contains(&n);
        let extra: Vec<_> = found.iter().filter(|n| !may_use(n.as_str())).collect();
        assert!(extra.is_empty(), "{} grew by {extra:?}; put what needs it into precompute", c.name);
        seen.extend(found);
    }
    assert!(seen.contains("memmap2") && seen.contains("glam"), "the list was read: {seen:?}");
}

#[test]
fn the_runtime_runs_without_rayon_and_agents_without_texts() {
    for c in crates().iter().filter(|c| c.is_in("runtime")) {
        for (name, _) in OPTIONAL.iter().filter(|(_, of)| of.is_empty() || *of == c.name) {
            if let Some(needed) = c.manifest.get("dependencies").and_then(|d| d.get(name)) {
                let optional = needed.get("optional").and_then(toml::Value::as_bool);
                assert_eq!(optional, Some(true), "{}: {name} must stay optional: {needed}", c.name);
            }
        }
        let default = c.manifest.get("features").and_then(|f| f.get("default")).and_then(|d| d.as_array());
        let names = default.into_iter().flatten().filter_map(toml::Value::as_str);
        assert!(
            !names.clone().any(|n| n.contains("rayon") || n.contains("text")),
            "{}: default features {default:?}",
            c.name
        );
    }
}

#[test]
fn dependencies_point_one_way() {
    let all = crates();
    let family = |c: &Crate| FAMILIES.iter().find(|(f, _)| c.is_in(f));
    for c in all.iter().filter(|c| !c.at.is_empty()) {
        let (name, allowed) = family(c).unwrap_or_else(|| panic!("{}: a folder without a family", c.at));
        for needed in c.built_with().into_iter().chain(c.needs("dev-dependencies")).filter(|n| is_ours(n)) {
            let at = all.iter().find(|o| o.name == needed).map(|o| o.at.clone()).unwrap_or_default();
            let fits = allowed.iter().any(|f| at.split('/').next() == Some(f));
            assert!(fits, "{} of {name} needs {needed}; only {allowed:?} may be needed there", c.name);
        }
    }
    for c in all.iter().filter(|c| c.name == "throng-crowd") {
        let extra: Vec<String> = c.built_with().into_iter().filter(|n| is_ours(n)).collect();
        assert!(extra.iter().all(|n| CROWD_MAY_USE.contains(&n.as_str())), "throng-crowd needs {extra:?}");
    }
}

#[test]
fn arguments_and_progress_bars_stay_in_the_command_line() {
    for c in crates().iter().filter(|c| c.is_in("runtime") || c.is_in("precompute")) {
        let found = c.built_with();
        let wrong: Vec<_> = COMMAND_LINE_ONLY.iter().filter(|n| found.contains(**n)).collect();
        assert!(wrong.is_empty(), "{}/Cargo.toml has {wrong:?}", c.at);
    }
}

#[test]
fn libraries_print_nothing() {
    for c in crates().iter().filter(|c| c.is_in("runtime") || c.is_in("precompute")) {
        for file in sources(&c.folder.join("src")) {
            let text = std::fs::read_to_string(&file).expect("a source file reads");
            let code = code(&text);
            let printing = ["println!", "print!(", "eprint!(", "dbg!("].into_iter().find(|m| code.contains(m));
            assert_eq!(printing, None, "{} prints; return it or report it through Progress", file.display());
        }
    }
}
