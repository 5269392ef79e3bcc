//! Bundles taken apart, changed and put together again with right checksums, so that the check under test is reached
//! and not the one before it.

use bytemuck::Pod;
use throng_core::format::{
    ALIGN, AlignedBytes, FileHeader, FormatError, Meta, SectionEntry, SectionTag, VERSION, crc32,
};
use throng_core::{Bundle, bundle::tags};

/// The sections of a bundle, to be changed in content and length.
#[derive(Clone)]
pub struct Parts {
    sections: Vec<(SectionTag, u32, Vec<u8>)>,
}

impl Parts {
    /// Takes a whole bundle apart.
    pub fn of(bytes: &[u8]) -> Self {
        let part = |s: &SectionEntry| {
            let range = s.range(bytes.len() as u64).expect("a section of a whole bundle");
            (s.tag, s.elem_size, bytes[range].to_vec())
        };
        Self { sections: Frame::of(bytes).rows.iter().map(part).collect() }
    }

    /// Changes the records of a section.
    pub fn edit<T: Pod>(&mut self, tag: SectionTag, change: impl FnOnce(&mut Vec<T>)) {
        let (_, elem_size, bytes) =
            self.sections.iter_mut().find(|(t, ..)| *t == tag).expect("the bundle has the section");
        assert_eq!(*elem_size as usize, size_of::<T>(), "{tag} holds other records");
        let mut records: Vec<T> = bytes.chunks(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect();
        change(&mut records);
        *bytes = bytemuck::cast_slice(&records).to_vec();
    }

    /// Changes what the bundle says of itself.
    pub fn edit_meta(&mut self, change: impl FnOnce(&mut Meta)) {
        self.edit::<u8>(tags::META, |bytes| {
            let mut meta = Meta::decode(bytes).expect("META of a whole bundle");
            change(&mut meta);
            *bytes = meta.encode().expect("META encodes");
        });
    }

    /// Puts the sections together as the format says, independently of the writer.
    pub fn join(&self) -> Vec<u8> {
        let mut out = vec![0; size_of::<FileHeader>() + self.sections.len() * size_of::<SectionEntry>()];
        let mut rows = Vec::new();
        for (tag, elem_size, bytes) in &self.sections {
            out.resize(out.len().next_multiple_of(ALIGN as usize), 0);
            rows.push(SectionEntry {
                tag: *tag,
                elem_size: *elem_size,
                offset: out.len() as u64,
                count: (bytes.len() / *elem_size as usize) as u64,
                crc32: crc32(bytes),
                reserved: 0,
            });
            out.extend_from_slice(bytes);
        }
        let header = FileHeader {
            magic: *b"\x89THRONG\n",
            version: VERSION,
            num_sections: rows.len() as u32,
            file_len: out.len() as u64,
            table_crc32: 0,
            header_crc32: 0,
            reserved: [0; 32],
        };
        Frame { header, rows, bytes: out }.seal()
    }
}

/// Header and section table of a bundle, to be changed.
#[derive(Clone)]
pub struct Frame {
    pub header: FileHeader,
    pub rows: Vec<SectionEntry>,
    /// The whole file; header and table are written over by [`Frame::seal`].
    pub bytes: Vec<u8>,
}

impl Frame {
    /// Header and table of a whole bundle.
    pub fn of(bytes: &[u8]) -> Self {
        let header: FileHeader = bytemuck::pod_read_unaligned(&bytes[..64]);
        let table = &bytes[64..][..header.num_sections as usize * 32];
        Self { header, rows: table.chunks(32).map(bytemuck::pod_read_unaligned).collect(), bytes: bytes.to_vec() }
    }

    /// The file with header and table as they are now, and the checksums of sections, table and header made right.
    pub fn seal(mut self) -> Vec<u8> {
        for row in &mut self.rows {
            if let Ok(range) = row.range(self.bytes.len() as u64) {
                row.crc32 = crc32(&self.bytes[range]);
            }
        }
        let table: &[u8] = bytemuck::cast_slice(&self.rows);
        self.bytes[64..][..table.len()].copy_from_slice(table);
        let claimed = 64 + self.header.num_sections as usize * 32;
        self.header.table_crc32 = crc32(self.bytes.get(64..claimed).unwrap_or_default());
        self.header.header_crc32 = 0;
        self.header.header_crc32 = crc32(bytemuck::bytes_of(&self.header));
        self.bytes[..64].copy_from_slice(bytemuck::bytes_of(&self.header));
        self.bytes
    }
}

/// Opens bytes as a bundle.
pub fn open(bytes: &[u8]) -> Result<Bundle, FormatError> {
    Bundle::from_bytes(AlignedBytes::from_slice(bytes))
}

/// Opens bytes without comparing checksums of sections.
pub fn open_unverified(bytes: &[u8]) -> Result<Bundle, FormatError> {
    Bundle::from_bytes_unverified(AlignedBytes::from_slice(bytes))
}

/// Why bytes are refused as a bundle, verified or not.
pub fn refusal(bytes: &[u8], what: &str) -> FormatError {
    assert!(open_unverified(bytes).is_err(), "{what}: opened without verification");
    open(bytes).err().unwrap_or_else(|| panic!("{what}: opened"))
}

/// What is changed in a bundle's content, and how.
#[allow(dead_code, reason = "not every test that has this file asks why")]
pub type Change<'a> = (&'a str, &'a dyn Fn(&mut Parts));

/// Every change of a whole bundle is refused by an error of that section; with `None`, by one of the layout.
#[allow(dead_code, reason = "not every test that has this file asks why")]
pub fn refuses(whole: &[u8], tag: Option<SectionTag>, changes: &[Change<'_>]) {
    for (what, change) in changes {
        let mut parts = Parts::of(whole);
        change(&mut parts);
        let bytes = parts.join();
        assert!(bytes != whole, "{what}: nothing was changed");
        match (refusal(&bytes, what), tag) {
            (FormatError::Value { tag: got, .. }, Some(wanted)) if got == wanted => {}
            (FormatError::Layout { .. }, None) => {}
            (e, _) => panic!("{what}: refused, but by {e:?}"),
        }
    }
}
