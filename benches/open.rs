//! Cost of opening a bundle by reading it, and by mapping it: tables of 11 MB, 100 MB and 1 GB, each opened in a separate
//! process. `cargo bench --bench open`
#![allow(unsafe_code)]

use std::path::Path;
use std::process::Command;
use std::time::Instant;
use throng_core::Bundle;
use throng_core::format::{ALIGN, FileHeader, SectionEntry, SectionTag, crc32};

/// Methods to open a file.
const OPEN_METHODS: [&str; 4] = ["open", "map", "open_unverified", "map_unverified"];
/// Number of repetitions of each; the fastest counts, as the least disturbed one.
const REPEATS: usize = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().collect();
    if let [_, one, method, file] = &args[..]
        && one == "--one"
    {
        return open(method, Path::new(file));
    }
    // `cargo test` runs benches too: small files are enough there.
    let whole = args.iter().any(|a| a == "--bench");
    let sizes: &[usize] = if whole { &[11_000_000, 100_000_000, 1_000_000_000] } else { &[1_000_000] };
    let folder = tempfile::tempdir()?;
    println!("MB    way              open_ms  over_map  own_MB  shared_MB");
    for &size in sizes {
        let file = folder.path().join("padded.throng");
        std::fs::write(&file, padded(size)?)?;
        let mut rows = Vec::new();
        for method in OPEN_METHODS {
            let mut best = [f64::INFINITY; 3];
            for _ in 0..REPEATS {
                let out = Command::new(std::env::current_exe()?).args(["--one", method]).arg(&file).output()?;
                let text = String::from_utf8(out.stdout)?;
                let found: Vec<f64> = text.split_whitespace().map_while(|w| w.parse().ok()).collect();
                let found: [f64; 3] =
                    found.try_into().map_err(|_| String::from_utf8_lossy(&out.stderr).into_owned())?;
                if found[0] < best[0] {
                    best = found;
                }
            }
            rows.push((method, best));
        }
        let map = rows[1].1[0];
        for (method, [ms, own, shared]) in rows {
            println!("{:<5} {method:<16} {ms:>7.2}  {:>8.2}  {own:>6.1}  {shared:>9.1}", size / 1_000_000, ms / map);
        }
    }
    Ok(())
}

/// Opens a file; prints how long that took (ms), memory of this process alone and memory that others share (MB).
fn open(method: &str, file: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let before = memory();
    let begin = Instant::now();
    // SAFETY: the file belongs to the parent process, which does not change it.
    let tables = match method {
        "open" => Bundle::open(file),
        "map" => unsafe { Bundle::map(file) },
        "open_unverified" => Bundle::open_unverified(file),
        _ => unsafe { Bundle::map_unverified(file) },
    }?;
    let ms = 1e3 * begin.elapsed().as_secs_f64();
    let after = memory();
    println!("{ms} {} {}", after[0] - before[0], after[1] - before[1]);
    drop(tables);
    Ok(())
}

/// Memory of this process alone, and of files, where the system reports it (MB).
fn memory() -> [f64; 2] {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let value = |key: &str| {
        let line = status.lines().find_map(|l| l.strip_prefix(key)).unwrap_or("0");
        line.split_whitespace().next().and_then(|kb| kb.parse::<f64>().ok()).unwrap_or(0.0) * 1024.0 / 1e6
    };
    [value("RssAnon:") + value("RssShmem:"), value("RssFile:")]
}

/// The golden tables with an additional section that is not read: a file of about `size` bytes.
fn padded(size: usize) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join(format!("data/golden/tables_v{}.throng", throng_core::format::VERSION));
    let golden = std::fs::read(path)?;
    let head = size_of::<FileHeader>();
    let mut header: FileHeader = bytemuck::pod_read_unaligned(&golden[..head]);
    let table = &golden[head..head + header.num_sections as usize * size_of::<SectionEntry>()];
    let old: Vec<SectionEntry> =
        table.chunks_exact(size_of::<SectionEntry>()).map(bytemuck::pod_read_unaligned).collect();
    let padding = SectionEntry { tag: SectionTag(*b"XPAD"), elem_size: 1, count: size as u64, ..old[0] };
    let mut out = vec![0; head + (old.len() + 1) * size_of::<SectionEntry>()];
    let mut rows = Vec::new();
    for s in old.iter().chain([&padding]) {
        out.resize(out.len().next_multiple_of(ALIGN as usize), 0);
        let offset = out.len();
        if s.tag == padding.tag {
            out.extend((0..size).map(|i| (i % 251) as u8));
        } else {
            out.extend(&golden[s.range(golden.len() as u64)?]);
        }
        rows.push(SectionEntry { offset: offset as u64, crc32: crc32(&out[offset..]), ..*s });
    }
    let rows: &[u8] = bytemuck::cast_slice(&rows);
    (header.num_sections, header.table_crc32) = (header.num_sections + 1, crc32(rows));
    header.file_len = out.len() as u64;
    header.header_crc32 = header.checksum();
    out[..head].copy_from_slice(bytemuck::bytes_of(&header));
    out[head..head + rows.len()].copy_from_slice(rows);
    Ok(out)
}
