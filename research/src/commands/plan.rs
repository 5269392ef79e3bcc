//! `plan`: reaches of planned limbs beside those of people, and problems for other planners.

use super::with;
use crate::args::{CacheArgs, CommandResult, fail, is_toml};
use crate::{keys, output};
use schemars::JsonSchema;
use serde::Serialize;
use std::error::Error;
use std::path::{Path, PathBuf};
use throng_planner::clips::with_motion;
use throng_planner::planner::{Budget, LimbPlanner, PlanConfig};
use throng_planner::task::Task;
use throng_precompute::config::BuildConfig;
use throng_precompute::files::write_atomically;
use throng_precompute::plans;
use throng_precompute::plans::scenes::{self, PlanScene, SCENES};
use throng_research::natural::{ReachNaturalness, measure_captured};
use throng_research::plain_problem::PlainProblem;
use throng_research::reaches::{ReachFigures, reach_figures};

/// Measure how much planned reaches look like people's, or write a scene for other planners.
///
/// Scenes are those of `throng bench plan`.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<PlanComparison>())]
pub struct Args {
    /// Names of scenes, or task files; all named scenes where absent.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    scene: Vec<String>,
    /// Seeds for each scene.
    #[arg(long, default_value_t = 100, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Captured motion to compare with: files and folders; reaches in it are found by the speed of hands.
    #[arg(long, value_name = "FILE_OR_FOLDER", num_args = 1..)]
    captured: Vec<PathBuf>,
    /// Write the one named scene, as it is at its beginning, as JSON for other planners (see research/ompl.cpp), and nothing else.
    #[arg(long, value_name = "FILE", requires = "scene")]
    plain: Option<PathBuf>,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Poses at random in what is written for other planners.
const PLAIN_SAMPLES: u32 = 10_000;

/// What is printed.
#[derive(Serialize, JsonSchema)]
struct PlanComparison {
    /// Every scene.
    results: Vec<Figures>,
    /// Reaches in the captured motion; none without it.
    captured: Option<ReachNaturalness>,
}

/// Reaches of a scene.
#[derive(Serialize, JsonSchema)]
struct Figures {
    /// Its name.
    scene: String,
    /// Share of the seeds with a plan.
    success_rate: f64,
    /// How much hands move as people's do on their way, in all plans.
    natural: Option<ReachNaturalness>,
}

pub fn run(args: &Args) -> CommandResult {
    let all = || SCENES.iter().map(|(name, _)| (*name).to_owned()).collect();
    let names: Vec<String> = if args.scene.is_empty() { all() } else { args.scene.clone() };
    if let Some(file) = &args.plain {
        let [name] = &names[..] else { return fail("expected one scene for --plain, such as --scene arm-static") };
        let Some(scene) = scenes::find_scene(name)? else { return fail(unknown(name)) };
        let text = serde_json::to_string(&PlainProblem::from_problem(&scene.problem()?, PLAIN_SAMPLES))?;
        write_atomically(file, |out| out.write_all(text.as_bytes()))?;
        return Ok(());
    }
    let captured = match args.captured.as_slice() {
        [] => None,
        files => {
            measure_captured(files, &BuildConfig::of_motion("", Vec::new())?, &|news| output::print_to_stderr(news))?
        }
    };
    let mut results = Vec::new();
    for name in &names {
        eprintln!("{name} ...");
        let (plans, reaches) = match scenes::find_scene(name)? {
            Some(scene) => of_scene(&scene, args.seeds)?,
            None if is_toml(Path::new(name)) => of_task(Path::new(name), args)?,
            None => return fail(unknown(name)),
        };
        let success_rate = plans as f64 / args.seeds as f64;
        let natural = ReachNaturalness::from_reaches(&reaches, captured.as_ref());
        results.push(Figures { scene: name.clone(), success_rate, natural });
    }
    if args.json {
        return output::json(&PlanComparison { results, captured });
    }
    let row = |what: &str, natural: Option<&ReachNaturalness>| {
        output::table(&[(what, natural.map_or_else(|| "no reach".into(), ReachNaturalness::text))])
    };
    results.iter().try_for_each(|f| row(&f.scene, f.natural.as_ref()))?;
    captured.map_or(Ok(()), |c| row("captured", Some(&c)))
}

fn unknown(name: &str) -> String {
    let known = SCENES.map(|(name, _)| name).join(", ");
    format!("there is no scene `{name}`; there are {known}, and task files (.toml)")
}

/// Plans a scene with every seed: the number of plans, and their reaches.
fn of_scene(scene: &PlanScene, seeds: u64) -> Result<(usize, Vec<ReachFigures>), Box<dyn Error>> {
    let (problem, who) = (scene.problem()?, &scene.actor);
    let (mut planner, config) = (LimbPlanner::new(), PlanConfig::default());
    let (mut plans, mut reaches) = (0, Vec::new());
    let window_s = scene.ends.map(|e| e.time_s);
    for seed in 0..seeds {
        let budget = Budget { seed, rate_hz: who.clip.rate_hz, ..Budget::default() };
        let outcome = planner.plan(&problem, &config, &budget);
        let Some(motion) = planner.motion().filter(|_| outcome.is_solved()) else { continue };
        let after = with_motion(&who.clip, 0.0, who.limb, &motion)?;
        plans += 1;
        reaches.extend(reach_figures(&after, &who.skeleton, who.limb, window_s));
    }
    Ok((plans, reaches))
}

/// Does a task with every seed: the number of seeds that did it, and the reaches of all arms that have a time.
fn of_task(path: &Path, args: &Args) -> Result<(usize, Vec<ReachFigures>), Box<dyn Error>> {
    let task = Task::read(path)?;
    let config = BuildConfig::of_motion("", Vec::new())?;
    let sources = with(&args.cache, |with| plans::load_sources(&task, &config, None, with))??;
    let (task, clips) = sources.stage_task(task, None)?;
    let (mut done, mut reaches) = (0, Vec::new());
    for seed in 0..args.seeds {
        let outcome = task.run(&clips, Some(seed))?;
        if !outcome.is_solved() {
            continue;
        }
        let arms = task.reach_windows().filter(|(_, limb, _)| limb.is_arm());
        let of = |(who, limb, window_s): (usize, _, _)| {
            reach_figures(&outcome.clips[who][1], &clips[who].skeleton, limb, window_s)
        };
        let found: Vec<ReachFigures> = arms.filter_map(of).collect();
        let one = [(seed, outcome)];
        if plans::plan_report(&task, &one).is_some() {
            reaches.extend(found);
            done += 1;
        }
    }
    Ok((done, reaches))
}
