//! Hashes the sources that decide what a stage makes of its input, so that no build reads outputs that other code
//! has left in the cache.

use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// Files that decide the versions of other crates and how they are compiled.
const CRATES: [&str; 2] = ["../../Cargo.lock", "../../Cargo.toml"];
/// Sources of the stages, relative to this crate's folder; files that a packaged crate lacks are skipped.
const SOURCES: [&str; 9] = [
    "src",
    "../motion/src",
    "../planner/src",
    "../synth/src",
    "../../runtime/geometry/src",
    "../../runtime/base/src",
    "../../runtime/core/src",
    "../../runtime/world/src",
    "../../data/skeletons",
];

fn main() -> std::io::Result<()> {
    let mut files = BTreeSet::new();
    for folder in SOURCES.map(Path::new).into_iter().filter(|f| f.is_dir()) {
        println!("cargo::rerun-if-changed={}", folder.display());
        collect(folder, &mut files)?;
    }
    for file in CRATES.map(Path::new).into_iter().filter(|f| f.is_file()) {
        println!("cargo::rerun-if-changed={}", file.display());
        files.insert(file.to_path_buf());
    }
    let mut hasher = DefaultHasher::new();
    // Last bits differ between kinds of processors.
    std::env::var("TARGET").ok().hash(&mut hasher);
    for file in files {
        file.hash(&mut hasher);
        std::fs::read(&file)?.hash(&mut hasher);
    }
    println!("cargo::rustc-env=THRONG_SOURCES={:016x}", hasher.finish());
    Ok(())
}

/// Adds the files of a folder and of those in it.
fn collect(folder: &Path, files: &mut BTreeSet<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else {
            files.insert(path);
        }
    }
    Ok(())
}
