//! TOML files that people write: faults name file, line and column, and for an unknown key the nearest known one.

use crate::error::BuildError;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Reads a file's text; `what` is what it holds, for messages.
///
/// # Errors
/// [`BuildError::Io`], or [`BuildError::Config`] with file and line for bytes that are not UTF-8.
pub fn read_text(path: &Path, what: &str) -> Result<String, BuildError> {
    let bytes = std::fs::read(path).map_err(|source| BuildError::Io { path: path.to_path_buf(), source })?;
    String::from_utf8(bytes).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count() + 1;
        let place = path.display();
        BuildError::Config { message: format!("{place}:{line}: expected a {what} as TOML in UTF-8, found other bytes") }
    })
}

/// Reads a file's text as the struct it stands for.
///
/// - `path`: for messages alone.
/// - `help`: what a message ends with where no known key is near an unknown one.
///
/// # Errors
/// [`BuildError::Config`] with file, line and column.
pub fn parse<T: DeserializeOwned>(text: &str, path: &Path, help: &str) -> Result<T, BuildError> {
    toml::from_str(text).map_err(|error| {
        let before = error.span().and_then(|s| text.get(..s.start)).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
        let message = error.message();
        let place = format!("{}:{line}:{column}: {message}", path.display());
        let message = match nearest_key(message) {
            Some(known) => format!("{place}. Did you mean `{known}`?"),
            None => format!("{place}. {help}"),
        };
        BuildError::Config { message }
    })
}

/// The key a message such as "unknown field `a`, expected one of `b`, `c`" most likely meant.
fn nearest_key(message: &str) -> Option<&str> {
    let mut quoted = message.strip_prefix("unknown ")?.split('`').skip(1).step_by(2);
    nearest(quoted.next()?, quoted)
}

/// The known name that is most like a word, for messages; none where nothing is known.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known.into_iter().max_by(|a, b| strsim::jaro_winkler(word, a).total_cmp(&strsim::jaro_winkler(word, b)))
}
