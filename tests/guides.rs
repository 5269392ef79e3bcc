//! Promise: README and guides are short, and what they link to is there.

use std::path::{Path, PathBuf};

/// README: what a reader in a hurry reads.
const MOST_WORDS: usize = 900;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// README, changelog, guides, design records, and the READMEs of crates.
fn guides() -> Vec<PathBuf> {
    let mut out = vec![root().join("README.md"), root().join("CHANGELOG.md")];
    for folder in ["docs", "docs/decisions"] {
        let files = std::fs::read_dir(root().join(folder)).expect(folder).map(|e| e.expect("an entry").path());
        out.extend(files.filter(|p| p.extension().is_some_and(|e| e == "md")));
    }
    out.extend(crates().into_iter().map(|c| c.join("README.md")));
    // Workspaces of their own.
    out.extend(["bevy/README.md", "research/README.md", "research/NOTES.md"].map(|file| root().join(file)));
    out
}

/// Folders of the workspace's crates but the root.
fn crates() -> Vec<PathBuf> {
    let manifest: toml::Table = read(&root().join("Cargo.toml")).parse().expect("a manifest");
    let members = manifest["workspace"]["members"].as_array().expect("members");
    members.iter().map(|m| root().join(m.as_str().expect("a folder"))).collect()
}

/// Targets of Markdown links and pictures that are files of this repository, without what stands after `#`.
fn targets(text: &str) -> impl Iterator<Item = &str> {
    let links = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
    links.filter(|t| !t.contains("://")).map(|t| t.split('#').next().unwrap_or(t)).filter(|t| !t.is_empty())
}

#[test]
fn the_readme_is_short() {
    let words = read(&root().join("README.md")).split_whitespace().count();
    assert!(words <= MOST_WORDS, "{words} words, at most {MOST_WORDS}: move what is new to docs/");
}

#[test]
fn links_lead_to_files() {
    let mut found = 0;
    for guide in guides() {
        let folder = guide.parent().expect("a folder");
        for target in targets(&read(&guide)) {
            assert!(folder.join(target).exists(), "{}: there is no {target}", guide.display());
            found += 1;
        }
    }
    assert!(found > 50, "{found} links were read");
}

#[test]
fn links_to_sections_lead_to_headings() {
    for guide in guides() {
        let (folder, text) = (guide.parent().expect("a folder"), read(&guide));
        let links = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
        for (file, section) in links.filter(|t| !t.contains("://")).filter_map(|t| t.split_once('#')) {
            let target = if file.is_empty() { text.clone() } else { read(&folder.join(file)) };
            let has = target.lines().filter(|l| l.starts_with('#')).any(|l| anchor(l) == section);
            assert!(has, "{}: {file} has no section `{section}`", guide.display());
        }
    }
}

/// What a heading is linked by.
fn anchor(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = text.chars().filter(|c| c.is_alphanumeric() || *c == ' ' || *c == '-');
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn every_crate_has_a_readme() {
    for folder in crates() {
        let lines = read(&folder.join("README.md")).lines().filter(|l| !l.trim().is_empty()).count();
        assert!((3..=30).contains(&lines), "{}: {lines} lines; about ten say what it is for", folder.display());
    }
}
