//! `throng bench bundle`: cost of queries, sampling and steps, and quality of policies.

use crate::args::{Outcome, fail};
use crate::{keys, output};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use throng_precompute::measure::{self, LevelFigures, MatchingConfig, MatchingFigures, MeasureConfig, Measured};
use throng_precompute::policy::{Quality, QualityConfig};
use throng_runtime::base::limits;

/// Measure queries, sampling and steps of a bundle beside copying the same bytes, and value iteration.
#[derive(clap::Args)]
#[command(after_long_help = keys::of::<Report>())]
pub struct Args {
    /// Bundle with a motion graph.
    #[arg(value_name = "BUNDLE")]
    file: PathBuf,
    /// Numbers of characters.
    #[arg(long, value_delimiter = ',', default_value = "1000,10000", value_name = "N,...", allow_negative_numbers = true, value_parser = limits::number::<usize>(&limits::CHARACTERS))]
    characters: Vec<usize>,
    /// Numbers of threads.
    #[arg(long, value_delimiter = ',', default_value = "1,2", value_name = "N,...", allow_negative_numbers = true, value_parser = limits::number::<usize>(&limits::THREADS))]
    threads: Vec<usize>,
    /// Time given to each figure.
    #[arg(long, default_value_t = 0.5, value_name = "S", allow_negative_numbers = true, value_parser = limits::number::<f64>(&limits::MEASURING_S))]
    seconds: f64,
    /// Also measure what the policies collect against search to a depth of four actions, and against motion matching over
    /// all frames of the bundle, with the same targets.
    #[arg(long)]
    quality: bool,
    /// Random (state, target) pairs that are searched.
    #[arg(long, default_value_t = 1000, value_name = "N", allow_negative_numbers = true, value_parser = limits::number::<usize>(&limits::PAIRS))]
    pairs: usize,
    /// Measure the levels of detail alone: everybody posed whole, without locked feet, as records of 32 bytes. On one thread.
    #[arg(long, conflicts_with = "quality")]
    lod: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Printed report.
#[derive(Serialize, JsonSchema)]
struct Report {
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    measured: Option<Measured>,
    /// The levels of detail; with `--lod`.
    #[serde(skip_serializing_if = "Option::is_none")]
    levels: Option<Vec<LevelFigures>>,
    /// Each policy against exhaustive search; with `--quality`.
    #[serde(skip_serializing_if = "Option::is_none")]
    quality: Option<Vec<Quality>>,
    /// Policies against motion matching; with `--quality`.
    #[serde(skip_serializing_if = "Option::is_none")]
    matching: Option<MatchingFigures>,
}

pub fn run(args: &Args) -> Outcome {
    let tables = crate::args::open(&args.file)?;
    if tables.graph().states.is_empty() && !tables.blends().spaces.is_empty() {
        let file = args.file.display();
        return fail(format!("{file}: holds blend spaces and no motion graph; use `throng bench blend {file}`"));
    }
    let config =
        MeasureConfig { characters: args.characters.clone(), threads: args.threads.clone(), seconds: args.seconds };
    let levels = args.lod.then(|| measure::levels(&tables, &config)).transpose()?;
    let measured = (!args.lod).then(|| measure::measure(&tables, &config)).transpose()?;
    let asked = QualityConfig { pairs: args.pairs, ..QualityConfig::default() };
    let quality = args.quality.then(|| measure::quality(&tables, &asked)).transpose()?;
    let against = MatchingConfig { seconds: args.seconds, ..MatchingConfig::default() };
    let matching = args.quality.then(|| measure::matching(&tables, &against)).transpose()?;
    let report = Report { measured, levels, quality, matching };
    if args.json { output::json(&report) } else { print(&report) }
}

/// Prints the figures as text.
fn print(report: &Report) -> Outcome {
    report.measured.iter().try_for_each(print_crowds)?;
    report.levels.iter().flatten().try_for_each(print_levels)?;
    report.quality.iter().flatten().try_for_each(print_quality)?;
    report.matching.iter().try_for_each(print_matching)
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

fn print_levels(l: &LevelFigures) -> Outcome {
    let bytes = l.record_bytes.map_or(String::new(), |b| format!(", {b:.0} bytes a character"));
    output::table(&[
        ("levels", format!("{} characters, 1 thread", l.characters)),
        ("  full", format!("{:.1} ns a character", l.full_ns)),
        ("  free feet", format!("{:.1} ns a character", l.free_feet_ns)),
        (
            "  record",
            format!("{:.1} ns a character, {:.2} of a full step{bytes}", l.record_ns, l.record_ns / l.full_ns),
        ),
    ])
}

fn print_quality(q: &Quality) -> Outcome {
    let percent = |v: f64| format!("{:.2} %", 100.0 * v);
    let temperatures: Vec<String> =
        q.temperatures.iter().map(|t| format!("{} at {}", percent(t.ratio_mean), t.temperature)).collect();
    let asked = ("quality", format!("{}: {} of {} pairs have something to gain", q.policy, q.pairs, q.asked));
    let time = ("  time", format!("{:.2} s, {:.2} of them for {} look-aheads", q.seconds, q.search_s, q.look_aheads));
    if q.pairs == 0 {
        return output::table(&[asked, ("  regret", format!("{:.5} on average", q.regret_mean)), time]);
    }
    output::table(&[
        asked,
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
        time,
    ])
}

fn print_matching(m: &MatchingFigures) -> Outcome {
    let seconds = |s: Option<f64>| s.map_or("never".to_owned(), |s| format!("{s:.2} s"));
    let mut rows = vec![
        ("matching", format!("{} frames", m.frames)),
        (
            "  a query",
            format!(
                "{:.1} us through boxes, {:.1} through a k-d tree, {:.1} through all; {:.0} look-aheads of {:.1} ns, {:.0} single loads of {:.1} ns",
                m.query_ns / 1e3,
                m.kd_tree_query_ns / 1e3,
                m.brute_force_query_ns / 1e3,
                m.query_over_lookahead,
                m.lookahead_ns,
                m.query_over_single_load,
                m.single_load_ns
            ),
        ),
        (
            "  reached",
            format!(
                "{:.1} % by the policy, after {}; {:.1} % by matching, after {}",
                100.0 * m.policy_reached_fraction,
                seconds(m.policy_time_to_reach_s),
                100.0 * m.matching_reached_fraction,
                seconds(m.matching_time_to_reach_s)
            ),
        ),
    ];
    if let (Some(policy), Some(matching)) = (m.policy_hits_per_minute, m.matching_hits_per_minute) {
        let share = |v: Option<f64>| format!("{:.0} % of them land", 100.0 * v.unwrap_or(0.0));
        let gap = |v: Option<f64>| format!("{:.1} cm between frames", 100.0 * v.unwrap_or(0.0));
        rows.push((
            "  hits",
            format!(
                "{policy:.1} a minute by the policies, {}, {}; {matching:.1} by matching, {}, {}",
                share(m.policy_landed_fraction),
                gap(m.policy_gap_m),
                share(m.matching_landed_fraction),
                gap(m.matching_gap_m)
            ),
        ));
    }
    output::table(&rows)
}
