//! Why a file is not a bundle this code can use.

use super::{Tag, VERSION};
use std::path::PathBuf;

/// Why a bundle was refused. Every message ends with the way out.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum FormatError {
    /// The file could not be opened or mapped.
    #[error("{}: cannot be opened: {source}. Check the path, or make a bundle with `throng build CONFIG --out FILE`.", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is shorter than the header or not the length the header gives.
    #[error(
        "the file is {got} bytes long, expected {expected}: it is cut short or has been added to. Build it again with `throng build`."
    )]
    Length {
        /// Length it should have. [Unit: bytes]
        expected: u64,
        /// Length it has. [Unit: bytes]
        got: u64,
    },
    /// The first bytes are not a bundle's.
    #[error("this is not a Throng bundle: it begins with {got:02x?}. Give the file that `throng build --out` wrote.")]
    Magic {
        /// What was found.
        got: [u8; 8],
    },
    /// Written by another version.
    #[error(
        "the bundle has format version {got}, this program reads version {VERSION}. Build it again from its config with `throng build`."
    )]
    Version {
        /// What was found.
        got: u32,
    },
    /// A checksum differs.
    #[error(
        "{what} has checksum {got:08x}, expected {expected:08x}: the file is damaged. Copy it anew or build it again with `throng build`."
    )]
    Checksum {
        /// The header, the section table or a section.
        what: String,
        /// Stored checksum.
        expected: u32,
        /// Checksum of the bytes.
        got: u32,
    },
    /// A section lies outside of the file or is misaligned.
    #[error(
        "section {tag} at {offset} with {byte_len} bytes does not fit a file of {file_len} bytes. Build the bundle again with `throng build`."
    )]
    Section {
        /// The section.
        tag: Tag,
        /// Its start. [Unit: bytes]
        offset: u64,
        /// Its length. [Unit: bytes]
        byte_len: u64,
        /// Length of the file. [Unit: bytes]
        file_len: u64,
    },
    /// A section is absent.
    #[error("section {tag} is missing. Build the bundle again with `throng build`.")]
    Missing {
        /// The section.
        tag: Tag,
    },
    /// The file's layout breaks a rule (order, overlap, padding, duplicates).
    #[error("{message}. Build the bundle again with `throng build`.")]
    Layout {
        /// What is wrong and where.
        message: String,
    },
    /// A record holds a value that cannot be: an index past its table, a number that is not finite.
    #[error("section {tag}, element {index}: {message}. Build the bundle again with `throng build`.")]
    Value {
        /// The section.
        tag: Tag,
        /// The element.
        index: usize,
        /// What is wrong.
        message: String,
    },
}

impl FormatError {
    pub(crate) fn value(tag: Tag, index: usize, message: impl Into<String>) -> Self {
        Self::Value { tag, index, message: message.into() }
    }

    pub(crate) fn layout(message: impl Into<String>) -> Self {
        Self::Layout { message: message.into() }
    }
}
