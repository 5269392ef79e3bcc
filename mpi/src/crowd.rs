//! `throng-mpi crowd`: one crowd in several processes.

use crate::progress::{ProgressLines, RankStatuses};
use crate::{MpiResult, print_json};
use std::{path::Path, sync::Arc};
use throng_core::base::error::ensure;
use throng_core::base::{Comm, limits};
use throng_precompute::run::{BUILT_IN_SCENES, SharedFigures, built_in_scene, run_shared};
use throng_simulation::Scene;

/// Move the agents of a scene in several processes, each of which has a region and hands agents over at its borders.
///
/// The state at the end is that of one process, bit by bit. JSON keys: agents, ranks, simulated_s, us_per_agent_second,
/// handed_over, overlaps, bytes_moved, state_hash, of_ranks[] (agents, busy_s, ran_s, bytes_moved, peak_bytes).
#[derive(clap::Args)]
pub struct Args {
    /// Built-in scene (flock, corridor, lanes, circle, ring, bottleneck), or a scene file of agents with goals alone.
    #[arg(value_name = "NAME_OR_FILE")]
    scene: String,
    /// Number of agents; that of the scene where absent.
    #[arg(long, value_name = "N", value_parser = limits::number_parser::<usize>(&limits::CHARACTERS))]
    agents: Option<usize>,
    /// Simulated time; what the scene says where absent.
    #[arg(long, value_name = "S", value_parser = limits::number_parser::<f64>(&limits::SECONDS))]
    seconds: Option<f64>,
    /// Seed of places, sizes and speeds; that of the scene where absent.
    #[arg(long, value_parser = limits::number_parser::<u64>(&limits::SEED))]
    seed: Option<u64>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args, comm: &dyn Comm, statuses: &Arc<dyn RankStatuses>) -> MpiResult {
    let mut scene = load(&args.scene)?;
    if let Some(agents) = args.agents {
        scene = scene.resized(agents);
    }
    scene.seed = args.seed.unwrap_or(scene.seed);
    scene.check()?;
    let progress = ProgressLines::new(args.json, comm.rank(), statuses);
    let figures = run_shared(&scene.open()?, args.seconds, comm, &progress)?;
    figures.map_or(Ok(()), |f| if args.json { print_json(&f) } else { print(&scene.name, &f) })
}

/// Loads a built-in scene, or a file.
fn load(name: &str) -> Result<Scene, Box<dyn std::error::Error>> {
    if let Some(own) = built_in_scene(name)? {
        return Ok(own);
    }
    let path = Path::new(name);
    ensure(path.exists(), || format!("{name}: expected one of {}, or a scene file", BUILT_IN_SCENES.join(", ")))?;
    Ok(Scene::load(path)?)
}

fn print(scene: &str, f: &SharedFigures) -> MpiResult {
    println!("scene        {scene}: {} agents, {} s, {} ranks", f.agents, f.simulated_s, f.ranks);
    println!("time         {:.2} us for an agent and a second", f.us_per_agent_second);
    println!("handed over  {}", f.handed_over);
    println!("overlaps     {}", f.overlaps);
    println!("moved        {:.1} MB", f.bytes_moved as f64 / 1e6);
    println!("state        {}", f.state_hash);
    for (rank, of) in f.of_ranks.iter().enumerate() {
        let (moved, peak) = (of.bytes_moved as f64 / 1e6, of.peak_bytes as f64 / 1e6);
        let busy = format!("{} agents, busy for {:.1} s", of.agents, of.busy_s);
        println!("rank {rank:<7} {busy}, sent {moved:.1} MB, at most {peak:.0} MB of memory");
    }
    Ok(())
}
