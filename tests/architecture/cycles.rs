//! Promise: no cycle between folders. Modules at the top of a crate's `src` use one another one way, and so do crates.

use super::workspace::{Crate, code, crates, sources};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Which modules a module uses, and in which files.
type Uses = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

/// Modules that may need each other: crate, the two modules, and why.
const MUTUAL: [(&str, [&str; 2], &str); 1] =
    [("throng-world", ["graph", "path_hierarchy"], "a graph keeps the hierarchy that is built by walking over it")];

#[test]
fn folders_of_a_crate_form_no_cycle() {
    let mut found = Vec::new();
    for c in crates() {
        let mut uses = module_uses(&c);
        for (_, [a, b], _) in MUTUAL.iter().filter(|(name, ..)| *name == c.name) {
            uses.entry((*a).to_owned()).or_default().remove(*b);
        }
        found.extend(cycles(&uses).into_iter().map(|cycle| format!("{}: {}", c.name, described(&cycle, &uses))));
    }
    assert!(
        found.is_empty(),
        "{} cycles; move what both sides need into one of them or below:\n{}",
        found.len(),
        found.join("\n")
    );
}

#[test]
fn crates_form_no_cycle_even_with_their_tests() {
    let mut uses = Uses::new();
    for c in crates() {
        let needs = c.built_with().into_iter().chain(c.needs("dev-dependencies"));
        let edges = needs.filter(|n| n.starts_with("throng") && *n != c.name);
        uses.entry(c.name.clone()).or_default().extend(edges.map(|n| (n, BTreeSet::from(["Cargo.toml".to_owned()]))));
    }
    let found: Vec<String> = cycles(&uses).iter().map(|cycle| described(cycle, &uses)).collect();
    assert!(found.is_empty(), "crates need each other: {found:?}");
}

#[test]
fn a_cycle_in_sources_is_found() {
    let text = |body: &str| names(body, 2);
    assert_eq!(text("use crate::pose::Pose;\nfn a() { crate::clip::cut() }"), set(&["clip", "pose"]));
    assert_eq!(text("use crate::{\n    pose::{Pose, hand::Hand},\n    clip,\n};"), set(&["clip", "pose"]));
    assert_eq!(text("use super::super::pose::Pose;\nuse super::near::Near;"), set(&["pose"]));
    assert_eq!(text("/// See `crate::pose`.\n// crate::clip\n"), set(&[]));
    assert_eq!(text("#[cfg(test)]\nmod tests {\n    use crate::pose::Pose;\n}"), set(&[]));

    let edge = |to: &str| (to.to_owned(), BTreeSet::from(["a.rs".to_owned()]));
    let mut uses = Uses::new();
    for (from, to) in [("a", "b"), ("b", "c"), ("c", "a"), ("c", "d"), ("d", "e")] {
        uses.entry(from.to_owned()).or_default().extend([edge(to)]);
    }
    assert_eq!(cycles(&uses), [set(&["a", "b", "c"])]);
    uses.get_mut("c").expect("c uses a").remove("a");
    assert_eq!(cycles(&uses), Vec::<BTreeSet<String>>::new());
}

fn set(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|n| (*n).to_owned()).collect()
}

/// Which top-level modules of a crate name which others; tests and the crate's root are left out.
fn module_uses(c: &Crate) -> Uses {
    let (folder, mut uses) = (c.folder.join("src"), Uses::new());
    for file in sources(&folder) {
        let below = file.strip_prefix(&folder).expect("it lies in src").with_extension("");
        let mut path: Vec<String> = below.iter().map(|p| p.to_string_lossy().into_owned()).collect();
        path.pop_if(|last| last == "mod");
        if matches!(path[0].as_str(), "lib" | "main") {
            continue;
        }
        let text = std::fs::read_to_string(&file).expect("a source file reads");
        for name in names(&text, path.len()).into_iter().filter(|n| is_module(&folder, n) && *n != path[0]) {
            let files = uses.entry(path[0].clone()).or_default().entry(name).or_default();
            files.insert(below.display().to_string());
        }
    }
    uses
}

fn is_module(src: &Path, name: &str) -> bool {
    src.join(name).is_dir() || src.join(name).with_extension("rs").is_file()
}

/// First names after `crate::`, or after as many `super::` as lead there, in code that is neither comment nor test.
///
/// - `depth`: 1 for a module at the top of the crate.
fn names(text: &str, depth: usize) -> BTreeSet<String> {
    let code = code(text);
    let up = "super::".repeat(depth);
    let mut out = BTreeSet::new();
    for root in ["crate::", &up] {
        for (at, _) in code.match_indices(root) {
            let before = code[..at].chars().next_back().unwrap_or(' ');
            let rest = &code[at + root.len()..];
            if is_word(before) || before == ':' || before == '$' || rest.starts_with("super::") {
                continue;
            }
            match rest.strip_prefix('{') {
                Some(list) => out.extend(first_names(list)),
                None => out.extend(leading_word(rest)),
            }
        }
    }
    out
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn leading_word(text: &str) -> Option<String> {
    let word: String = text.trim_start().chars().take_while(|c| is_word(*c)).collect();
    (!word.is_empty()).then_some(word)
}

/// What each entry of a list in braces begins with; `list` is what follows the opening one.
fn first_names(list: &str) -> Vec<String> {
    let (mut depth, mut from, mut out) = (0, 0, Vec::new());
    for (i, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => {
                out.extend(leading_word(&list[from..i]));
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                out.extend(leading_word(&list[from..i]));
                from = i + 1;
            }
            _ => {}
        }
    }
    out
}

/// Sets of names of which each leads to each other.
fn cycles(uses: &Uses) -> Vec<BTreeSet<String>> {
    let reached: BTreeMap<&String, BTreeSet<String>> = uses.keys().map(|k| (k, reach(k, uses))).collect();
    let together = |a: &String| -> BTreeSet<String> {
        let there = |b: &&String| reached[a].contains(*b) && reached[*b].contains(a);
        uses.keys().filter(there).cloned().collect()
    };
    let found: BTreeSet<BTreeSet<String>> = uses.keys().map(together).filter(|cycle| cycle.len() > 1).collect();
    found.into_iter().collect()
}

fn reach(from: &str, uses: &Uses) -> BTreeSet<String> {
    let (mut out, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(next) = open.pop() {
        for to in uses.get(next).into_iter().flat_map(BTreeMap::keys) {
            if out.insert(to.clone()) {
                open.push(to);
            }
        }
    }
    out
}

/// The edges of a cycle, each with a file that makes it.
fn described(cycle: &BTreeSet<String>, uses: &Uses) -> String {
    let edge = |from: &String| {
        let to = uses[from].iter().filter(|(to, _)| cycle.contains(*to));
        to.map(|(to, files)| format!("{from} -> {to} ({})", files.first().map_or("", String::as_str)))
            .collect::<Vec<_>>()
            .join(", ")
    };
    cycle.iter().map(edge).collect::<Vec<_>>().join(", ")
}
