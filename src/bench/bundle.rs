//! `throng bench bundle`: cost of queries, sampling and steps, and quality of policies.

use crate::args::{CommandResult, open_bundle};
use crate::{keys, output};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use throng_core::{base::error::ensure, base::limits};
use throng_precompute::measure::{self, BundleMeasureConfig, CharactersFigures, LevelFigures};

/// Measure queries, sampling and steps of a bundle beside copying the same bytes.
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
    /// One entry for each number of characters and threads; without `--lod`.
    #[serde(skip_serializing_if = "Option::is_none")]
    results: Option<Vec<CharactersFigures>>,
    /// The levels of detail; with `--lod`.
    #[serde(skip_serializing_if = "Option::is_none")]
    levels: Option<Vec<LevelFigures>>,
}

pub fn run(args: &Args) -> CommandResult {
    let tables = open_bundle(&args.file)?;
    let is_measured = !tables.graph().states.is_empty() || tables.blends().spaces.is_empty();
    let fault = || format!("{}: holds blend spaces and no motion graph, which alone is measured", args.file.display());
    ensure(is_measured, fault)?;
    let (characters, threads) = (args.characters.clone(), args.threads.clone());
    let config = BundleMeasureConfig { characters, threads, seconds: args.seconds };
    let levels = args.lod.then(|| measure::levels(&tables, &config)).transpose()?;
    let results = (!args.lod).then(|| measure::characters(&tables, &config)).transpose()?;
    output::report(&BundleBenchReport { results, levels }, args.json, print)
}

/// Prints the figures as text.
fn print(report: &BundleBenchReport) -> CommandResult {
    report.results.iter().flatten().try_for_each(print_crowd)?;
    report.levels.iter().flatten().try_for_each(print_levels)
}

fn print_crowd(r: &CharactersFigures) -> CommandResult {
    let [step, copy] = [r.step_ns_per_character, r.memcpy_ns_per_character];
    let single = format!("({:.1} with single load)", r.step_single_load_ns_per_character);
    let weighed = format!("over {:.1} actions", r.lookahead_actions);
    output::table(&[
        ("crowd", format!("{} characters, {} thread(s)", r.characters, r.threads)),
        ("  single load", format!("{:.1} ns a query", r.control_ns_per_query)),
        ("  look-ahead", format!("{:.1} ns a query {weighed}", r.lookahead_ns_per_query)),
        ("  sampling", format!("{:.2} ns a joint, model matrices included", r.sample_ns_per_joint)),
        ("  step", format!("{step:.1} ns a character {single}, {:.0} steps a second", r.steps_per_second)),
        ("  memcpy", format!("{copy:.1} ns a character; a step takes {:.1} times as long", step / copy)),
    ])
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
