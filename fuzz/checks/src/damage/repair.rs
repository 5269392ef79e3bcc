//! Puts the checksums of damaged files right, so that what lies behind them is reached.

use std::io::{Cursor, Write};
use throng_core::format::{FileHeader, MAGIC, SectionEntry, VERSION, crc32};
use throng_world::{WORLD_MAGIC, WORLD_VERSION};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// First bytes of each frame of a snapshot, and where its length, checksum and content lie after them.
const SNAPSHOT_MAGIC: &[u8] = b"THRGSNAP";
const LENGTH: usize = 32;
const SUM: usize = 40;
const BODY: usize = 44;

/// A bundle: magic, version, length and all checksums.
pub fn bundle(data: &[u8]) -> Vec<u8> {
    file(data, MAGIC, VERSION)
}

/// A world: the same.
pub fn world(data: &[u8]) -> Vec<u8> {
    file(data, WORLD_MAGIC, WORLD_VERSION)
}

fn file(data: &[u8], magic: [u8; 8], version: u32) -> Vec<u8> {
    const HEAD: usize = size_of::<FileHeader>();
    const ROW: usize = size_of::<SectionEntry>();
    let mut data = data.to_vec();
    if data.len() < HEAD {
        return data;
    }
    let mut header: FileHeader = bytemuck::pod_read_unaligned(&data[..HEAD]);
    let table_end = HEAD.saturating_add((header.num_sections as usize).saturating_mul(ROW));
    if table_end <= data.len() {
        for at in (HEAD..table_end).step_by(ROW) {
            let mut row: SectionEntry = bytemuck::pod_read_unaligned(&data[at..at + ROW]);
            if let Some(content) = row.range(data.len() as u64).ok().and_then(|range| data.get(range)) {
                row.crc32 = crc32(content);
                data[at..at + ROW].copy_from_slice(bytemuck::bytes_of(&row));
            }
        }
        header.table_crc32 = crc32(&data[HEAD..table_end]);
    }
    header.magic = magic;
    header.version = version;
    header.file_len = data.len() as u64;
    header.reserved = [0; 32];
    header.header_crc32 = header.checksum();
    data[..HEAD].copy_from_slice(bytemuck::bytes_of(&header));
    data
}

/// A snapshot: the checksums of all frames, the inner ones first, and the kind and setup of the outer one.
///
/// - `good`: a snapshot of the same simulation.
pub fn snapshot(data: &[u8], good: &[u8]) -> Vec<u8> {
    let mut data = data.to_vec();
    if data.len() < BODY || good.len() < BODY {
        return data;
    }
    data[..LENGTH].copy_from_slice(&good[..LENGTH]);
    let length = (data.len() - BODY) as u64;
    data[LENGTH..LENGTH + 8].copy_from_slice(&length.to_le_bytes());
    let starts = data.windows(SNAPSHOT_MAGIC.len()).enumerate().filter(|(_, w)| *w == SNAPSHOT_MAGIC).map(|(at, _)| at);
    for at in starts.collect::<Vec<_>>().into_iter().rev() {
        let Some(length) = data.get(at + LENGTH..at + LENGTH + 8) else { continue };
        let length = u64::from_le_bytes(std::array::from_fn(|i| length[i]));
        let end = usize::try_from(length).ok().and_then(|n| n.checked_add(at + BODY));
        let Some(body) = end.and_then(|end| data.get(at + BODY..end)) else { continue };
        let sum = crc32(body).to_le_bytes();
        data[at + SUM..at + BODY].copy_from_slice(&sum);
    }
    data
}

/// Parts the arrays of an `npz` input: the way, the turns, the rate.
pub const NPZ_SEAM: &[u8] = b"#--npy--\n";

/// An `.npz` file of the arrays between the seams; nothing where there are none.
pub fn npz(data: &[u8]) -> Option<Vec<u8>> {
    let seams = data.windows(NPZ_SEAM.len()).enumerate().filter(|(_, w)| *w == NPZ_SEAM).map(|(at, _)| at);
    let mut from = 0;
    let mut files = Vec::new();
    for to in seams.chain([data.len()]) {
        files.push(&data[from.min(to)..to]);
        from = to + NPZ_SEAM.len();
    }
    (files.len() > 1).then(|| zip(&["trans.npy", "poses.npy", "mocap_framerate.npy"], &files))
}

/// An archive of files without compression.
pub(super) fn zip(names: &[&str], files: &[&[u8]]) -> Vec<u8> {
    let mut out = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (name, content) in names.iter().zip(files) {
        let written = out.start_file(*name, options).and_then(|()| Ok(out.write_all(content)?));
        written.expect("memory takes all bytes");
    }
    out.finish().expect("memory takes all bytes").into_inner()
}

#[cfg(test)]
mod tests {
    use super::super::seeds;
    use super::*;
    use throng_core::Bundle;
    use throng_core::format::AlignedBytes;

    #[test]
    fn what_is_whole_stays_as_it_is_and_a_flipped_bit_passes_the_checksums() {
        for good in seeds::bundle() {
            assert!(bundle(&good) == good);
            let mut flipped = good.clone();
            // In the last section with content: no more than a weight or a best action. Zeros at the end are padding.
            *flipped.iter_mut().rfind(|byte| **byte != 0).unwrap() ^= 1;
            let open = |bytes: &[u8]| Bundle::from_bytes(AlignedBytes::from_slice(bytes));
            let e = open(&flipped).unwrap_err().to_string();
            assert!(e.contains("checksum"), "{e}");
            let e = open(&bundle(&flipped)).err().map(|e| e.to_string()).unwrap_or_default();
            assert!(!e.contains("checksum"), "{e}");
        }
        assert!(seeds::world().iter().all(|good| world(good) == *good));
        assert!(seeds::of_policy().iter().all(|good| snapshot(good, good) == *good));
    }
}
