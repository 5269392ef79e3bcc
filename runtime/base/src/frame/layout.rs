//! Checks a file's frame: header, section table, padding, checksums. What the records say is checked by `Bundle`.

use super::{ALIGN, FileHeader, FileKind, FormatError, SectionEntry, SectionTag, crc32};
use crate::error::ensure;
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
            let (range, tag) = (s.range(bytes.len() as u64)?, s.tag);
            let fault = || format!("section {tag} starts at {}, not after its forerunner", range.start);
            ensure(range.start == end.next_multiple_of(ALIGN as usize), || FormatError::layout(fault()))?;
            let is_padded = s.reserved == 0 && bytes[end..range.start].iter().all(|&b| b == 0);
            let fault = || format!("the padding before section {tag} is not zero");
            ensure(is_padded, || FormatError::layout(fault()))?;
            let is_new = sections.iter().all(|(o, _)| o.tag != tag);
            ensure(is_new, || FormatError::layout(format!("section {tag} stands there twice")))?;
            if checksums {
                check(&format!("section {tag}"), s.crc32, crc32(&bytes[range.clone()]))?;
            }
            end = range.end;
            sections.push((s, range));
        }
        check_length(end as u64, bytes.len() as u64)?;
        Ok(Self { sections })
    }

    /// Byte range of the section of that tag, whose elements must be `T`.
    pub fn section<T: Pod>(&self, tag: SectionTag) -> Result<Range<usize>, FormatError> {
        let (s, range) = self.sections.iter().find(|(s, _)| s.tag == tag).ok_or(FormatError::Missing { tag })?;
        let (got, expected) = (s.elem_size as usize, size_of::<T>());
        let fault = || format!("section {tag} has elements of {got} bytes, expected {expected}");
        ensure(got == expected, || FormatError::layout(fault()))?;
        Ok(range.clone())
    }

    /// Row of the section table and bytes of every section, in file order.
    pub fn sections(&self) -> &[(SectionEntry, Range<usize>)] {
        &self.sections
    }
}

fn read_header(bytes: &[u8], kind: FileKind) -> Result<FileHeader, FormatError> {
    let FileKind { what, magic, version: expected } = kind;
    let (got, header_len) = (bytes.len() as u64, size_of::<FileHeader>());
    if let Some(got) = bytes.first_chunk().copied() {
        ensure(got == magic, || FormatError::Magic { what, got })?;
    }
    let head = bytes.get(..header_len).ok_or(FormatError::Length { expected: header_len as u64, got })?;
    let header: FileHeader = bytemuck::pod_read_unaligned(head);
    ensure(header.version == expected, || FormatError::Version { what, expected, got: header.version })?;
    check("the header", header.header_crc32, header.checksum())?;
    check_length(header.file_len, got)?;
    let fault = "the header's reserved bytes or section count are not this version's";
    let is_known = header.num_sections <= MAX_SECTIONS && header.reserved == [0; 32];
    ensure(is_known, || FormatError::layout(fault))?;
    Ok(header)
}

fn check_length(expected: u64, got: u64) -> Result<(), FormatError> {
    ensure(expected == got, || FormatError::Length { expected, got })
}

fn check(what: &str, expected: u32, got: u32) -> Result<(), FormatError> {
    ensure(expected == got, || FormatError::Checksum { what: what.to_owned(), expected, got })
}
