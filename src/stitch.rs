//! `throng stitch`: a world from the patches of a bundle.

use crate::args::{CacheArgs, Outcome};
use crate::{keys, output, progress};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use throng_precompute::cache::Cache;
use throng_precompute::run::{self, Cached};
use throng_precompute::stitch::{self, Kit, StitchReport, WorldSource};
use throng_runtime::Bundle;
use throng_runtime::world::World;

/// Stitch a world: place the motion patches of a bundle in a target environment and join them.
#[derive(clap::Args)]
#[command(after_long_help = keys::of::<Report<'static>>())]
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
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Printed report.
#[derive(Serialize, JsonSchema)]
struct Report<'a> {
    /// Name of the world.
    world: &'a str,
    #[serde(flatten)]
    stitched: &'a StitchReport,
    /// File that was written.
    out: &'a Path,
}

pub fn run(args: &Args) -> Outcome {
    let mut source = WorldSource::load(&args.file)?;
    if let Some(bundle) = &args.bundle {
        (source.bundle, source.config) = (bundle.clone(), None);
    }
    let out = match &args.out {
        Some(out) => out.clone(),
        None => source.stitched_path(),
    };
    stitch::check_replaced(&args.file, &out)?;
    let tables = bundle(&source, &args.cache)?;
    let report = make(&source, &args.file, &tables, &out)?;
    if args.json {
        return output::json(&Report { world: &source.name, stitched: &report, out: &out });
    }
    print(&source, &report, &out)
}

/// Opens the bundle of a world, which is built first if it does not exist.
pub fn bundle(source: &WorldSource, cache: &CacheArgs) -> Result<Bundle, Box<dyn std::error::Error>> {
    crate::run::make_bundle(&source.bundle, source.config.as_deref(), cache)?;
    crate::args::open(&source.bundle)
}

/// Stitches a world and writes it.
fn make(
    source: &WorldSource,
    file: &Path,
    tables: &Bundle,
    out: &Path,
) -> Result<StitchReport, Box<dyn std::error::Error>> {
    let kit = Kit::new(tables, &source.bundle)?;
    let (mut world, mut report) = stitch::stitch_source(source, file, tables, &kit, &progress::Bar::default())?;
    report.world_bytes = stitch::save(&mut world, file, tables.patches(), out)?;
    Ok(report)
}

/// Opens the stitched world of a world file, which is stitched first if it is missing, or if the bundle or the source changed.
pub fn open(source: &WorldSource, file: &Path, tables: &Bundle) -> Result<World, Box<dyn std::error::Error>> {
    let out = source.stitched_path();
    let progress = progress::Bar::default();
    let with = Cached { cache: &Cache::none(), progress: &progress, tell: &|news| output::tell(news) };
    run::ensure_world(source, file, tables, &out, &with)?;
    Ok(World::open(&out, tables)?)
}

fn print(source: &WorldSource, r: &StitchReport, out: &Path) -> Outcome {
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
