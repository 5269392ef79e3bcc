//! `throng query`: what would a character do?

use crate::args::{Outcome, fail};
use crate::output;
use glam::Vec3;
use serde::Serialize;
use std::path::PathBuf;
use throng_runtime::policy::{BestActionJob, MAX_ACTIONS};

/// Ask a policy for the action of a state and a target.
///
/// JSON keys: behaviour, state, target_m, action (index within the state's actions), value (of the state for this
/// target), score (of the action), segment, frames, single_load_action, best [action, score].
#[derive(clap::Args)]
pub struct Args {
    /// Bundle.
    file: PathBuf,
    /// Name of the behaviour.
    #[arg(long, default_value = "approach", value_name = "NAME")]
    behaviour: String,
    /// State of the motion graph.
    #[arg(long)]
    state: u32,
    /// Target in the character's frame: X to its left, Z ahead, in metres.
    #[arg(long, value_name = "X,Z", allow_hyphen_values = true, value_parser = parse_target)]
    target: [f32; 2],
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Ranked {
    action: usize,
    score: f32,
}

#[derive(Serialize)]
struct Report {
    behaviour: String,
    state: u32,
    target_m: [f32; 2],
    action: usize,
    value: f32,
    score: f32,
    segment: u32,
    frames: u32,
    single_load_action: u8,
    best: Vec<Ranked>,
}

fn parse_target(text: &str) -> Result<[f32; 2], String> {
    let number = |t: &str| t.trim().parse::<f32>().ok().filter(|v| v.is_finite());
    match text.split_once(',').map(|(x, z)| (number(x), number(z))) {
        Some((Some(x), Some(z))) => Ok([x, z]),
        _ => Err(format!("expected two numbers such as 1.5,3, found `{text}`")),
    }
}

pub fn run(args: &Args) -> Outcome {
    let tables = crate::args::open(&args.file)?;
    let Some(index) = tables.find_policy(&args.behaviour) else {
        let known = tables.meta().behaviours.join(", ");
        return fail(format!("{}: no behaviour `{}`; there are: {known}", args.file.display(), args.behaviour));
    };
    let num_states = tables.graph().states.len();
    if args.state as usize >= num_states {
        return fail(format!(
            "{}: no state {}; states count from 0 to {}",
            args.file.display(),
            args.state,
            num_states.saturating_sub(1)
        ));
    }
    let policy = tables.policy(index);
    let target = Vec3::new(args.target[0], 0.0, args.target[1]);
    let mut scores = [0.0; MAX_ACTIONS];
    let n = policy.action_scores(args.state, target, &mut scores)?;
    let mut single_load = [0u8];
    let (states, targets) = ([args.state], [target]);
    BestActionJob { policy, states: &states, targets: &targets, choice: 0, actions: &mut single_load }.run()?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| scores[b].total_cmp(&scores[a]).then(a.cmp(&b)));
    let segment = tables.graph().segments_of(args.state)[order[0]];
    let report = Report {
        behaviour: args.behaviour.clone(),
        state: args.state,
        target_m: args.target,
        action: order[0],
        value: policy.value(args.state, target),
        score: scores[order[0]],
        segment,
        frames: tables.graph().segments[segment as usize].num_frames,
        single_load_action: single_load[0],
        best: order.iter().take(4).map(|&a| Ranked { action: a, score: scores[a] }).collect(),
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
