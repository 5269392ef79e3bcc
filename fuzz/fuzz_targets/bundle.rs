//! A bundle: opened, and if it opens, queried and stepped. Nothing that opens may panic or loop later.
#![no_main]

use glam::Vec3;
use libfuzzer_sys::fuzz_target;
use throng_runtime::format::{AlignedBytes, Header, MAGIC, Section, VERSION, crc32};
use throng_runtime::characters::{Choice, Goal, MotionSet, Start, Characters, CharactersConfig};
use throng_runtime::{Planar, Bundle};

fuzz_target!(|data: &[u8]| {
    let _ = Bundle::from_bytes(AlignedBytes::from_slice(data)).map(|t| use_tables(&t));
    let repaired = repair(data.to_vec());
    let _ = Bundle::from_bytes_unverified(AlignedBytes::from_slice(&repaired)).map(|t| use_tables(&t));
});

/// Puts magic, version, length and the checksums of header and section table right, so that what lies behind them
/// is reached.
fn repair(mut data: Vec<u8>) -> Vec<u8> {
    const HEAD: usize = size_of::<Header>();
    if data.len() < HEAD {
        return data;
    }
    let mut header: Header = bytemuck::pod_read_unaligned(&data[..HEAD]);
    let table_end = HEAD.saturating_add((header.num_sections as usize).saturating_mul(size_of::<Section>()));
    if let Some(table) = data.get(HEAD..table_end) {
        header.table_crc32 = crc32(table);
    }
    header.magic = MAGIC;
    header.version = VERSION;
    header.file_len = data.len() as u64;
    header.reserved = [0; 32];
    header.header_crc32 = header.checksum();
    data[..HEAD].copy_from_slice(bytemuck::bytes_of(&header));
    data
}

fn use_tables(tables: &Bundle) {
    let motion_set = MotionSet::new(tables);
    let states = tables.graph().states.len() as u32;
    let starts: Vec<Start> =
        (0..5).map(|i| Start { root: Planar::new(i as f32, -1.0, 0.7), state: i * 7 % states }).collect();
    let targets = [Vec3::new(2.0, 0.3, 3.0); 5];
    for choice in [Choice::BestAction, Choice::LookAhead { temperature: 0.5 }] {
        let config = CharactersConfig { choice, ..CharactersConfig::default() };
        let Ok(mut characters) = Characters::new(&motion_set, config, &starts) else { continue };
        let goals = [Goal { policy: 0, weight: 1.0, targets: &targets }];
        let goals = &goals[..motion_set.num_policies().min(1)];
        for _ in 0..8 {
            if characters.step(&motion_set, 0.4, goals).is_err() {
                break;
            }
        }
    }
}
