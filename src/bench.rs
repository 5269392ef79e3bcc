//! `throng bench`: what does it cost on this machine?

mod blend;
mod crowd;

use crate::args::{CacheArgs, Outcome, fail};
use crate::output;
use serde::Serialize;
use std::path::PathBuf;
use throng_precompute::measure::{
    self, EditFigures, MatchingConfig, MatchingFigures, MeasureConfig, Measured, PathFigures, WorldFigures,
};
use throng_precompute::policy::{Quality, QualityConfig};
use throng_precompute::scene::Scene;
use throng_precompute::stitch::WorldSource;

/// Measure queries, sampling and steps of a bundle beside copying the same bytes, and value iteration.
///
/// JSON keys: results [characters, threads, control_ns_per_query, lookahead_ns_per_query, lookahead_actions,
/// lookahead_62_ns_per_query, sample_ns_per_joint, step_ns_per_character, step_single_load_ns_per_character,
/// memcpy_ns_per_character, steps_per_second], value_iteration {pairs, sweeps, greedy_sweeps, seconds (setup and
/// sweeps), setup_seconds, sweep_seconds, residual, bytes_per_sweep, copy_bytes_per_second}; with --quality also
/// quality [policy, asked, pairs (with something to gain), ratio_mean, ratio_p05, near_best_fraction,
/// realised_ratio_mean, regret_mean, single_load_ratio_mean, temperatures [temperature, ratio_mean], look_aheads,
/// search_s, seconds] and matching {policies, frames, query_ns, kd_tree_query_ns, brute_force_query_ns, lookahead_ns,
/// single_load_ns, query_over_lookahead, query_over_single_load, policy_reached_fraction, matching_reached_fraction,
/// policy_time_to_reach_s, matching_time_to_reach_s, policy_hits_per_minute, matching_hits_per_minute,
/// policy_landed_fraction, matching_landed_fraction, policy_gap_m, matching_gap_m (distance of hips, feet and fists where
/// one frame takes the place of another)}.
///
/// Of a world (`.toml`): world, instances, cells, transitions, stitch_seconds (all threads), peak_bytes, edits [unit,
/// placed (how many), place (the one that was moved, the middle one), done (moves that were not refused), seconds (moving
/// it a few centimetres on, all threads, the median; null where all were refused), over_stitch], one for every kind of
/// unit, paths {found, seconds_mean, seconds_max, length_mean_m,
/// length_max_m, duration_mean_s, opened_instances_mean (ways of the upper layer), opened_nodes_mean, first_seconds (making
/// the planner), slowest (instances from and to), compared, over_dijkstra_mean, over_dijkstra_max, worst (instances from and
/// to; null in worlds too large to search through), over_bound_max (over what no way takes less than)}, paths_soon {the same
/// of paths for who cannot wait}, characters, steps_per_second (of all of them, on one thread).
///
/// Of blending (the word `blend`, which measures the project's own locomotion, or a bundle with blend spaces and no motion
/// graph): the figures of the first blend space, and spaces, those of all: space, examples, axes, joints,
/// postures_per_second, retargeted_per_second, memcpy_ns_per_posture, posture_over_memcpy, weights_ns_per_query,
/// weights_direct_ns_per_query, weights_direct_over_table, weight_table_max_error, weight_table_bytes, foot_slip_p95_mps,
/// crossfade_foot_slip_p95_mps, knee_rate_max_radps, crossfade_knee_rate_max_radps, joint_acceleration_max_mps2,
/// crossfade_joint_acceleration_max_mps2 (while parameters jump; beside cross-fading the nearest examples).
///
/// Of a crowd (the word `crowd`): scene, members, engine, simulated_s, wall_s_per_simulated_s, us_per_member_second,
/// events_per_member_second, decisions_per_member_second, overlap_over_1mm_fraction, overlap_over_1cm_fraction (overlapping
/// pairs for each member and frame at 30 Hz), max_overlap_m, progress_mps (mean speed towards the goal), desired_mps, arrived,
/// stuck, state_hash; of the engine occupancy also crossings_per_member_second (of cells); where the scene has them informed, lane_order, crossed, flow_per_m_s, human_flow_per_m_s (least and
/// most that was measured of people); of several scenes, numbers of members or engines, runs [the same].
///
/// `quality` is the discounted reward that a policy collects over the best that search to a depth of four actions
/// finds; `matching` sets the policies against motion matching over all frames of the bundle, the same targets for both.
#[derive(clap::Args)]
pub struct Args {
    /// Bundle, world file (`.toml`), or one of the words `blend` and `crowd`.
    file: PathBuf,
    /// Numbers of characters.
    #[arg(long, value_delimiter = ',', default_value = "1000,10000", value_name = "N,...")]
    characters: Vec<usize>,
    /// Numbers of threads; 1 and 2, and for a crowd 1, where absent.
    #[arg(long, value_delimiter = ',', value_name = "N,...")]
    threads: Vec<usize>,
    /// Time given to each figure, 0.5 where absent; of a crowd simulated time, what its scene says where absent.
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    #[command(flatten)]
    crowd: crowd::CrowdOptions,
    /// Also measure what the policies collect against search, and against motion matching.
    #[arg(long)]
    quality: bool,
    /// Random (state, target) pairs that are searched.
    #[arg(long, default_value_t = 1000, value_name = "N")]
    pairs: usize,
    #[command(flatten)]
    cache: CacheArgs,
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
    #[serde(skip_serializing_if = "Option::is_none")]
    matching: Option<MatchingFigures>,
}

impl Args {
    /// Time given to each figure. [Unit: s]
    fn seconds(&self) -> f64 {
        self.seconds.unwrap_or(0.5)
    }
}

pub fn run(args: &Args) -> Outcome {
    if args.file.as_os_str() == "crowd" && !args.file.exists() {
        return crowd::run(args);
    }
    if args.crowd.is_given() {
        return fail("--scene, --members, --engine and --png are for `throng bench crowd`");
    }
    if Scene::is_scene(&args.file) {
        return run_world(args);
    }
    if args.file.as_os_str() == "blend" && !args.file.exists() {
        return blend::run_own(args);
    }
    let tables = crate::args::open(&args.file)?;
    if tables.graph().states.is_empty() && !tables.blends().spaces.is_empty() {
        return blend::run(args, &tables);
    }
    let threads = if args.threads.is_empty() { vec![1, 2] } else { args.threads.clone() };
    let seconds = args.seconds();
    let config = MeasureConfig { characters: args.characters.clone(), threads, seconds };
    let measured = measure::measure(&tables, &config)?;
    let asked = QualityConfig { pairs: args.pairs, ..QualityConfig::default() };
    let quality = args.quality.then(|| measure::quality(&tables, &asked)).transpose()?;
    let against = MatchingConfig { seconds, ..MatchingConfig::default() };
    let matching = args.quality.then(|| measure::matching(&tables, &against)).transpose()?;
    let report = Report { measured, quality, matching };
    if args.json { output::json(&report) } else { print(&report) }
}

/// Measures a world, whose bundle is built where it is not there.
fn run_world(args: &Args) -> Outcome {
    let source = WorldSource::load(&args.file)?;
    let tables = crate::stitch::bundle(&source, &args.cache)?;
    let figures = measure::world(&tables, &source, &args.file)?;
    if args.json { output::json(&figures) } else { print_world(&figures) }
}

fn print_world(w: &WorldFigures) -> Outcome {
    let mut rows = vec![
        ("world", format!("{}: {} instances, {} cells, {} transitions", w.world, w.instances, w.cells, w.transitions)),
        ("stitching", format!("{:.3} s, {} at most", w.stitch_seconds, output::bytes(w.peak_bytes))),
    ];
    rows.extend(w.edits.iter().map(|e| ("  moving", edit(e))));
    rows.extend([
        ("first planner", format!("{:.3} s", w.paths.first_seconds)),
        ("paths", paths(&w.paths)),
        ("paths soon", paths(&w.paths_soon)),
        ("crowd", format!("{} characters, {:.0} steps a second on one thread", w.characters, w.steps_per_second)),
    ]);
    output::table(&rows)
}

fn edit(e: &EditFigures) -> String {
    let what = format!("{} (place {}, one of {})", e.unit, e.place, e.placed);
    match (e.seconds, e.over_stitch) {
        (Some(s), Some(share)) => format!("{what}: {:.1} ms, {share:.4} of stitching anew", 1e3 * s),
        _ => format!("{what}: every move was refused"),
    }
}

/// What planning paths costs.
fn paths(p: &PathFigures) -> String {
    let dijkstra = match (p.over_dijkstra_mean, p.over_dijkstra_max, p.worst) {
        (Some(mean), Some(most), Some([from, to])) => format!(
            "; {mean:.3} times the time of Dijkstra's on average, {most:.3} at most (from instance {from} to {to}), of {}",
            p.compared
        ),
        _ => String::new(),
    };
    let [from, to] = p.slowest;
    format!(
        "{:.2} ms on average, {:.2} at most (from instance {from} to {to}), for {:.0} m ({:.0} s), {:.0} at most; {:.0} ways of the upper layer and {:.0} nodes opened; {:.3} times what is proved to be needed at most{dijkstra}",
        1e3 * p.seconds_mean,
        1e3 * p.seconds_max,
        p.length_mean_m,
        p.duration_mean_s,
        p.length_max_m,
        p.opened_instances_mean,
        p.opened_nodes_mean,
        p.over_bound_max,
    )
}

/// The figures for people.
fn print(report: &Report) -> Outcome {
    print_crowds(&report.measured)?;
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
