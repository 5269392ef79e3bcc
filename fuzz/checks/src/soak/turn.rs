//! One run of a scene with all its checks.

use super::pools::{self, Pools};
use super::{SoakConfig, SoakReport, Worst, fault};
use rand::{Rng, RngExt};
use rayon::ThreadPool;
use std::time::Instant;
use throng_core::{Inline, Planar, Rayon};
use throng_lab::run::{SceneFigures, SceneWatch};
use throng_motion::error::BuildError;
use throng_simulation::{CompiledScene, Scene, Simulation};

/// Nobody is faster than this on the whole, nor farther from its start than that allows (m/s, m).
const FASTEST_MPS: f32 = 12.0;
const SLACK_M: f32 = 3.0;
/// Farthest of a joint from its root over the ground, and from the ground (m).
const REACH_M: f32 = 3.0;
const HEIGHT_M: f32 = 100.0;
/// Steps between comparisons with runs on several threads.
const COMPARED: usize = 15;

/// What a run has to come to again.
struct Seen {
    /// Hashes at the start and after every [`COMPARED`] steps.
    hashes: Vec<u64>,
    /// The state at the moment of the snapshot.
    kept: Vec<u8>,
    /// The hash at the later moment.
    then: u64,
}

/// Runs a scene and checks it; then runs it from a snapshot, and on several threads, and compares. One simulation is
/// there at a time.
///
/// # Errors
/// [`BuildError::Config`] for a scene that cannot be opened or stepped.
pub fn turn(
    scene: &Scene,
    config: &SoakConfig,
    pools: &Pools,
    rng: &mut impl Rng,
    report: &mut SoakReport,
) -> Result<(), BuildError> {
    let compiled = scene.open().map_err(fault)?;
    let (steps, hz) = ((config.run_s * config.step_hz).round().max(2.0) as usize, config.step_hz);
    let kept_at = rng.random_range(0..steps);
    let until = rng.random_range(kept_at + 1..=steps);
    let pool = pools.any(rng);
    let name = format!("{} (seed {})", scene.name, scene.seed);

    let Seen { hashes, kept, then } = watched(&compiled, config, &name, [kept_at, until], report)?;
    let mut sim = Simulation::new(&compiled).map_err(fault)?;
    let restored = sim.restore(&kept);
    let refusal = restored.as_ref().err().map(ToString::to_string).unwrap_or_default();
    report.check(restored.is_ok(), || format!("{name}: the snapshot of step {kept_at} is refused: {refusal}"));
    if restored.is_ok() {
        (kept_at + 1..=until).try_for_each(|step| sim.step_to(step as f64 / hz, &Inline)).map_err(fault)?;
        let now = sim.hash();
        report.check(now == then, || {
            format!("{name}: from the snapshot of step {kept_at} to {until}: {now:016x}, not {then:016x}")
        });
    }
    // Its room is the next one's.
    drop(sim);

    let together = hashes_of(&compiled, steps, hz, pool)?;
    let threads = pool.current_num_threads();
    let differs = (0..hashes.len()).find(|&k| together.get(k) != hashes.get(k));
    report.check(differs.is_none(), || {
        format!("{name}: {threads} threads differ by step {}", COMPARED * differs.unwrap_or_default())
    });
    report.runs += 1;
    report.simulated_s += config.run_s;
    Ok(())
}

/// Runs a scene, and checks every step.
fn watched(
    scene: &CompiledScene,
    config: &SoakConfig,
    name: &str,
    [kept_at, until]: [usize; 2],
    report: &mut SoakReport,
) -> Result<Seen, BuildError> {
    let mut sim = Simulation::new(scene).map_err(fault)?;
    let groups: Vec<usize> = (0..sim.groups().len()).collect();
    let mut watch = SceneWatch::new(&sim, &groups)?;
    let mut checker = RootChecker { starts: sim.roots().collect(), last: sim.roots().collect() };
    let mut seen = Seen { hashes: vec![sim.hash()], kept: sim.snapshot(), then: sim.hash() };
    let steps = (config.run_s * config.step_hz).round().max(2.0) as usize;
    for step in 1..=steps {
        let begin = Instant::now();
        sim.step_to(step as f64 / config.step_hz, &Inline).map_err(fault)?;
        report.worst.step_ms = report.worst.step_ms.max(1e3 * begin.elapsed().as_secs_f64());
        watch.observe(&sim, (1.0 / config.step_hz) as f32, step, config.step_hz);
        checker.check_step(&sim, name, (1.0 / config.step_hz) as f32, report);
        if step == kept_at {
            seen.kept = sim.snapshot();
        }
        if step == until {
            seen.then = sim.hash();
        }
        if step.is_multiple_of(COMPARED) {
            seen.hashes.push(sim.hash());
        }
    }
    overlaps(&watch.figures(&sim, config.run_s, None), name, report);
    Ok(seen)
}

/// The hash of a scene after some simulated time, on so many threads (s).
///
/// # Errors
/// [`BuildError::Config`] for a scene that cannot be opened or stepped.
pub fn hash_at_end(scene: &Scene, config: &SoakConfig, threads: usize) -> Result<u64, BuildError> {
    let compiled = scene.open().map_err(fault)?;
    let steps = (config.run_s * config.step_hz).round().max(1.0) as usize;
    let (pool, mut sim) = (pools::build_pool(threads)?, Simulation::new(&compiled).map_err(fault)?);
    pool.install(|| (1..=steps).try_for_each(|k| sim.step_to(k as f64 / config.step_hz, &Rayon))).map_err(fault)?;
    Ok(sim.hash())
}

/// Hashes of a scene on several threads. The simulation is made by the calling one, where the allocator has room of the
/// one before it.
fn hashes_of(scene: &CompiledScene, steps: usize, hz: f64, pool: &ThreadPool) -> Result<Vec<u64>, BuildError> {
    let mut sim = Simulation::new(scene).map_err(fault)?;
    let mut hashes = vec![sim.hash()];
    for step in 1..=steps {
        pool.install(|| sim.step_to(step as f64 / hz, &Rayon)).map_err(fault)?;
        if step.is_multiple_of(COMPARED) {
            hashes.push(sim.hash());
        }
    }
    Ok(hashes)
}

/// Checks of a run, step by step: roots of all characters at the start and at the last step.
struct RootChecker {
    starts: Vec<Option<Planar>>,
    last: Vec<Option<Planar>>,
}

impl RootChecker {
    /// Checks all numbers of all characters after a step.
    fn check_step(&mut self, sim: &Simulation, name: &str, dt_s: f32, report: &mut SoakReport) {
        let allowed = FASTEST_MPS * sim.time_s() as f32 + SLACK_M;
        for who in 0..sim.num_characters() {
            let (root, time_s) = (sim.root(who), sim.time_s());
            report.character_steps += 1;
            let Some(root) = root else { continue };
            let finite = [root.x, root.z, root.heading].iter().all(|v| v.is_finite());
            report.check(finite, || format!("{name}: {time_s:.2} s, character {who}: root {root:?}"));
            if let Some(start) = self.starts[who].filter(|_| finite) {
                let far = (root.x - start.x).hypot(root.z - start.z);
                let worst = &mut report.worst;
                worst.farthest_m = worst.farthest_m.max(f64::from(far));
                report.check(far <= allowed, || {
                    format!("{name}: {time_s:.2} s, character {who}: {far} m from its start")
                });
            }
            if let Some(last) = self.last[who] {
                let speed = f64::from((root.x - last.x).hypot(root.z - last.z) / dt_s);
                report.worst.fastest_mps = report.worst.fastest_mps.max(speed);
            }
            self.last[who] = Some(root);
            if let Some(pose) = sim.pose(who) {
                let finite = pose.iter().all(|m| m.rows.as_flattened().iter().all(|v| v.is_finite()));
                let joint = |m: &throng_core::Mat3x4| m.translation();
                let reach = pose.iter().map(|m| joint(m).x.hypot(joint(m).z)).fold(0.0, f32::max);
                let high = pose.iter().map(|m| joint(m).y.abs()).fold(0.0, f32::max);
                report.worst.reach_m = report.worst.reach_m.max(f64::from(reach));
                report.check(finite && reach < REACH_M && high < HEIGHT_M, || {
                    format!(
                        "{name}: {time_s:.2} s, character {who}: finite {finite}, joints {reach} m away, {high} m high"
                    )
                });
            }
        }
    }
}

/// Checks that agents did not overlap, and keeps what else was worst.
fn overlaps(figures: &SceneFigures, name: &str, report: &mut SoakReport) {
    let worst: &mut Worst = &mut report.worst;
    worst.foot_slip_p95_mps = worst.foot_slip_p95_mps.max(figures.foot_slip_p95_mps.unwrap_or(0.0));
    if let Some(world) = &figures.world {
        worst.people_overlap_m = worst.people_overlap_m.max(figures.deepest_overlap_m.unwrap_or(0.0));
        worst.penetration_m = worst.penetration_m.max(world.deepest_penetration_m);
    }
    if let Some(crowd) = &figures.crowd {
        worst.agent_overlap_m = worst.agent_overlap_m.max(crowd.max_overlap_m);
        let most = crowd.max_overlap_m;
        report.check(crowd.overlap_over_1mm_fraction == 0.0, || format!("{name}: agents overlap by {most} m"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_lab::run::built_in_scene;

    #[test]
    fn agents_that_overlap_are_a_fault() {
        let scene = built_in_scene("circle").unwrap().unwrap().resized(10);
        let mut sim = Simulation::new(&scene.open().unwrap()).unwrap();
        let mut watch = SceneWatch::new(&sim, &[0]).unwrap();
        sim.step_to(0.1, &Inline).unwrap();
        watch.observe(&sim, 0.1, 1, 10.0);
        let (mut figures, mut report) = (watch.figures(&sim, 0.1, None), SoakReport::default());
        overlaps(&figures, "circle", &mut report);
        assert_eq!((report.checks, report.failed), (1, 0));
        let crowd = figures.crowd.as_mut().unwrap();
        (crowd.overlap_over_1mm_fraction, crowd.max_overlap_m) = (0.01, 0.02);
        overlaps(&figures, "circle", &mut report);
        assert_eq!((report.checks, report.failed, report.worst.agent_overlap_m), (2, 1, 0.02));
        assert_eq!(report.faults, ["circle: agents overlap by 0.02 m"]);
    }
}
