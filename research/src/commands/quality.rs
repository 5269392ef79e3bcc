//! `quality`: policies against exhaustive search, and against motion matching.

use crate::args::CommandResult;
use crate::{keys, output};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use throng_core::base::limits;
use throng_research::measure::{self, MatchingConfig, MatchingFigures};
use throng_research::quality::{PAIRS, Quality, QualityConfig, quality};

/// Measure what policies collect against search to a depth of four actions, and against motion matching over all frames of
/// the bundle, with the same targets.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<QualityComparison>())]
pub struct Args {
    /// Bundle with a motion graph.
    #[arg(value_name = "BUNDLE")]
    file: PathBuf,
    /// Time given to each figure.
    #[arg(long, default_value_t = 0.5, value_name = "S", allow_negative_numbers = true, value_parser = limits::number_parser::<f64>(&limits::MEASURING_S))]
    seconds: f64,
    /// Random (state, target) pairs that are searched.
    #[arg(long, default_value_t = 1000, value_name = "N", allow_negative_numbers = true, value_parser = limits::number_parser::<usize>(&PAIRS))]
    pairs: usize,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Everything that was measured.
#[derive(Serialize, JsonSchema)]
struct QualityComparison {
    /// Each policy against exhaustive search.
    quality: Vec<Quality>,
    /// Policies against motion matching.
    matching: MatchingFigures,
}

pub fn run(args: &Args) -> CommandResult {
    let tables = crate::args::open_bundle(&args.file)?;
    let quality = quality(&tables, &QualityConfig { pairs: args.pairs, ..QualityConfig::default() })?;
    let matching = measure::matching(&tables, &MatchingConfig { seconds: args.seconds, ..MatchingConfig::default() })?;
    if args.json {
        return output::json(&QualityComparison { quality, matching });
    }
    quality.iter().try_for_each(print_quality)?;
    print_matching(&matching)
}

fn print_quality(q: &Quality) -> CommandResult {
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

fn print_matching(m: &MatchingFigures) -> CommandResult {
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
