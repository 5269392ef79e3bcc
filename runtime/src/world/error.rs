//! Why a file is not a world this code can use.

use super::file::WORLD_VERSION;
use crate::format::{FormatError, Tag};

/// Why a world was refused. Every message ends with the way out.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The file's frame is not that of a world: it cannot be opened, is cut short, damaged or of another version.
    #[error("{message}. Stitch the world again with `throng stitch`.")]
    Layout {
        /// What is wrong.
        message: String,
    },
    /// It was stitched with another bundle.
    #[error(
        "the world `{world}` was stitched with another build of the bundle `{bundle}`, this one is `{given}`: patches, cells and links do not fit. Stitch the world again with `throng stitch`, or give the bundle it was stitched with."
    )]
    OtherBundle {
        /// Name of the world.
        world: String,
        /// Name of the bundle it was stitched with.
        bundle: String,
        /// Name of the bundle that was given.
        given: String,
    },
    /// A record holds a value that cannot be: an index past its table, a number that is not finite.
    #[error("section {tag}, element {index}: {message}. Stitch the world again with `throng stitch`.")]
    Value {
        /// The section.
        tag: Tag,
        /// The element.
        index: usize,
        /// What is wrong.
        message: String,
    },
}

impl WorldError {
    pub(super) fn value(tag: Tag, index: usize, message: impl Into<String>) -> Self {
        Self::Value { tag, index, message: message.into() }
    }

    pub(super) fn layout(message: impl Into<String>) -> Self {
        Self::Layout { message: message.into() }
    }
}

/// The same fault in a world file: what the frame of a bundle says of itself, with the way out of a world.
impl From<FormatError> for WorldError {
    fn from(e: FormatError) -> Self {
        match e {
            FormatError::Value { tag, index, message } => Self::Value { tag, index, message },
            FormatError::Layout { message } => Self::Layout { message },
            FormatError::Io { path, source } => Self::layout(format!("{}: cannot be opened: {source}", path.display())),
            FormatError::Length { expected, got } => Self::layout(format!(
                "the file is {got} bytes long, expected {expected}: it is cut short or has been added to"
            )),
            FormatError::Magic { got } => {
                Self::layout(format!("this is not the file of a Throng world: it begins with {got:02x?}"))
            }
            FormatError::Version { got } => {
                Self::layout(format!("the world has format version {got}, this program reads version {WORLD_VERSION}"))
            }
            FormatError::Checksum { what, expected, got } => {
                Self::layout(format!("{what} has checksum {got:08x}, expected {expected:08x}: the file is damaged"))
            }
            FormatError::Section { tag, offset, byte_len, file_len } => Self::layout(format!(
                "section {tag} at {offset} with {byte_len} bytes does not fit a file of {file_len} bytes"
            )),
            FormatError::Missing { tag } => Self::layout(format!("section {tag} is missing")),
        }
    }
}
