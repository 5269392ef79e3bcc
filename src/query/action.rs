//! The action that a policy chooses.

use crate::args::{CommandResult, parse_point};
use crate::{keys, output};
use glam::Vec3;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use throng_core::policy::{BestActionJob, MAX_ACTIONS, TargetGrid};
use throng_core::{base::error::ensure, base::limits};

/// Ask a policy of a bundle for the action of a state and a target.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<ActionQueryReport>())]
pub struct Args {
    /// Bundle.
    #[arg(value_name = "BUNDLE")]
    file: PathBuf,
    /// Name of the behaviour.
    #[arg(long, default_value = "approach", value_name = "NAME")]
    behaviour: String,
    /// State of the motion graph.
    #[arg(long, value_parser = limits::number_parser::<u32>(&limits::STATE))]
    state: u32,
    /// Target in the frame of the character, in metres: X to its left, Z ahead.
    #[arg(long, value_name = "X,Z", allow_hyphen_values = true, value_parser = parse_point)]
    target: [f32; 2],
    /// Height of the target over the ground, in metres, for policies that need one, as for blows; by default the middle of
    /// the policy's range.
    #[arg(long, value_name = "M", value_parser = limits::number_parser::<f32>(&limits::COORDINATE))]
    height: Option<f32>,
    /// Time left until the blow lands, in seconds, for policies that need one, as for evading.
    #[arg(long, value_name = "S", value_parser = limits::number_parser::<f32>(&limits::SECONDS))]
    time_left: Option<f32>,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize, JsonSchema)]
struct RankedAction {
    /// Index within the state's actions.
    action: usize,
    /// Score of the action.
    score: f32,
}

#[derive(Serialize, JsonSchema)]
struct ActionQueryReport {
    /// Name of the behaviour.
    behaviour: String,
    /// State of the query.
    state: u32,
    /// Target in the frame of the character: X to its left, Z ahead (m).
    target_m: [f32; 2],
    /// Height of the target over the ground, if the policy needs one (m).
    height_m: Option<f32>,
    /// Time left until the blow lands, if the policy needs one (s).
    time_left_s: Option<f32>,
    /// Best action, as an index within the actions of the state.
    action: usize,
    /// Value of the state for this target.
    value: f32,
    /// Score of the action: its reward, and the discounted value of the state that it leads to.
    score: f32,
    /// Segment that the action plays.
    segment: u32,
    /// Frames of the segment.
    frames: u32,
    /// Stored best action of the nearest cell.
    single_load_action: u8,
    /// The best few actions, best first.
    best: Vec<RankedAction>,
}

/// The height of the target where the policy knows heights, or the reason why the height or the time left of the
/// arguments does not fit the policy.
fn target_height(args: &Args, grid: &TargetGrid) -> Result<Option<f32>, String> {
    let record = grid.record();
    let [first, last] = [0.0, (record.num_heights - 1) as f32].map(|k| record.height_start + k * record.height_spacing);
    let (is_timed, has_heights) = (grid.is_space_time(), record.num_heights > 1);
    ensure(is_timed || args.time_left.is_none(), || "it is not about a moment. Leave --time-left out")?;
    let knows_height = has_heights && !is_timed;
    ensure(knows_height || args.height.is_none(), || "it knows no height. Leave --height out")?;
    let fault = || format!("it is about a blow that lands soon. Add --time-left S, from {first} to {last:.2}");
    ensure(!is_timed || args.time_left.is_some(), fault)?;
    Ok(knows_height.then(|| args.height.unwrap_or(0.5 * (first + last))))
}

pub fn run(args: &Args) -> CommandResult {
    let state = args.state;
    let tables = crate::args::open_bundle(&args.file)?;
    let file = args.file.display();
    let policy = tables.policy(&args.behaviour).map_err(|e| format!("{file}: {e}"))?.table().clone();
    let num_states = tables.graph().states.len();
    let last = num_states.saturating_sub(1);
    let fault = || format!("{file}: no state {state}; states count from 0 to {last}");
    ensure((state as usize) < num_states, fault)?;
    let height_m = target_height(args, policy.grid());
    let height_m = height_m.map_err(|why| format!("policy `{}` of {file}: {why}", args.behaviour))?;
    let time_left_s = args.time_left;
    let target = Vec3::new(args.target[0], height_m.or(time_left_s).unwrap_or(0.0), args.target[1]);
    let mut scores = [0.0; MAX_ACTIONS];
    let n = policy.action_scores(state, target, &mut scores)?;
    let mut single_load = [0u8];
    let (policy, states, targets) = (&policy, &[state], &[target]);
    BestActionJob { policy, states, targets, choice: 0, actions: &mut single_load }.run()?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| scores[b].total_cmp(&scores[a]).then(a.cmp(&b)));
    let segment = tables.graph().segments_of(state)[order[0]];
    let report = ActionQueryReport {
        behaviour: args.behaviour.clone(),
        state,
        target_m: args.target,
        height_m,
        time_left_s,
        action: order[0],
        value: policy.value(state, target),
        score: scores[order[0]],
        segment,
        frames: tables.graph().segments[segment as usize].num_frames,
        single_load_action: single_load[0],
        best: order.iter().take(4).map(|&a| RankedAction { action: a, score: scores[a] }).collect(),
    };
    if args.json {
        return output::json(&report);
    }
    let best: Vec<_> = report.best.iter().map(|r| format!("{} ({:.4})", r.action, r.score)).collect();
    output::table(&[
        ("action", format!("{} of {n}: segment {segment}, {} frames", report.action, report.frames)),
        ("value", format!("{:.4}", report.value)),
        ("best", best.join(", ")),
        ("single load", format!("{}", report.single_load_action)),
    ])
}
