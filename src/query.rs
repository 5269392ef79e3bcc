//! `throng query`: what would a character do, and which way would it go?

mod world;

use crate::args::{CacheArgs, Outcome, fail};
use crate::output;
use glam::Vec3;
use serde::Serialize;
use std::path::PathBuf;
use throng_precompute::scene::Scene;
use throng_runtime::policy::{BestActionJob, MAX_ACTIONS};

/// Ask a policy for the action of a state and a target, or plan a path through a world.
///
/// JSON keys: of a bundle, behaviour, state, target_m, action (index within the state's actions), value (of the state for this
/// target), score (of the action), segment, frames, single_load_action, best [action, score]; of a world, world, from_m and
/// to_m (the nearest places where one can stay), length_m, duration_s, transitions, opened_instances (states of
/// instances), opened_nodes, seconds (that planning took), path_m [x, y, z].
#[derive(clap::Args)]
pub struct Args {
    /// Bundle, or world file (`.toml`), which is stitched where that has not been done.
    #[arg(value_name = "BUNDLE_OR_WORLD")]
    file: PathBuf,
    /// Name of the behaviour.
    #[arg(long, default_value = "approach", value_name = "NAME")]
    behaviour: String,
    /// State of the motion graph; of a bundle only, and needed there.
    #[arg(long)]
    state: Option<u32>,
    /// Where the path begins; of a world only, and needed there.
    #[arg(long, value_name = "X,Z", allow_hyphen_values = true, value_parser = parse_target)]
    from: Option<[f32; 2]>,
    /// Target, in metres: of a bundle in the character's frame, X to its left, Z ahead; of a world in its frame.
    #[arg(long, value_name = "X,Z", allow_hyphen_values = true, value_parser = parse_target)]
    target: [f32; 2],
    #[command(flatten)]
    cache: CacheArgs,
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
    if Scene::is_scene(&args.file) {
        return world::run(args);
    }
    let (Some(state), None) = (args.state, args.from) else {
        return fail(format!("{}: a bundle is asked with --state and without --from", args.file.display()));
    };
    let tables = crate::args::open(&args.file)?;
    let Some(index) = tables.find_policy(&args.behaviour) else {
        let known = tables.meta().behaviours.join(", ");
        return fail(format!("{}: no behaviour `{}`; there are: {known}", args.file.display(), args.behaviour));
    };
    let num_states = tables.graph().states.len();
    if state as usize >= num_states {
        return fail(format!(
            "{}: no state {}; states count from 0 to {}",
            args.file.display(),
            state,
            num_states.saturating_sub(1)
        ));
    }
    let policy = tables.policy(index);
    let target = Vec3::new(args.target[0], 0.0, args.target[1]);
    let mut scores = [0.0; MAX_ACTIONS];
    let n = policy.action_scores(state, target, &mut scores)?;
    let mut single_load = [0u8];
    let (states, targets) = ([state], [target]);
    BestActionJob { policy, states: &states, targets: &targets, choice: 0, actions: &mut single_load }.run()?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| scores[b].total_cmp(&scores[a]).then(a.cmp(&b)));
    let segment = tables.graph().segments_of(state)[order[0]];
    let report = Report {
        behaviour: args.behaviour.clone(),
        state,
        target_m: args.target,
        action: order[0],
        value: policy.value(state, target),
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
