//! What do a query, a joint and a character cost, at 1k, 10k and 100k characters? `cargo bench --bench characters`.

use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::measure::{self, MeasureConfig};
use throng_precompute::progress::Silent;
use throng_precompute::synth::{self, SynthConfig, SynthSet};
use throng_precompute::{BuildError, pipeline};
use throng_runtime::Bundle;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // `cargo test` runs benches too: a few characters are enough there.
    let whole = std::env::args().any(|a| a == "--bench");
    let minutes = if whole { 6.0 } else { 1.0 };
    let folder = tempfile::tempdir()?;
    let bundle = folder.path().join("bench.throng");
    build(folder.path(), &bundle, minutes)?;
    let tables = Bundle::open(&bundle)?;
    let config = if whole {
        MeasureConfig { characters: vec![1_000, 10_000, 100_000], threads: vec![1, 2], seconds: 1.0 }
    } else {
        MeasureConfig { characters: vec![16], threads: vec![1], seconds: 0.001 }
    };
    for figures in measure::characters(&tables, &config)? {
        println!("{figures:#?}");
    }
    Ok(())
}

fn build(folder: &std::path::Path, bundle: &std::path::Path, minutes: f64) -> Result<(), BuildError> {
    synth::write(SynthSet::Walk, &SynthConfig { minutes, ..SynthConfig::default() }, folder)?;
    let config = BuildConfig::new("bench", vec![folder.to_path_buf()]);
    pipeline::build(&config, bundle, &Cache::none(), &Silent)?;
    Ok(())
}
