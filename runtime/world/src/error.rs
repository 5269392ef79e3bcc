//! Errors of files that are no worlds this code can use.

use throng_core::format::FormatError;

/// Reason why a world was refused. Every message ends with a remedy.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The file cannot be opened, is damaged or of another version, or its parts do not fit together.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The world was stitched with another bundle.
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
}
