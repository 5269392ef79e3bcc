//! Writes the golden tables of the current format version, which `tests/golden.rs` opens:
//!
//! ```text
//! cargo run --example make_golden -- data/golden/tables_v8.throng
//! ```
//!
//! They are made of synthetic motion alone, by the ordinary build. They are written anew when the version is, in place of those of
//! the version before; the figures in `tests/golden.rs` are then those that its tests print.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::examples::{AxisConfig, AxisKind, BlendConfig, FindConfig};
use throng_precompute::pipeline;
use throng_precompute::policy::GridConfig;
use throng_precompute::progress::Silent;
use throng_precompute::synth::{self, SynthConfig, SynthSet};

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args_os().nth(1).ok_or("usage: make_golden FILE")?;
    let out = std::path::absolute(PathBuf::from(out))?;
    let folder = tempfile::tempdir()?;
    // The bundle names its sources: from inside the folder, their names are the same on every machine.
    std::env::set_current_dir(folder.path())?;
    let motion = SynthConfig { minutes: 0.35, clip_seconds: 12.0, ..SynthConfig::default() };
    synth::write_set(SynthSet::Walk, &motion, "walk".as_ref())?;
    let mut config = BuildConfig::new("golden", vec!["walk".into()]);
    config.resample.rate_hz = 20.0;
    config.behaviours[0].grid = GridConfig::polar(5, 8, 6.0, 0.75, 2.5);
    let axis = |kind| AxisConfig { kind, name: String::new(), range: None, spacing: None, tags: BTreeMap::new() };
    let find = FindConfig {
        clips: vec!["*".into()],
        mirror: true,
        most: Some(5),
        closing_deg: Some(20.0),
        ..FindConfig::default()
    };
    let walks = BlendConfig {
        axes: vec![axis(AxisKind::Speed), axis(AxisKind::Gyration)],
        find: vec![find],
        phases: 8,
        weight_tolerance: 0.1,
        speed_tolerance: 0.5,
        gyration_tolerance: 0.8,
        ..BlendConfig::default()
    };
    config.blend.insert("walks".into(), walks);
    let report = pipeline::build(&config, &out, &Cache::disabled(), &Silent)?;
    println!("{} bytes, {} states, {} actions", report.bundle_bytes, report.states, report.actions);
    Ok(())
}
