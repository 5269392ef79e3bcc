//! `throng bench` of blend spaces.

use super::Args;
use crate::args::Outcome;
use crate::{output, progress};
use serde::Serialize;
use std::path::Path;
use throng_precompute::config::BuildConfig;
use throng_precompute::measure::{self, BlendFigures};
use throng_precompute::pipeline;
use throng_runtime::Tables;

/// The project's own locomotion; it names no file.
const LOCOMOTION: &str = include_str!("../../data/locomotion.toml");
/// Its space with the 20 examples of the paper's crowds.
const FIRST: &str = "gaits";

/// What is printed.
#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    first: &'a BlendFigures,
    spaces: &'a [BlendFigures],
}

/// Bakes the project's own locomotion and measures it.
pub fn run_own(args: &Args) -> Outcome {
    let config = BuildConfig::parse(LOCOMOTION, Path::new("locomotion.toml"))?;
    let folder = tempfile::tempdir()?;
    let bundle = folder.path().join("locomotion.throng");
    eprintln!("baking synthetic locomotion ...");
    pipeline::build(&config, &bundle, &args.cache.cache(), &progress::Bar::default())?;
    run(args, &crate::args::open(&bundle)?)
}

/// Measures the blend spaces of a bundle.
pub fn run(args: &Args, tables: &Tables) -> Outcome {
    let spaces = measure::blend(tables, args.seconds())?;
    let first = spaces.iter().find(|s| s.space == FIRST).unwrap_or(&spaces[0]);
    if args.json {
        return output::json(&Report { first, spaces: &spaces });
    }
    spaces.iter().try_for_each(print)
}

fn print(f: &BlendFigures) -> Outcome {
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
