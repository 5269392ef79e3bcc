//! `throng bench crowd`: cost, progress and overlaps of crowds.

use crate::args::{CommandResult, named_engine};
use crate::{figures::print_figures, keys, output};
use serde::Serialize;
use std::{collections::BTreeMap, path::Path};
use throng_core::{base::error::ensure, base::limits};
use throng_crowd::Scheme;
use throng_precompute::run::{self, BUILT_IN_SCENES, SceneFigures, built_in_scene};
use throng_simulation::Scene;

/// Name that stands for all built-in scenes.
const ALL: &str = "all";

/// Measure crowds with one or several engines, sizes and scenes.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys_under::<CrowdBenchRun>("JSON keys (of several runs, `runs[]` with the same keys)"))]
pub struct Args {
    /// Built-in scenes (flock, corridor, lanes, circle, ring, bottleneck, square), `all` of them, or
    /// scene files.
    #[arg(long, value_delimiter = ',', default_value = "corridor", value_name = "NAME_OR_FILE,...")]
    scene: Vec<String>,
    /// Numbers of agents; that of the scene where absent. With several scenes, those of fixed size leave out numbers larger
    /// than their own.
    #[arg(long, value_delimiter = ',', value_name = "N,...", value_parser = limits::number_parser::<usize>(&limits::CHARACTERS))]
    agents: Vec<usize>,
    /// Engines: events, occupancy; that of the scene where absent. The program of research/ has fixed and pairs too.
    #[arg(long, value_delimiter = ',', value_name = "ENGINE,...")]
    engine: Vec<String>,
    /// Number of runs of each; the fastest is reported in full, as the least disturbed one, with the least, median and
    /// largest time for an agent.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = limits::number_parser::<u32>(&limits::REPEATS))]
    repeats: u32,
    /// Number of threads.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = limits::number_parser::<usize>(&limits::THREADS))]
    threads: usize,
    /// Seed of places, sizes and speeds; that of the scene where absent.
    #[arg(long, value_parser = limits::number_parser::<u64>(&limits::SEED))]
    seed: Option<u64>,
    /// Simulated time; what the scene says where absent.
    #[arg(long, value_name = "S", value_parser = limits::number_parser::<f64>(&limits::SECONDS))]
    seconds: Option<f64>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Printed report of one run.
#[derive(Serialize, schemars::JsonSchema)]
pub struct CrowdBenchRun {
    /// The scene's name.
    pub scene: String,
    #[serde(flatten)]
    pub figures: SceneFigures,
}

impl CrowdBenchRun {
    /// Time for an agent and a simulated second (us).
    pub fn us_per_agent(&self) -> f64 {
        self.figures.crowd.as_ref().and_then(|c| c.us_per_agent_second).unwrap_or_default()
    }

    /// Wall time of a simulated second (s).
    pub fn wall_s(&self) -> f64 {
        self.figures.crowd.as_ref().and_then(|c| c.wall_s_per_simulated_s).unwrap_or_default()
    }
}

/// Measures every requested scene with every number of agents and every engine.
pub fn run(args: &Args) -> CommandResult<Vec<CrowdBenchRun>> {
    let trials = requested_scenes(args)?;
    let is_sweep = trials.len() > 1;
    let mut runs = Vec::new();
    if is_sweep && !args.json {
        println!("{}", SceneFigures::HEADINGS);
    }
    for scene in &trials {
        scene.check()?;
        let run = fastest_run(scene, args)?;
        if is_sweep && !args.json {
            output::text(run.figures.row(&run.scene) + "\n")?;
        } else if !args.json {
            let (agents, seconds) = (run.figures.agents.unwrap_or(0), run.figures.simulated_s);
            let scene = format!("{}: {agents} agent(s), {seconds:.0} s", run.scene);
            print_figures("scene", scene, &run.figures)?;
        }
        runs.push(run);
    }
    match &runs[..] {
        _ if !args.json => {}
        [one] => output::json(one)?,
        _ => output::json(&BTreeMap::from([("runs", &runs)]))?,
    }
    Ok(runs)
}

/// The fastest of several runs, which only differ in their time.
fn fastest_run(scene: &Scene, args: &Args) -> CommandResult<CrowdBenchRun> {
    let compiled = scene.open()?;
    let run = || run::run_agents(&compiled, args.seconds, args.threads);
    let run = || run().map(|figures| CrowdBenchRun { scene: scene.name.clone(), figures });
    let mut best = run()?;
    let mut us = vec![best.us_per_agent()];
    for _ in 1..args.repeats {
        let again = run()?;
        us.push(again.us_per_agent());
        best = if again.wall_s() < best.wall_s() { again } else { best };
    }
    us.sort_by(f64::total_cmp);
    let range = [us[0], us[us.len() / 2], us[us.len() - 1]];
    best.figures.crowd.iter_mut().for_each(|c| c.us_range = Some(range));
    Ok(best)
}

/// All scenes to run, one for each scene, number of agents and engine.
fn requested_scenes(args: &Args) -> CommandResult<Vec<Scene>> {
    let names = args.scene.iter().flat_map(|n| if n == ALL { BUILT_IN_SCENES.to_vec() } else { vec![n.as_str()] });
    let scenes = names.map(load).collect::<Result<Vec<_>, _>>()?;
    let mut trials = Vec::new();
    for scene in &scenes {
        let own = scene.num_characters();
        let agents = if args.agents.is_empty() { vec![own] } else { args.agents.clone() };
        for engine in engines(args, scene)? {
            // A scene of fixed size gets too dense; it is only run if it is the only one requested.
            let fits = |n: &&usize| scenes.len() == 1 || scene.measure.grows || **n <= own;
            trials.extend(agents.iter().filter(fits).map(|&n| {
                let mut trial = scene.resized(n);
                trial.agents.engine = engine;
                trial.seed = args.seed.unwrap_or(trial.seed);
                trial
            }));
        }
    }
    Ok(trials)
}

/// Loads a built-in scene, or a file.
fn load(name: &str) -> CommandResult<Scene> {
    if let Some(own) = built_in_scene(name)? {
        return Ok(own);
    }
    let path = Path::new(name);
    let unknown = || format!("--scene {name}: expected one of {}, or a scene file", BUILT_IN_SCENES.join(", "));
    ensure(path.exists(), unknown)?;
    let scene = Scene::load(path)?;
    let other = || format!("--scene {name}: expected groups of agents alone, with `motion = \"none\"`");
    ensure(scene.groups.iter().all(|g| g.is_of_agents()), other)?;
    Ok(scene)
}

fn engines(args: &Args, scene: &Scene) -> CommandResult<Vec<Scheme>> {
    if args.engine.is_empty() {
        return Ok(vec![scene.agents.engine]);
    }
    args.engine.iter().map(|name| named_engine(name)).collect()
}
