//! The bytes under a bundle: a file that was read or mapped, or memory of the same alignment. The only `unsafe` outside of
//! hot kernels lives here.
#![allow(unsafe_code)]

use super::{FileHeader, FormatError};
use crate::file::{MAX_BUNDLE_BYTES, open_file};
use crate::{Error, error::ensure};
use std::io::{ErrorKind, Read, Seek};
use std::{fs::File, path::Path};

#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct AlignedLine([u8; 64]);

/// Bytes in memory that start on 64, as a mapped file does.
#[derive(Clone, Debug, Default)]
pub struct AlignedBytes {
    lines: Vec<AlignedLine>,
    len: usize,
}

impl AlignedBytes {
    /// A copy of `bytes`.
    pub fn from_slice(bytes: &[u8]) -> Self {
        let mut out = Self { lines: vec![AlignedLine([0; 64]); bytes.len().div_ceil(64)], len: bytes.len() };
        out.as_mut_slice().copy_from_slice(bytes);
        out
    }

    /// Zeros; an error where there is no memory for them.
    ///
    /// # Errors
    /// [`ErrorKind::OutOfMemory`].
    pub fn zeros(len: usize) -> std::io::Result<Self> {
        let mut lines = Vec::new();
        lines.try_reserve_exact(len.div_ceil(64)).map_err(|_| ErrorKind::OutOfMemory)?;
        lines.resize(len.div_ceil(64), AlignedLine([0; 64]));
        Ok(Self { lines, len })
    }

    /// The bytes, to be changed.
    pub fn as_mut_slice(&mut self) -> &mut [u8] {
        &mut bytemuck::cast_slice_mut(&mut self.lines)[..self.len]
    }

    /// The bytes.
    pub fn as_slice(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.lines)[..self.len]
    }
}

/// The bytes of a file: a map, or memory.
#[derive(Debug)]
pub enum FileStorage {
    /// A map of the file, or read-only pages that it was read into.
    Mapped(memmap2::Mmap),
    /// Bytes that were made, or read where there are no pages to be had.
    Memory(AlignedBytes),
}

impl FileStorage {
    /// Reads a file into read-only pages of this process, which later changes of the file do not reach. A file whose
    /// header is missing or damaged is refused after its header alone.
    ///
    /// - `what`: content of the file, with its article, for messages ("a bundle").
    ///
    /// # Errors
    /// [`FormatError::Io`] where it cannot be read, [`FormatError::File`] for anything but a regular file,
    /// [`FormatError::Length`] for an empty one, for one whose header gives another length, and for one that is cut
    /// short meanwhile.
    pub fn read(path: &Path, what: &str) -> Result<Self, FormatError> {
        let io = |source| FormatError::Io { path: path.to_path_buf(), source };
        let (mut file, length) = open(path, what)?;
        let head = in_memory(path, &mut file, length.min(size_of::<FileHeader>()))?;
        let header = bytemuck::try_pod_read_unaligned(head.bytes()).ok();
        let Some(FileHeader { file_len, .. }) = header.filter(|h: &FileHeader| h.header_crc32 == h.checksum()) else {
            return Ok(head);
        };
        let (expected, got) = (file_len, length as u64);
        ensure(expected == got, || FormatError::Length { expected, got })?;
        file.rewind().map_err(io)?;
        // Pages come zeroed from the system: nothing is cleared here, and giving them back is one call.
        let mut pages = match memmap2::MmapMut::map_anon(length) {
            // As in WebAssembly.
            Err(e) if e.kind() == ErrorKind::Unsupported => return in_memory(path, &mut file, length),
            pages => pages.map_err(io)?,
        };
        // Fewer, larger pages are filled faster; a system that has none leaves them small.
        #[cfg(target_os = "linux")]
        let _ = pages.advise(memmap2::Advice::HugePage);
        fill(&mut pages, path, &mut file)?;
        Ok(Self::Mapped(pages.make_read_only().map_err(io)?))
    }

    /// Maps a file: pages are loaded when they are touched, and all processes that map it share them.
    ///
    /// # Errors
    /// As [`FileStorage::read`].
    ///
    /// # Safety
    /// For as long as the storage or a [`super::Table`] of it lives, the file must not be written into or cut short, in
    /// this process or another. A file that is replaced by renaming another one over it stays whole for processes that
    /// map it.
    pub unsafe fn map(path: &Path, what: &str) -> Result<Self, FormatError> {
        let (file, _) = open(path, what)?;
        // SAFETY: the caller promises that the bytes do not change.
        let map = unsafe { memmap2::Mmap::map(&file) };
        map.map(Self::Mapped).map_err(|source| FormatError::Io { path: path.to_path_buf(), source })
    }

    /// Bytes of the whole file.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Mapped(m) => m,
            Self::Memory(m) => m.as_slice(),
        }
    }
}

/// Reads the begin of a file into memory of this process.
fn in_memory(path: &Path, file: &mut File, length: usize) -> Result<FileStorage, FormatError> {
    let bytes = AlignedBytes::zeros(length);
    let mut bytes = bytes.map_err(|source| FormatError::Io { path: path.to_path_buf(), source })?;
    fill(bytes.as_mut_slice(), path, file)?;
    Ok(FileStorage::Memory(bytes))
}

/// Reads as many bytes as there is room for; [`FormatError::Length`] where the file has fewer.
fn fill(room: &mut [u8], path: &Path, file: &mut File) -> Result<(), FormatError> {
    let mut got = 0;
    while got < room.len() {
        match file.read(&mut room[got..]) {
            Ok(0) => return Err(FormatError::Length { expected: room.len() as u64, got: got as u64 }),
            Ok(n) => got += n,
            Err(e) if e.kind() == ErrorKind::Interrupted => (),
            Err(source) => return Err(FormatError::Io { path: path.to_path_buf(), source }),
        }
    }
    Ok(())
}

/// Opens a regular file that is not empty. Its length is in bytes.
fn open(path: &Path, what: &str) -> Result<(File, usize), FormatError> {
    let (file, length) = open_file(path, what, MAX_BUNDLE_BYTES).map_err(|e| match e {
        Error::Io { path, source } => FormatError::Io { path, source },
        Error::Format { why, .. } => FormatError::File { why },
        e => FormatError::layout(e.to_string()),
    })?;
    match usize::try_from(length) {
        Ok(0) => Err(FormatError::Length { expected: 64, got: 0 }),
        Ok(length) => Ok((file, length)),
        Err(_) => Err(FormatError::File { why: format!("has {length} bytes, more than this machine can address") }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg_attr(miri, ignore = "Miri maps no files")]
    fn without_pages_the_same_bytes_are_read_into_memory() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        let expected = std::fs::read(&path).unwrap();
        let read = |length: usize| in_memory(&path, &mut File::open(&path).unwrap(), length);
        let memory = read(expected.len()).unwrap();
        assert!(matches!(&memory, FileStorage::Memory(_)) && memory.bytes() == expected);
        assert_eq!(memory.bytes().as_ptr().addr() % 64, 0);
        let e = read(expected.len() + 1).unwrap_err();
        assert!(matches!(e, FormatError::Length { got, .. } if got == expected.len() as u64), "{e}");
        let e = read(usize::MAX / 2).unwrap_err();
        assert!(matches!(&e, FormatError::Io { source, .. } if source.kind() == ErrorKind::OutOfMemory), "{e}");
    }

    #[test]
    #[cfg_attr(miri, ignore = "Miri maps no files")]
    fn of_a_file_that_is_refused_for_its_header_no_more_is_read() {
        let path = std::env::temp_dir().join(format!("throng-header-{}", std::process::id()));
        let (mut file, mut bytes) = (super::super::BundleWriter::new(), Vec::new());
        file.section(super::super::SectionTag(*b"TEST"), &[1u32, 2]);
        file.write(&mut bytes).unwrap();
        let read = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            FileStorage::read(&path, "a bundle")
        };
        assert_eq!(read(&bytes).unwrap().bytes(), bytes);
        assert_eq!(read(&[0; 5000]).unwrap().bytes(), [0; 64]);
        assert_eq!(read(&bytes[..9]).unwrap().bytes(), &bytes[..9]);
        let longer = read(&[&bytes[..], &[0]].concat());
        assert!(matches!(longer, Err(FormatError::Length { expected, .. }) if expected == bytes.len() as u64));
        std::fs::remove_file(&path).unwrap();
    }
}
