//! `blend`: what blending costs, and how it moves beside cross-fading.

use crate::args::{CacheArgs, CommandResult, fail};
use crate::{keys, output, progress};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use throng_core::Bundle;
use throng_core::base::limits;
use throng_precompute::config::BuildConfig;
use throng_precompute::pipeline;
use throng_research::measure::{self, BlendFigures};

/// Synthetic locomotion; this config names no file.
const LOCOMOTION: &str = include_str!("../../../data/locomotion.toml");
/// Its space with 20 examples, as many as the crowds of Kim, Kim and Shin (2003b) have.
const FIRST: &str = "gaits";

/// Measure blend spaces: weights, postures, retargeting, and jumps of the parameters beside cross-fading.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<BlendComparison<'static>>())]
pub struct Args {
    /// Bundle with blend spaces; synthetic locomotion, baked first, where absent.
    #[arg(value_name = "BUNDLE")]
    file: Option<PathBuf>,
    /// Time given to each figure.
    #[arg(long, default_value_t = 0.5, value_name = "S", allow_negative_numbers = true, value_parser = limits::number_parser::<f64>(&limits::MEASURING_S))]
    seconds: f64,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// What is printed: the figures of the space `gaits`, or of the first one, and those of all.
#[derive(Serialize, JsonSchema)]
struct BlendComparison<'a> {
    #[serde(flatten)]
    first: &'a BlendFigures,
    /// The same figures of every blend space.
    spaces: &'a [BlendFigures],
}

pub fn run(args: &Args) -> CommandResult {
    let tables = match &args.file {
        Some(file) => crate::args::open_bundle(file)?,
        None => own(&args.cache)?,
    };
    if tables.blends().spaces.is_empty() {
        let file = args.file.as_deref().unwrap_or(Path::new("the bundle")).display();
        return fail(format!("{file}: has no blend space; data/locomotion.toml makes some"));
    }
    let spaces = measure::blend(&tables, args.seconds)?;
    let first = spaces.iter().find(|s| s.space == FIRST).unwrap_or(&spaces[0]);
    if args.json {
        return output::json(&BlendComparison { first, spaces: &spaces });
    }
    spaces.iter().try_for_each(print)
}

/// Bakes synthetic locomotion.
fn own(cache: &CacheArgs) -> Result<Bundle, Box<dyn std::error::Error>> {
    let config = BuildConfig::parse(LOCOMOTION, Path::new("locomotion.toml"))?;
    let folder = tempfile::tempdir()?;
    let bundle = folder.path().join("locomotion.throng");
    eprintln!("baking synthetic locomotion ...");
    pipeline::build(&config, &bundle, &cache.cache()?, &progress::BuildProgressBar::default())?;
    crate::args::open_bundle(&bundle)
}

fn print(f: &BlendFigures) -> CommandResult {
    output::table(&[
        ("space", format!("{}: {} examples, {} axes, {} joints", f.space, f.examples, f.axes, f.joints)),
        (
            "weights",
            format!(
                "{:.1} ns a query, {:.1} times faster than directly ({:.0} ns); error {:.4} at most, {}",
                f.weights_ns_per_query,
                f.weights_direct_over_table,
                f.weights_direct_ns_per_query,
                f.weight_table_max_error,
                output::bytes(f.weight_table_bytes)
            ),
        ),
        (
            "postures",
            format!(
                "{:.2} million a second, {:.1} times a copy ({:.1} ns); retargeted {:.2} million",
                f.postures_per_second / 1e6,
                f.posture_over_memcpy,
                f.memcpy_ns_per_posture,
                f.retargeted_per_second / 1e6
            ),
        ),
        (
            "jumps",
            format!(
                "feet slip {:.3} m/s (95th percentile), cross-faded {:.3}; knees turn at {:.0} rad/s, {:.0}; joints \
                 accelerate by {:.0} m/s^2, {:.0}",
                f.foot_slip_p95_mps,
                f.crossfade_foot_slip_p95_mps,
                f.knee_rate_max_radps,
                f.crossfade_knee_rate_max_radps,
                f.joint_acceleration_max_mps2,
                f.crossfade_joint_acceleration_max_mps2
            ),
        ),
    ])
}
