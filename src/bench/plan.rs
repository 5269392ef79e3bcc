//! `throng bench plan`: cost and success rate of limb plans.

mod ik;

use crate::args::{CacheArgs, CommandResult, fail, is_toml};
use crate::{keys, output};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use throng_core::base::error::ensure;
use throng_planner::planner::{Budget, LimbPlanner, PlanConfig};
use throng_planner::{clips::with_motion, recheck::Recheck, setup::SELF_PRESS_M, task::Task};
use throng_precompute::plans::scenes::{self, PlanScene, SCENES};
use throng_precompute::{Clip, config::BuildConfig, plans};

/// Measure plans of limbs: how often they succeed, what they take, how smooth they are.
///
/// Plans run on one core. Scenes: `table` (an arm from below a table to above it), `arm-static` (between shelves of 26 000
/// triangles; without time), `spheres` (the same among 40 balls), `ring` (through a ring of 20 000 triangles that moves),
/// `walk` (a walking arm past a post of 30 000 triangles).
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<PlanBenchReport>())]
pub struct Args {
    /// Names of scenes, task files, or folders of task files, such as data/tasks; all named scenes where absent.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    scene: Vec<String>,
    /// Seeds for each scene.
    #[arg(long, default_value_t = 100, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Plans of each scene that are checked by other means.
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u64).range(0..=100_000))]
    recheck: u64,
    /// Poses that inverse kinematics is measured on.
    #[arg(long, default_value_t = 100_000, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    poses: u32,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// What is printed.
#[derive(Serialize, JsonSchema)]
struct PlanBenchReport {
    /// Figures of every scene.
    results: Vec<PlanBenchFigures>,
}

/// Figures of a scene.
#[derive(Serialize, JsonSchema)]
struct PlanBenchFigures {
    /// Name of the scene.
    scene: String,
    /// Share of the seeds with a plan.
    success_rate: f64,
    /// Time until the first path, median of the seeds that have one (ms).
    first_ms_median: Option<f64>,
    /// Time until the first path, 95th percentile (ms).
    first_ms_p95: Option<f64>,
    /// Time with smoothing, median (ms).
    total_ms_median: Option<f64>,
    /// Time with smoothing, 95th percentile (ms).
    total_ms_p95: Option<f64>,
    /// Collision samples a second within plans: one pose at one time against everything.
    checks_per_second: f64,
    /// Time of a plan over its number of collision samples (ns).
    ns_per_check: f64,
    /// Sum of joint rotations, median (rad).
    path_length_rad: Option<f64>,
    /// Jerk after smoothing over that before, median.
    jerk_ratio: Option<f64>,
    /// Violations that an independent check found in the checked plans.
    recheck_violations: usize,
    /// Time of an inverse-kinematics solution of an arm from any pose, without collisions (ns).
    ik_ns: f64,
    /// Greatest distance of hands from their targets (m).
    ik_error_max_m: f64,
    /// Share of reachable targets that were reached.
    ik_solved_fraction: f64,
    /// Mean angle between the motions of two seeds, mean of neighbouring seeds (rad).
    variants_distance_rad: Option<f64>,
    /// What the paper gives for a scene like it (s).
    paper_s: Option<f64>,
}

/// Plans of a scene that were found, and the violations of those that were checked.
#[derive(Default)]
struct PlanSamples {
    plans: Vec<PlanSample>,
    violations: usize,
}

/// Measurements of one plan, or of all plans of a task.
struct PlanSample {
    first_s: f64,
    total_s: f64,
    checks: u64,
    length_rad: f64,
    jerk: [f64; 2],
    clip: Option<Clip>,
}

pub fn run(args: &Args) -> CommandResult {
    let all = || SCENES.iter().map(|(name, _)| (*name).to_owned()).collect();
    let names: Vec<String> = if args.scene.is_empty() { all() } else { expand_folders(&args.scene)? };
    let ik = ik::measure(args.poses);
    let mut results = Vec::new();
    for name in &names {
        eprintln!("{name} ...");
        let samples = match scenes::find_scene(name)? {
            Some(scene) => plan_scene(&scene, args)?,
            None if is_toml(Path::new(name)) => plan_task(Path::new(name), args)?,
            None => {
                let known = SCENES.map(|(name, _)| name).join(", ");
                return fail(format!("there is no scene `{name}`; there are {known}, and task files (.toml)"));
            }
        };
        results.push(figures(name, &samples, &ik, args.seeds));
    }
    if args.json { output::json(&PlanBenchReport { results }) } else { results.iter().try_for_each(print) }
}

/// Expands folders to the task files in them, sorted by name.
fn expand_folders(scenes: &[String]) -> CommandResult<Vec<String>> {
    let mut out = Vec::new();
    for scene in scenes {
        if !Path::new(scene).is_dir() {
            out.push(scene.clone());
            continue;
        }
        let files = std::fs::read_dir(scene).map_err(|e| format!("{scene}: {e}"))?;
        let mut tasks = files.map(|f| f.map(|f| f.path())).collect::<Result<Vec<_>, _>>()?;
        tasks.retain(|f| is_toml(f) && plans::is_task(f));
        tasks.sort();
        let none = || format!("{scene}: expected task files (.toml with `[[tasks]]`) in the folder");
        ensure(!tasks.is_empty(), none)?;
        out.extend(tasks.iter().map(|f| f.to_string_lossy().into_owned()));
    }
    Ok(out)
}

/// Plans a scene with every seed.
fn plan_scene(scene: &PlanScene, args: &Args) -> CommandResult<PlanSamples> {
    let (problem, who) = (scene.problem()?, &scene.actor);
    let (mut planner, config) = (LimbPlanner::new(), PlanConfig::default());
    let mut samples = PlanSamples::default();
    let joints = who.limb.joints();
    let planned: Vec<_> = joints.into_iter().zip(problem.limits).collect();
    let [init, goal] = scene.ends.map(|e| e.time_s);
    for seed in 0..args.seeds {
        let budget = Budget { seed, rate_hz: who.clip.rate_hz, ..Budget::default() };
        let outcome = planner.plan(&problem, &config, &budget);
        let Some(motion) = planner.motion().filter(|_| outcome.is_solved()) else { continue };
        let after = with_motion(&who.clip, 0.0, who.limb, &motion)?;
        if seed < args.recheck {
            let recheck = Recheck {
                skeleton: &who.skeleton,
                before: &who.clip,
                after: &after,
                span_s: [init, goal],
                planned: &planned,
                capsules: &who.shape.capsules,
                held: &[],
                solids: &scene.solids,
                others: &[],
                allowed: &scene.allowed,
                penetration_m: 1e-3,
                self_press_m: SELF_PRESS_M,
            };
            samples.violations += recheck.run().violations.len();
        }
        samples.plans.push(PlanSample {
            first_s: outcome.first_solution_s,
            total_s: outcome.total_s,
            checks: outcome.checks,
            length_rad: outcome.roughness[1].length_rad,
            jerk: outcome.roughness.map(|r| r.jerk_rms),
            clip: Some(after),
        });
    }
    Ok(samples)
}

/// Solves a task with every seed.
fn plan_task(path: &Path, args: &Args) -> CommandResult<PlanSamples> {
    let task = Task::read(path)?;
    let config = BuildConfig::of_motion("", Vec::new())?;
    let sources = crate::run::with_build_context(&args.cache, |with| plans::load_sources(&task, &config, None, with))??;
    let (task, clips) = sources.stage_task(task, None)?;
    let mut samples = PlanSamples::default();
    for seed in 0..args.seeds {
        let found = [(seed, task.run(&clips, Some(seed))?)];
        samples.violations += found[0].1.recheck.violations.len();
        let report = plans::plan_report(&task, &found);
        let [(_, outcome)] = found;
        let Some(r) = report.filter(|r| r.solved) else { continue };
        samples.plans.push(PlanSample {
            first_s: r.first_solution_s,
            total_s: r.total_s,
            checks: r.checks,
            length_rad: r.path_length_rad,
            jerk: [r.jerk_before, r.jerk_after],
            clip: outcome.clips.into_iter().next().map(|[_, after]| after),
        });
    }
    Ok(samples)
}

fn figures(name: &str, samples: &PlanSamples, ik: &ik::IkFigures, seeds: u64) -> PlanBenchFigures {
    let PlanSamples { plans: samples, violations: recheck_violations } = samples;
    let rank = |share: f64, f: &dyn Fn(&PlanSample) -> f64| {
        let mut all: Vec<f64> = samples.iter().map(f).filter(|x| x.is_finite()).collect();
        all.sort_by(f64::total_cmp);
        all.get((share * all.len() as f64) as usize).or(all.last()).copied()
    };
    let (checks, seconds) = samples.iter().fold((0, 0.0), |(c, s), x| (c + x.checks, s + x.total_s));
    let distances: Vec<f64> =
        samples.windows(2).filter_map(|w| mean_joint_angle(w[0].clip.as_ref()?, w[1].clip.as_ref()?)).collect();
    let known = SCENES.iter().find(|(n, _)| *n == name);
    PlanBenchFigures {
        scene: name.into(),
        success_rate: samples.len() as f64 / seeds as f64,
        first_ms_median: rank(0.5, &|s| 1e3 * s.first_s),
        first_ms_p95: rank(0.95, &|s| 1e3 * s.first_s),
        total_ms_median: rank(0.5, &|s| 1e3 * s.total_s),
        total_ms_p95: rank(0.95, &|s| 1e3 * s.total_s),
        checks_per_second: checks as f64 / f64::max(seconds, 1e-12),
        ns_per_check: seconds * 1e9 / checks.max(1) as f64,
        path_length_rad: rank(0.5, &|s| s.length_rad),
        jerk_ratio: rank(0.5, &|s| s.jerk[1] / s.jerk[0]),
        recheck_violations: *recheck_violations,
        ik_ns: ik.ns,
        ik_error_max_m: ik.error_max_m,
        ik_solved_fraction: ik.solved_fraction,
        variants_distance_rad: (!distances.is_empty()).then(|| distances.iter().sum::<f64>() / distances.len() as f64),
        paper_s: known.and_then(|(_, s)| *s),
    }
}

/// Mean angle between the joints of two clips where they differ; 0 for equal clips (rad).
fn mean_joint_angle(a: &Clip, b: &Clip) -> Option<f64> {
    let differ = a.rotations.iter().zip(&b.rotations).filter(|(p, q)| p != q);
    let angles: Vec<f64> = differ.map(|(p, q)| f64::from(p.angle_between(*q))).collect();
    (a.num_frames() == b.num_frames()).then(|| angles.iter().sum::<f64>() / angles.len().max(1) as f64)
}

fn print(f: &PlanBenchFigures) -> CommandResult {
    let text = |x: Option<f64>| x.map_or_else(|| "-".into(), |x| format!("{x:.2}"));
    let [first, first_95] = [f.first_ms_median, f.first_ms_p95].map(text);
    let [total, total_95] = [f.total_ms_median, f.total_ms_p95].map(text);
    let ways = format!("first way {first} ms (95 %: {first_95}), with smoothing {total} ms (95 %: {total_95})");
    let [length, jerk, apart] = [f.path_length_rad, f.jerk_ratio, f.variants_distance_rad].map(text);
    let motion = format!("{length} rad, jerk {jerk} of that before smoothing, {apart} rad from seed to seed");
    let solution = format!("{:.0} ns a solution of inverse kinematics", f.ik_ns);
    let (off_m, solved) = (f.ik_error_max_m, f.ik_solved_fraction);
    output::table(&[
        ("scene", format!("{}: {:.0} % of the seeds have a plan", f.scene, 100.0 * f.success_rate)),
        ("time", format!("{ways}; {:.0} ns a look", f.ns_per_check)),
        ("motion", format!("{motion}; {} violations", f.recheck_violations)),
        ("arm", format!("{solution}, {off_m:.2e} m off at most, {solved:.6} solved")),
    ])
}
