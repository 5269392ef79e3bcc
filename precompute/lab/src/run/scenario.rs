//! Speed of scenes with rules, state graphs and news, timed part by part.

use super::{groups::agents_crowd, report::config_error};
use crate::overlap::NearPairs;
use glam::Vec3Swizzles;
use serde::Serialize;
use std::time::Instant;
use throng_core::{Executor, Inline, Rayon, base::limits::THREADS};
use throng_geometry::Bounds2d;
use throng_motion::error::Result;
use throng_simulation::{AnyCharacterGroup, CompiledScene, Simulation};

/// Frames a simulated second (Hz).
const FRAME_HZ: f64 = 30.0;
/// Frames between two samples of overlaps and of occupied slots.
const SAMPLE_FRAMES: u64 = 3;

/// Figures of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ScenarioFigures {
    /// The scene's name.
    pub scene: String,
    /// Number of agents, including those that enter later.
    pub agents: usize,
    /// Number of threads.
    pub threads: usize,
    /// Simulated time (s).
    pub simulated_s: f64,
    /// Frames of a thirtieth of a second computed per second of wall time: crowd, rules and bodies, without drawing.
    pub frames_per_second: f64,
    /// That rate over the one that the paper gives for its scene of this name, with drawing.
    pub over_paper: Option<f64>,
    /// Share of the time for rules and graphs.
    pub rules_share: f64,
    /// Share of the time for the crowd.
    pub crowd_share: f64,
    /// Share of the time for bodies.
    pub motion_share: f64,
    /// Predicates and amounts evaluated per simulated second.
    pub evaluations_per_second: f64,
    /// Time to evaluate a predicate of ten operations (ns).
    pub ns_per_evaluation: f64,
    /// Memory of an agent without body: in the crowd and in its brain (bytes).
    pub bytes_per_agent: usize,
    /// Time to compile the scene, its bundle already open (s).
    pub compile_s: f64,
    /// Agents that know of any event.
    pub informed: usize,
    /// Time at which the last of them learnt of it (s).
    pub informed_last_s: Option<f64>,
    /// Pairs of agents of which one informed the other.
    pub informed_pairs: usize,
    /// Agents found holding two slots, at ten samples a simulated second; always 0.
    pub queued_twice: usize,
    /// Deepest overlap of two agents, at ten samples a simulated second (m).
    pub max_overlap_m: f64,
    /// Reports of agents that make no progress.
    pub stuck: u64,
    /// Memory allocations while stepping, if they are counted.
    pub allocations: Option<u64>,
    /// Hash of the state at the end.
    pub state_hash: String,
}

/// Rates of Kim, Kim and Shin (2003b), section 4, with drawing, on a processor of 2.4 GHz (frames a second).
const PAPER_RATES: [(&str, f64); 4] = [("square", 5.0), ("race", 20.0), ("race-100", 10.0), ("park", 5.0)];

/// Runs a scene and times it, without the time to sample agents.
///
/// - `count`: number of allocations so far, if they are counted.
///
/// # Errors
/// As [`Simulation::new`] and [`Simulation::step`].
pub fn measure_scenario(
    scene: &CompiledScene,
    seconds: Option<f64>,
    threads: usize,
    count: &(dyn Fn() -> Option<u64> + Sync),
) -> Result<ScenarioFigures> {
    THREADS.check_count("threads", threads).map_err(config_error)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(config_error)?;
    pool.install(|| {
        let seconds = seconds.unwrap_or(scene.scene().seconds);
        let begin = Instant::now();
        scene.scene().compile_story().map_err(config_error)?;
        let compile_s = begin.elapsed().as_secs_f64();
        let mut sim = Simulation::new(scene).map_err(config_error)?;
        sim.set_timed();
        let run: &dyn Executor = if threads > 1 { &Rayon } else { &Inline };
        let (mut busy_s, mut taken, mut overlap_m, mut twice, mut last) = (0.0, 0, f64::NEG_INFINITY, 0, 0);
        for frame in 1..=(seconds * FRAME_HZ).round() as u64 {
            let (before, begin) = (count(), Instant::now());
            sim.step_to(frame as f64 / FRAME_HZ, run).map_err(config_error)?;
            busy_s += begin.elapsed().as_secs_f64();
            taken += count().zip(before).map_or(0, |(now, before)| now - before);
            last = frame;
            if frame.is_multiple_of(SAMPLE_FRAMES) {
                overlap_m = deepest_overlap_m(&sim).max(overlap_m);
                twice += sim.brains().map_or(0, |m| m.num_holding_twice());
            }
            if sim.has_ended() {
                break;
            }
        }
        let spent = sim.character_groups().iter().find_map(|group| match group {
            AnyCharacterGroup::Ground(agents) => agents.timings(),
            AnyCharacterGroup::Air(agents) => agents.timings(),
            _ => None,
        });
        let crowd = sim.character_groups().iter().find_map(agents_crowd);
        let share = |s: f64| s / busy_s.max(1e-12);
        let (spent, simulated_s) = (spent.unwrap_or_default(), sim.time_s());
        let brains = sim.brains();
        let spread = brains.map_or_else(Vec::new, |m| m.event_spreads());
        let frames_per_second = last as f64 / busy_s.max(1e-12);
        let name = scene.scene().name.clone();
        let paper = PAPER_RATES.iter().find(|p| p.0 == name).map(|p| p.1);
        Ok(ScenarioFigures {
            agents: sim.num_characters(),
            threads,
            simulated_s,
            frames_per_second,
            over_paper: paper.map(|paper| frames_per_second / paper),
            rules_share: share(spent.brains_s),
            crowd_share: share(spent.all_s - spent.brains_s),
            motion_share: share(spent.bodies_s),
            evaluations_per_second: brains.map_or(0.0, |m| m.evaluations() as f64 / simulated_s.max(1e-9)),
            ns_per_evaluation: ns_per_evaluation(),
            bytes_per_agent: brains.map_or(0, |m| m.bytes_per_agent()) + crowd.map_or(0, |c| c.bytes_per_agent()),
            compile_s,
            informed: brains.map_or(0, |m| m.num_informed()),
            informed_last_s: spread.iter().filter_map(|s| s.last_s).reduce(f64::max),
            informed_pairs: spread.iter().map(|s| s.passed_on).sum(),
            queued_twice: twice,
            max_overlap_m: overlap_m.max(0.0),
            stuck: crowd.map_or(0, |c| c.counts().stuck),
            allocations: count().map(|_| taken),
            state_hash: format!("{:016x}", sim.hash()),
            scene: name,
        })
    })
}

/// Deepest current overlap of two agents; negative or minus infinity if none overlap (m).
fn deepest_overlap_m(sim: &Simulation) -> f64 {
    let discs: Vec<_> = (0..sim.num_characters()).filter_map(|who| sim.disc(who)).collect();
    let mut most = f64::NEG_INFINITY;
    let bounds = discs.iter().map(|d| Bounds2d::around_disc(d.centre.xz(), d.radius));
    NearPairs::default().visit(bounds, |i, j| {
        let (a, b) = (&discs[i], &discs[j]);
        most = most.max(f64::from(a.radius + b.radius - a.centre.distance(b.centre)));
    });
    most
}

/// Time to evaluate a predicate of ten operations (ns).
fn ns_per_evaluation() -> f64 {
    const TIMES: u32 = 400_000;
    let begin = Instant::now();
    let sum = throng_simulation::scenario::evaluate_sample(TIMES);
    let ns = begin.elapsed().as_secs_f64() * 1e9 / f64::from(TIMES);
    // The result has to be used, so that the evaluation is not optimized away.
    if sum.is_finite() { ns } else { f64::NAN }
}
