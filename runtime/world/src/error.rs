//! Why a file is not a world this code can use.

use throng_core::format::{FormatError, Tag};

/// Why a world was refused. Every message ends with the way out.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The file's frame is not that of a world: it cannot be opened, is cut short, damaged or of another version.
    #[error(transparent)]
    Frame(#[from] FormatError),
    /// The parts of the world do not go together.
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
        /// Content hash of the bundle it was stitched with.
        expected: u128,
        /// Content hash of the bundle that was given.
        got: u128,
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
