//! `throng bench motion`: quality of motion at run time beside the clips that it comes from.

use crate::args::{CacheArgs, CommandResult, is_bundle, open_bundle};
use crate::{keys, output, run};
use schemars::JsonSchema;
use serde::Serialize;
use std::{collections::BTreeMap, path::PathBuf};
use throng_precompute::drills::{self, DrillFigures};
use throng_precompute::trial::{self, TrialConfig, TrialReport};
use throng_precompute::{config::BuildConfig, quality::MotionQuality, run::motion_name};

/// Compare motion at run time with its clips: moving, standing and changing apart, and answers to orders.
///
/// 200 characters chase targets for 20 s; the first 50 are measured in every frame. 24 walk, and turn, stop and follow.
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
    #[serde(flatten)]
    drills: DrillFigures,
    /// 95th percentile of the speed of planted heels and toes (m/s).
    foot_slip_p95_mps: f64,
    /// Share of the characters that came within reach of their target.
    reached_fraction: f64,
}

pub fn run(args: &Args) -> CommandResult {
    let mut results = Vec::new();
    if args.what.is_empty() {
        let folder = tempfile::tempdir()?;
        let bundle = folder.path().join("demo.throng");
        crate::demo::bake(&bundle)?;
        results.push(figures("synthetic walk".into(), &open_bundle(&bundle)?)?);
    }
    for what in &args.what {
        let motion = std::slice::from_ref(what);
        let tables = if is_bundle(what) {
            open_bundle(what)?
        } else {
            run::motion_bundle(&BuildConfig::of_motion(motion_name(motion), motion.to_vec())?, &args.cache)?
        };
        results.push(figures(what.display().to_string(), &tables)?);
    }
    if args.json {
        return output::json(&BTreeMap::from([("results", results)]));
    }
    let mut text = String::from(
        "low toes m/s (clips)  knee max  p99.9  at changes (clips)  between frames  hand > 6 Hz (clips)  slip m/s\n",
    );
    for MotionBenchFigures { name, quality: q, foot_slip_p95_mps: slip, .. } in &results {
        let toes = format!("{:11.2} ({:.2})", q.toe_speed_low_p95_mps, q.source_toe_speed_low_p95_mps);
        let knees = format!("{:11.2} {:6.2}", q.knee_rate_max_ratio, q.knee_rate_p999_ratio);
        let [own, source] = [q.change_acceleration_ratio, q.source_change_acceleration_ratio];
        let changes = format!("{:11.2} ({:.2})", own.unwrap_or(0.0), source.unwrap_or(0.0));
        let between = q.hips_acceleration_between_frames;
        let hands = format!("{:12.3} ({:.3})", q.hand_power_above_6hz, q.source_hand_power_above_6hz);
        text.push_str(&format!("{toes} {knees} {changes} {between:15.2} {hands} {slip:9.3}  {name}\n"));
    }
    text.push_str(
        "\nbackwards (clips)  facing deg (clips)  standing: drift cm (clips)  hips off cm (clips)  repeats s (clips)\n",
    );
    for MotionBenchFigures { name, quality: MotionQuality { apart: a, source_apart: b, .. }, .. } in &results {
        let pair = |a: Option<f64>, b: Option<f64>| {
            let [a, b] = [a, b].map(|v| v.map_or("-".into(), |v| format!("{v:.1}")));
            format!("{a:>11} ({b})")
        };
        let moving = format!("{:11.3} ({:.3})", a.backwards_share, b.backwards_share);
        let facing = pair(Some(a.facing_error_deg), Some(b.facing_error_deg));
        let drift = pair(a.standing_drift_cm, b.standing_drift_cm);
        let [off, repeat] = [pair(a.hips_off_feet_cm, b.hips_off_feet_cm), pair(a.repeat_s, b.repeat_s)];
        text.push_str(&format!("{moving} {facing} {drift:>20} {off:>18} {repeat:>18}  {name}\n"));
    }
    text.push_str("\na minute: changes moving, standing, manner  knee snaps  turn 90 s, m  180 s, m  standing 180 s  stop s, m  answer s  lag m\n");
    for MotionBenchFigures { name, quality: q, drills: d, .. } in &results {
        let [moving, standing] = [q.apart.changes_moving_per_min, q.apart.changes_standing_per_min];
        let changes = format!(
            "{moving:16.0} {standing:10.0} {:7.1} {:12.1}",
            q.apart.manner_changes_per_min, q.knee_snaps_per_min
        );
        let turns = format!("{:8.1} {:5.1} {:5.1} {:4.1}", d.turn_90_s, d.turn_90_m, d.turn_180_s, d.turn_180_m);
        let rest =
            format!("{:14.1} {:6.1} {:4.1} {:9.2} {:6.1}", d.turn_standing_s, d.stop_s, d.stop_m, d.answer_s, d.lag_m);
        text.push_str(&format!("{changes} {turns} {rest}  {name}\n"));
    }
    output::text(text)
}

fn figures(name: String, tables: &throng_core::Bundle) -> CommandResult<MotionBenchFigures> {
    let config = TrialConfig { characters: 200, ..TrialConfig::default() };
    let TrialReport { quality, foot_slip_p95_mps, reached_fraction, .. } = trial::run(tables, &config)?.0;
    Ok(MotionBenchFigures { name, quality, drills: drills::run(tables)?, foot_slip_p95_mps, reached_fraction })
}
