//! `throng stitch`: a world from the patches of a bundle.

use crate::args::{CacheArgs, Outcome};
use crate::{output, progress};
use serde::Serialize;
use std::path::{Path, PathBuf};
use throng_precompute::stitch::{self, Kit, StitchReport, WorldSource};
use throng_runtime::Tables;
use throng_runtime::world::WorldFile;

/// Stitch a world: lay the motion patches of a bundle over a target environment and join them.
///
/// JSON keys: world, instances, patches (object: name to count), cells, transitions, motion_hours, disabled (object: cells
/// and links taken out, by reason: no_neighbour, obstacle, dead_end, outside_component), tables, joints, seconds,
/// peak_bytes, world_bytes, out.
#[derive(clap::Args)]
pub struct Args {
    /// World file (TOML); data/worlds/ has examples. Its bundle is built from its config where it is not there.
    #[arg(value_name = "WORLD")]
    file: PathBuf,
    /// File to write; the world's name with `.world`, beside the bundle, where absent.
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

/// What is printed.
#[derive(Serialize)]
struct Report<'a> {
    world: &'a str,
    #[serde(flatten)]
    stitched: &'a StitchReport,
    out: &'a Path,
}

pub fn run(args: &Args) -> Outcome {
    let mut source = WorldSource::load(&args.file)?;
    if let Some(bundle) = &args.bundle {
        (source.bundle, source.config) = (bundle.clone(), None);
    }
    let out = args.out.clone().unwrap_or_else(|| source.stitched_path());
    let tables = bundle(&source, &args.cache)?;
    let report = make(&source, &args.file, &tables, &out)?;
    if args.json {
        return output::json(&Report { world: &source.name, stitched: &report, out: &out });
    }
    print(&source, &report, &out)
}

/// The bundle of a world, which is built where it is not there.
pub fn bundle(source: &WorldSource, cache: &CacheArgs) -> Result<Tables, Box<dyn std::error::Error>> {
    crate::run::make_bundle(&source.bundle, source.config.as_deref(), cache)?;
    crate::args::open(&source.bundle)
}

/// Stitches a world and writes it.
fn make(
    source: &WorldSource,
    file: &Path,
    tables: &Tables,
    out: &Path,
) -> Result<StitchReport, Box<dyn std::error::Error>> {
    let kit = Kit::new(tables, &source.bundle)?;
    let (world, mut report) = stitch::stitch_source(source, file, tables, &kit, &progress::Bar::default())?;
    report.world_bytes = stitch::save(&world, out)?;
    Ok(report)
}

/// The stitched world of a world file; it is stitched where that has not been done, or was done with another bundle or
/// from another text.
pub fn open(source: &WorldSource, file: &Path, tables: &Tables) -> Result<WorldFile, Box<dyn std::error::Error>> {
    let out = source.stitched_path();
    if is_newer(&out, file)
        && let Ok(world) = WorldFile::open(&out, tables)
    {
        return Ok(world);
    }
    eprintln!("stitching {} ...", source.name);
    make(source, file, tables, &out)?;
    Ok(WorldFile::open(&out, tables)?)
}

/// True where `made` is there and was written after `from`.
fn is_newer(made: &Path, from: &Path) -> bool {
    let time = |p: &Path| std::fs::metadata(p).and_then(|m| m.modified());
    time(made).is_ok_and(|m| time(from).is_ok_and(|f| m > f))
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
