//! `throng soak`: scenes in turns, with checks on every step.

use crate::args::{CacheArgs, Outcome, fail};
use crate::{keys, output, progress};
use std::path::PathBuf;
use throng_precompute::soak::{self, SoakConfig, SoakReport};
use throng_runtime::simulation::Scene;

/// Run scenes in turns for hours, and check every step: numbers, bounds, overlaps, memory, snapshots, threads.
#[derive(clap::Args)]
#[command(after_long_help = keys::of::<SoakReport>())]
pub struct Args {
    /// Scenes to run; by default small ones of every kind of motion, which need no file.
    #[arg(value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Duration in hours; every scene runs at least once.
    #[arg(long, value_name = "H", conflicts_with = "seconds", value_parser = hours)]
    hours: Option<f64>,
    /// Duration in seconds; 60 where absent.
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
    /// Simulated time of one run.
    #[arg(long, value_name = "S", default_value_t = 20.0, value_parser = run_seconds)]
    run_seconds: f64,
    /// Seed of scenes, and of the moments of snapshots.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// A number within limits.
fn number(text: &str, low: f64, high: f64) -> Result<f64, String> {
    let fits = |v: &f64| (low..=high).contains(v);
    text.parse().ok().filter(fits).ok_or_else(|| format!("expected a number from {low} to {high}"))
}

fn hours(text: &str) -> Result<f64, String> {
    number(text, 0.0, 10_000.0)
}

fn seconds(text: &str) -> Result<f64, String> {
    number(text, 0.0, 3.6e7)
}

fn run_seconds(text: &str) -> Result<f64, String> {
    number(text, 0.1, 1e5)
}

pub fn run(args: &Args) -> Outcome {
    let seconds = args.hours.map(|h| 3600.0 * h).or(args.seconds).unwrap_or(60.0);
    let folder = progress::Scratch::new()?;
    let scenes = if args.scenes.is_empty() {
        crate::run::with(&args.cache, |with| soak::scenes(folder.path(), with))??
    } else {
        let load = |path: &PathBuf| -> Result<Scene, Box<dyn std::error::Error>> {
            let scene = Scene::load(path)?;
            crate::run::ensure(&scene, &args.cache)?;
            Ok(scene)
        };
        args.scenes.iter().map(load).collect::<Result<_, _>>()?
    };
    let config = SoakConfig { seconds, run_s: args.run_seconds, seed: args.seed, ..SoakConfig::default() };
    let report = soak::soak(&scenes, &config)?;
    if args.json {
        output::json(&report)?;
    } else {
        print(&report)?;
    }
    match report.failed {
        0 => Ok(()),
        n => fail(format!("{n} of {} checks failed", report.checks)),
    }
}

fn print(r: &SoakReport) -> Outcome {
    let w = &r.worst;
    let mut rows = vec![
        ("soak", format!("{} runs, {:.0} s simulated in {:.0} s", r.runs, r.simulated_s, r.seconds)),
        ("steps", format!("{} of characters", r.character_steps)),
        ("checks", format!("{}, {} failed", r.checks, r.failed)),
        ("farthest", format!("{:.1} m from the start, {:.1} m/s at most", w.farthest_m, w.fastest_mps)),
        ("overlaps", format!("agents {:.4} m, people in worlds {:.2} m", w.agent_overlap_m, w.people_overlap_m)),
        ("longest step", format!("{:.1} ms", w.step_ms)),
    ];
    if let (Some(warm), Some(most)) = (r.warm_bytes, r.most_bytes) {
        let memory = format!("{} after the first rounds, {} at most later", output::bytes(warm), output::bytes(most));
        rows.push(("memory", memory));
    }
    rows.extend(r.faults.iter().map(|f| ("fault", f.clone())));
    output::table(&rows)
}
