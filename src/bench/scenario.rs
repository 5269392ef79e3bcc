//! `throng bench scenario`: speed of scenes with rules, state graphs and news.

use crate::args::{CacheArgs, CommandResult};
use crate::{keys, output};
use std::{collections::BTreeMap, path::Path};
use throng_core::base::limits;
use throng_precompute::run::{ScenarioFigures, measure_scenario};
use throng_simulation::Scene;

/// Measure scenes in which people live by rules, state graphs and news.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys_under::<ScenarioFigures>("JSON keys (of each of `results[]`)"))]
pub struct Args {
    /// Scene files, or names of those in `data/scenes`.
    #[arg(long, value_delimiter = ',', default_value = "square,race,race-100,park", value_name = "NAME_OR_FILE,...")]
    scene: Vec<String>,
    /// Number of agents; that of the scene where absent.
    #[arg(long, value_name = "N", value_parser = limits::number_parser::<usize>(&limits::CHARACTERS))]
    agents: Option<usize>,
    /// Numbers of threads.
    #[arg(long, value_delimiter = ',', default_value = "1", value_name = "N,...", value_parser = limits::number_parser::<usize>(&limits::THREADS))]
    threads: Vec<usize>,
    /// Simulated time; what the scene says where absent.
    #[arg(long, value_name = "S", value_parser = limits::number_parser::<f64>(&limits::SECONDS))]
    seconds: Option<f64>,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> CommandResult {
    let mut results = Vec::new();
    for name in &args.scene {
        let is_file = Path::new(name).extension().is_some();
        let path = if is_file { name.into() } else { Path::new("data/scenes").join(format!("{name}.toml")) };
        let mut scene = Scene::load(&path)?;
        if let Some(agents) = args.agents {
            scene = scene.resized(agents);
        }
        crate::run::ensure_scene(&scene, &args.cache)?;
        let compiled = scene.open()?;
        for &threads in &args.threads {
            let count = || Some(crate::allocations::num_allocations());
            results.push(measure_scenario(&compiled, args.seconds, threads, &count)?);
        }
    }
    if args.json {
        return output::json(&BTreeMap::from([("results", results)]));
    }
    let mut text = String::from(
        "scene              agents  threads  frames/s  over paper  rules  crowd  motion  informed  by others\n",
    );
    for r in &results {
        let over = r.over_paper.map_or_else(String::new, |o| format!("{o:.0}"));
        let run = format!("{:<18} {:>6} {:>8} {:>9.0}", r.scene, r.agents, r.threads, r.frames_per_second);
        let [rules, crowd, motion] = [r.rules_share, r.crowd_share, r.motion_share].map(|share| 100.0 * share);
        let news = format!("{:>9} {:>5}", r.informed, r.informed_pairs);
        text.push_str(&format!("{run} {over:>11} {rules:>5.0}% {crowd:>5.0}% {motion:>6.0}% {news}\n"));
    }
    output::text(text)
}
