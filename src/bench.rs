//! `throng bench`: what does it cost on this machine?

use crate::args::Outcome;
use crate::output;
use serde::Serialize;
use std::path::PathBuf;
use throng_precompute::measure::{self, MeasureConfig, Measured};
use throng_precompute::policy::{Quality, QualityConfig};

/// Measure queries, sampling and steps of a bundle beside copying the same bytes, and value iteration.
///
/// JSON keys: results [characters, threads, control_ns_per_query, lookahead_ns_per_query, lookahead_actions,
/// lookahead_62_ns_per_query, sample_ns_per_joint, step_ns_per_character, step_single_load_ns_per_character,
/// memcpy_ns_per_character, steps_per_second], value_iteration {pairs, sweeps, greedy_sweeps, seconds (setup and
/// sweeps), setup_seconds, sweep_seconds, residual, bytes_per_sweep, copy_bytes_per_second}.
#[derive(clap::Args)]
pub struct Args {
    /// Bundle.
    file: PathBuf,
    /// Numbers of characters.
    #[arg(long, value_delimiter = ',', default_value = "1000,10000", value_name = "N,...")]
    characters: Vec<usize>,
    /// Numbers of threads.
    #[arg(long, value_delimiter = ',', default_value = "1,2", value_name = "N,...")]
    threads: Vec<usize>,
    /// Time given to each figure.
    #[arg(long, default_value_t = 0.5, value_name = "S")]
    seconds: f64,
    /// Also measure what the policies collect against search.
    #[arg(long)]
    quality: bool,
    /// Random (state, target) pairs that are searched.
    #[arg(long, default_value_t = 1000, value_name = "N")]
    pairs: usize,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Everything that was measured.
#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    measured: Measured,
    #[serde(skip_serializing_if = "Option::is_none")]
    quality: Option<Vec<Quality>>,
}

pub fn run(args: &Args) -> Outcome {
    let tables = crate::args::open(&args.file)?;
    let config =
        MeasureConfig { characters: args.characters.clone(), threads: args.threads.clone(), seconds: args.seconds };
    let measured = measure::measure(&tables, &config)?;
    let asked = QualityConfig { pairs: args.pairs, ..QualityConfig::default() };
    let quality = args.quality.then(|| measure::quality(&tables, &asked)).transpose()?;
    let report = Report { measured, quality };
    if args.json { output::json(&report) } else { print(&report) }
}

/// The figures for people.
fn print(report: &Report) -> Outcome {
    print_crowds(&report.measured)?;
    report.quality.iter().flatten().try_for_each(print_quality)
}

fn print_crowds(measured: &Measured) -> Outcome {
    for r in &measured.results {
        output::table(&[
            ("crowd", format!("{} characters, {} thread(s)", r.characters, r.threads)),
            ("  single load", format!("{:.1} ns a query", r.control_ns_per_query)),
            (
                "  look-ahead",
                format!(
                    "{:.1} ns a query over {:.1} actions, {:.1} over 62",
                    r.lookahead_ns_per_query, r.lookahead_actions, r.lookahead_62_ns_per_query
                ),
            ),
            ("  sampling", format!("{:.2} ns a joint, model matrices included", r.sample_ns_per_joint)),
            (
                "  step",
                format!(
                    "{:.1} ns a character ({:.1} with single load), {:.0} steps a second",
                    r.step_ns_per_character, r.step_single_load_ns_per_character, r.steps_per_second
                ),
            ),
            (
                "  memcpy",
                format!(
                    "{:.1} ns a character; a step takes {:.1} times as long",
                    r.memcpy_ns_per_character,
                    r.step_ns_per_character / r.memcpy_ns_per_character
                ),
            ),
        ])?;
    }
    let v = &measured.value_iteration;
    output::table(&[(
        "value iteration",
        format!(
            "{:.1} million pairs, {} sweeps ({} greedy), {:.3} s: setup {:.3}, sweeps {:.3}; residual {:.1e}; a sweep moves {}, at {:.1} GB/s if greedy ones were free, a copy moves {:.1} GB/s",
            v.pairs as f64 / 1e6,
            v.sweeps,
            v.greedy_sweeps,
            v.seconds,
            v.setup_seconds,
            v.sweep_seconds,
            v.residual,
            output::bytes(v.bytes_per_sweep as u64),
            v.bytes_per_sweep as f64 * f64::from(v.sweeps) / v.sweep_seconds.max(1e-9) / 1e9,
            v.copy_bytes_per_second / 1e9
        ),
    )])
}

fn print_quality(q: &Quality) -> Outcome {
    let percent = |v: f64| format!("{:.2} %", 100.0 * v);
    let temperatures: Vec<String> =
        q.temperatures.iter().map(|t| format!("{} at {}", percent(t.ratio_mean), t.temperature)).collect();
    output::table(&[
        ("quality", format!("{}: {} of {} pairs have something to gain", q.policy, q.pairs, q.asked)),
        (
            "  against search",
            format!(
                "{} on average, {} at the 5th percentile, above 99 % in {} of the pairs; {} of what can be had by its actions; regret {:.5}",
                percent(q.ratio_mean),
                percent(q.ratio_p05),
                percent(q.near_best_fraction),
                percent(q.realised_ratio_mean),
                q.regret_mean
            ),
        ),
        ("  single load", format!("{} on average", percent(q.single_load_ratio_mean))),
        ("  at random", format!("{} (temperature)", temperatures.join(", "))),
        ("  time", format!("{:.2} s, {:.2} of them for {} look-aheads", q.seconds, q.search_s, q.look_aheads)),
    ])
}
