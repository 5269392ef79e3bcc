//! `throng inspect`: what is in a motion file or bundle?

mod environment;

use crate::args::{Outcome, fail};
use crate::{keys, output};
use std::path::PathBuf;
use throng_precompute::import::ImportConfig;
use throng_precompute::inspect::{self, BundleReport, ClipReport, hit_picture};

/// Report what is in a motion file (format, units, axes, rest pose, roles, foot contacts, effective hits, and why), or
/// which motion and hits a bundle holds; or infer from contacts what the clips were captured on.
#[derive(clap::Args)]
#[command(after_long_help = help())]
pub struct Args {
    /// Motion file (.bvh, .amc) or bundle (.throng); several motion files with --environment-out and --environment-png.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Skeleton of an AMC file; found beside it by default.
    #[arg(long, value_name = "FILE")]
    asf: Option<PathBuf>,
    /// Draw the effective hitting points from the front, from above and from the side (PNG).
    #[arg(long, value_name = "FILE")]
    hits_png: Option<PathBuf>,
    /// Write the surroundings that contacts speak for (TOML): what feet, seats and hands of the clips, captured in one
    /// session, were on. `-units` and `-world` are put to its name for its units and for a world that is stitched of
    /// them. Heights are those of a build of the same files with default settings.
    #[arg(long, value_name = "FILE")]
    environment_out: Option<PathBuf>,
    /// Draw the person at several moments in the inferred surroundings (PNG).
    #[arg(long, value_name = "FILE")]
    environment_png: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// What `--json` prints, by what is asked.
fn help() -> String {
    let clip = keys::section::<ClipReport>("JSON keys (of a motion file)");
    let bundle = keys::section::<BundleReport>("JSON keys (of a bundle)");
    let with = "JSON keys (with --environment-out or --environment-png)";
    format!(
        "{clip}
{bundle}
{}",
        keys::section::<environment::Report<'static>>(with)
    )
}

pub fn run(args: &Args) -> Outcome {
    if args.environment_out.is_some() || args.environment_png.is_some() {
        return environment::run(args);
    }
    let [file] = args.files.as_slice() else {
        return fail(format!("expected one file, found {}: several are for --environment-out", args.files.len()));
    };
    let stem = file.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let title = format!("{stem}: effective hitting points");
    if crate::args::is_bundle(file) {
        let tables = crate::args::open(file)?;
        if let Some(path) = &args.hits_png {
            hit_picture::of_tables(&tables, &title).save_png(path)?;
        }
        return print(args, &BundleReport::new(file, &tables));
    }
    let config = ImportConfig { asf: args.asf.clone(), ..ImportConfig::default() };
    let inspected = inspect::inspect_clip(file, &config)?;
    if let Some(path) = &args.hits_png {
        hit_picture::of_set(&inspected.clips, &title).save_png(path)?;
    }
    print(args, &inspected.report)
}

fn print(args: &Args, report: &(impl serde::Serialize + std::fmt::Display)) -> Outcome {
    if args.json {
        return output::json(report);
    }
    output::text(report)
}
