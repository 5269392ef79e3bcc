//! Writer of bundles: arranges sections in a file.

use super::{ALIGN, FileHeader, FileKind, SectionEntry, SectionTag, crc32, crc32_of_pieces};
use bytemuck::{Pod, Zeroable};
use std::borrow::Cow;
use std::io::{self, Write};

/// Collects sections and writes them as one bundle.
#[derive(Debug, Default)]
pub struct BundleWriter<'a> {
    sections: Vec<SectionParts<'a>>,
}

/// A section: the bytes of its parts follow each other.
#[derive(Debug)]
struct SectionParts<'a> {
    tag: SectionTag,
    elem_size: u32,
    bytes: Vec<Cow<'a, [u8]>>,
}

impl SectionParts<'_> {
    fn len(&self) -> usize {
        self.bytes.iter().map(|b| b.len()).sum()
    }
}

impl<'a> BundleWriter<'a> {
    /// A bundle without sections.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a section with a copy of records. Sections are written in the order in which they were added.
    pub fn section<T: Pod>(&mut self, tag: SectionTag, records: &[T]) {
        self.section_bytes::<T>(tag, bytemuck::cast_slice(records).to_vec());
    }

    /// Adds a section of records that are bytes already, see [`BundleWriter::section`].
    pub fn section_bytes<T: Pod>(&mut self, tag: SectionTag, records: Vec<u8>) {
        self.sections.push(SectionParts { tag, elem_size: size_of::<T>() as u32, bytes: vec![records.into()] });
    }

    /// Adds a section of records in several slices, without a copy, see [`BundleWriter::section`].
    pub fn section_of<T: Pod>(&mut self, tag: SectionTag, records: impl Iterator<Item = &'a [T]>) {
        let bytes = records.map(|records| bytemuck::cast_slice(records).into()).collect();
        self.sections.push(SectionParts { tag, elem_size: size_of::<T>() as u32, bytes });
    }

    /// Length of the bundle (bytes).
    pub fn byte_len(&self) -> usize {
        let table = size_of::<FileHeader>() + self.sections.len() * size_of::<SectionEntry>();
        self.sections.iter().fold(table, |end, section| end.next_multiple_of(ALIGN as usize) + section.len())
    }

    /// Writes header, section table and sections.
    ///
    /// # Errors
    /// What `out` returns.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        self.write_kind(out, FileKind::BUNDLE)
    }

    /// Writes a file of another kind.
    pub fn write_kind(&self, out: &mut impl Write, kind: FileKind) -> io::Result<()> {
        let mut end = (size_of::<FileHeader>() + self.sections.len() * size_of::<SectionEntry>()) as u64;
        let mut table = Vec::with_capacity(self.sections.len());
        for section in &self.sections {
            let offset = end.next_multiple_of(ALIGN);
            table.push(SectionEntry {
                tag: section.tag,
                elem_size: section.elem_size,
                offset,
                count: section.len() as u64 / u64::from(section.elem_size),
                crc32: crc32_of_pieces(section.bytes.iter().map(|b| &**b)),
                reserved: 0,
            });
            end = offset + section.len() as u64;
        }
        let table: &[u8] = bytemuck::cast_slice(&table);
        let mut header = FileHeader {
            magic: kind.magic,
            version: kind.version,
            num_sections: self.sections.len() as u32,
            file_len: end,
            table_crc32: crc32(table),
            ..FileHeader::zeroed()
        };
        header.header_crc32 = header.checksum();
        out.write_all(bytemuck::bytes_of(&header))?;
        out.write_all(table)?;
        let mut at = (size_of::<FileHeader>() + table.len()) as u64;
        for section in &self.sections {
            let pad = at.next_multiple_of(ALIGN) - at;
            out.write_all(&[0; ALIGN as usize][..pad as usize])?;
            section.bytes.iter().try_for_each(|bytes| out.write_all(bytes))?;
            at += pad + section.len() as u64;
        }
        Ok(())
    }
}
