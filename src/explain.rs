//! `throng explain`: why an agent acted as it did, in a recorded run.

use crate::args::{CacheArgs, CommandResult, fail};
use crate::{keys, output};
use serde::Serialize;
use std::{collections::BTreeMap, fmt::Write, path::PathBuf};
use throng_core::base::limits;
use throng_precompute::run::RunRecording;
use throng_simulation::scenario::{AgentBrains, Explanation, KnownEvent};

/// Replay a run that `throng run SCENE --record FILE` has recorded, and explain what an agent did, why, and from whom it
/// learnt of events.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<Explanation>())]
pub struct Args {
    /// Recording.
    #[arg(value_name = "RECORDING")]
    recording: PathBuf,
    /// Number of an agent.
    #[arg(long, value_name = "A", value_parser = limits::number_parser::<usize>(&limits::FOLLOWED))]
    agent: Option<usize>,
    /// Simulated time; the end where absent.
    #[arg(long, value_name = "T", value_parser = limits::number_parser::<f64>(&limits::SECONDS))]
    at: Option<f64>,
    /// Name of an event: who learnt of it from whom, as a tree.
    #[arg(long, value_name = "NAME")]
    message: Option<String>,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// Printed report: agents that learnt of an event, and from whom.
#[derive(Serialize)]
struct EventSpreadReport {
    event: String,
    learnt: Vec<InformedAgent>,
}

#[derive(Serialize)]
struct InformedAgent {
    agent: usize,
    #[serde(flatten)]
    known: KnownEvent,
}

pub fn run(args: &Args) -> CommandResult {
    let recording = RunRecording::load(&args.recording)?;
    let scene = recording.scene()?;
    crate::run::ensure_scene(&scene, &args.cache)?;
    let sim = recording.replay(&scene.open()?, args.at)?;
    let Some(brains) = sim.brains() else { return fail("the scene says no more than goals: no agent has a brain") };
    match (&args.message, args.agent) {
        (Some(event), _) => print_event_spread(brains, event, args.json),
        (None, Some(agent)) if agent < sim.num_characters() => {
            let why = brains.explain(agent, sim.time_s());
            if args.json { output::json(&why) } else { output::text(why.to_string()) }
        }
        (None, Some(agent)) => fail(format!("--agent {agent}: expected less than {}", sim.num_characters())),
        (None, None) => fail("expected `--agent A` or `--message NAME`"),
    }
}

fn print_event_spread(brains: &AgentBrains, event: &str, json: bool) -> CommandResult {
    let learnt = brains.event_learners(event)?;
    if json {
        let learnt = learnt.into_iter().map(|(agent, known)| InformedAgent { agent, known }).collect();
        return output::json(&EventSpreadReport { event: event.into(), learnt });
    }
    let mut text = String::new();
    let mut informed: BTreeMap<Option<usize>, Vec<usize>> = BTreeMap::new();
    learnt.iter().enumerate().for_each(|(i, (_, known))| informed.entry(known.from).or_default().push(i));
    let informed_by = |from: Option<usize>| informed.get(&from).into_iter().flatten().rev().copied();
    // Depth first, from the agents that learnt of it from no other agent.
    let mut open: Vec<(usize, usize)> = informed_by(None).map(|i| (i, 0)).collect();
    while let Some((i, depth)) = open.pop() {
        let (agent, known) = &learnt[i];
        let [x, z] = known.at;
        let (indent, how, time_s) = ("  ".repeat(depth), &known.how, known.time_s);
        _ = writeln!(text, "{indent}{agent}  {time_s:.2} s at {x:.1}, {z:.1} ({how})");
        open.extend(informed_by(Some(*agent)).map(|n| (n, depth + 1)));
    }
    if text.is_empty() {
        text = format!("nobody knows of `{event}`\n");
    }
    output::text(text)
}
