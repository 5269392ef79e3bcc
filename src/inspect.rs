//! `throng inspect`: what is in a motion file or bundle?

use crate::args::Outcome;
use crate::output;
use std::path::PathBuf;
use throng_precompute::import::ImportConfig;
use throng_precompute::inspect::{self, BundleReport, hit_picture};

/// Report what is in a motion file (format, units, axes, rest pose, roles, foot contacts, effective hits, and why), or
/// which motion and hits a bundle holds.
///
/// JSON keys: file, format, joints, frames, rate_hz, duration_s, metres_per_unit, up, rest_pose, facing_deg, height_m,
/// profile, roles (object: role to joint), findings, contact, hits {count, angle_rad, distance_m, height_m (each
/// [min, max], null without hits), kinds (object: name to count)}, excluded, warnings; of a bundle: file, name, clips,
/// frames, rate_hz, states, actions, behaviours, hits, clip_hits (object: clip to kinds).
#[derive(clap::Args)]
pub struct Args {
    /// Motion file (.bvh, .amc) or bundle (.throng).
    file: PathBuf,
    /// Skeleton of an AMC file; found beside it by default.
    #[arg(long, value_name = "FILE")]
    asf: Option<PathBuf>,
    /// Draw the effective hitting points from the front, from above and from the side (PNG).
    #[arg(long, value_name = "FILE")]
    hits_png: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    let stem = args.file.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let title = format!("{stem}: effective hitting points");
    if crate::args::is_bundle(&args.file) {
        let tables = crate::args::open(&args.file)?;
        if let Some(path) = &args.hits_png {
            hit_picture::of_tables(&tables, &title).save_png(path)?;
        }
        return print(args, &BundleReport::new(&args.file, &tables));
    }
    let config = ImportConfig { asf: args.asf.clone(), ..ImportConfig::default() };
    let inspected = inspect::inspect_clip(&args.file, &config)?;
    if let Some(path) = &args.hits_png {
        hit_picture::of_set(&inspected.clips, &title).save_png(path)?;
    }
    print(args, &inspected.report)
}

fn print(args: &Args, report: &(impl serde::Serialize + std::fmt::Display)) -> Outcome {
    if args.json {
        return output::json(report);
    }
    print!("{report}");
    Ok(())
}
