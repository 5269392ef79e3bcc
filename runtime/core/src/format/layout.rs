//! Checks a file's frame: header, section table, padding, checksums. What the records say is checked by `Bundle`.

use super::{ALIGN, FileHeader, FileKind, FormatError, SectionEntry, SectionTag, crc32};
use bytemuck::Pod;
use std::ops::Range;

/// Most sections a bundle may have; a larger count is damage.
const MAX_SECTIONS: u32 = 1024;

/// Byte ranges of the sections of a checked file.
#[derive(Debug)]
pub struct SectionLayout {
    sections: Vec<(SectionEntry, Range<usize>)>,
}

impl SectionLayout {
    /// Checks the frame of `bytes`; section checksums only where `checksums` is set.
    pub fn read(bytes: &[u8], checksums: bool) -> Result<Self, FormatError> {
        Self::read_kind(bytes, checksums, FileKind::BUNDLE)
    }

    /// Checks the frame of a file of another kind.
    pub fn read_kind(bytes: &[u8], checksums: bool, kind: FileKind) -> Result<Self, FormatError> {
        let header = read_header(bytes, kind)?;
        let table_end = size_of::<FileHeader>() + header.num_sections as usize * size_of::<SectionEntry>();
        let table = bytes
            .get(size_of::<FileHeader>()..table_end)
            .ok_or(FormatError::Length { expected: table_end as u64, got: bytes.len() as u64 })?;
        check("the section table", header.table_crc32, crc32(table))?;

        let mut sections: Vec<(SectionEntry, Range<usize>)> = Vec::with_capacity(header.num_sections as usize);
        let mut end = table_end;
        for row in table.chunks_exact(size_of::<SectionEntry>()) {
            let s: SectionEntry = bytemuck::pod_read_unaligned(row);
            let range = s.range(bytes.len() as u64)?;
            if range.start != end.next_multiple_of(ALIGN as usize) {
                let start = range.start;
                return Err(FormatError::layout(format!(
                    "section {} starts at {start}, not after its forerunner",
                    s.tag
                )));
            }
            if s.reserved != 0 || bytes[end..range.start].iter().any(|&b| b != 0) {
                return Err(FormatError::layout(format!("the padding before section {} is not zero", s.tag)));
            }
            if sections.iter().any(|(o, _)| o.tag == s.tag) {
                return Err(FormatError::layout(format!("section {} stands there twice", s.tag)));
            }
            if checksums {
                check(&format!("section {}", s.tag), s.crc32, crc32(&bytes[range.clone()]))?;
            }
            end = range.end;
            sections.push((s, range));
        }
        if end != bytes.len() {
            return Err(FormatError::Length { expected: end as u64, got: bytes.len() as u64 });
        }
        Ok(Self { sections })
    }

    /// Byte range of the section of that tag, whose elements must be `T`.
    pub fn section<T: Pod>(&self, tag: SectionTag) -> Result<Range<usize>, FormatError> {
        let (s, range) = self.sections.iter().find(|(s, _)| s.tag == tag).ok_or(FormatError::Missing { tag })?;
        if s.elem_size as usize != size_of::<T>() {
            return Err(FormatError::layout(format!(
                "section {tag} has elements of {} bytes, expected {}",
                s.elem_size,
                size_of::<T>()
            )));
        }
        Ok(range.clone())
    }

    /// Tag, length of an element and bytes of every section, in file order.
    pub fn ranges(&self) -> impl Iterator<Item = (SectionTag, usize, Range<usize>)> + '_ {
        self.sections.iter().map(|(s, range)| (s.tag, s.elem_size as usize, range.clone()))
    }

    /// Tag and length in bytes of every section, in file order.
    pub fn sizes(&self) -> impl Iterator<Item = (SectionTag, usize)> + '_ {
        self.sections.iter().map(|(s, r)| (s.tag, r.len()))
    }
}

fn read_header(bytes: &[u8], kind: FileKind) -> Result<FileHeader, FormatError> {
    let got = bytes.len() as u64;
    let head = bytes.get(..size_of::<FileHeader>());
    if let Some(magic) = bytes.first_chunk::<8>()
        && *magic != kind.magic
    {
        return Err(FormatError::Magic { what: kind.what, got: *magic });
    }
    let header: FileHeader = bytemuck::pod_read_unaligned(
        head.ok_or(FormatError::Length { expected: size_of::<FileHeader>() as u64, got })?,
    );
    if header.version != kind.version {
        return Err(FormatError::Version { what: kind.what, expected: kind.version, got: header.version });
    }
    check("the header", header.header_crc32, header.checksum())?;
    if header.file_len != got {
        return Err(FormatError::Length { expected: header.file_len, got });
    }
    if header.num_sections > MAX_SECTIONS || header.reserved != [0; 32] {
        return Err(FormatError::layout("the header's reserved bytes or section count are not this version's"));
    }
    Ok(header)
}

fn check(what: &str, expected: u32, got: u32) -> Result<(), FormatError> {
    if expected == got { Ok(()) } else { Err(FormatError::Checksum { what: what.to_owned(), expected, got }) }
}
