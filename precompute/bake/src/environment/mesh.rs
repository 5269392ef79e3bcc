//! Triangles of glTF files, and their external buffer files.

use std::path::{Path, PathBuf};
use throng_base::file::read_file;
pub(super) use throng_motion::import::gltf::{MAX_TRIANGLES, triangles as read};
use throng_motion::{Result, import::gltf};

/// Buffer files of a `.gltf` file, for messages and provenance.
///
/// # Errors
/// As [`read`].
pub(crate) fn buffer_files(path: &Path) -> Result<Vec<PathBuf>> {
    Ok(gltf::buffer_files(&read_file(path, "a mesh", gltf::MAX_BYTES)?, path)?)
}

#[cfg(test)]
mod tests;
