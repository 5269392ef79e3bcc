//! Measures one crowd that several processes move.

use super::groups::agents_crowd;
use super::report::{config_error, scene_error};
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;
use throng_base::{Comm, Error, clock::thread_cpu_s, limits::SECONDS};
use throng_crowd::Crowd;
use throng_motion::error::{Result, ensure};
use throng_motion::{memory, progress::Progress};
use throng_simulation::{CompiledScene, Simulation};

/// Samples of overlaps a simulated second (Hz).
const OVERLAP_HZ: f64 = 10.0;

/// Cost of a crowd that several processes move.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SharedFigures {
    /// Number of agents at the start.
    pub agents: usize,
    /// Number of processes.
    pub ranks: usize,
    /// Simulated time (s).
    pub simulated_s: f64,
    /// Time of the slowest process for an agent and a simulated second, without sampling overlaps (us).
    pub us_per_agent_second: f64,
    /// Handovers of agents from one process to another.
    pub handed_over: u64,
    /// Agents found overlapping another one, at ten samples a simulated second; always 0.
    pub overlaps: u64,
    /// Bytes that all processes sent to others.
    pub bytes_moved: u64,
    /// Hash of the state at the end, equal to that of a single process.
    pub state_hash: String,
    /// Figures of each process.
    pub of_ranks: Vec<RankFigures>,
}

/// Cost of one of several processes.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RankFigures {
    /// Agents in its region at the end.
    pub agents: usize,
    /// Time without waiting for others (s).
    pub busy_s: f64,
    /// Processor time; with MPI, waiting counts as running. 0 where the system does not report it (s).
    pub ran_s: f64,
    /// Bytes that it sent to others.
    pub bytes_moved: u64,
    /// Peak memory, without gathering all agents at the end (bytes); 0 where the system does not report it.
    pub peak_bytes: u64,
}

/// Moves the agents of a scene together with other processes, each of which calls this with the same arguments.
///
/// - `progress`: counts simulated tenths of a second.
/// - returns the figures on rank 0.
///
/// # Errors
/// [`throng_motion::error::BuildError::Stage`] for a scene in which agents have more than goals, or other characters;
/// as [`Crowd::advance`].
pub fn run_shared(
    scene: &CompiledScene,
    seconds: Option<f64>,
    comm: &dyn Comm,
    progress: &dyn Progress,
) -> Result<Option<SharedFigures>> {
    let seconds = seconds.unwrap_or(scene.scene().seconds);
    SECONDS.check("seconds", None, seconds).map_err(config_error)?;
    let crowd = crowd_of(scene)?;
    let agents = crowd.num_agents();
    let mut part = crowd.share(comm).map_err(|e| config_error(Error::from(e)))?;
    comm.barrier().map_err(config_error)?;
    let (mut advance_s, mut busy_s, mut ran_s, mut overlaps) = (0.0, 0.0, 0.0, 0);
    let mut before = comm.traffic();
    let moved = before.bytes_moved;
    let looks = (seconds * OVERLAP_HZ).ceil() as u64;
    progress.begin("crowd", looks, "tenths of a second");
    for observe in 1..=looks {
        let (begin, running) = (Instant::now(), thread_cpu_s());
        part.advance((observe as f64 / OVERLAP_HZ).min(seconds), comm).map_err(|e| config_error(Error::from(e)))?;
        let (wall_s, traffic) = (begin.elapsed().as_secs_f64(), comm.traffic());
        advance_s += wall_s;
        busy_s += wall_s - (traffic.waited_s - before.waited_s);
        ran_s += thread_cpu_s().zip(running).map_or(0.0, |(after, begin)| after - begin);
        before = traffic;
        overlaps += part.num_overlapping();
        progress.advance(1);
    }
    progress.end();
    let (num_bytes, peak_bytes) = (before.bytes_moved - moved, memory::peak_bytes().unwrap_or(0));
    let mine = [part.num_agents() as f64, busy_s, ran_s, num_bytes as f64, peak_bytes as f64];
    let mut all: [Vec<f64>; 5] = Default::default();
    for (all, number) in all.iter_mut().zip(mine) {
        *all = comm.all_numbers(number).map_err(config_error)?;
    }
    let of_ranks = (0..comm.num_ranks()).map(|r| RankFigures {
        agents: all[0][r] as usize,
        busy_s: all[1][r],
        ran_s: all[2][r],
        bytes_moved: all[3][r] as u64,
        peak_bytes: all[4][r] as u64,
    });
    let slowest_s = comm.max(advance_s).map_err(config_error)?;
    let handed_over = comm.sum(part.num_handed_over()).map_err(config_error)?;
    let overlaps = comm.sum(overlaps).map_err(config_error)?;
    let whole = part.gather(comm).map_err(|e| config_error(Error::from(e)))?;
    Ok(whole.map(|whole| SharedFigures {
        agents,
        ranks: comm.num_ranks(),
        simulated_s: seconds,
        us_per_agent_second: 1e6 * slowest_s / (agents as f64 * seconds),
        handed_over,
        overlaps,
        bytes_moved: all[3].iter().map(|&b| b as u64).sum(),
        state_hash: format!("{:016x}", whole.hash()),
        of_ranks: of_ranks.collect(),
    }))
}

/// The crowd of a scene whose agents only have goals.
fn crowd_of(scene: &CompiledScene) -> Result<Crowd> {
    if scene.scenario().is_some() {
        return Err(scene_error("its agents react to what happens, and only one process can move such; leave out happenings, rules and wandering".into()));
    }
    let others = || scene_error("expected a scene of agents, with `motion = \"none\"`".into());
    ensure(scene.scene().groups.iter().all(|g| g.is_of_agents()), others)?;
    let sim = Simulation::new(scene).map_err(config_error)?;
    agents_crowd(&sim.character_groups()[0]).cloned().ok_or_else(others)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::built_in_scene;
    use throng_base::{LocalComm, SingleRank};
    use throng_motion::progress::Silent;

    #[test]
    fn every_plain_scene_ends_as_in_one_process() {
        for (name, agents) in [("lanes", 250), ("circle", 60), ("bottleneck", 80), ("flock", 200)] {
            let scene = built_in_scene(name).unwrap().expect("it is there").resized(agents).open().unwrap();
            let mut alone = crowd_of(&scene).unwrap();
            alone.advance(60.0, &mut |_| {}).unwrap();
            let hash = format!("{:016x}", alone.hash());
            for ranks in 1..=4 {
                let run = |comm: &LocalComm| run_shared(&scene, Some(60.0), comm, &Silent).unwrap();
                let figures = LocalComm::run(ranks, run).swap_remove(0).expect("rank 0 has them");
                assert_eq!(figures.state_hash, hash, "{name} at {ranks} ranks");
                assert_eq!((figures.agents, figures.ranks, figures.overlaps), (agents, ranks, 0));
                assert_eq!(figures.handed_over > 0, ranks > 1, "{name} at {ranks} ranks");
                assert_eq!(figures.bytes_moved > 0, ranks > 1);
                assert_eq!(figures.of_ranks.len(), ranks);
            }
        }
    }

    #[test]
    fn scene_in_which_agents_tell_each_other_is_refused() {
        let scene = built_in_scene("square").unwrap().expect("it is there").open().unwrap();
        let error = run_shared(&scene, None, &SingleRank, &Silent).unwrap_err();
        assert!(error.to_string().contains("only one process"), "{error}");
    }
}
