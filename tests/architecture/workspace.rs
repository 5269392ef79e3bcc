//! The crates of the workspace, as their manifests and folders have them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A member of the workspace.
pub struct Crate {
    /// Its name.
    pub name: String,
    /// Its folder below the workspace's, as `runtime/core`; empty for the root package.
    pub at: String,
    /// Its folder.
    pub folder: PathBuf,
    /// Its `Cargo.toml`.
    pub manifest: toml::Table,
}

/// The root package and all members.
pub fn crates() -> Vec<Crate> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let members = manifest(&root)["workspace"]["members"].as_array().expect("a list of members").clone();
    let members = members.iter().map(|m| m.as_str().expect("a folder").to_owned());
    let all: Vec<Crate> = std::iter::once(String::new())
        .chain(members)
        .map(|at| {
            let folder = root.join(&at);
            let manifest = manifest(&folder);
            let name = manifest["package"]["name"].as_str().expect("a name").to_owned();
            Crate { name, at, folder, manifest }
        })
        .collect();
    assert!(all.len() > 5, "the workspace was read");
    all
}

fn manifest(folder: &Path) -> toml::Table {
    let path = folder.join("Cargo.toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.parse().unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

impl Crate {
    /// True for crates below a top-level folder.
    pub fn is_in(&self, family: &str) -> bool {
        self.at.split('/').next() == Some(family)
    }

    /// Names in every table of a kind of dependencies, those of single targets included.
    pub fn needs(&self, kind: &str) -> BTreeSet<String> {
        let of = |t: &toml::Table| t.get(kind).and_then(|v| v.as_table()).cloned().unwrap_or_default();
        let targets = self.manifest.get("target").and_then(|v| v.as_table()).cloned().unwrap_or_default();
        let by_target = targets.values().filter_map(|v| v.as_table()).flat_map(of);
        of(&self.manifest).into_iter().chain(by_target).map(|(name, _)| name).collect()
    }

    /// Dependencies and build dependencies.
    pub fn built_with(&self) -> BTreeSet<String> {
        self.needs("dependencies").into_iter().chain(self.needs("build-dependencies")).collect()
    }
}

/// All Rust files below a folder, in order; test modules in files of their own are left out.
pub fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("a folder lists").path()).collect();
    paths.sort();
    let mut out = Vec::new();
    for path in paths.into_iter().filter(|p| p.file_stem().is_some_and(|s| s != "tests")) {
        if path.is_dir() {
            out.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
    out
}

/// A source text without comments and the unit tests that end it.
pub fn code(text: &str) -> String {
    let lines = text.lines().map(|l| l.split("//").next().unwrap_or_default());
    let code = lines.collect::<Vec<_>>().join("\n");
    let tests = ["", "pub(super) "].map(|seen| format!("#[cfg(test)]\n{seen}mod tests"));
    let end = tests.iter().filter_map(|t| code.find(t)).min().unwrap_or(code.len());
    code[..end].to_owned()
}
