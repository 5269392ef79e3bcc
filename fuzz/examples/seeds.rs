//! Writes the seeds of all fuzz targets to `corpus/`: small synthetic files, nothing captured.
//!
//! `cargo run --example seeds` in this folder.

use std::path::Path;
use throng_precompute::damage::READERS;

fn main() -> std::io::Result<()> {
    for reader in READERS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(reader.name);
        std::fs::create_dir_all(&folder)?;
        for (number, bytes) in (reader.seeds)().iter().enumerate() {
            std::fs::write(folder.join(format!("seed_{number}")), bytes)?;
        }
    }
    Ok(())
}
