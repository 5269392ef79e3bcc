//! Where in a file something stands, for messages.

use std::ops::Range;
use std::path::{Path, PathBuf};
use throng_base::{Error, Result};
use toml::de::{DeTable, DeValue};

const HELP: &str = "`throng schema --of scene` lists all keys, and data/scenes/ has examples";

/// The text of a scene file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Source {
    path: PathBuf,
    text: String,
}

/// The text of bytes in UTF-8.
///
/// # Errors
/// [`Error::Text`] at the first byte of anything else.
pub(super) fn utf8(bytes: Vec<u8>, path: &Path) -> Result<String> {
    String::from_utf8(bytes).map_err(|e| {
        let good = String::from_utf8_lossy(&e.as_bytes()[..e.utf8_error().valid_up_to()]).into_owned();
        let end = good.len();
        Source::new(&good, path).error(end..end, "expected a scene as TOML in UTF-8, found other bytes".into())
    })
}

impl Source {
    pub fn new(text: &str, path: &Path) -> Self {
        Self { path: path.to_path_buf(), text: text.into() }
    }

    /// An error at bytes of the text.
    pub fn error(&self, span: Range<usize>, why: String) -> Error {
        let before = self.text.get(..span.start).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
        Error::Text { path: self.path.clone(), line, column, why }
    }

    /// An error at a key such as `groups[0].place`, or at the last part of it that stands in the text.
    pub fn at(&self, key: &str, why: String) -> Error {
        let span = self.table().and_then(|t| find(&t, key)).unwrap_or(0..0);
        self.error(span, why)
    }

    /// What the reader of TOML found wrong; for an unknown key with the nearest known one.
    pub fn explain(&self, e: &toml::de::Error) -> Error {
        let (message, span) = (e.message(), e.span().unwrap_or(0..0));
        let help = nearest_key(message).map_or(HELP.into(), |known| format!("did you mean `{known}`?"));
        self.error(span, format!("{message}; {help}"))
    }

    /// The text as a table; `None` where it is none.
    pub fn table(&self) -> Option<DeTable<'_>> {
        Some(DeTable::parse(&self.text).ok()?.into_inner())
    }
}

/// Bytes of a key, or of the last part of it that is there.
fn find(table: &DeTable<'_>, key: &str) -> Option<Range<usize>> {
    let (first, rest) = key.split_once('.').unwrap_or((key, ""));
    let (name, index) = first.split_once('[').unwrap_or((first, ""));
    let (at, value) = table.iter().find(|(k, _)| k.get_ref() == name)?;
    let (mut span, mut value) = (at.span(), value);
    if let (Ok(index), DeValue::Array(items)) = (index.trim_end_matches(']').parse::<usize>(), value.get_ref())
        && let Some(item) = items.get(index)
    {
        (span, value) = (item.span(), item);
    }
    match value.get_ref() {
        DeValue::Table(inner) if !rest.is_empty() => Some(find(inner, rest).unwrap_or(span)),
        _ => Some(span),
    }
}

/// The key that a message such as "unknown field `a`, expected one of `b`, `c`" most likely meant.
fn nearest_key(message: &str) -> Option<&str> {
    let mut quoted = message.strip_prefix("unknown ")?.split('`').skip(1).step_by(2);
    let unknown = quoted.next()?;
    let nearest = quoted.min_by_key(|known| distance(unknown, known))?;
    (2 * distance(unknown, nearest) <= unknown.len()).then_some(nearest)
}

/// Letters to be inserted, removed or changed (Levenshtein 1966).
fn distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.bytes().enumerate() {
        let mut before = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.bytes().enumerate() {
            let change = before + usize::from(x != y);
            before = row[j + 1];
            row[j + 1] = change.min(before + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
