//! Errors between files and tables, in words that name the place and the way out.

use crate::progress::StopRequested;
use std::path::{Path, PathBuf};
pub use throng_base::error::ensure;
use throng_base::text::TomlSource;

/// A file that could not be read as motion.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}. {}", path.display(), way_out(source))]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// A file of settings cannot be read, or has a fault.
    #[error(transparent)]
    Settings(#[from] throng_base::Error),
    /// The text does not follow the format.
    #[error("{}:{line}:{column}: expected {expected}, found {found}. {help}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// Expected text.
        expected: String,
        /// Text that was found.
        found: String,
        /// The way out.
        help: String,
    },
    /// The file reads, but is not motion of a body.
    #[error("{}: {message}. {help}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The fault, naming the joint where there is one.
        message: String,
        /// The way out.
        help: String,
    },
    /// The file was written while it was read.
    #[error("{}: it has changed while it was read. Try again when nobody writes to it", path.display())]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// Reading was stopped.
    #[error(transparent)]
    Stopped(#[from] StopRequested),
}

impl ImportError {
    /// True where the same file may be readable at another time: its contents are not at fault.
    pub fn is_passing(&self) -> bool {
        // POSIX numbers of a fault of the disk, and of too many open files.
        const NUMBERS: [i32; 3] = [5, 23, 24];
        use std::io::ErrorKind::{Interrupted, OutOfMemory, StaleNetworkFileHandle, TimedOut};
        match self {
            Self::Io { source, .. } => {
                matches!(source.kind(), Interrupted | OutOfMemory | StaleNetworkFileHandle | TimedOut)
                    || (cfg!(unix) && source.raw_os_error().is_some_and(|n| NUMBERS.contains(&n)))
            }
            Self::Changed { .. } | Self::Stopped(_) => true,
            _ => false,
        }
    }

    /// The file.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Io { path, .. } | Self::Syntax { path, .. } | Self::Content { path, .. } | Self::Changed { path } => {
                Some(path)
            }
            Self::Settings(throng_base::Error::Io { path, .. } | throng_base::Error::Format { path, .. }) => Some(path),
            Self::Settings(_) | Self::Stopped(_) => None,
        }
    }
}

/// Result of what a build does.
pub type Result<T, E = BuildError> = std::result::Result<T, E>;

/// Reason why a build cannot go on.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// An input file has a fault.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A file cannot be read, or has a fault.
    #[error(transparent)]
    File(#[from] throng_base::Error),
    /// The configuration has a fault.
    #[error("{message}")]
    Config {
        /// File, line and key, what was expected, the way out.
        message: String,
    },
    /// A key of a text that people write has a fault.
    #[error("{key}: {why}")]
    Key {
        /// Path of the key, from the outermost table on, such as `behaviours[2].grid.height`.
        key: String,
        /// Expected and found value, and the way out.
        why: String,
    },
    /// A stage cannot do its work with this input.
    #[error("{stage}: {message}. {help}")]
    Stage {
        /// The stage's name.
        stage: &'static str,
        /// The fault.
        message: String,
        /// The way out.
        help: String,
    },
    /// A file could not be written or read.
    #[error("{}: {source}. {}", path.display(), way_out(source))]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// A store of objects failed, such as a cache on a network.
    #[error("{address}: {why}")]
    Store {
        /// Address of the store.
        address: String,
        /// The fault, and the way out.
        why: String,
    },
    /// The tables could not be opened again.
    #[error("{0}")]
    Format(String),
    /// The build was stopped.
    #[error(transparent)]
    Stopped(#[from] StopRequested),
}

impl BuildError {
    /// A fault of a key.
    pub fn key(key: impl Into<String>, why: impl std::fmt::Display) -> Self {
        Self::Key { key: key.into(), why: why.to_string() }
    }

    /// This error relative to the table or list entry that holds the key, such as `behaviours[2]`.
    #[must_use]
    pub fn within_key(self, outer: &str) -> Self {
        match self {
            Self::Key { key, why } if key.is_empty() => Self::Key { key: outer.into(), why },
            Self::Key { key, why } => Self::Key { key: format!("{outer}.{key}"), why },
            other => other,
        }
    }

    /// This error with line and column of the key in a text.
    #[must_use]
    pub fn with_position(self, source: &TomlSource) -> Self {
        match self {
            Self::Key { key, why } => Self::File(source.error_at_key(&key, format!("{key}: {why}"))),
            other => other,
        }
    }

    /// This error with the place in a file, which is read again for it.
    #[must_use]
    pub fn in_file(self, path: &Path) -> Self {
        match (self, TomlSource::read(path, "a text")) {
            (Self::Key { key, why }, Err(_)) => {
                Self::File(throng_base::Error::Format { path: path.to_path_buf(), why: format!("{key}: {why}") })
            }
            (fault, Ok(source)) => fault.with_position(&source),
            (other, _) => other,
        }
    }
}

/// Checks numbers against their ranges: key, number, least, greatest.
///
/// # Errors
/// [`BuildError::Key`] for the first one that is out of its range, or no number.
pub fn check_ranges<'a, N: Into<f64>>(ranges: impl IntoIterator<Item = (&'a str, N, f64, f64)>) -> Result<()> {
    let numbers = ranges.into_iter().map(|(key, value, low, high)| (key, value.into(), low, high));
    let bad = numbers.into_iter().find(|(_, value, low, high)| !(low..=high).contains(&value));
    let Some((key, value, low, high)) = bad else { return Ok(()) };
    // Numbers of single precision are shown as they are written.
    let single = value as f32;
    let found = if f64::from(single) == value { single.to_string() } else { value.to_string() };
    Err(BuildError::key(key, format!("expected {low} to {high}, found {found}. Correct it or leave it out.")))
}

/// Advice for an error of the system.
fn way_out(source: &std::io::Error) -> &'static str {
    use std::io::ErrorKind::{OutOfMemory, PermissionDenied, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
    match source.kind() {
        StorageFull | QuotaExceeded => "Free some space, or write elsewhere.",
        ReadOnlyFilesystem => "Write to a folder that may be changed.",
        PermissionDenied => "Change its permissions, or choose another place.",
        OutOfMemory => "Free some memory, or give it less to do at once.",
        _ => "Check the path and its permissions.",
    }
}

/// Tolerable faults of the input, collected and reported once.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Warnings {
    /// One sentence each, naming the file.
    pub messages: Vec<String>,
}

impl Warnings {
    /// Adds a sentence.
    pub fn push(&mut self, message: impl Into<String>) {
        self.messages.push(message.into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_gets_its_place_from_the_text() {
        let fault = || {
            check_ranges([("height", f64::from(0.7f32), 1.0, 2.0)]).unwrap_err().within_key("grid").within_key("b[1]")
        };
        let key = "b[1].grid.height: expected 1 to 2, found 0.7. Correct it or leave it out.";
        assert_eq!(fault().to_string(), key);
        let text = "[[b]]\n[[b]]\nname = 'x'\n  grid.height = 0.7\n";
        let source = TomlSource::new(text, Path::new("a.toml"));
        assert_eq!(fault().with_position(&source).to_string(), format!("a.toml:4:8: {key}"));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        assert!(fault().in_file(&path).to_string().ends_with(&format!("a.toml: {key}")));
        std::fs::write(&path, text).unwrap();
        assert!(fault().in_file(&path).to_string().ends_with(&format!("a.toml:4:8: {key}")));
        assert!(check_ranges([("a", f64::NAN, 0.0, 1.0)]).is_err() && check_ranges([("a", 1.0, 0.0, 1.0)]).is_ok());
    }
}
