//! `throng inspect`: what is in a motion file or bundle?

mod environment;

use crate::args::{Outcome, fail};
use crate::output;
use std::path::PathBuf;
use throng_precompute::import::ImportConfig;
use throng_precompute::inspect::{self, BundleReport, hit_picture};

/// Report what is in a motion file (format, units, axes, rest pose, roles, foot contacts, effective hits, and why), or
/// which motion and hits a bundle holds; or infer from contacts what the clips of a session were captured on.
///
/// JSON keys: file, format, joints, frames, rate_hz, duration_s, metres_per_unit, up, rest_pose, facing_deg, height_m,
/// profile, roles (object: role to joint), findings, contact, hits {count, angle_rad, distance_m, height_m (each
/// [min, max], null without hits), kinds (object: name to count)}, excluded, warnings; of a bundle: file, name, clips,
/// frames, rate_hz, states, actions, behaviours, hits, clip_hits (object: clip to kinds); with --environment-out or
/// --environment-png: clips, frames, foot_places, seat_places, hand_places, hands_unexplained, on_ground, plates,
/// plates_of_one, bars, bars_guessed, dismissed, units, residual_rms_m, residual_max_m, planted_share, penetrating_share,
/// environment_out, units_out, world_out (the files written, with --environment-out).
#[derive(clap::Args)]
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
    print!("{report}");
    Ok(())
}
