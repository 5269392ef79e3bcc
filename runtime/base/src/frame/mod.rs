//! The frame of baked files: a header, a table of sections, and their records, which are viewed in place.
//!
//! A 64-byte [`FileHeader`] is followed by a table of [`SectionEntry`] rows and by the sections themselves, each starting
//! on 64 bytes with zero padding between, in the order of the table, and nothing after the last.

#[cfg(not(target_endian = "little"))]
compile_error!("baked files are little-endian and viewed in place; this target is big-endian");

mod error;
mod header;
mod layout;
mod storage;
mod table;
mod writer;

pub use crate::checksum::{crc32, crc32_of_pieces};
pub use error::FormatError;
pub use header::{ALIGN, FileHeader, FileKind, MAGIC, SectionEntry, SectionTag, VERSION};
pub use layout::SectionLayout;
pub use storage::{AlignedBytes, FileStorage};
pub use table::Table;
pub use writer::BundleWriter;
