//! `throng run`: a scene, or characters on a bundle.

use crate::args::{
    CacheArgs, CommandResult, CrowdArgs, MOTION_FLAGS, SelectArgs, UnitArgs, fail, given_flags, is_bundle, is_toml,
    load_scene, named_engine,
};
use crate::{build, figures::print_figures, help, keys, output, progress};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::{fmt::Write, net::SocketAddr};
use throng_core::{Bundle, base::error::ensure, base::limits};
use throng_precompute::activities::ActivityReport;
use throng_precompute::live::{LiveConfig, LiveReport, SceneServer};
use throng_precompute::run::{self, BuildContext, SceneReport, SceneRunConfig, TrajectoryPoint};
use throng_precompute::trial::{self, TrialReport};
use throng_precompute::{config::BuildConfig, error::Result, examples::BlendReport, files, picture, verdict::Verdict};
use throng_simulation::{CompiledScene, GroupMotion, Scene};

/// Run a scene, or characters on a bundle that each chase a target of their own, and measure them.
#[derive(clap::Args)]
#[command(after_long_help = help())]
pub struct Args {
    /// Scene (`.toml`), bundle, or motion as `throng build` takes it, which is built first, into the cache. A scene's
    /// bundles are built and its worlds stitched where they are missing.
    #[arg(required = true, value_name = "SCENE_BUNDLE_OR_MOTION")]
    what: Vec<PathBuf>,
    /// Picture to write: of a bundle, the crowd from above and a strip of one character's poses; of a scene, a sheet for
    /// each kind of motion.
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Table of trajectories, for PedPy: CSV of time_s, agent, x_m, z_m, vx_mps and vz_mps.
    #[arg(long, help_heading = "Scenes", value_name = "FILE")]
    trajectories: Option<PathBuf>,
    /// Points of a trajectory a simulated second.
    #[arg(long, help_heading = "Scenes", value_name = "HZ", default_value_t = 10.0,
        value_parser = limits::number_parser::<f64>(&limits::TRAJECTORY_HZ))]
    trajectory_hz: f64,
    /// Recording of a scene to write, for `throng explain`.
    #[arg(long, help_heading = "Scenes", value_name = "FILE")]
    record: Option<PathBuf>,
    /// Bundle in place of the scene's; its world is then beside it.
    #[arg(long, help_heading = "Scenes", value_name = "FILE")]
    bundle: Option<PathBuf>,
    /// Engine of agents in place of that of the scene: events or occupancy.
    #[arg(long, help_heading = "Scenes", value_name = "NAME")]
    engine: Option<String>,
    /// Leave out a behaviour of the scene; may be given several times.
    #[arg(long, help_heading = "Scenes", value_name = "BEHAVIOUR")]
    without: Vec<String>,
    #[command(flatten)]
    select: SelectArgs,
    #[command(flatten)]
    live: LiveArgs,
    #[command(flatten)]
    units: UnitArgs,
    #[command(flatten)]
    crowd: CrowdArgs,
    /// Read only files beside a stranger's scene or below, and build nothing.
    #[arg(long, help_heading = "Scenes", hide_short_help = true)]
    untrusted: bool,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// Options for serving a scene to programs that show it.
#[derive(clap::Args)]
struct LiveArgs {
    /// Serve roots, poses and events of the running scene at ADDRESS (127.0.0.1:7468) to other programs. The
    /// run waits for the first client, and goes on in real time.
    #[arg(long, help_heading = "Live", value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "127.0.0.1:7468",
        conflicts_with_all = ["png", "trajectories", "record", "json"])]
    serve: Option<SocketAddr>,
    /// With --serve, allow an address that others can reach.
    #[arg(long, help_heading = "Live", requires = "serve")]
    serve_anyone: bool,
    /// With --serve, simulated seconds a second; 0 is as fast as possible.
    #[arg(long, help_heading = "Live", value_name = "X", requires = "serve", default_value_t = 1.0, value_parser = limits::number_parser::<f64>(&limits::LIVE_SPEED))]
    speed: f64,
}

/// Help on the JSON keys, for each kind of input.
fn help() -> String {
    let bundle = keys::json_keys_under::<BundleRunReport>("JSON keys (of a bundle)");
    let of = "of a scene; those that do not apply are left out, and `groups[]` has the same of each group";
    [bundle, keys::json_keys_under::<SceneReport>(&format!("JSON keys ({of})"))].join("\n")
}

/// Printed report of a bundle.
#[derive(Serialize, JsonSchema)]
struct BundleRunReport {
    #[serde(flatten)]
    trial: TrialReport,
    /// Verdict on the trial.
    verdict: Verdict,
    /// Quality of the blend spaces, and the examples they are made of.
    blend_spaces: Vec<BlendReport>,
    /// Activities of standing bodies.
    activities: Vec<ActivityReport>,
}

pub fn run(args: &Args) -> CommandResult {
    let files = [&args.png, &args.trajectories, &args.record];
    files::check_targets(files.into_iter().flatten(), args.what.iter().chain(&args.bundle))?;
    let is_single = |p: &PathBuf| is_toml(p) || is_bundle(p);
    let is_for_motion = !args.select.is_given() || !args.what.iter().any(is_single);
    ensure(
        is_for_motion,
        || "--use and --leave are for motion, which is built; name it in place of its bundle or scene",
    )?;
    if let (Some(flag), Some(single)) = (given_flags(&MOTION_FLAGS).first(), args.what.iter().find(|p| is_single(p))) {
        return fail(format!("{}: {flag} is for motion: it is read already", single.display()));
    }
    match args.what.as_slice() {
        [scene] if is_toml(scene) => return run_scene(load_scene(scene, args.untrusted)?, scene, args),
        [_] => {}
        several => ensure(!several.iter().any(is_single), || "expected one scene, one bundle, or motion alone")?,
    }
    let files_of_scenes = [&args.bundle, &args.trajectories, &args.record].into_iter().flatten();
    let is_of_scene = args.engine.is_some() || !args.without.is_empty() || args.live.serve.is_some();
    let fault =
        "--bundle, --engine, --record, --serve, --trajectories and --without are for scenes; name the bundle alone";
    ensure(!is_of_scene && files_of_scenes.count() == 0, || fault)?;
    let folder = progress::ScratchFolder::new()?;
    let file = match args.what.as_slice() {
        [bundle] if is_bundle(bundle) => bundle.clone(),
        motion => {
            let mut config = args.units.motion_config(motion)?;
            args.select.add_to(&mut config);
            build_motion(&config, &args.cache, &folder)?
        }
    };
    let tables = crate::args::open_bundle(&file)?;
    let blend_spaces = BlendReport::of_bundle(&tables)?;
    let rate_hz = tables.meta().rate_hz;
    let activities: Vec<_> = tables.meta().activities.iter().map(|a| ActivityReport::from_meta(a, rate_hz)).collect();
    let mut rows: Vec<_> = blend_spaces.iter().flat_map(build::blend_summary).collect();
    rows.extend(build::activities(&activities));
    if tables.policies().is_empty() && !blend_spaces.is_empty() {
        if !args.json {
            output::table(&rows)?;
        }
        return run_scene(run::blend_scene(&tables, &file)?, &file, args);
    }
    if tables.policies().is_empty() {
        let what = args.what.iter().map(|p| p.to_string_lossy()).collect::<Vec<_>>().join(" ");
        return fail(format!(
            "nobody walks in {what}; `throng view {what}` plays it. For a crowd, name walks beside its motion: `throng run MOTION WALKS`"
        ));
    }
    let mut config = args.crowd.trial();
    // Poses are for the picture; a number beyond the last character is refused all the same.
    config.recorded = config.recorded.filter(|&c| args.png.is_some() || c >= config.characters);
    let (report, record) = trial::run(&tables, &config)?;
    if let Some(png) = &args.png {
        picture::trial_sheet(&tables, &config, &report, &record)?.save_png(png)?;
    }
    let verdict = Verdict::new(&tables, &report, &blend_spaces);
    if args.json {
        return output::json(&BundleRunReport { trial: report, verdict, blend_spaces, activities });
    }
    print(&report)?;
    output::table(&rows)?;
    output::text(format!("\n{}", build::verdict_text(&verdict)))?;
    match (&args.png, args.what.as_slice()) {
        (Some(_), [shown]) => help::next_step(&["view", &shown.to_string_lossy()]),
        _ => Ok(()),
    }
}

/// Opens the bundle of some motion, which is built into the cache if it is not there yet.
pub fn motion_bundle(config: &BuildConfig, cache: &CacheArgs) -> CommandResult<Bundle> {
    let folder = progress::ScratchFolder::new()?;
    // Read, not mapped: without a cache, the file goes with its folder.
    crate::args::open_bundle(&build_motion(config, cache, &folder)?)
}

/// Builds the bundle of some motion into the cache, or into a folder without one.
fn build_motion(config: &BuildConfig, cache: &CacheArgs, folder: &progress::ScratchFolder) -> CommandResult<PathBuf> {
    let otherwise = folder.path().join("motion.throng");
    Ok(with_build_context(cache, |with| run::ensure_motion(config, &otherwise, with))??)
}

/// Runs a scene.
///
/// - `file`: file of the scene, or of the bundle that it was made for.
fn run_scene(mut scene: Scene, file: &Path, args: &Args) -> CommandResult {
    override_scene(&mut scene, args)?;
    scene.check()?;
    ensure_scene(&scene, &args.cache)?;
    let compiled = scene.open()?;
    if let Some(address) = args.live.serve {
        return serve(&compiled, address, args);
    }
    let config = SceneRunConfig {
        seconds: args.crowd.seconds.map(f64::from),
        step_hz: args.crowd.step_hz.into(),
        recorded: args.png.is_some(),
        trajectory_hz: args.trajectories.as_ref().map(|_| args.trajectory_hz),
    };
    let mut recording = args.record.as_ref().map(|_| run::RunRecording::new(&compiled, config.step_hz)).transpose()?;
    let (report, record, sim) = run::run_recorded(&compiled, &config, recording.as_mut())?;
    if let (Some(file), Some(recording)) = (&args.record, &recording) {
        files::write_atomically(file, |out| out.write_all(&recording.bytes()))?;
    }
    if let Some(png) = &args.png {
        picture::scene_sheet(&compiled, &sim, &report, &record)?.save_png(png)?;
    }
    if let Some(file) = &args.trajectories {
        write_trajectories(&record.trajectories, file)?;
    }
    for (time_s, character, what) in record.faults.iter().take(5) {
        output::print_to_stderr(format_args!("at {time_s:.1} s, character {character}: {what}"));
    }
    if args.json {
        return output::json(&report);
    }
    print_scene(&report)?;
    if let Some(recording) = args.record.as_ref().filter(|_| scene.has_story()) {
        return help::next_step(&["explain", &recording.to_string_lossy(), "--agent", "0"]);
    }
    let is_written = [&args.png, &args.trajectories, &args.record].iter().any(|file| file.is_some());
    if is_written { help::next_step(&["view", &file.to_string_lossy()]) } else { Ok(()) }
}

/// Runs a scene for programs that show it.
fn serve(scene: &CompiledScene, address: SocketAddr, args: &Args) -> CommandResult {
    let server = SceneServer::bind(address, args.live.serve_anyone)?;
    let (name, at) = (&scene.scene().name, server.address()?);
    output::text(format!("{name}: served at {at}; it begins when somebody connects. Ctrl+C ends it.\n"))?;
    let (seconds, step_hz) = (args.crowd.seconds.map(f64::from), args.crowd.step_hz.into());
    let config = LiveConfig { seconds, step_hz, speed: args.live.speed };
    let LiveReport { frames, clients, missed_frames: missed } =
        server.serve(scene, &config, progress::stop_on_interrupt())?;
    output::text(format!("{frames} frames for {clients} client(s), who missed {missed}\n"))
}

/// Writes trajectories as CSV.
fn write_trajectories(points: &[TrajectoryPoint], file: &Path) -> CommandResult {
    let mut text = String::from("time_s,agent,x_m,z_m,vx_mps,vz_mps\n");
    for p in points {
        let ([x, z], [vx, vz]) = (p.at.to_array(), p.velocity.to_array());
        _ = writeln!(text, "{:.3},{},{x:.4},{z:.4},{vx:.4},{vz:.4}", p.time_s, p.agent);
    }
    Ok(files::write_atomically(file, |out| out.write_all(text.as_bytes()))?)
}

/// Overrides settings of a scene by the given options.
fn override_scene(scene: &mut Scene, args: &Args) -> CommandResult {
    args.crowd.override_scene(scene)?;
    if let Some(name) = &args.engine {
        let has_agents = scene.groups.iter().any(|g| g.is_of_agents());
        ensure(has_agents, || "--engine is for scenes with agents")?;
        scene.agents.engine = named_engine(name)?;
    }
    for name in &args.without {
        let known: Vec<_> = scene.groups.iter().flat_map(|g| &g.behaviours).map(|b| b.name.clone()).collect();
        let there_is = || if known.is_empty() { "no behaviour to leave out".into() } else { known.join(", ") };
        ensure(known.contains(name), || format!("--without {name}: the scene has {}", there_is()))?;
        scene.groups.iter_mut().for_each(|g| g.behaviours.retain(|b| b.name != *name));
    }
    if let Some(bundle) = &args.bundle {
        let has_bundle = scene.groups.iter().any(|g| g.motion != GroupMotion::None);
        ensure(has_bundle, || "--bundle: the scene has no group with a bundle that it could replace")?;
        scene.set_bundle(bundle);
    }
    Ok(())
}

/// Builds and stitches what a scene names and is missing.
pub fn ensure_scene(scene: &Scene, cache: &CacheArgs) -> CommandResult {
    Ok(with_build_context(cache, |with| run::ensure_scene(scene, with))??)
}

/// Builds a bundle if it is missing.
pub fn ensure_bundle(bundle: &Path, config: Option<&Path>, cache: &CacheArgs) -> CommandResult {
    Ok(with_build_context(cache, |with| run::ensure_bundle(bundle, config, with))??)
}

/// Calls `make` with the cache, a progress bar, and messages on standard error.
pub fn with_build_context<T>(cache: &CacheArgs, make: impl FnOnce(&BuildContext<'_>) -> T) -> Result<T> {
    let (cache, progress) = (cache.cache()?, progress::BuildProgressBar::on_interrupt(cache.folder()));
    Ok(make(&BuildContext { cache: &cache, progress: &progress, report_news: &|news| output::print_to_stderr(news) }))
}

/// Prints the report of a scene as text.
fn print_scene(r: &SceneReport) -> CommandResult {
    let who = r.total.characters.map(|n| format!("{n} character(s)"));
    let agents = r.total.agents.map(|n| format!("{n} agent(s)"));
    let all: Vec<String> = who.into_iter().chain(agents).collect();
    let scene = format!("{}: {}, {:.0} s", r.scene, all.join(" and "), r.total.simulated_s);
    print_figures("scene", scene, &r.total)?;
    for s in &r.statistics.services {
        let lost = format!("{} balked, {} gave up", s.balked, s.gave_up);
        let waits = format!("waits {:.1} s on average, 90th percentile {:.1} s", s.wait_mean_s, s.wait_p90_s);
        let busy = 100.0 * s.busy_while_waiting;
        let text = format!(
            "{}: {} served, {lost}; {waits}; tills busy {busy:.0} % of the time that people wait",
            s.name, s.served
        );
        output::table(&[("service", text)])?;
    }
    for s in r.statistics.sources.iter().filter(|s| s.refused > 0) {
        let text = format!("{}: {} entered, {} tries found no room or nobody to enter", s.name, s.entered, s.refused);
        output::table(&[("source", text)])?;
    }
    let mut groups = r.groups.iter().filter(|_| r.groups.len() > 1);
    groups.try_for_each(|g| print_figures("group", format!("{}, motion {}", g.group, g.motion), &g.figures))
}

/// Prints the report of a trial as text.
pub fn print(r: &TrialReport) -> CommandResult {
    let [reached, stayed] = [r.reached_fraction, r.stayed_fraction].map(|fraction| 100.0 * fraction);
    let after = r.mean_arrival_s.map_or(String::new(), |s| format!(", after {s:.1} s on average"));
    let [mean, p95] = [r.foot_slip_mean_mps, r.foot_slip_p95_mps];
    let steps = format!("{:.0} steps a second of the whole crowd on one thread", r.steps_per_second);
    let [millions, choices] = [r.poses_per_second / 1e6, r.choices_per_second];
    let made = r.made.map(|m| format!("{:.0} % of what plays on the way was made", 100.0 * m.share_of_moving));
    let mut rows = vec![
        ("crowd", format!("{} characters, {:.0} s", r.characters, r.simulated_s)),
        ("targets", format!("{reached:.1} % reached{after}; {stayed:.1} % near at the end")),
        ("foot slip", format!("{mean:.3} m/s mean, {p95:.3} m/s 95th percentile, while planted")),
        ("speed", format!("{steps}; {millions:.2} million poses, {choices:.0} choices a second")),
    ];
    rows.extend(made.map(|made| ("made motion", made)));
    output::table(&rows)
}
