//! What `throng help keys` says is what is printed.

use super::{BundleFolder, at, done, folder, json};
use serde_json::Value;
use std::collections::BTreeMap;

/// One documented key and those of what it holds.
#[derive(Debug, Default)]
struct Key {
    kind: Kind,
    is_optional: bool,
    text: String,
    inner: BTreeMap<String, Key>,
}

#[derive(Debug, Default, PartialEq)]
enum Kind {
    #[default]
    Value,
    List,
    Map,
}

/// The keys in a section of a help text, by their indentation.
fn documented(help: &str, heading: &str) -> BTreeMap<String, Key> {
    let mut lines = help.lines().skip_while(|l| !l.starts_with(heading)).skip(1).peekable();
    assert!(lines.peek().is_some(), "no section `{heading}` in {help}");
    below(&mut lines, 2)
}

fn below<'a>(lines: &mut std::iter::Peekable<impl Iterator<Item = &'a str>>, indent: usize) -> BTreeMap<String, Key> {
    let mut out = BTreeMap::new();
    while let Some(line) = lines.next_if(|l| l.len() > indent && l.find(|c| c != ' ') == Some(indent)) {
        let (name, text) = line.trim().split_once(": ").unwrap_or_else(|| panic!("a key without a text: {line}"));
        let is_optional = name.ends_with(" (optional)");
        let name = name.trim_end_matches(" (optional)");
        let (name, kind) = match (name.strip_suffix("[]"), name.strip_suffix("{}")) {
            (Some(list), _) => (list, Kind::List),
            (_, Some(map)) => (map, Kind::Map),
            _ => (name, Kind::Value),
        };
        let key = Key { kind, is_optional, text: text.to_owned(), inner: below(lines, indent + 2) };
        out.insert(name.to_owned(), key);
    }
    out
}

/// Asserts that an object has the documented keys and no other, all the way down.
fn compare(place: &str, keys: &BTreeMap<String, Key>, printed: &Value) {
    let object = printed.as_object().unwrap_or_else(|| panic!("{place}: not an object: {printed}"));
    for name in object.keys() {
        assert!(keys.contains_key(name), "{place}: `{name}` is printed and not documented");
    }
    for (name, key) in keys {
        assert!(!key.text.is_empty(), "{place}: `{name}` is not explained");
        let Some(value) = object.get(name) else {
            assert!(key.is_optional, "{place}: `{name}` is documented and not printed");
            continue;
        };
        let place = format!("{place}, {name}");
        let held: Vec<&Value> = match (&key.kind, value) {
            (Kind::List, Value::Array(all)) => all.iter().collect(),
            (Kind::Map, Value::Object(all)) => all.values().collect(),
            (Kind::Value, one) => vec![one],
            (_, Value::Null) => Vec::new(),
            (kind, other) => panic!("{place}: documented as {kind:?}, printed as {other}"),
        };
        for one in held.into_iter().filter(|v| !key.inner.is_empty() && !v.is_null()) {
            compare(&place, &key.inner, one);
        }
    }
}

/// Compares the list of a command with what it prints when it is called like this.
fn check(command: &[&str], heading: &str, args: &[&str]) {
    let help = done(&[&["help", "keys"], command].concat());
    let keys = documented(&help, heading);
    assert!(keys.len() >= 2, "{help}");
    compare(&command.join(" "), &keys, &json(&[command, args, &["--json"]].concat(), &[]));
}

#[test]
fn help_lists_exactly_the_keys_that_are_printed() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let (bundle, clip, config) = (place.bundle(), place.first_clip(), place.path("little.toml"));
    let (clips, out, environment) = (at(&folder, "clips"), at(&folder, "a.throng"), at(&folder, "ground.toml"));
    check(&["synth"], "JSON keys", &["--out", &clips, "--minutes", "0.5"]);
    check(&["build"], "JSON keys", &[&config, "--out", &out, "--no-cache"]);
    check(&["bake"], "JSON keys", &[&config, "--shard", "0/1", "--cache", &at(&folder, "cache")]);
    check(&["verify"], "JSON keys", &[&bundle]);
    check(&["inspect"], "JSON keys (of a motion file)", &[&clip]);
    check(&["inspect"], "JSON keys (of a bundle)", &[&bundle]);
    check(&["inspect"], "JSON keys (with --environment-out", &[&clip, "--environment-out", &environment]);
    check(&["query", "action"], "JSON keys", &[&bundle, "--state", "0", "--target", "1,3"]);
    let quick = ["--characters", "8", "--threads", "1", "--seconds", "0.001"];
    check(&["bench", "bundle"], "JSON keys", &[&[bundle.as_str()], &quick[..]].concat());
    check(&["bench", "crowd"], "JSON keys", &["--scene", "lanes", "--agents", "20", "--seconds", "0.5"]);
    let (task, planned) = (concat!(env!("CARGO_MANIFEST_DIR"), "/data/tasks/arm-low.toml"), at(&folder, "arm.bvh"));
    check(&["plan"], "JSON keys", &[task, "--out", &planned, "--variants", "2"]);
    check(&["selftest"], "JSON keys", &["--mutants", "1", "--no-cache"]);
    check(&["run"], "JSON keys (of a bundle)", &[&bundle, "--characters", "4", "--seconds", "1"]);
    let (png, kept) = (at(&folder, "demo.png"), at(&folder, "demo.throng"));
    let demo = ["--characters", "4", "--seconds", "1", "--out", &png, "--bundle", &kept];
    check(&["demo"], "JSON keys", &demo);
}
