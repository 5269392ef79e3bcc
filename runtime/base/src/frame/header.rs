//! The fixed head of a bundle and the rows of its section table.

use super::FormatError;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// First bytes of every bundle.
pub const MAGIC: [u8; 8] = *b"\x89THRONG\n";
/// The version this code writes and reads.
pub const VERSION: u32 = 8;

/// Kind of a file that has the frame of a bundle.
#[derive(Clone, Copy, Debug)]
pub struct FileKind {
    /// Name of the kind in messages.
    pub what: &'static str,
    /// First bytes.
    pub magic: [u8; 8],
    /// The version that is read and written.
    pub version: u32,
}

impl FileKind {
    /// A bundle.
    pub const BUNDLE: Self = Self { what: "bundle", magic: MAGIC, version: VERSION };
}

/// Sections start on multiples of this (bytes).
pub const ALIGN: u64 = 64;

/// Four ASCII letters that say what a section holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct SectionTag(pub [u8; 4]);

impl std::fmt::Display for SectionTag {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0.escape_ascii())
    }
}

/// Fixed 64-byte file header, little-endian. Versions of bundles: `format` of `throng-core`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct FileHeader {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// [`VERSION`].
    pub version: u32,
    /// Rows in the section table, which follows the header.
    pub num_sections: u32,
    /// Length of the file (bytes).
    pub file_len: u64,
    /// CRC-32 of the section table.
    pub table_crc32: u32,
    /// CRC-32 of this header with this field zero.
    pub header_crc32: u32,
    /// Zero.
    pub reserved: [u8; 32],
}

const _: () = assert!(size_of::<FileHeader>() == 64);

impl FileHeader {
    /// The checksum of this header's bytes with `header_crc32` taken as zero.
    pub fn checksum(mut self) -> u32 {
        self.header_crc32 = 0;
        super::crc32(bytemuck::bytes_of(&self))
    }
}

/// Row of the section table.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SectionEntry {
    /// Tag of the section's content.
    pub tag: SectionTag,
    /// Size of one element (bytes, > 0).
    pub elem_size: u32,
    /// Start from the beginning of the file, a multiple of [`ALIGN`] (bytes).
    pub offset: u64,
    /// Number of elements.
    pub count: u64,
    /// CRC-32 of the section's bytes.
    pub crc32: u32,
    /// Zero.
    pub reserved: u32,
}

const _: () = assert!(size_of::<SectionEntry>() == 32);

impl SectionEntry {
    /// Byte range of this section, or why it cannot be one.
    ///
    /// # Errors
    /// [`FormatError::Section`] where it is misaligned or reaches past the end of the file.
    pub fn range(&self, file_len: u64) -> Result<Range<usize>, FormatError> {
        let byte_len = self.count.saturating_mul(self.elem_size.into());
        match self.offset.checked_add(byte_len) {
            Some(end) if end <= file_len && self.offset.is_multiple_of(ALIGN) && self.elem_size > 0 => {
                Ok(self.offset as usize..end as usize)
            }
            _ => Err(FormatError::Section { tag: self.tag, offset: self.offset, byte_len, file_len }),
        }
    }
}
