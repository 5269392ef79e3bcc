//! Errors of files that are no bundles this code can use.

use super::SectionTag;
use std::path::PathBuf;

/// Remedy of every fault, for messages.
const AGAIN: &str =
    "Make it again with `throng build` (a bundle), `throng stitch` (a world) or `throng level` (a level).";

/// Reason why a file was refused. Every message ends with a remedy.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum FormatError {
    /// The file could not be opened, read or mapped.
    #[error("{}: cannot be opened: {source}. Check the path, or make the file with `throng build` (a bundle), `throng stitch` (a world) or `throng level` (a level).", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Not a regular file, or one that is far too long.
    #[error("the file {why}")]
    File {
        /// Kind of the file, and the kind that was expected.
        why: String,
    },
    /// The file is shorter than the header or not the length the header gives.
    #[error("the file is {got} bytes long, expected {expected}: it is cut short or has been added to. {AGAIN}")]
    Length {
        /// Length it should have (bytes).
        expected: u64,
        /// Length it has (bytes).
        got: u64,
    },
    /// The first bytes are not a bundle's.
    #[error("this is not a Throng {what}: it begins with {got:02x?}. {AGAIN}")]
    Magic {
        /// Expected kind of file.
        what: &'static str,
        /// First bytes of the file.
        got: [u8; 8],
    },
    /// Written by another version.
    #[error("the {what} has format version {got}, this program reads version {expected}. {AGAIN}")]
    Version {
        /// Kind of the file.
        what: &'static str,
        /// The version that is read.
        expected: u32,
        /// Version of the file.
        got: u32,
    },
    /// A checksum differs.
    #[error("{what} has checksum {got:08x}, expected {expected:08x}: the file is damaged. Copy it anew. {AGAIN}")]
    Checksum {
        /// The header, the section table or a section.
        what: String,
        /// Stored checksum.
        expected: u32,
        /// Checksum of the bytes.
        got: u32,
    },
    /// A section lies outside of the file or is misaligned.
    #[error("section {tag} at {offset} with {byte_len} bytes does not fit a file of {file_len} bytes. {AGAIN}")]
    Section {
        /// The section.
        tag: SectionTag,
        /// Start of the section (bytes).
        offset: u64,
        /// Length of the section (bytes).
        byte_len: u64,
        /// Length of the file (bytes).
        file_len: u64,
    },
    /// A section is absent.
    #[error("section {tag} is missing. {AGAIN}")]
    Missing {
        /// The section.
        tag: SectionTag,
    },
    /// The file's layout breaks a rule (order, overlap, padding, duplicates).
    #[error("{message}. {AGAIN}")]
    Layout {
        /// Broken rule and its place.
        message: String,
    },
    /// A record holds a value that cannot be: an index past its table, a number that is not finite.
    #[error("section {tag}, element {index}: {message}. {AGAIN}")]
    Value {
        /// The section.
        tag: SectionTag,
        /// The element.
        index: usize,
        /// Defect of the value.
        message: String,
    },
}

impl FormatError {
    /// [`FormatError::Value`].
    pub fn value(tag: SectionTag, index: usize, message: impl Into<String>) -> Self {
        Self::Value { tag, index, message: message.into() }
    }

    /// [`FormatError::Layout`].
    pub fn layout(message: impl Into<String>) -> Self {
        Self::Layout { message: message.into() }
    }
}
