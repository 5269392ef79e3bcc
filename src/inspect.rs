//! `throng inspect`: what is in a motion file?

use crate::args::Outcome;
use crate::output;
use std::path::PathBuf;
use throng_precompute::import::ImportConfig;
use throng_precompute::inspect;

/// Report what is in a motion file: format, units, axes, rest pose, roles, foot contacts, and why.
///
/// JSON keys: file, format, joints, frames, rate_hz, duration_s, metres_per_unit, up, rest_pose, facing_deg, height_m,
/// profile, roles (object: role to joint), findings, contact, hits {count, angle_rad, distance_m, height_m as
/// [min, max] (null without hits), kinds {name: count}}, excluded, warnings.
#[derive(clap::Args)]
pub struct Args {
    /// Motion file (.bvh, .amc).
    clip: PathBuf,
    /// Skeleton of an AMC file; found beside it by default.
    #[arg(long, value_name = "FILE")]
    asf: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    let config = ImportConfig { asf: args.asf.clone(), ..ImportConfig::default() };
    let report = inspect::inspect(&args.clip, &config)?;
    if args.json {
        return output::json(&report);
    }
    print!("{report}");
    Ok(())
}
