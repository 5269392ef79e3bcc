//! Errors before anything is drawn.

/// Result of drawing.
pub type Result<T, E = RenderError> = std::result::Result<T, E>;

/// Why a scene cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The device cannot read a storage buffer in a vertex shader.
    #[error(
        "this graphics device offers {available} storage buffers per shader stage, 3 are needed: choose another adapter or backend (WGPU_BACKEND=vulkan)"
    )]
    NoStorageBuffers {
        /// Number that the device offers.
        available: u32,
    },
    /// One kind of data exceeds the limit of the device.
    #[error(
        "{count} {what} take {needed} bytes, this graphics device binds {limit} at most: show fewer than {most} of them"
    )]
    TooMany {
        /// Name of the data.
        what: &'static str,
        /// Requested number.
        count: usize,
        /// (bytes)
        needed: u64,
        /// (bytes)
        limit: u64,
        /// Largest number that fits.
        most: u64,
    },
    /// The palette does not hold one pose per character.
    #[error("{characters} characters need {expected} joint matrices, got {got}: pass num_joints matrices for each")]
    PaletteLength {
        /// Number of characters.
        characters: usize,
        /// Matrices needed.
        expected: usize,
        /// Matrices passed.
        got: usize,
    },
    /// A record names a frame row that does not exist.
    #[error("a record names frame row {row}, there are {rows}: pass the poses of all rows of its bundle")]
    Rows {
        /// Which.
        row: u32,
        /// Number of rows.
        rows: usize,
    },
    /// The picture could not be copied back from the device.
    #[error("the picture could not be read back from the graphics device: {0}")]
    ReadBack(String),
}
