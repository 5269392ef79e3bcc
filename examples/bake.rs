//! Bakes a bundle from code: synthetic clips as files, a config, the pipeline.
//!
//! ```sh
//! cargo run --release --example bake
//! ```

use std::path::Path;
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::progress::Silent;
use throng_precompute::synth::{self, SynthConfig, SynthSet};
use throng_precompute::{pipeline, policy::PolicyBehaviourConfig};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run(std::env::args().nth(1).unwrap_or_else(|| "walk.throng".into()).as_ref())
}

/// Writes two minutes of walking to a temporary folder, and bakes them.
pub fn run(out: &Path) -> Result<(), Box<dyn std::error::Error>> {
    // Any BVH or ASF/AMC files will do; these are made here.
    let folder = tempfile::tempdir()?;
    synth::write_set(SynthSet::Walk, &SynthConfig { minutes: 2.0, ..SynthConfig::default() }, folder.path())?;

    // The settings of a config file, field by field. A second behaviour looks further ahead.
    let mut config = BuildConfig::new("walk", vec![folder.path().to_path_buf()]);
    config.behaviours.push(PolicyBehaviourConfig {
        name: "far".into(),
        discount: Some(0.99),
        ..PolicyBehaviourConfig::default()
    });

    let report = pipeline::build(&config, out, &Cache::disabled(), &Silent)?;
    println!("{} states, {} actions, {} bytes", report.states, report.actions, report.bundle_bytes);
    for p in &report.policies {
        println!("{}: {} cells, residual {:.1e} after {} sweeps", p.name, p.cells, p.residual, p.sweeps);
    }
    Ok(())
}
