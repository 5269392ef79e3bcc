//! The bytes under a bundle: a mapped file, or memory of the same alignment. The only `unsafe` outside of
//! hot kernels lives here.
#![allow(unsafe_code)]

use super::FormatError;
use std::{fs::File, path::Path};

#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct Line([u8; 64]);

/// Bytes in memory that start on 64, as a mapped file does.
#[derive(Clone, Debug, Default)]
pub struct AlignedBytes {
    lines: Vec<Line>,
    len: usize,
}

impl AlignedBytes {
    /// A copy of `bytes`.
    pub fn from_slice(bytes: &[u8]) -> Self {
        let mut lines = vec![Line([0; 64]); bytes.len().div_ceil(64)];
        bytemuck::cast_slice_mut::<Line, u8>(&mut lines)[..bytes.len()].copy_from_slice(bytes);
        Self { lines, len: bytes.len() }
    }

    /// The bytes.
    pub fn as_slice(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.lines)[..self.len]
    }
}

/// The bytes of a file, mapped or in memory.
#[derive(Debug)]
pub enum Storage {
    /// A map of the file.
    Mapped(memmap2::Mmap),
    /// Bytes that were read or made.
    Memory(AlignedBytes),
}

impl Storage {
    /// Maps a file.
    ///
    /// # Errors
    /// [`FormatError::Io`] where it cannot be read, [`FormatError::Length`] for an empty one.
    pub fn map(path: &Path) -> Result<Self, FormatError> {
        let io = |source| FormatError::Io { path: path.to_path_buf(), source };
        let file = File::open(path).map_err(io)?;
        let len = file.metadata().map_err(io)?.len();
        if len == 0 {
            return Err(FormatError::Length { expected: 64, got: 0 });
        }
        // SAFETY: the map is read-only and private to this process. A file that another process cuts short while
        // it is mapped makes reads fault; bundles are replaced by renaming, which leaves the mapped one whole.
        let map = unsafe { memmap2::Mmap::map(&file) }.map_err(io)?;
        Ok(Self::Mapped(map))
    }

    /// All bytes.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Mapped(m) => m,
            Self::Memory(m) => m.as_slice(),
        }
    }
}
