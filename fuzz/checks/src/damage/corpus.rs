//! Seeds of all fuzz targets, as files: small synthetic ones, nothing captured.

use super::READERS;
use std::fs;
use std::io;
use std::path::Path;

/// Guides, whose command lines are the seeds of the target `arguments`.
const GUIDES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs");

/// Writes the seeds of each target to a folder of its name.
///
/// - returns the number of files.
///
/// # Errors
/// Those of the file system.
pub fn write_corpus(folder: &Path) -> io::Result<usize> {
    let mut files = 0;
    for reader in READERS {
        files += write_seeds(&folder.join(reader.name), (reader.seeds)())?;
    }
    Ok(files + write_seeds(&folder.join("arguments"), command_lines()?)?)
}

fn write_seeds(folder: &Path, seeds: Vec<Vec<u8>>) -> io::Result<usize> {
    fs::create_dir_all(folder)?;
    for (number, bytes) in seeds.iter().enumerate() {
        fs::write(folder.join(format!("seed_{number}")), bytes)?;
    }
    Ok(seeds.len())
}

/// Command lines of the guides, a word a line.
fn command_lines() -> io::Result<Vec<Vec<u8>>> {
    let mut pages = fs::read_dir(GUIDES)?.map(|page| Ok(page?.path())).collect::<io::Result<Vec<_>>>()?;
    pages.sort();
    let mut lines = Vec::new();
    for text in pages.iter().filter_map(|page| fs::read_to_string(page).ok()) {
        for line in text.lines().filter_map(|line| line.strip_prefix("throng ")) {
            let words: Vec<&str> = line.split_whitespace().take_while(|word| *word != "#").collect();
            lines.push(words.join("\n").into_bytes());
        }
    }
    Ok(lines)
}
