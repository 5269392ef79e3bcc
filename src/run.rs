//! `throng run`: a crowd on a bundle.

use crate::args::{CrowdArgs, Outcome};
use crate::output;
use std::path::{Path, PathBuf};
use throng_precompute::trial::{self, TrialConfig, TrialRecord, TrialReport};
use throng_runtime::Tables;

/// Run characters that each chase a target of their own, and measure what they do.
///
/// JSON keys: characters, simulated_s, reached_fraction, stayed_fraction, mean_arrival_s, mean_final_distance_m,
/// foot_slip_mean_mps, foot_slip_p95_mps, steps_per_second, poses_per_second, choices_per_second.
#[derive(clap::Args)]
pub struct Args {
    /// Bundle.
    bundle: PathBuf,
    /// Picture to write: the crowd from above and a strip of one character's poses.
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    #[command(flatten)]
    crowd: CrowdArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    let tables = crate::args::open(&args.bundle)?;
    let config = args.crowd.trial();
    let (report, record) = trial::run(&tables, &config)?;
    if let Some(png) = &args.png {
        draw(&tables, &config, &report, &record, png)?;
    }
    if args.json { output::json(&report) } else { print(&report) }
}

/// Writes the picture of a trial.
pub fn draw(tables: &Tables, config: &TrialConfig, report: &TrialReport, record: &TrialRecord, path: &Path) -> Outcome {
    throng_precompute::picture::trial_sheet(tables, config, report, record).save_png(path)?;
    Ok(())
}

/// What was measured, for people.
pub fn print(r: &TrialReport) -> Outcome {
    output::table(&[
        ("crowd", format!("{} characters, {:.0} s", r.characters, r.simulated_s)),
        (
            "targets",
            format!(
                "{:.1} % reached{}; {:.1} % near at the end",
                100.0 * r.reached_fraction,
                r.mean_arrival_s.map_or(String::new(), |s| format!(", after {s:.1} s on average")),
                100.0 * r.stayed_fraction
            ),
        ),
        (
            "foot slip",
            format!(
                "{:.3} m/s mean, {:.3} m/s 95th percentile, while planted",
                r.foot_slip_mean_mps, r.foot_slip_p95_mps
            ),
        ),
        (
            "speed",
            format!(
                "{:.0} steps a second of the whole crowd on one thread; {:.2} million poses, {:.0} choices a second",
                r.steps_per_second,
                r.poses_per_second / 1e6,
                r.choices_per_second
            ),
        ),
    ])
}
