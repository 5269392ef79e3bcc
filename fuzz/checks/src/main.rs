//! `throng-checks`: soaks, and the seeds of fuzz targets.

use clap::{Parser, Subcommand};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use throng_bake::cache::Cache;
use throng_checks::damage::write_corpus;
use throng_checks::soak::{self, SoakConfig, SoakReport};
use throng_core::base::limit_threads;
use throng_lab::run::{BuildContext, ensure_scene};
use throng_motion::progress::Silent;
use throng_simulation::Scene;

/// Seeds of the fuzz targets.
const CORPUS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../corpus");

/// Checks of Throng for its developers.
#[derive(Parser)]
#[command(name = "throng-checks", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Soak(SoakArgs),
    Seeds(SeedsArgs),
}

/// Run scenes in turns for hours, and check every step: numbers, bounds, overlaps, memory, snapshots, threads.
#[derive(clap::Args)]
struct SoakArgs {
    /// Scenes to run; without any, small ones of every kind of motion, which need no file.
    #[arg(value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Time to go on for; every scene runs at least once.
    #[arg(long, value_name = "H", conflicts_with = "seconds", value_parser = hours)]
    hours: Option<f64>,
    /// The same in seconds; 60 where absent.
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
    /// Simulated time of one run.
    #[arg(long, value_name = "S", default_value_t = 20.0, value_parser = run_seconds)]
    run_seconds: f64,
    /// Seed of scenes, and of the moments of snapshots.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder that keeps the outputs of stages between builds.
    #[arg(long, value_name = "DIR", default_value = Cache::FOLDER)]
    cache: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Write the seeds of all fuzz targets, which are good files.
#[derive(clap::Args)]
struct SeedsArgs {
    /// Folder that gets a folder for each target.
    #[arg(long, value_name = "DIR", default_value = CORPUS)]
    out: PathBuf,
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

fn main() -> ExitCode {
    limit_threads();
    let done = match Cli::parse().command {
        Command::Soak(args) => run_soak(&args),
        Command::Seeds(args) => write_seeds(&args.out),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::FAILURE
        }
    }
}

fn write_seeds(out: &Path) -> Result<(), Box<dyn Error>> {
    let files = write_corpus(out).map_err(|e| format!("{}: {e}", out.display()))?;
    println!("{files} seeds in {}", out.display());
    Ok(())
}

fn run_soak(args: &SoakArgs) -> Result<(), Box<dyn Error>> {
    let seconds = args.hours.map(|h| 3600.0 * h).or(args.seconds).unwrap_or(60.0);
    let folder = tempfile::tempdir()?;
    let cache = Cache::at_address(&args.cache, Cache::LIMIT_BYTES)?;
    let with = BuildContext { cache: &cache, progress: &Silent, report_news: &|news| eprintln!("{news}") };
    let scenes = if args.scenes.is_empty() {
        soak::scenes(folder.path(), &with)?
    } else {
        let load = |path: &PathBuf| -> Result<Scene, Box<dyn Error>> {
            let scene = Scene::load(path)?;
            ensure_scene(&scene, &with)?;
            Ok(scene)
        };
        args.scenes.iter().map(load).collect::<Result<_, _>>()?
    };
    let config = SoakConfig { seconds, run_s: args.run_seconds, seed: args.seed, ..SoakConfig::default() };
    let report = soak::soak(&scenes, &config)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        print(&report);
    }
    match report.failed {
        0 => Ok(()),
        n => Err(format!("{n} of {} checks failed", report.checks).into()),
    }
}

fn print(r: &SoakReport) {
    let w = &r.worst;
    println!("soak          {} runs, {:.0} s simulated in {:.0} s", r.runs, r.simulated_s, r.seconds);
    println!("steps         {} of characters", r.character_steps);
    println!("checks        {}, {} failed", r.checks, r.failed);
    println!("farthest      {:.1} m from the start, {:.1} m/s at most", w.farthest_m, w.fastest_mps);
    println!("overlaps      agents {:.4} m, people in worlds {:.2} m", w.agent_overlap_m, w.people_overlap_m);
    println!("longest step  {:.1} ms", w.step_ms);
    if let (Some(warm), Some(most)) = (r.warm_bytes, r.most_bytes) {
        let mb = |bytes: u64| bytes as f64 / 1e6;
        println!("memory        {:.1} MB after the first rounds, {:.1} MB at most later", mb(warm), mb(most));
    }
    r.faults.iter().for_each(|fault| println!("fault         {fault}"));
}
