use super::*;
use proptest::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    count: u64,
    offset: i32,
    scale: f32,
    name: String,
    on: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
    range: [f64; 2],
    kinds: Vec<Kind>,
    inner: BTreeMap<String, Inner>,
}

#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Plain,
    Wrapped(u32),
    Pair(i64, f64),
    WithFields { width: f64 },
}

#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(untagged)]
enum Inner {
    Number(f64),
    Word(String),
    List(Vec<Inner>),
}

fn kind() -> impl Strategy<Value = Kind> {
    prop_oneof![
        Just(Kind::Plain),
        any::<u32>().prop_map(Kind::Wrapped),
        (any::<i64>(), -1e9..1e9).prop_map(|(a, b)| Kind::Pair(a, b)),
        (-1e9..1e9).prop_map(|width| Kind::WithFields { width }),
    ]
}

fn inner() -> impl Strategy<Value = Inner> {
    let leaf = prop_oneof![(-1e9..1e9).prop_map(Inner::Number), "\\PC{0,9}".prop_map(Inner::Word)];
    leaf.prop_recursive(3, 12, 4, |inner| prop::collection::vec(inner, 0..4).prop_map(Inner::List))
}

fn settings() -> impl Strategy<Value = Settings> {
    let numbers = (0..1_u64 << 62, any::<i32>(), -1e9_f32..1e9, "\\PC{0,12}", any::<bool>());
    let rest = (
        prop::option::of(0..1_u64 << 62),
        [-1e9..1e9, -1e9..1e9],
        prop::collection::vec(kind(), 0..5),
        prop::collection::btree_map("[a-z ]{1,5}", inner(), 0..4),
    );
    (numbers, rest).prop_map(|((count, offset, scale, name, on), (seed, range, kinds, inner))| Settings {
        count,
        offset,
        scale,
        name,
        on,
        seed,
        range,
        kinds,
        inner,
    })
}

proptest! {
    #[test]
    fn settings_are_read_as_they_were_written(settings in settings()) {
        let text = toml::to_string(&settings).unwrap();
        let read: Settings = TomlSource::new(&text, Path::new("a.toml")).parse("help").unwrap();
        prop_assert_eq!(&read, &settings);
        prop_assert_eq!(&read, &toml::from_str::<Settings>(&text).unwrap());
    }

    /// Damaged texts: refused by both readers or by none, at the same place.
    #[test]
    fn faults_stand_where_the_toml_crate_finds_them(settings in settings(), at in any::<prop::sample::Index>(), to in "[a-z0-9.\"\\[\\]{}=\n]") {
        let mut text = toml::to_string(&settings).unwrap();
        let at = text.char_indices().map(|(i, _)| i).nth(at.index(text.chars().count())).unwrap();
        text.replace_range(at..at + text[at..].chars().next().unwrap().len_utf8(), &to);
        let source = TomlSource::new(&text, Path::new("a.toml"));
        match (source.parse::<Settings>("help"), toml::from_str::<Settings>(&text)) {
            (Ok(a), Ok(b)) => prop_assert_eq!(a, b),
            (Err(a), Err(b)) => {
                let place = |e: Error| match e { Error::Text { line, column, .. } => (line, column), e => panic!("{e}") };
                prop_assert_eq!(place(a), place(source.error_at_span(b.span().unwrap_or(0..0), String::new())), "{}", b);
            }
            (a, b) => prop_assert!(false, "{:?} {:?}\n{}", a, b, text),
        }
    }
}

#[test]
fn faults_name_line_column_and_the_way_out() {
    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Scene {
        #[serde(rename = "seconds")]
        _seconds: f64,
        #[serde(default, rename = "kinds")]
        _kinds: Vec<Kind>,
    }
    for (text, expected) in [
        ("secnds = 1", "s.toml:1:1: unknown field `secnds`, expected `seconds` or `kinds`. Did you mean `seconds`?"),
        ("zq = 1", "s.toml:1:1: unknown field `zq`, expected `seconds` or `kinds`. See the list."),
        ("kinds = []", "s.toml:1:1: missing field `seconds`. See the list."),
        ("\nseconds = \"a\"", "s.toml:2:11: invalid type: string \"a\", expected f64. See the list."),
        ("seconds = 1\nkinds = ['wrapped']", "s.toml:2:10: `wrapped` needs content: { wrapped = ... }. See the list."),
        ("seconds = 1\nkinds = [{}]", "s.toml:2:10: expected a table with one key, found 0. See the list."),
    ] {
        let error = TomlSource::new(text, Path::new("s.toml")).parse::<Scene>("See the list.").unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
}

#[test]
fn keys_are_found_as_deep_as_they_stand() {
    let source =
        TomlSource::new("a = 1\n[[groups]]\nname = 'x'\n[[groups]]\n  place = { x = 2 }\n", Path::new("s.toml"));
    for (key, place) in [("a", "1:1"), ("groups[1].place.x", "5:13"), ("groups[1].place.y", "5:3"), ("b", "1:1")] {
        assert!(
            source.error_at_key(key, "wrong".into()).to_string().starts_with(&format!("s.toml:{place}: ")),
            "{key}"
        );
    }
    let dotted = TomlSource::new("[clips.walk]\nx = 1\n[clips.\"walk.1\"]\ntags = [1, [2, 3]]\n", Path::new("s.toml"));
    for (key, place) in [("clips.walk.1.tags[1]", "4:12"), ("clips.walk.x", "2:1"), ("clips.walk.1", "3:8")] {
        assert!(
            dotted.error_at_key(key, "wrong".into()).to_string().starts_with(&format!("s.toml:{place}: ")),
            "{key}"
        );
    }
    assert_eq!(dotted.value_span("clips.walk.1.tags[1][0]").map(|v| &dotted.text()[v]), Some("2"));
}

/// Keys of many parts in many braces: as deep as the product of both.
#[test]
fn texts_too_deep_for_a_stack_are_refused_by_line_and_column() {
    let key = ["a"; 79].join(".");
    let deep = |n: usize| {
        format!("# [[[\n{}1{}", format!("{key} = {{").repeat(n).replacen('{', "{ s = '''[\n''', ", 1), "}".repeat(n))
    };
    let parse = |text: String| {
        let read = move || TomlSource::new(&text, Path::new("s.toml")).parse::<BTreeMap<String, u8>>("See the list.");
        let small = std::thread::Builder::new().stack_size(1 << 20);
        small.spawn(read).unwrap().join().unwrap().unwrap_err().to_string()
    };
    let e = parse(deep(33).replace("{1", "{b = 1"));
    assert!(e.starts_with("s.toml:3:") && e.contains("brackets and braces stand 32 deep at most"), "{e}");
    let e = parse(deep(32).replace("{1", "{b = 1"));
    assert!(e.contains("invalid type: map"), "{e}");
    let told = |text: &str| find_excess_depth(text.as_bytes());
    for string in [r#""\"[[[""#, "'[[['", "\"\"\"\n\"[[[\\\"\"\"\"\"", "'''\n'[[['''", "'' # [[[\n"] {
        assert_eq!(told(&format!("a = [{}]", [string; 20].join(", "))), None, "{string}");
    }
    // What is no string, or is ended by its line, hides nothing; nor does a bracket close a brace.
    for open in ["[", "a'[", "{]", "'\n{", "\"\\\n[", "'''''''['''[", "#\r["] {
        assert!(told(&open.repeat(33)).is_some(), "{open}");
    }
}

#[test]
fn messages_quote_no_more_than_a_page() {
    let long = format!("{} = 1", "ab".repeat(100_000));
    let e = TomlSource::new(&long, Path::new("s.toml")).parse::<Settings>("Help.").unwrap_err().to_string();
    assert!(e.len() < 3000 && e.starts_with("s.toml:1:1: unknown field `abab") && e.contains(" ... "), "{e}");
    let odd = "\u{1f600}".repeat(1000);
    let short = shorten_message(odd.clone());
    assert!(short.len() < 2100 && short.starts_with('\u{1f600}') && short.ends_with('\u{1f600}'));
    assert_eq!(shorten_message("short".into()), "short");
}

#[test]
fn nothing_in_a_name_steers_a_terminal() {
    assert_eq!(
        escape_for_terminal("walk \u{1b}[31m\r\u{7}\u{9b}2J\u{202e}"),
        "walk \\u{1b}[31m\\r\\u{7}\\u{9b}2J\\u{202e}"
    );
    assert_eq!(escape_json_for_terminal("{\"walk \u{7f}\u{9b}2J\u{202e}\": 1}"), r#"{"walk \u007f\u009b2J\u202e": 1}"#);
    for kept in ["", "a\tb\nc", "Gehen \u{e4}\u{1f980} \u{65e5}"] {
        assert!(matches!(escape_for_terminal(kept), Cow::Borrowed(same) if same == kept), "{kept}");
    }
}
