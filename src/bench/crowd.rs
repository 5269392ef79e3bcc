//! `throng bench crowd`: what does a crowd cost, and does it keep its promises?

use super::Args;
use crate::args::{Outcome, fail};
use crate::output;
use crate::run::crowd::print;
use serde::Serialize;
use std::path::Path;
use throng_precompute::picture::{self, Plot};
use throng_precompute::scene::crowd::{self, CrowdReport, CrowdRun, CrowdScene, Engine, OWN_SCENES};

/// What is asked of a crowd.
#[derive(clap::Args)]
pub struct CrowdOptions {
    /// With the word `crowd`: one of the project's own scenes (flock, corridor, lanes, circle, ring, bottleneck,
    /// square), or a file.
    #[arg(long, value_name = "NAME_OR_FILE")]
    scene: Option<String>,
    /// With the word `crowd`: numbers of members; that of the scene where absent.
    #[arg(long, value_delimiter = ',', value_name = "N,...")]
    members: Vec<usize>,
    /// With the word `crowd`: events, occupancy, fixed; that of the scene where absent.
    #[arg(long, value_delimiter = ',', value_name = "ENGINE,...")]
    engine: Vec<String>,
    /// With the word `crowd`: times that each is run; the fastest counts, as one that nothing else slowed down.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    repeats: u32,
    /// With the word `crowd`: plot of the wall time for one simulated second over the number of members.
    #[arg(long, value_name = "FILE")]
    png: Option<std::path::PathBuf>,
}

impl CrowdOptions {
    /// True where something was asked that is for crowds alone.
    pub fn is_given(&self) -> bool {
        let many = !self.members.is_empty() || !self.engine.is_empty() || self.repeats > 1;
        self.scene.is_some() || many || self.png.is_some()
    }
}

/// Several runs.
#[derive(Serialize)]
struct Sweep {
    runs: Vec<CrowdReport>,
}

/// Measures a scene with every number of members and every engine that was asked for.
pub fn run(args: &Args) -> Outcome {
    let options = &args.crowd;
    let scene = load(options.scene.as_deref().unwrap_or("corridor"))?;
    let members = if options.members.is_empty() { vec![scene.num_members()] } else { options.members.clone() };
    let engines = engines(options, &scene)?;
    let threads = args.threads.first().copied().unwrap_or(1);
    let mut runs = Vec::new();
    for &engine in &engines {
        for &n in &members {
            let scene = CrowdScene { engine, ..scene.resized(n) };
            scene.check(Path::new(&scene.name))?;
            let config = CrowdRun { seconds: args.seconds, timed_apart: true, threads, recorded: false };
            runs.push(fastest(&scene, &config, options.repeats)?);
            if !args.json {
                print(&runs[runs.len() - 1])?;
            }
        }
    }
    if let Some(png) = &options.png {
        plot(&scene.name, &runs, &engines).save_png(png)?;
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

/// Wall time over members, a line for each engine: figure 6 of Kim, Kim and Shin 2003.
fn plot(scene: &str, runs: &[CrowdReport], engines: &[Engine]) -> picture::Picture {
    let line = |e: &Engine| {
        let of_engine = runs.iter().filter(|r| r.engine == e.name());
        (e.name().to_owned(), of_engine.map(|r| [r.members as f64, 1e3 * r.wall_s_per_simulated_s]).collect())
    };
    picture::plot(&Plot {
        title: &format!("{scene}: time to simulate one second"),
        subtitle: &compared(runs).unwrap_or_else(|| "without drawing or measuring".into()),
        axes: ["members", "wall time for one simulated second (ms)"],
        lines: engines.iter().map(line).collect(),
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
