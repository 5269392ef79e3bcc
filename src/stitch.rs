//! `throng stitch`: a world from the patches of a bundle.

use crate::args::{CacheArgs, CommandResult};
use crate::{help, keys, output, progress};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use throng_core::Bundle;
use throng_precompute::cache::Cache;
use throng_precompute::run::{self, BuildContext};
use throng_precompute::stitch::{self, StitchKit, StitchReport, WorldSource};
use throng_world::World;

/// Stitch a world: place the motion patches of a bundle in a target environment and join them.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<StitchCommandReport<'static>>())]
pub struct Args {
    /// World file (TOML); data/worlds/ has examples. Its bundle is built from its config if it is missing.
    #[arg(value_name = "WORLD")]
    file: PathBuf,
    /// File to write; the world's name with `.world`, beside the bundle, where absent. A world of that name that was
    /// stitched from another file is then refused, not replaced.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Bundle in place of the world's.
    #[arg(long, value_name = "FILE")]
    bundle: Option<PathBuf>,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// Printed report.
#[derive(Serialize, JsonSchema)]
struct StitchCommandReport<'a> {
    /// Name of the world.
    world: &'a str,
    #[serde(flatten)]
    stitched: &'a StitchReport,
    /// File that was written.
    out: &'a Path,
}

pub fn run(args: &Args) -> CommandResult {
    let mut source = WorldSource::load(&args.file)?;
    if let Some(bundle) = &args.bundle {
        (source.bundle, source.config) = (bundle.clone(), None);
    }
    let out = args.out.clone().unwrap_or_else(|| source.stitched_path());
    stitch::check_replaced(&args.file, &out)?;
    let tables = world_bundle(&source, &args.cache)?;
    let (kit, bar) = (StitchKit::new(&tables, &source.bundle)?, progress::BuildProgressBar::default());
    let (mut world, mut report) = stitch::stitch_source(&source, &args.file, &tables, &kit, &bar)?;
    report.world_bytes = stitch::save(&mut world, &args.file, tables.patches(), &out)?;
    if args.json {
        return output::json(&StitchCommandReport { world: &source.name, stitched: &report, out: &out });
    }
    print(&source, &report, &out)?;
    help::next_step(&["view", &args.file.to_string_lossy()])
}

/// Opens the bundle of a world, which is built first if it does not exist.
pub fn world_bundle(source: &WorldSource, cache: &CacheArgs) -> CommandResult<Bundle> {
    crate::run::ensure_bundle(&source.bundle, source.config.as_deref(), cache)?;
    crate::args::open_bundle(&source.bundle)
}

/// Opens the stitched world of a world file, which is stitched first if it is missing, or if the bundle or the source changed.
pub fn open_world(source: &WorldSource, file: &Path, tables: &Bundle) -> CommandResult<World> {
    let (out, progress) = (source.stitched_path(), progress::BuildProgressBar::default());
    let report_news = &|news| output::print_to_stderr(news);
    let with = BuildContext { cache: &Cache::disabled(), progress: &progress, report_news };
    run::ensure_world(source, file, tables, &out, &with)?;
    Ok(World::open(&out, tables)?)
}

fn print(source: &WorldSource, r: &StitchReport, out: &Path) -> CommandResult {
    let of = |counts: &std::collections::BTreeMap<String, u64>| {
        let each: Vec<String> = counts.iter().map(|(name, n)| format!("{n} {}", name.replace('_', " "))).collect();
        if each.is_empty() { "nothing".to_owned() } else { each.join(", ") }
    };
    let patches: Vec<String> = r.patches.iter().map(|(name, n)| format!("{n} {name}")).collect();
    output::table(&[
        ("world", format!("{}: {} instances ({})", source.name, r.instances, patches.join(", "))),
        ("motion", format!("{} cells, {} transitions, {:.2} h", r.cells, r.transitions, r.motion_hours)),
        ("joints", format!("{} in {} kinds of overlaps", r.joints, r.tables)),
        ("disabled", of(&r.disabled)),
        ("time", format!("{:.2} s, {} at most", r.seconds, output::bytes(r.peak_bytes))),
        ("written", format!("{}, {}", out.display(), output::bytes(r.world_bytes))),
    ])
}
