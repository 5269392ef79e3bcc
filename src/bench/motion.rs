//! `throng bench motion`: quality of motion at run time beside the clips that it comes from.

use crate::args::{CacheArgs, CommandResult, is_bundle};
use crate::{keys, output, run};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use throng_precompute::quality::MotionQuality;
use throng_precompute::trial::{self, TrialConfig};

/// Compare motion at run time with its clips: low toes, knees, changes of segment, smoothness, life of the hands.
///
/// 200 characters chase targets for 20 s; the first 50 are measured in every frame.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys_under::<MotionBenchFigures>("JSON keys (of each of `results[]`)"))]
pub struct Args {
    /// Bundles, and folders or files of motion, each by itself; the synthetic walk by default.
    #[arg(value_name = "BUNDLE_OR_MOTION")]
    what: Vec<PathBuf>,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// Figures of one bundle.
#[derive(Serialize, JsonSchema)]
struct MotionBenchFigures {
    /// Name of the bundle or motion.
    name: String,
    #[serde(flatten)]
    quality: MotionQuality,
    /// 95th percentile of the speed of planted heels and toes (m/s).
    foot_slip_p95_mps: f64,
    /// Share of the characters that came within reach of their target.
    reached_fraction: f64,
}

#[derive(Serialize)]
struct MotionBenchReport {
    results: Vec<MotionBenchFigures>,
}

pub fn run(args: &Args) -> CommandResult {
    let mut results = Vec::new();
    if args.what.is_empty() {
        let folder = tempfile::tempdir()?;
        let bundle = folder.path().join("demo.throng");
        crate::demo::bake(&bundle)?;
        results.push(figures("synthetic walk".into(), &crate::args::open_bundle(&bundle)?)?);
    }
    for what in &args.what {
        let motion = std::slice::from_ref(what);
        let tables =
            if is_bundle(what) { crate::args::open_bundle(what)? } else { run::motion_bundle(motion, &args.cache)? };
        results.push(figures(what.display().to_string(), &tables)?);
    }
    if args.json {
        return output::json(&MotionBenchReport { results });
    }
    let mut text = String::from(
        "low toes m/s (clips)  knee max  p99.9  at changes (clips)  between frames  hand > 6 Hz (clips)  slip m/s\n",
    );
    for MotionBenchFigures { name, quality: q, foot_slip_p95_mps, .. } in &results {
        text.push_str(&format!(
            "{:11.2} ({:.2}) {:11.2} {:6.2} {:11.2} ({:.2}) {:15.2} {:12.3} ({:.3}) {:9.3}  {name}\n",
            q.toe_speed_low_p95_mps,
            q.source_toe_speed_low_p95_mps,
            q.knee_rate_max_ratio,
            q.knee_rate_p999_ratio,
            q.change_acceleration_ratio.unwrap_or(0.0),
            q.source_change_acceleration_ratio.unwrap_or(0.0),
            q.hips_acceleration_between_frames,
            q.hand_power_above_6hz,
            q.source_hand_power_above_6hz,
            foot_slip_p95_mps,
        ));
    }
    output::text(text)
}

fn figures(name: String, tables: &throng_core::Bundle) -> CommandResult<MotionBenchFigures> {
    let config = TrialConfig { characters: 200, ..TrialConfig::default() };
    let (report, _) = trial::run(tables, &config)?;
    let (quality, foot_slip_p95_mps) = (report.quality, report.foot_slip_p95_mps);
    Ok(MotionBenchFigures { name, quality, foot_slip_p95_mps, reached_fraction: report.reached_fraction })
}
