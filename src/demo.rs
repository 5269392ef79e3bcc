//! `throng demo`: from synthetic motion to a crowd and its picture.

use crate::args::{CommandResult, CrowdArgs};
use crate::{build, help, keys, output, progress, run};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use throng_precompute::synth::{SynthConfig, SynthSet};
use throng_precompute::trial::{self, TrialConfig, TrialReport};
use throng_precompute::{cache::Cache, config::BuildConfig, picture, pipeline, report::BuildReport, synth};

/// Synthesise motion, bake it, run 1000 characters, draw a picture.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<DemoReport>())]
pub struct Args {
    /// Picture to write.
    #[arg(long, value_name = "FILE", default_value = "demo.png")]
    out: PathBuf,
    /// Bundle to keep.
    #[arg(long, value_name = "FILE", default_value = "demo.throng")]
    bundle: PathBuf,
    #[command(flatten)]
    crowd: CrowdArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize, JsonSchema)]
struct DemoReport {
    #[serde(flatten)]
    trial: TrialReport,
    /// Report of the build.
    build: BuildReport,
}

/// Bakes the synthetic walk.
pub fn bake(bundle: &Path) -> CommandResult<BuildReport> {
    let clips = progress::ScratchFolder::new()?;
    eprintln!("synthesising motion ...");
    synth::write_set(SynthSet::Walk, &SynthConfig::default(), clips.path())?;
    eprintln!("baking it ...");
    let mut config = BuildConfig::new("demo", vec![clips.path().to_path_buf()]);
    config.resample.mirror = true;
    let built = pipeline::build(&config, bundle, &Cache::disabled(), &progress::BuildProgressBar::on_interrupt(None))?;
    output::warnings(&built.skipped, &built.warnings);
    Ok(built)
}

pub fn run(args: &Args) -> CommandResult {
    let built = bake(&args.bundle)?;
    eprintln!("running the crowd ...");
    let tables = crate::args::open_bundle(&args.bundle)?;
    // Farther than most targets of a run, so that many characters pass each other.
    let trial_config = TrialConfig { streams: true, distances: [7.0, 8.0], ..args.crowd.trial() };
    let (report, record) = trial::run(&tables, &trial_config)?;
    picture::trial_sheet(&tables, &trial_config, &report, &record)?.save_png(&args.out)?;
    if args.json {
        return output::json(&DemoReport { trial: report, build: built });
    }
    build::print(&built, None, &args.bundle.display().to_string())?;
    run::print(&report)?;
    output::table(&[("picture", args.out.display().to_string())])?;
    let model = args.bundle.with_extension("glb");
    help::next_step(&["export", &args.bundle.to_string_lossy(), "--format", "glb", "--out", &model.to_string_lossy()])
}
