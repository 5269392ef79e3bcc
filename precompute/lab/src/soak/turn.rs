//! One run of a scene with all its checks.

use super::{SoakConfig, SoakReport, Worst, fault};
use crate::run::Figures;
use crate::run::watch::Watch;
use rand::{Rng, RngExt};
use std::time::Instant;
use throng_motion::error::BuildError;
use throng_runtime::simulation::{CompiledScene, Scene, Simulation};
use throng_runtime::{Inline, Planar, Rayon, Run};

/// Nobody is faster than this on the whole, nor farther from its start than that allows (m/s, m).
const FASTEST_MPS: f32 = 12.0;
const SLACK_M: f32 = 3.0;
/// Farthest of a joint from its root over the ground, and from the ground (m).
const REACH_M: f32 = 3.0;
const HEIGHT_M: f32 = 100.0;
/// Steps between comparisons with runs on several threads.
const COMPARED: usize = 15;

/// Runs a scene and checks it; then runs it on several threads, and from a snapshot, and compares.
///
/// # Errors
/// [`BuildError::Config`] for a scene that cannot be opened or stepped.
pub fn turn(scene: &Scene, config: &SoakConfig, rng: &mut impl Rng, report: &mut SoakReport) -> Result<(), BuildError> {
    let compiled = scene.open().map_err(fault)?;
    let steps = (config.run_s * config.step_hz).round().max(2.0) as usize;
    let kept_at = rng.random_range(0..steps);
    let until = rng.random_range(kept_at + 1..=steps);
    let threads = [2, 8][rng.random_range(0..2usize)];
    let name = format!("{} (seed {})", scene.name, scene.seed);

    let mut sim = Simulation::new(&compiled).map_err(fault)?;
    let groups: Vec<usize> = (0..sim.groups().len()).collect();
    let mut watch = Watch::new(&sim, &groups)?;
    let mut look = Look { starts: sim.roots().collect(), last: sim.roots().collect() };
    let mut hashes = vec![sim.hash()];
    let (mut kept, mut then) = (sim.snapshot(), sim.hash());
    for step in 1..=steps {
        let begin = Instant::now();
        sim.step_to(step as f64 / config.step_hz, &Inline).map_err(fault)?;
        report.worst.step_ms = report.worst.step_ms.max(1e3 * begin.elapsed().as_secs_f64());
        watch.observe(&sim, (1.0 / config.step_hz) as f32, step, config.step_hz);
        look.at(&sim, &name, (1.0 / config.step_hz) as f32, report);
        if step == kept_at {
            kept = sim.snapshot();
        }
        if step == until {
            then = sim.hash();
        }
        if step.is_multiple_of(COMPARED) {
            hashes.push(sim.hash());
        }
    }
    overlaps(&watch.figures(&sim, config.run_s, None), &name, report);

    let mut other = Simulation::new(&compiled).map_err(fault)?;
    let restored = other.restore(&kept);
    report.check(restored.is_ok(), || format!("{name}: the snapshot of step {kept_at} is refused"));
    for step in kept_at + 1..=until {
        other.step_to(step as f64 / config.step_hz, &Inline).map_err(fault)?;
    }
    let now = other.hash();
    report.check(now == then, || {
        format!("{name}: from the snapshot of step {kept_at} to {until}: {now:016x}, not {then:016x}")
    });

    let together = on_threads(threads, || hashes_of(&compiled, steps, config.step_hz, &Rayon))?;
    let differs = (0..hashes.len()).find(|&k| together.get(k) != hashes.get(k));
    report.check(differs.is_none(), || {
        format!("{name}: {threads} threads differ by step {}", COMPARED * differs.unwrap_or_default())
    });
    report.runs += 1;
    report.simulated_s += config.run_s;
    Ok(())
}

/// The hash of a scene after some simulated time, on so many threads (s).
///
/// # Errors
/// [`BuildError::Config`] for a scene that cannot be opened or stepped.
pub fn hash_at_end(scene: &Scene, config: &SoakConfig, threads: usize) -> Result<u64, BuildError> {
    let compiled = scene.open().map_err(fault)?;
    let steps = (config.run_s * config.step_hz).round().max(1.0) as usize;
    let hashes = on_threads(threads, || {
        let mut sim = Simulation::new(&compiled).map_err(fault)?;
        (1..=steps).try_for_each(|k| sim.step_to(k as f64 / config.step_hz, &Rayon).map_err(fault))?;
        Ok(vec![sim.hash()])
    })?;
    Ok(hashes[0])
}

fn on_threads(
    threads: usize,
    work: impl FnOnce() -> Result<Vec<u64>, BuildError> + Send,
) -> Result<Vec<u64>, BuildError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| BuildError::Config { message: e.to_string() })?.install(work)
}

fn hashes_of(scene: &CompiledScene, steps: usize, hz: f64, run: &dyn Run) -> Result<Vec<u64>, BuildError> {
    let mut sim = Simulation::new(scene).map_err(fault)?;
    let mut hashes = vec![sim.hash()];
    for step in 1..=steps {
        sim.step_to(step as f64 / hz, run).map_err(fault)?;
        if step.is_multiple_of(COMPARED) {
            hashes.push(sim.hash());
        }
    }
    Ok(hashes)
}

/// Where everybody began, and was at the last step.
struct Look {
    starts: Vec<Option<Planar>>,
    last: Vec<Option<Planar>>,
}

impl Look {
    /// Checks all numbers of all characters after a step.
    fn at(&mut self, sim: &Simulation, name: &str, dt_s: f32, report: &mut SoakReport) {
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
                let joint = |m: &throng_runtime::Mat3x4| m.translation();
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
fn overlaps(figures: &Figures, name: &str, report: &mut SoakReport) {
    let worst: &mut Worst = &mut report.worst;
    worst.foot_slip_p95_mps = worst.foot_slip_p95_mps.max(figures.foot_slip_p95_mps.unwrap_or(0.0));
    if let Some(world) = &figures.world {
        worst.people_overlap_m = worst.people_overlap_m.max(world.deepest_overlap_m);
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
    use crate::run::own_scene;

    #[test]
    fn agents_that_overlap_are_a_fault() {
        let scene = own_scene("circle").unwrap().unwrap().resized(10);
        let mut sim = Simulation::new(&scene.open().unwrap()).unwrap();
        let mut watch = Watch::new(&sim, &[0]).unwrap();
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
