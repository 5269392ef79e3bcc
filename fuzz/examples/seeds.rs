//! Writes the seeds of all fuzz targets to `corpus/`: small synthetic files, nothing captured.
//!
//! `cargo run --example seeds` in this folder.

use std::path::Path;
use throng_precompute::damage::READERS;

fn main() -> std::io::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for reader in READERS {
        let folder = root.join("corpus").join(reader.name);
        std::fs::create_dir_all(&folder)?;
        for (number, bytes) in (reader.seeds)().iter().enumerate() {
            std::fs::write(folder.join(format!("seed_{number}")), bytes)?;
        }
    }
    command_lines(&root.join("corpus/arguments"))
}

/// Those of the documentation, a word a line.
fn command_lines(folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let mut number = 0;
    let mut pages = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs"))?
        .map(|page| Ok(page?.path()))
        .collect::<std::io::Result<Vec<_>>>()?;
    pages.sort();
    for text in pages.iter().filter_map(|page| std::fs::read_to_string(page).ok()) {
        for line in text.lines().filter_map(|line| line.strip_prefix("throng ")) {
            let words: Vec<&str> = line.split_whitespace().take_while(|word| *word != "#").collect();
            std::fs::write(folder.join(format!("seed_{number}")), words.join("\n"))?;
            number += 1;
        }
    }
    Ok(())
}
