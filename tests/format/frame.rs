//! Damage to the frame of a bundle: its length, header, section table and checksums.

use super::patch::{Frame, Parts, open, open_unverified, refusal};
use crate::common::bundle;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use throng_core::format::{FileHeader, FormatError, SectionEntry, VERSION};
use throng_core::{Bundle, bundle::tags};

#[test]
fn the_writer_lays_bundles_out_as_the_format_says() {
    assert!(Parts::of(bundle()).join() == bundle());
    assert!(Frame::of(bundle()).seal() == bundle());
    assert!(open(bundle()).is_ok() && open_unverified(bundle()).is_ok());
}

/// Where sections begin and end.
fn borders() -> Vec<usize> {
    let ends = |s: &SectionEntry| {
        let r = s.range(bundle().len() as u64).expect("a section of a whole bundle");
        [r.start, r.end]
    };
    Frame::of(bundle()).rows.iter().flat_map(ends).collect()
}

/// The first 4 KB, the surroundings of every border, and some between.
fn prefix_lengths() -> Vec<usize> {
    let len = bundle().len();
    let mut lengths: Vec<usize> = (0..4096).chain((4096..len).step_by(9973)).collect();
    lengths.extend(borders().iter().flat_map(|&b| b.saturating_sub(9)..b + 9));
    lengths.retain(|&n| n < len);
    lengths
}

#[test]
fn every_prefix_is_refused() {
    for n in prefix_lengths() {
        let e = refusal(&bundle()[..n], &format!("{n} bytes"));
        assert!(matches!(e, FormatError::Length { .. }), "{n} bytes: {e}");
    }
}

#[test]
fn a_prefix_whose_header_claims_its_length_is_refused_too() {
    let head = 64 + 32 * Frame::of(bundle()).rows.len();
    for n in prefix_lengths().into_iter().filter(|n| *n >= head) {
        let mut frame = Frame::of(bundle());
        frame.bytes.truncate(n);
        frame.header.file_len = n as u64;
        refusal(&frame.seal(), &format!("{n} bytes"));
    }
}

#[test]
fn cut_files_are_refused_and_opening_names_what_is_wrong() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("cut.throng");
    for n in [0, 1, 63, 64, 500, bundle().len() - 1] {
        std::fs::write(&path, &bundle()[..n]).expect("a file");
        for e in [Bundle::open(&path), Bundle::open_unverified(&path)].map(|t| t.expect_err("a cut file")) {
            assert!(matches!(e, FormatError::Length { got, .. } if got == n as u64), "{n} bytes: {e}");
        }
    }
    std::fs::write(&path, bundle()).expect("a file");
    assert!(Bundle::open(&path).is_ok() && Bundle::open_unverified(&path).is_ok());
    let e = Bundle::open(folder.path().join("absent.throng")).expect_err("no such file");
    assert!(matches!(e, FormatError::Io { .. }) && e.to_string().contains("absent.throng"), "{e}");
}

#[test]
fn added_bytes_are_refused() {
    for extra in [1, 2, 63, 64, 65] {
        let mut bytes = [bundle(), &vec![0; extra]].concat();
        assert!(matches!(refusal(&bytes, "longer"), FormatError::Length { .. }));
        let mut frame = Frame::of(&bytes);
        frame.header.file_len = bytes.len() as u64;
        bytes = frame.seal();
        assert!(matches!(refusal(&bytes, "longer, and says so"), FormatError::Length { .. }));
    }
}

#[test]
fn every_flipped_byte_of_header_table_and_meta_is_refused() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let meta = Frame::of(bundle()).rows.into_iter().find(|s| s.tag == tags::META).expect("META");
    let end = meta.range(bundle().len() as u64).expect("META lies in the bundle").end;
    let mut bytes = bundle().to_vec();
    for at in 0..end {
        let flip = rng.random_range(1..=255u8);
        bytes[at] ^= flip;
        assert!(open(&bytes).is_err(), "byte {at} xor {flip:#04x}");
        if at < 64 + 32 * 14 {
            assert!(open_unverified(&bytes).is_err(), "byte {at} xor {flip:#04x}, unverified");
        }
        bytes[at] ^= flip;
    }
}

#[test]
fn flipped_bytes_elsewhere_are_refused() {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    let mut bytes = bundle().to_vec();
    let samples = (0..400).map(|_| rng.random_range(0..bytes.len())).collect::<Vec<_>>();
    let edges = borders().into_iter().flat_map(|b| [b - 1, b]).filter(|&b| b < bundle().len());
    for at in samples.into_iter().chain(edges) {
        let flip = 1 << rng.random_range(0..8);
        bytes[at] ^= flip;
        let e = open(&bytes).expect_err("a flipped bit");
        assert!(
            matches!(
                e,
                FormatError::Checksum { .. }
                    | FormatError::Layout { .. }
                    | FormatError::Magic { .. }
                    | FormatError::Version { .. }
            ),
            "byte {at}: {e}"
        );
        bytes[at] ^= flip;
    }
}

#[test]
fn other_magic_is_refused_as_no_bundle() {
    for magic in [*b"\x89PNG\r\n\x1a\n", *b"HIERARCH", [0; 8], *b"\x89THRONG\r"] {
        let mut frame = Frame::of(bundle());
        frame.header.magic = magic;
        let e = refusal(&frame.seal(), "other magic");
        assert!(
            matches!(e, FormatError::Magic { got, .. } if got == magic) && e.to_string().contains("throng build"),
            "{e}"
        );
    }
}

#[test]
fn other_versions_are_refused_with_what_to_run() {
    for version in (0..VERSION).chain([VERSION + 1, 256, u32::MAX]) {
        let mut frame = Frame::of(bundle());
        frame.header.version = version;
        let e = refusal(&frame.seal(), "other version");
        assert!(matches!(e, FormatError::Version { got, .. } if got == version), "{version}: {e}");
        let message = e.to_string();
        assert!(message.contains(&format!("version {version},")) && message.contains("`throng build`"), "{message}");
    }
}

/// A change of header and rows, what it is, and whether an error is the right one.
type Change = (&'static str, fn(&mut Frame), fn(&FormatError) -> bool);

/// The last row of the section table.
fn last(frame: &mut Frame) -> &mut SectionEntry {
    frame.rows.last_mut().expect("a bundle has sections")
}

#[test]
fn tables_that_break_a_rule_are_refused() {
    let layout = |e: &FormatError| matches!(e, FormatError::Layout { .. });
    let section = |e: &FormatError| matches!(e, FormatError::Section { .. });
    let missing = |e: &FormatError| matches!(e, FormatError::Missing { .. });
    let length = |e: &FormatError| matches!(e, FormatError::Length { .. });
    let changes: [Change; 22] = [
        ("overlap", |f| f.rows[4].offset = f.rows[3].offset, layout),
        ("overlap by a line", |f| f.rows[4].offset -= 64, layout),
        ("a gap", |f| f.rows[4].offset += 64, layout),
        ("a section inside the table", |f| f.rows[0].offset = 64, layout),
        ("a section over the header", |f| f.rows[0].offset = 0, layout),
        ("misaligned by 1", |f| f.rows[5].offset += 1, section),
        ("misaligned by 32", |f| f.rows[5].offset += 32, section),
        ("past the end", |f| last(f).count += 64, section),
        ("length past any integer", |f| f.rows[3].count = u64::MAX, section),
        ("offset past any integer", |f| f.rows[3].offset = u64::MAX - 63, section),
        ("elements of no size", |f| f.rows[3].elem_size = 0, section),
        // A line of the file belongs to nothing then.
        ("a shorter section", |f| f.rows[3].count -= 1, layout),
        ("order", |f| f.rows.swap(4, 5), layout),
        ("twice the same tag", |f| f.rows[5].tag = f.rows[4].tag, layout),
        ("reserved field of a row", |f| f.rows[7].reserved = 1, layout),
        ("reserved bytes of the header", |f| f.header.reserved[31] = 1, layout),
        ("no sections", |f| f.header.num_sections = 0, length),
        // The row too many is padding or the beginning of the first section.
        (
            "more sections than there are",
            |f| f.header.num_sections += 1,
            |e| matches!(e, FormatError::Layout { .. } | FormatError::Section { .. }),
        ),
        (
            "fewer sections than there are",
            |f| f.header.num_sections -= 1,
            |e| matches!(e, FormatError::Layout { .. } | FormatError::Length { .. }),
        ),
        ("countless sections", |f| f.header.num_sections = u32::MAX, layout),
        ("another length", |f| f.header.file_len -= 1, length),
        ("an unknown tag", |f| f.rows[6].tag.0 = *b"none", missing),
    ];
    for (what, change, right) in changes {
        let mut frame = Frame::of(bundle());
        change(&mut frame);
        let e = refusal(&frame.seal(), what);
        assert!(right(&e), "{what}: {e:?}");
    }
}

#[test]
fn every_section_must_be_there_with_the_right_elements() {
    for i in 0..Frame::of(bundle()).rows.len() {
        let mut frame = Frame::of(bundle());
        let tag = frame.rows[i].tag;
        frame.rows[i].tag.0[0] = b'x';
        let e = refusal(&frame.seal(), "renamed");
        assert!(matches!(e, FormatError::Missing { tag: t } if t == tag), "{tag}: {e}");

        let mut frame = Frame::of(bundle());
        let row = &mut frame.rows[i];
        let bytes = row.count * u64::from(row.elem_size);
        (row.elem_size, row.count) = if row.elem_size == 1 { (bytes as u32, 1) } else { (1, bytes) };
        let e = refusal(&frame.seal(), "other elements");
        assert!(matches!(&e, FormatError::Layout { message } if message.contains(&tag.to_string())), "{tag}: {e}");
    }
}

#[test]
fn padding_must_be_zero() {
    let frame = Frame::of(bundle());
    let mut tried = 0;
    for pair in frame.rows.windows(2) {
        let end = pair[0].range(bundle().len() as u64).expect("a section").end;
        for at in end..pair[1].offset as usize {
            let mut bytes = bundle().to_vec();
            bytes[at] = 1;
            assert!(matches!(refusal(&bytes, "padding"), FormatError::Layout { .. }), "byte {at}");
            tried += 1;
        }
    }
    assert!(tried > 0, "the bundle has no padding to try");
}

#[test]
fn wrong_checksums_are_refused_unless_they_are_not_wanted() {
    for i in 0..Frame::of(bundle()).rows.len() {
        let mut bytes = bundle().to_vec();
        // The row's crc32, with table and header made right by hand: sealing would mend it.
        bytes[64 + 32 * i + 24] ^= 1;
        let mut header: FileHeader = bytemuck::pod_read_unaligned(&bytes[..64]);
        header.table_crc32 = throng_core::format::crc32(&bytes[64..][..32 * header.num_sections as usize]);
        header.header_crc32 = header.checksum();
        bytes[..64].copy_from_slice(bytemuck::bytes_of(&header));
        assert!(matches!(open(&bytes), Err(FormatError::Checksum { .. })));
        assert!(open_unverified(&bytes).is_ok());
    }
}
