//! TOML files that people write: every fault names file, line and column, and for an unknown name the nearest known one.

mod value;

use crate::file::{MAX_TEXT_BYTES, read_file};
use crate::{Error, Result};
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use std::{borrow::Cow, ops::Range};
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use value::{SpannedValue, TomlFault};

/// Deepest nesting of brackets and braces in a text.
const MOST_DEPTH: usize = 32;

/// Most bytes of a message about a text, which may quote any part of it.
const MAX_MESSAGE_BYTES: usize = 2000;

/// Message about a text, with `...` in place of the middle of a long one.
pub fn shorten_message(said: String) -> String {
    if said.len() <= MAX_MESSAGE_BYTES {
        return said;
    }
    let half = MAX_MESSAGE_BYTES / 2;
    let (begin, end) = (said.floor_char_boundary(half), said.ceil_char_boundary(said.len() - half));
    format!("{} ... {}", &said[..begin], &said[end..])
}

/// Text for a terminal, with control characters, which may stand in names of foreign files, replaced by their codes (`\u{1b}`).
pub fn escape_for_terminal(text: &str) -> Cow<'_, str> {
    escape_controls(text, |c| c.escape_default().to_string())
}

/// JSON for a terminal, with control characters replaced by escapes of JSON (`\u007f`), so that its meaning stays.
pub fn escape_json_for_terminal(json: &str) -> Cow<'_, str> {
    escape_controls(json, |c| format!("\\u{:04x}", u32::from(c)))
}

/// Text with codes in place of marks of writing direction and of control characters other than line ends and tabs.
fn escape_controls(text: &str, code: impl Fn(char) -> String) -> Cow<'_, str> {
    let steers = |c: char| match c {
        '\n' | '\t' => false,
        '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => true,
        c => c.is_control(),
    };
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.chars().map(|c| if steers(c) { code(c) } else { c.to_string() }).collect())
}

/// TOML text with the path of its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TomlSource {
    path: PathBuf,
    text: String,
}

impl TomlSource {
    /// Reads a file; `what` is what it holds, with its article, for messages ("a scene").
    ///
    /// # Errors
    /// As [`read_file`]; [`Error::Text`] at the first byte that is not UTF-8.
    pub fn read(path: &Path, what: &str) -> Result<Self> {
        String::from_utf8(read_file(path, what, MAX_TEXT_BYTES)?).map(|text| Self::new(&text, path)).map_err(|e| {
            let good = e.utf8_error().valid_up_to();
            let read = Self::new(&String::from_utf8_lossy(&e.as_bytes()[..good]), path);
            read.error_at_span(good..good, format!("expected {what} as TOML in UTF-8, found other bytes"))
        })
    }

    /// Source with a given text; messages name it `path`.
    pub fn new(text: &str, path: &Path) -> Self {
        Self { path: path.to_path_buf(), text: text.into() }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Parses the text into a struct; `help` ends messages that name no nearest key.
    ///
    /// # Errors
    /// [`Error::Text`].
    pub fn parse<T: DeserializeOwned>(&self, help: &str) -> Result<T> {
        self.parse_table()
            .and_then(|table| {
                let span = table.span();
                T::deserialize(SpannedValue { value: &DeValue::Table(table.into_inner()), span })
            })
            .map_err(|TomlFault { why, span }| {
                let way_out = nearest_key(&why).map_or_else(|| help.into(), |name| format!("Did you mean `{name}`?"));
                let why = format!("{}. {way_out}", why.trim_end().trim_end_matches('.'));
                self.error_at_span(span.unwrap_or(0..0), why)
            })
    }

    /// Error at a range of bytes of the text.
    pub fn error_at_span(&self, span: Range<usize>, why: String) -> Error {
        let before = self.text.get(..span.start).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
        Error::Text { path: self.path.clone(), line, column, why: shorten_message(why) }
    }

    /// Error at a key such as `groups[0].place`, or at the last part of the key that the text has.
    pub fn error_at_key(&self, key: &str, why: String) -> Error {
        let span = self.table().and_then(|t| find_key_span(&t, key)).unwrap_or(0..0);
        self.error_at_span(span, why)
    }

    /// Error at a byte of a key's value, such as an expression in quotes; as [`TomlSource::error_at_key`] where the text lacks the key.
    pub fn error_within_value(&self, key: &str, byte: usize, why: String) -> Error {
        let Some(table) = self.table() else { return self.error_at_span(0..0, why) };
        match find_value_span(&table, key) {
            Some(span) => self.error_at_span(span.start + 1 + byte..span.end, why),
            None => self.error_at_key(key, why),
        }
    }

    /// Bytes of the value of a key such as `groups[0].place[1]`; `None` where it is not in the text.
    pub fn value_span(&self, key: &str) -> Option<Range<usize>> {
        find_value_span(&self.table()?, key)
    }

    /// Bytes of the name of a key such as `groups[0].place[1]`; `None` where it is not in the text.
    pub fn key_span(&self, key: &str) -> Option<Range<usize>> {
        self.value_span(key)?;
        find_key_span(&self.table()?, key)
    }

    /// The text as a table; `None` where it is none.
    pub fn table(&self) -> Option<DeTable<'_>> {
        Some(self.parse_table().ok()?.into_inner())
    }

    fn parse_table(&self) -> Result<Spanned<DeTable<'_>>, TomlFault> {
        if let Some(at) = find_excess_depth(self.text.as_bytes()) {
            let why = format!("brackets and braces stand {MOST_DEPTH} deep at most, here is one more");
            return Err(TomlFault { why, span: Some(at..at) });
        }
        DeTable::parse(&self.text).map_err(|e| TomlFault { why: e.message().into(), span: e.span() })
    }
}

/// Byte of the first bracket or brace that is nested too deeply for a recursive reader.
fn find_excess_depth(text: &[u8]) -> Option<usize> {
    let (mut at, mut open) = (0, Vec::new());
    while let Some(&byte) = text.get(at) {
        match byte {
            b'[' | b'{' if open.len() == MOST_DEPTH => return Some(at),
            b'[' | b'{' => open.push(byte),
            b']' | b'}' if open.last() == Some(&if byte == b']' { b'[' } else { b'{' }) => _ = open.pop(),
            _ => {}
        }
        at += token_length(&text[at..]);
    }
    None
}

/// Length of the token that begins a text, as the parser splits texts (bytes).
fn token_length(text: &[u8]) -> usize {
    let until = |ends: &[u8]| text.iter().position(|b| ends.contains(b)).unwrap_or(text.len());
    match text[0] {
        b'#' => until(b"\r\n"),
        b'"' | b'\'' => string_length(text),
        _ => until(b".=,[]{} \t#\r\n").max(1),
    }
}

/// Length of the string literal that begins a text (bytes).
fn string_length(text: &[u8]) -> usize {
    let (quote, is_long) = (text[0], text.starts_with(&[text[0]; 3]));
    let end = &text[..if is_long { 3 } else { 1 }];
    let mut at = end.len();
    while at < text.len() && !text[at..].starts_with(end) {
        if !is_long && text[at] == b'\n' {
            return at;
        }
        let escapes = quote == b'"' && text[at] == b'\\' && matches!(text.get(at + 1), Some(b'"' | b'\\'));
        at += 1 + usize::from(escapes);
    }
    at = (at + end.len()).min(text.len());
    // Two quotes may stand before those that end a long one.
    at + text[at..].iter().take(if is_long { 2 } else { 0 }).take_while(|&&b| b == quote).count()
}

/// Name, value, and the part of a key after the name.
type Entry<'t, 'k, 'a> = (&'t Spanned<Cow<'a, str>>, &'t Spanned<DeValue<'a>>, &'k str);

/// Entry of a table that a key begins with, and the part of the key after its name. Names in quotes may have dots: the
/// longest one that fits is taken.
fn find_entry<'t, 'k, 'a>(table: &'t DeTable<'a>, key: &'k str) -> Option<Entry<'t, 'k, 'a>> {
    let fits = table.iter().filter_map(|(name, value)| {
        let more = key.strip_prefix(name.get_ref().as_ref())?;
        (more.is_empty() || more.starts_with(['.', '['])).then_some((name, value, more))
    });
    fits.min_by_key(|(.., more)| more.len())
}

/// Bytes of a key, or of the last part of it that exists.
fn find_key_span(table: &DeTable<'_>, key: &str) -> Option<Range<usize>> {
    let (at, value, more) = find_entry(table, key)?;
    let (first, rest) = more.split_once('.').unwrap_or((more, ""));
    let index = first.trim_start_matches('[');
    let (mut span, mut value) = (at.span(), value);
    if let (Ok(index), DeValue::Array(items)) = (index.trim_end_matches(']').parse::<usize>(), value.get_ref())
        && let Some(item) = items.get(index)
    {
        (span, value) = (item.span(), item);
    }
    match value.get_ref() {
        DeValue::Table(inner) if !rest.is_empty() => Some(find_key_span(inner, rest).unwrap_or(span)),
        _ => Some(span),
    }
}

/// Bytes of the value of a key, if the whole key exists.
fn find_value_span(table: &DeTable<'_>, key: &str) -> Option<Range<usize>> {
    let (_, mut value, more) = find_entry(table, key)?;
    let (first, rest) = more.split_once('.').unwrap_or((more, ""));
    for index in first.split('[').skip(1) {
        let DeValue::Array(items) = value.get_ref() else { return None };
        value = items.get(index.trim_end_matches(']').parse::<usize>().ok()?)?;
    }
    match value.get_ref() {
        DeValue::Table(inner) if !rest.is_empty() => self::find_value_span(inner, rest),
        _ if rest.is_empty() => Some(value.span()),
        _ => None,
    }
}

/// Known key most like the unknown one of a message such as "unknown field `a`, expected one of `b`, `c`".
fn nearest_key(message: &str) -> Option<&str> {
    let mut quoted = message.strip_prefix("unknown ")?.split('`').skip(1).step_by(2);
    nearest_name(quoted.next()?, quoted)
}

/// Known name most like a word (Jaro and Winkler); `None` where none is similar.
fn nearest_name<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Comparing takes as many steps as the product of their lengths.
    const LONGEST: usize = 200;
    let likeness = known
        .into_iter()
        .filter(|name| word.len().max(name.len()) <= LONGEST)
        .map(|name| (strsim::jaro_winkler(word, name), name));
    likeness.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|&(likeness, _)| likeness > 0.75).map(|(_, name)| name)
}

/// Hint " Did you mean `NAME`?" for the end of a message about an unknown word; empty where no known name is similar.
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest_name(word, known).map_or_else(String::new, |name| format!(" Did you mean `{name}`?"))
}

#[cfg(test)]
mod tests;
