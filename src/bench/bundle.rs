//! `throng bench bundle`: cost of queries, sampling and steps, and quality of policies.

use crate::args::{CommandResult, open_bundle};
use crate::{keys, output};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use throng_core::base::error::ensure;
use throng_core::base::limits;
use throng_precompute::measure::{self, BundleMeasureConfig, BundleMeasureReport, LevelFigures};

/// Measure queries, sampling and steps of a bundle beside copying the same bytes, and value iteration.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<BundleBenchReport>())]
pub struct Args {
    /// Bundle with a motion graph.
    #[arg(value_name = "BUNDLE")]
    file: PathBuf,
    /// Numbers of characters.
    #[arg(long, value_delimiter = ',', default_value = "1000,10000", value_name = "N,...", value_parser = limits::number_parser::<usize>(&limits::CHARACTERS))]
    characters: Vec<usize>,
    /// Numbers of threads.
    #[arg(long, value_delimiter = ',', default_value = "1,2", value_name = "N,...", value_parser = limits::number_parser::<usize>(&limits::THREADS))]
    threads: Vec<usize>,
    /// Time given to each figure.
    #[arg(long, default_value_t = 0.5, value_name = "S", value_parser = limits::number_parser::<f64>(&limits::MEASURING_S))]
    seconds: f64,
    /// Measure the levels of detail alone: everybody posed whole, without locked feet, as records of 32 bytes. On one thread.
    #[arg(long)]
    lod: bool,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// Printed report.
#[derive(Serialize, JsonSchema)]
struct BundleBenchReport {
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    measured: Option<BundleMeasureReport>,
    /// The levels of detail; with `--lod`.
    #[serde(skip_serializing_if = "Option::is_none")]
    levels: Option<Vec<LevelFigures>>,
}

pub fn run(args: &Args) -> CommandResult {
    let tables = open_bundle(&args.file)?;
    let is_measured = !tables.graph().states.is_empty() || tables.blends().spaces.is_empty();
    let fault = || format!("{}: holds blend spaces and no motion graph, which alone is measured", args.file.display());
    ensure(is_measured, fault)?;
    let config = BundleMeasureConfig {
        characters: args.characters.clone(),
        threads: args.threads.clone(),
        seconds: args.seconds,
    };
    let levels = args.lod.then(|| measure::levels(&tables, &config)).transpose()?;
    let measured = (!args.lod).then(|| measure::measure(&tables, &config)).transpose()?;
    output::report(&BundleBenchReport { measured, levels }, args.json, print)
}

/// Prints the figures as text.
fn print(report: &BundleBenchReport) -> CommandResult {
    report.measured.iter().try_for_each(print_crowds)?;
    report.levels.iter().flatten().try_for_each(print_levels)
}

fn print_crowds(measured: &BundleMeasureReport) -> CommandResult {
    for r in &measured.results {
        let [look, actions, look_62] = [r.lookahead_ns_per_query, r.lookahead_actions, r.lookahead_62_ns_per_query];
        let [step, copy] = [r.step_ns_per_character, r.memcpy_ns_per_character];
        let single = format!("({:.1} with single load)", r.step_single_load_ns_per_character);
        output::table(&[
            ("crowd", format!("{} characters, {} thread(s)", r.characters, r.threads)),
            ("  single load", format!("{:.1} ns a query", r.control_ns_per_query)),
            ("  look-ahead", format!("{look:.1} ns a query over {actions:.1} actions, {look_62:.1} over 62")),
            ("  sampling", format!("{:.2} ns a joint, model matrices included", r.sample_ns_per_joint)),
            ("  step", format!("{step:.1} ns a character {single}, {:.0} steps a second", r.steps_per_second)),
            ("  memcpy", format!("{copy:.1} ns a character; a step takes {:.1} times as long", step / copy)),
        ])?;
    }
    let v = &measured.value_iteration;
    let pairs = format!("{:.1} million pairs, {} sweeps ({} greedy)", v.pairs as f64 / 1e6, v.sweeps, v.greedy_sweeps);
    let times = format!("{:.3} s: setup {:.3}, sweeps {:.3}", v.seconds, v.setup_seconds, v.sweep_seconds);
    let bytes = output::bytes(v.bytes_per_sweep as u64);
    let gb_s = v.bytes_per_sweep as f64 * f64::from(v.sweeps) / v.sweep_seconds.max(1e-9) / 1e9;
    let moved = format!("a sweep moves {bytes}, at {gb_s:.1} GB/s if greedy ones were free");
    let copied = format!("a copy moves {:.1} GB/s", v.copy_bytes_per_second / 1e9);
    output::table(&[("value iteration", format!("{pairs}, {times}; residual {:.1e}; {moved}, {copied}", v.residual))])
}

fn print_levels(l: &LevelFigures) -> CommandResult {
    let bytes = l.record_bytes.map_or(String::new(), |b| format!(", {b:.0} bytes a character"));
    let share = format!("{:.2} of a full step", l.record_ns / l.full_ns);
    output::table(&[
        ("levels", format!("{} characters, 1 thread", l.characters)),
        ("  full", format!("{:.1} ns a character", l.full_ns)),
        ("  free feet", format!("{:.1} ns a character", l.free_feet_ns)),
        ("  record", format!("{:.1} ns a character, {share}{bytes}", l.record_ns)),
    ])
}
