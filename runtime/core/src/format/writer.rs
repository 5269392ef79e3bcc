//! Lays sections out as a bundle.

use super::{ALIGN, Header, Kind, Section, Tag, crc32};
use bytemuck::{Pod, Zeroable};
use std::io::{self, Write};

/// Collects sections and writes them as one bundle.
#[derive(Debug, Default)]
pub struct BundleWriter {
    sections: Vec<(Tag, u32, Vec<u8>)>,
}

impl BundleWriter {
    /// A bundle without sections.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a section of records. Sections are written in the order in which they were added.
    pub fn section<T: Pod>(&mut self, tag: Tag, records: &[T]) {
        self.sections.push((tag, size_of::<T>() as u32, bytemuck::cast_slice(records).to_vec()));
    }

    /// As [`BundleWriter::section`], of records of which the bytes are there already.
    pub fn section_bytes<T: Pod>(&mut self, tag: Tag, records: Vec<u8>) {
        self.sections.push((tag, size_of::<T>() as u32, records));
    }

    /// Length of the bundle (bytes).
    pub fn byte_len(&self) -> usize {
        let table = size_of::<Header>() + self.sections.len() * size_of::<Section>();
        self.sections.iter().fold(table, |end, (_, _, bytes)| end.next_multiple_of(ALIGN as usize) + bytes.len())
    }

    /// Writes header, section table and sections.
    ///
    /// # Errors
    /// What `out` returns.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        self.write_kind(out, Kind::BUNDLE)
    }

    /// The same of a file of another kind.
    pub fn write_kind(&self, out: &mut impl Write, kind: Kind) -> io::Result<()> {
        let mut end = (size_of::<Header>() + self.sections.len() * size_of::<Section>()) as u64;
        let mut table = Vec::with_capacity(self.sections.len());
        for (tag, elem_size, bytes) in &self.sections {
            let offset = end.next_multiple_of(ALIGN);
            table.push(Section {
                tag: *tag,
                elem_size: *elem_size,
                offset,
                count: bytes.len() as u64 / u64::from(*elem_size),
                crc32: crc32(bytes),
                reserved: 0,
            });
            end = offset + bytes.len() as u64;
        }
        let table: &[u8] = bytemuck::cast_slice(&table);
        let mut header = Header {
            magic: kind.magic,
            version: kind.version,
            num_sections: self.sections.len() as u32,
            file_len: end,
            table_crc32: crc32(table),
            ..Header::zeroed()
        };
        header.header_crc32 = header.checksum();
        out.write_all(bytemuck::bytes_of(&header))?;
        out.write_all(table)?;
        let mut at = (size_of::<Header>() + table.len()) as u64;
        for (_, _, bytes) in &self.sections {
            let pad = at.next_multiple_of(ALIGN) - at;
            out.write_all(&[0; ALIGN as usize][..pad as usize])?;
            out.write_all(bytes)?;
            at += pad + bytes.len() as u64;
        }
        Ok(())
    }
}
