//! Promise: an application reaches few types through `throng-runtime`, and each is named in its source.

use super::workspace::code;
use std::collections::BTreeSet;

/// Types that can be reached, hidden ones included.
const MOST_TYPES: usize = 80;
/// Names that begin with a small letter: the one foreign crate, and functions. Another would be a module of any size.
const NO_TYPES: [&str; 2] = ["glam", "scatter_rest_nodes"];

/// Types that a source text names to its users, or why they cannot be counted.
fn types(text: &str) -> Result<BTreeSet<String>, String> {
    let code = code(text);
    let mut found = BTreeSet::new();
    for item in code.split("pub ").skip(1) {
        let (kind, rest) = item.split_once(char::is_whitespace).unwrap_or((item, ""));
        match kind {
            "use" => {
                for name in leaves(rest.split(';').next().unwrap_or(rest))? {
                    let is_constant = name.len() > 1 && !name.contains(char::is_lowercase);
                    if name.starts_with(char::is_lowercase) && !NO_TYPES.contains(&name.as_str()) {
                        return Err(format!("{name} may be a module, whose types are not listed"));
                    }
                    if name.starts_with(char::is_uppercase) && !is_constant {
                        found.insert(name);
                    }
                }
            }
            "mod" if rest.split(['{', ';']).count() > 1 && !rest.split(';').next().is_some_and(|r| r.contains('{')) => {
                return Err(format!("{} is a file, whose types are not listed", rest.trim()));
            }
            "struct" | "enum" | "trait" | "type" | "union" => {
                found.extend(rest.split(|c: char| !c.is_alphanumeric()).next().map(str::to_owned));
            }
            _ => {}
        }
    }
    Ok(found)
}

/// Names at the end of a tree of `use`; a renamed one by its new name.
fn leaves(tree: &str) -> Result<Vec<String>, String> {
    let leaves = tree.split(['{', '}', ',']).map(str::trim).filter(|part| !part.is_empty() && !part.ends_with("::"));
    leaves
        .map(|path| match path.rsplit("::").next().map(str::trim) {
            Some("*") => Err(format!("{path} has no end")),
            Some("self") => Err(format!("{tree} is a module, whose types are not listed")),
            Some(name) => Ok(name.rsplit(" as ").next().unwrap_or(name).trim().to_owned()),
            None => Err(format!("{path} names nothing")),
        })
        .collect()
}

/// The source of the facade.
fn facade() -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("runtime/src/lib.rs");
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[test]
fn an_application_reaches_at_most_eighty_types() {
    let found = types(&facade()).unwrap_or_else(|why| panic!("list what applications need, name by name: {why}"));
    assert!(
        found.len() <= MOST_TYPES,
        "{} types, at most {MOST_TYPES}; the house's own crates need no facade",
        found.len()
    );
    assert!(found.len() > 50 && found.contains("PolicyCharacters"), "the list was read: {found:?}");
}

#[test]
fn names_that_hide_others_are_refused() {
    for hiding in [
        "pub use throng_crowd::*;",
        "#[doc(hidden)]\npub use throng_core::{Bundle, graph::*};",
        "pub use throng_crowd as crowd;",
        "pub use throng_core::{self as core, Bundle};",
        "pub use throng_core::{policy, Bundle};",
        "pub mod hidden {\n    pub use throng_world::inhabitants;\n}",
        "pub mod elsewhere;",
    ] {
        let with = format!("{hiding}\n{}", facade());
        assert!(types(&with).is_err(), "{hiding} was counted: {:?}", types(&with));
    }
    let counted = types(&facade()).expect("the facade is a list").len();
    for one in
        ["pub use throng_core::policy::GridRecord;", "#[doc(hidden)]\npub struct Extra(u32);", "pub type Bare = u32;"]
    {
        assert_eq!(types(&format!("{one}\n{}", facade())).map(|t| t.len()), Ok(counted + 1), "{one}");
    }
}
