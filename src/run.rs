//! `throng run`: a crowd on a bundle, or a scene.

pub mod crowd;
pub mod walkers;
pub mod world;

use crate::args::{CacheArgs, CrowdArgs, Outcome, fail};
use crate::{output, progress};
use std::path::{Path, PathBuf};
use throng_precompute::config::BuildConfig;
use throng_precompute::picture;
use throng_precompute::pipeline;
use throng_precompute::scene::crowd::CrowdScene;
use throng_precompute::scene::walkers::WalkersScene;
use throng_precompute::scene::world::WorldScene;
use throng_precompute::scene::{self, RunConfig, Scene, SceneKind, SceneReport};
use throng_precompute::trial::{self, TrialConfig, TrialRecord, TrialReport};
use throng_runtime::Tables;

/// Run a scene, or characters on a bundle that each chase a target of their own, and measure what they do.
///
/// JSON keys: of a scene, scene, characters, simulated_s, steps_per_second (of all characters, on one thread),
/// hits_per_minute (that landed, for each character), landed_fraction, blocked_fraction, thrown, foot_slip_mean_mps,
/// foot_slip_p95_mps, max_penetration_m, deep_fraction, distance_mean_m, distance_max_m; of a scene in a world, scene, characters,
/// simulated_s, steps_per_second, character_overlaps (times at which trunks of two came into each other), deepest_overlap_m,
/// environment_penetrations (times at which somebody came more than 8 cm into a unit), deepest_penetration_m, stuck
/// (characters that stayed within half a metre for 30 s though they wished to go), fulfilled_per_minute,
/// travelled_m_per_minute (both for each character), waiting_fraction, foot_slip_mean_mps, foot_slip_p95_mps; of a
/// scene of walkers, scene, characters, simulated_s, steps_per_second, speed_mean_mps, speed_max_mps, foot_slip_mean_mps,
/// foot_slip_p95_mps, knee_rate_max_radps, below_ground_max_m; of a
/// scene of a crowd, the keys of `throng bench crowd`, and where it has bodies foot_slip_mean_mps, foot_slip_p95_mps,
/// hips_off_max_m; of a bundle, characters, simulated_s, reached_fraction, stayed_fraction, mean_arrival_s,
/// mean_final_distance_m, foot_slip_mean_mps, foot_slip_p95_mps, steps_per_second, poses_per_second,
/// choices_per_second.
#[derive(clap::Args)]
pub struct Args {
    /// Scene (`.toml`) or bundle. A scene's bundle is built from its config where it is not there.
    #[arg(value_name = "SCENE_OR_BUNDLE")]
    file: PathBuf,
    /// Picture to write: of a bundle, the crowd from above and a strip of one character's poses; of a scene, those
    /// who fight.
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Bundle in place of the scene's.
    #[arg(long, value_name = "FILE")]
    bundle: Option<PathBuf>,
    /// Engine in place of that of the scene of a crowd: events, occupancy or fixed.
    #[arg(long, value_name = "NAME")]
    engine: Option<String>,
    /// Leave out a behaviour of the scene; may be given several times.
    #[arg(long, value_name = "BEHAVIOUR")]
    without: Vec<String>,
    #[command(flatten)]
    crowd: CrowdArgs,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    if args.engine.is_some() && !CrowdScene::is_one(&args.file) {
        return fail("--engine is for scenes of crowds");
    }
    if Scene::is_scene(&args.file) {
        return match &args.file {
            file if WorldScene::is_one(file) => world::run(args),
            file if WalkersScene::is_one(file) => walkers::run(args),
            file if CrowdScene::is_one(file) => crowd::run(args),
            _ => run_scene(args),
        };
    }
    if args.bundle.is_some() || !args.without.is_empty() {
        return fail("--bundle and --without are for scenes; name the bundle alone");
    }
    let tables = crate::args::open(&args.file)?;
    let config = args.crowd.trial();
    let (report, record) = trial::run(&tables, &config)?;
    if let Some(png) = &args.png {
        draw(&tables, &config, &report, &record, png)?;
    }
    if args.json { output::json(&report) } else { print(&report) }
}

fn run_scene(args: &Args) -> Outcome {
    let mut scene = Scene::load(&args.file)?;
    args.crowd.change(&mut scene)?;
    leave_out(&mut scene, &args.without)?;
    scene.check(&args.file)?;
    if let Some(bundle) = &args.bundle {
        (scene.bundle, scene.config) = (bundle.clone(), None);
    }
    make_bundle(&scene.bundle, scene.config.as_deref(), &args.cache)?;
    let tables = crate::args::open(&scene.bundle)?;
    let config = RunConfig { recorded: args.png.is_some(), ..args.crowd.scene_run() };
    let (report, record) = scene::run(&tables, &scene, &config)?;
    if let Some(png) = &args.png {
        picture::scene_sheet(&tables, &scene, &report, &record).save_png(png)?;
    }
    if args.json { output::json(&report) } else { print_scene(&scene, &report) }
}

/// Takes behaviours out of a scene.
fn leave_out(scene: &mut Scene, without: &[String]) -> Outcome {
    for name in without {
        if !scene.goals.iter().any(|g| g.behaviour == *name) {
            let known: Vec<_> = scene.goals.iter().map(|g| g.behaviour.as_str()).collect();
            return fail(format!("--without {name}: expected one of {}", known.join(", ")));
        }
        scene.goals.retain(|g| g.behaviour != *name);
    }
    Ok(())
}

/// Builds a bundle where it is not there.
pub fn make_bundle(bundle: &Path, config: Option<&Path>, cache: &CacheArgs) -> Outcome {
    if bundle.exists() {
        return Ok(());
    }
    let Some(config) = config else {
        let name = bundle.display();
        return fail(format!(
            "{name}: there is no such bundle; build it with `throng build`, or name another with --bundle"
        ));
    };
    eprintln!("{} is not there: building it from {} ...", bundle.display(), config.display());
    let report = pipeline::build(&BuildConfig::load(config)?, bundle, &cache.cache(), &progress::Bar::default())?;
    output::warnings(&report.skipped, &report.warnings);
    Ok(())
}

/// What was measured of a scene, for people.
fn print_scene(scene: &Scene, r: &SceneReport) -> Outcome {
    let what = if scene.kind == SceneKind::Pairs { "opponent" } else { "target" };
    let mut rows = vec![
        ("scene", format!("{}: {} character(s), {:.0} s", r.scene, r.characters, r.simulated_s)),
        (
            "blows",
            format!(
                "{} thrown: {:.1} % landed, {:.1} % blocked; {:.1} landed a minute and character",
                r.thrown,
                100.0 * r.landed_fraction,
                100.0 * r.blocked_fraction,
                r.hits_per_minute
            ),
        ),
        (
            "distance",
            format!(
                "{:.2} m from the {what} on average{}",
                r.distance_mean_m,
                r.distance_max_m.map_or(String::new(), |m| format!(", {m:.2} m at most after 5 s"))
            ),
        ),
    ];
    if scene.kind == SceneKind::Pairs {
        rows.push((
            "penetration",
            format!("{:.3} m at most, deep {:.2} % of the time", r.max_penetration_m, 100.0 * r.deep_fraction),
        ));
    }
    rows.push((
        "foot slip",
        format!("{:.3} m/s mean, {:.3} m/s 95th percentile, while planted", r.foot_slip_mean_mps, r.foot_slip_p95_mps),
    ));
    rows.push(("speed", format!("{:.0} steps a second of everybody, on one thread", r.steps_per_second)));
    output::table(&rows)
}

/// Writes the picture of a trial.
pub fn draw(tables: &Tables, config: &TrialConfig, report: &TrialReport, record: &TrialRecord, path: &Path) -> Outcome {
    throng_precompute::picture::trial_sheet(tables, config, report, record).save_png(path)?;
    Ok(())
}

/// What was measured, for people.
pub fn print(r: &TrialReport) -> Outcome {
    output::table(&[
        ("crowd", format!("{} characters, {:.0} s", r.characters, r.simulated_s)),
        (
            "targets",
            format!(
                "{:.1} % reached{}; {:.1} % near at the end",
                100.0 * r.reached_fraction,
                r.mean_arrival_s.map_or(String::new(), |s| format!(", after {s:.1} s on average")),
                100.0 * r.stayed_fraction
            ),
        ),
        (
            "foot slip",
            format!(
                "{:.3} m/s mean, {:.3} m/s 95th percentile, while planted",
                r.foot_slip_mean_mps, r.foot_slip_p95_mps
            ),
        ),
        (
            "speed",
            format!(
                "{:.0} steps a second of the whole crowd on one thread; {:.2} million poses, {:.0} choices a second",
                r.steps_per_second,
                r.poses_per_second / 1e6,
                r.choices_per_second
            ),
        ),
    ])
}
