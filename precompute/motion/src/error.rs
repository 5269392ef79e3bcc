//! What can go wrong between files and tables, in words that name the place and the way out.

use std::path::PathBuf;

/// A file that could not be read as motion.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}. {}", path.display(), way_out(source))]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file of settings that cannot be read, or says something wrong.
    #[error(transparent)]
    Settings(#[from] throng_base::Error),
    /// The text is not what the format asks for.
    #[error("{}:{line}:{column}: expected {expected}, found {found}. {help}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// What should stand there.
        expected: String,
        /// What stands there.
        found: String,
        /// The way out.
        help: String,
    },
    /// The file reads, but is not motion of a body.
    #[error("{}: {message}. {help}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong, naming the joint where there is one.
        message: String,
        /// The way out.
        help: String,
    },
}

/// A build that cannot go on.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// A file of the input.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A file that cannot be read, or says something wrong.
    #[error(transparent)]
    File(#[from] throng_base::Error),
    /// The configuration.
    #[error("{message}")]
    Config {
        /// File, line and key, what was expected, the way out.
        message: String,
    },
    /// A stage cannot do its work with this input.
    #[error("{stage}: {message}. {help}")]
    Stage {
        /// The stage's name.
        stage: &'static str,
        /// What is wrong.
        message: String,
        /// The way out.
        help: String,
    },
    /// A file could not be written or read.
    #[error("{}: {source}. {}", path.display(), way_out(source))]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The tables could not be opened again.
    #[error("{0}")]
    Format(String),
}

/// What to do about what the system says.
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
