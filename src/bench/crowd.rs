//! `throng bench crowd`: what does a crowd cost, and does it keep its promises?

use super::Args;
use crate::args::{Outcome, fail};
use crate::output;
use crate::run::crowd::print;
use serde::Serialize;
use std::path::Path;
use throng_precompute::picture::{self, Plot};
use throng_precompute::scene::crowd::{self, CrowdReport, CrowdRun, CrowdScene, Engine, OWN_SCENES};

/// The word for all of the project's own scenes.
const ALL: &str = "all";

/// What is asked of a crowd.
#[derive(clap::Args)]
pub struct CrowdOptions {
    /// With the word `crowd`: some of the project's own scenes (flock, corridor, lanes, circle, ring, bottleneck,
    /// square), `all` of them, or files.
    #[arg(long, value_delimiter = ',', value_name = "NAME_OR_FILE,...")]
    scene: Vec<String>,
    /// With the word `crowd`: numbers of members; that of the scene where absent. Of several scenes, those that do not
    /// grow leave out larger numbers than their own.
    #[arg(long, value_delimiter = ',', value_name = "N,...")]
    members: Vec<usize>,
    /// With the word `crowd`: events, occupancy, fixed; that of the scene where absent.
    #[arg(long, value_delimiter = ',', value_name = "ENGINE,...")]
    engine: Vec<String>,
    /// With the word `crowd`: times that each is run; the fastest counts, as one that nothing else slowed down.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    repeats: u32,
    /// With the word `crowd`: plot of the time for one simulated second over the number of members.
    #[arg(long, value_name = "FILE")]
    png: Option<std::path::PathBuf>,
}

impl CrowdOptions {
    /// True where something was asked that is for crowds alone.
    pub fn is_given(&self) -> bool {
        let many = !self.members.is_empty() || !self.engine.is_empty() || self.repeats > 1;
        !self.scene.is_empty() || many || self.png.is_some()
    }
}

/// Several runs.
#[derive(Serialize)]
struct Sweep {
    runs: Vec<CrowdReport>,
}

/// Measures every scene with every number of members and every engine that was asked for.
pub fn run(args: &Args) -> Outcome {
    let options = &args.crowd;
    let trials = trials(options)?;
    let threads = args.threads.first().copied().unwrap_or(1);
    let is_sweep = trials.len() > 1;
    let mut runs = Vec::new();
    if is_sweep && !args.json {
        println!("{}", CrowdReport::HEADINGS);
    }
    for scene in &trials {
        scene.check(Path::new(&scene.name))?;
        let config = CrowdRun { seconds: args.seconds, timed_apart: true, threads, recorded: false };
        let report = fastest(scene, &config, options.repeats)?;
        match args.json {
            true => (),
            false if is_sweep => println!("{}", report.row()),
            false => print(&report)?,
        }
        runs.push(report);
    }
    if let Some(png) = &options.png {
        plot(&runs).save_png(png)?;
    }
    match &runs[..] {
        _ if !args.json => Ok(()),
        [one] => output::json(one),
        _ => output::json(&Sweep { runs }),
    }
}

/// Runs a scene so many times; everything but its time is the same in all of them.
fn fastest(scene: &CrowdScene, config: &CrowdRun, repeats: u32) -> Result<CrowdReport, throng_precompute::BuildError> {
    let mut best = crowd::run(scene, config)?.0;
    for _ in 1..repeats {
        let again = crowd::run(scene, config)?.0;
        if again.wall_s_per_simulated_s < best.wall_s_per_simulated_s {
            best = again;
        }
    }
    Ok(best)
}

/// All that is to be run.
fn trials(options: &CrowdOptions) -> Result<Vec<CrowdScene>, Box<dyn std::error::Error>> {
    let mut names: Vec<&str> = options.scene.iter().map(String::as_str).collect();
    if names.is_empty() {
        names.push("corridor");
    }
    let names = names.iter().flat_map(|n| if *n == ALL { OWN_SCENES.to_vec() } else { vec![*n] });
    let scenes = names.map(load).collect::<Result<Vec<_>, _>>()?;
    let mut trials = Vec::new();
    for scene in &scenes {
        let own = scene.num_members();
        let members = if options.members.is_empty() { vec![own] } else { options.members.clone() };
        for engine in engines(options, scene)? {
            // One that does not grow gets too dense; asked for alone, it is tried.
            let fits = |n: &&usize| scenes.len() == 1 || scene.grows || **n <= own;
            trials.extend(members.iter().filter(fits).map(|&n| CrowdScene { engine, ..scene.resized(n) }));
        }
    }
    Ok(trials)
}

/// One of the project's own scenes, or a file.
fn load(name: &str) -> Result<CrowdScene, Box<dyn std::error::Error>> {
    if let Some(own) = crowd::own_scene(name)? {
        return Ok(own);
    }
    let path = Path::new(name);
    if !path.exists() {
        return fail(format!("--scene {name}: expected one of {}, or a scene file", OWN_SCENES.join(", ")));
    }
    if !CrowdScene::is_one(path) {
        return fail(format!("--scene {name}: expected a scene of a crowd, which has [[groups]]"));
    }
    Ok(CrowdScene::load(path)?)
}

fn engines(options: &CrowdOptions, scene: &CrowdScene) -> Result<Vec<Engine>, Box<dyn std::error::Error>> {
    if options.engine.is_empty() {
        return Ok(vec![scene.engine]);
    }
    options.engine.iter().map(|name| engine(name)).collect()
}

/// The engine of a name.
pub fn engine(name: &str) -> Result<Engine, Box<dyn std::error::Error>> {
    match Engine::named(name) {
        Some(engine) => Ok(engine),
        None => fail(format!("--engine {name}: expected one of {}", Engine::ALL.map(Engine::name).join(", "))),
    }
}

/// Time over members, a line for each scene and engine: figure 6 of Kim, Kim and Shin 2003.
fn plot(runs: &[CrowdReport]) -> picture::Picture {
    let scene = runs.first().map_or("", |r| &r.scene);
    let is_one = runs.iter().all(|r| r.scene == scene);
    let mut lines: Vec<(String, Vec<[f64; 2]>)> = Vec::new();
    for r in runs {
        let name = if is_one { r.engine.clone() } else { format!("{}, {}", r.scene, r.engine) };
        let point = [r.members as f64, 1e-3 * r.us_per_member_second * r.members as f64];
        match lines.iter_mut().find(|l| l.0 == name) {
            Some(line) => line.1.push(point),
            None => lines.push((name, vec![point])),
        }
    }
    picture::plot(&Plot {
        title: &format!("{}: time to simulate one second", if is_one { scene } else { "crowds" }),
        subtitle: &compared(runs).filter(|_| is_one).unwrap_or_else(|| "without drawing or measuring".into()),
        axes: ["members", "time for one simulated second (ms)"],
        lines,
    })
}

/// How the slowest and the fastest engine compare with most members; none where there is but one.
fn compared(runs: &[CrowdReport]) -> Option<String> {
    let most = runs.iter().map(|r| r.members).max()?;
    let wall = |r: &&CrowdReport| r.wall_s_per_simulated_s;
    let all = || runs.iter().filter(|r| r.members == most);
    let slow = all().max_by(|a, b| wall(a).total_cmp(&wall(b)))?;
    let fast = all().min_by(|a, b| wall(a).total_cmp(&wall(b)))?;
    let times = wall(&slow) / wall(&fast);
    let text = format!("with {most} members, {} takes {times:.1} times as long as {}", slow.engine, fast.engine);
    (slow.engine != fast.engine && times.is_finite()).then_some(text)
}
