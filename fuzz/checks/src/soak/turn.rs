//! One run of a scene with all its checks.

use super::pools::{self, Pools};
use super::{SoakConfig, SoakReport, Worst, fault};
use rand::{Rng, RngExt};
use rayon::ThreadPool;
use std::time::Instant;
use throng_core::{Executor, Inline, Mat3x4, NUM_JOINTS, Planar, Rayon};
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

/// Access of the checks to a simulation. Tests put faults in here, which the checks have to find.
#[derive(Clone, Copy)]
pub(super) struct RunAccess {
    /// Executor of runs on several threads.
    pub(super) threads: &'static dyn Executor,
    /// Called with a simulation that a snapshot was put into.
    pub(super) restored: fn(&mut Simulation),
    /// Root of a character.
    pub(super) root: fn(&Simulation, usize) -> Option<Planar>,
    /// Pose of a character.
    pub(super) pose: fn(&Simulation, usize) -> Option<[Mat3x4; NUM_JOINTS]>,
}

impl Default for RunAccess {
    fn default() -> Self {
        Self { threads: &Rayon, restored: |_| (), root: Simulation::root, pose: |sim, who| sim.pose(who).copied() }
    }
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
    turn_with(scene, config, pools, rng, &RunAccess::default(), report)
}

/// As [`turn`], with another access.
pub(super) fn turn_with(
    scene: &Scene,
    config: &SoakConfig,
    pools: &Pools,
    rng: &mut impl Rng,
    access: &RunAccess,
    report: &mut SoakReport,
) -> Result<(), BuildError> {
    let compiled = scene.open().map_err(fault)?;
    let (steps, hz) = ((config.run_s * config.step_hz).round().max(2.0) as usize, config.step_hz);
    let kept_at = rng.random_range(0..steps);
    let until = rng.random_range(kept_at + 1..=steps);
    let pool = pools.any(rng);
    let name = format!("{} (seed {})", scene.name, scene.seed);

    let Seen { hashes, kept, then } = watched(&compiled, config, &name, [kept_at, until], access, report)?;
    let mut sim = Simulation::new(&compiled).map_err(fault)?;
    let restored = sim.restore(&kept);
    let refusal = restored.as_ref().err().map(ToString::to_string).unwrap_or_default();
    report.check(restored.is_ok(), || format!("{name}: the snapshot of step {kept_at} is refused: {refusal}"));
    if restored.is_ok() {
        (access.restored)(&mut sim);
        (kept_at + 1..=until).try_for_each(|step| sim.step_to(step as f64 / hz, &Inline)).map_err(fault)?;
        let now = sim.hash();
        report.check(now == then, || {
            format!("{name}: from the snapshot of step {kept_at} to {until}: {now:016x}, not {then:016x}")
        });
    }
    // Its room is the next one's.
    drop(sim);

    let together = hashes_of(&compiled, steps, hz, pool, access.threads)?;
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
    access: &RunAccess,
    report: &mut SoakReport,
) -> Result<Seen, BuildError> {
    let mut sim = Simulation::new(scene).map_err(fault)?;
    let groups: Vec<usize> = (0..sim.groups().len()).collect();
    let mut watch = SceneWatch::new(&sim, &groups)?;
    let mut checker = RootChecker::new(&sim);
    let mut seen = Seen { hashes: vec![sim.hash()], kept: sim.snapshot(), then: sim.hash() };
    let steps = (config.run_s * config.step_hz).round().max(2.0) as usize;
    for step in 1..=steps {
        let begin = Instant::now();
        sim.step_to(step as f64 / config.step_hz, &Inline).map_err(fault)?;
        report.worst.step_ms = report.worst.step_ms.max(1e3 * begin.elapsed().as_secs_f64());
        watch.observe(&sim, (1.0 / config.step_hz) as f32, step, config.step_hz);
        checker.check_step(&sim, access, name, (1.0 / config.step_hz) as f32, report);
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
fn hashes_of(
    scene: &CompiledScene,
    steps: usize,
    hz: f64,
    pool: &ThreadPool,
    threads: &dyn Executor,
) -> Result<Vec<u64>, BuildError> {
    let mut sim = Simulation::new(scene).map_err(fault)?;
    let mut hashes = vec![sim.hash()];
    for step in 1..=steps {
        pool.install(|| sim.step_to(step as f64 / hz, threads)).map_err(fault)?;
        if step.is_multiple_of(COMPARED) {
            hashes.push(sim.hash());
        }
    }
    Ok(hashes)
}

/// Checks of a run, step by step: since when and where all characters are there, and their roots at the last step.
struct RootChecker {
    starts: Vec<Option<(f64, Planar)>>,
    last: Vec<Option<Planar>>,
}

impl RootChecker {
    fn new(sim: &Simulation) -> Self {
        Self { starts: sim.roots().map(|root| root.map(|root| (0.0, root))).collect(), last: sim.roots().collect() }
    }

    /// Checks all numbers of all characters after a step.
    fn check_step(&mut self, sim: &Simulation, access: &RunAccess, name: &str, dt_s: f32, report: &mut SoakReport) {
        for who in 0..sim.num_characters() {
            report.character_steps += 1;
            self.check_root(sim, access, who, name, dt_s, report);
            let Some(pose) = (access.pose)(sim, who) else { continue };
            let finite = pose.iter().all(|m| m.rows.as_flattened().iter().all(|v| v.is_finite()));
            let joint = |m: &Mat3x4| m.translation();
            let reach = pose.iter().map(|m| joint(m).x.hypot(joint(m).z)).fold(0.0, f32::max);
            let high = pose.iter().map(|m| joint(m).y.abs()).fold(0.0, f32::max);
            report.worst.reach_m = report.worst.reach_m.max(f64::from(reach));
            let time_s = sim.time_s();
            report.check(finite && reach < REACH_M && high < HEIGHT_M, || {
                format!("{name}: {time_s:.2} s, character {who}: finite {finite}, joints {reach} m away, {high} m high")
            });
        }
    }

    /// Checks the root of a character. One that has left, and enters elsewhere, starts anew.
    fn check_root(
        &mut self,
        sim: &Simulation,
        access: &RunAccess,
        who: usize,
        name: &str,
        dt_s: f32,
        report: &mut SoakReport,
    ) {
        let (root, time_s) = ((access.root)(sim, who), sim.time_s());
        let Some(root) = root else {
            (self.starts[who], self.last[who]) = (None, None);
            return;
        };
        let finite = [root.x, root.z, root.heading].iter().all(|v| v.is_finite());
        report.check(finite, || format!("{name}: {time_s:.2} s, character {who}: root {root:?}"));
        if !finite {
            return;
        }
        let (since_s, start) = *self.starts[who].get_or_insert((time_s, root));
        let far = (root.x - start.x).hypot(root.z - start.z);
        report.worst.farthest_m = report.worst.farthest_m.max(f64::from(far));
        let allowed = FASTEST_MPS * (time_s - since_s) as f32 + SLACK_M;
        report.check(far <= allowed, || {
            format!("{name}: {time_s:.2} s, character {who}: {far} m from where it was {:.2} s ago", time_s - since_s)
        });
        if let Some(last) = self.last[who].replace(root) {
            let speed = f64::from((root.x - last.x).hypot(root.z - last.z) / dt_s);
            report.worst.fastest_mps = report.worst.fastest_mps.max(speed);
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
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;
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

    /// What a soak of a scene reports.
    fn soaked(scene: &Scene, access: &RunAccess) -> SoakReport {
        let config = SoakConfig { run_s: 1.0, ..SoakConfig::default() };
        let (pools, mut rng) = (Pools::new().unwrap(), Pcg64Mcg::seed_from_u64(5));
        let mut report = SoakReport::default();
        turn_with(scene, &config, &pools, &mut rng, access, &mut report).unwrap();
        report
    }

    /// An executor that forgets the last part of the work.
    struct Forgetful;

    impl Executor for Forgetful {
        fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
            (0..num_parts.saturating_sub(1).max(1).min(num_parts)).for_each(part);
        }
    }

    #[test]
    fn every_check_of_a_run_can_fail() {
        let crowd = |name: &str, agents: usize| built_in_scene(name).unwrap().unwrap().resized(agents);
        let scene = crowd("square", 50);
        let good = RunAccess::default();
        assert_eq!(soaked(&scene, &good).faults, Vec::<String>::new());

        let faults = |access: RunAccess| soaked(&scene, &access).faults;
        let one = |faults: Vec<String>, words: &str| {
            assert!(faults.len() == 1 && faults[0].contains(words), "{words}: {faults:?}");
        };
        // A great crowd alone is shared among threads.
        one(
            soaked(&crowd("circle", 2100), &RunAccess { threads: &Forgetful, ..good }).faults,
            " threads differ by step ",
        );
        // A snapshot that leaves the seed out.
        let restored = |sim: &mut Simulation| {
            let mut other = sim.scene().clone();
            other.seed += 1;
            let until_s = sim.time_s();
            *sim = Simulation::new(&other.open().unwrap()).unwrap();
            sim.step_to(until_s, &Inline).unwrap();
        };
        one(faults(RunAccess { restored, ..good }), ": from the snapshot of step ");

        /// The 20th step.
        fn is_then(sim: &Simulation) -> bool {
            (sim.time_s() - 20.0 / 30.0).abs() < 1e-3
        }
        let nan = |sim: &Simulation, who: usize| {
            sim.root(who).map(|root| if who == 7 && is_then(sim) { Planar { heading: f32::NAN, ..root } } else { root })
        };
        one(faults(RunAccess { root: nan, ..good }), "0.67 s, character 7: root ");
        let infinite = |sim: &Simulation, who: usize| {
            sim.root(who).map(|root| if who == 7 && is_then(sim) { Planar { x: f32::INFINITY, ..root } } else { root })
        };
        one(faults(RunAccess { root: infinite, ..good }), "0.67 s, character 7: root ");
        let far = |sim: &Simulation, who: usize| {
            sim.root(who).map(|root| if who == 7 && is_then(sim) { Planar { x: root.x + 30.0, ..root } } else { root })
        };
        one(faults(RunAccess { root: far, ..good }), "character 7: ");
        let pose = |sim: &Simulation, who: usize| {
            let mut pose = [Mat3x4::from_rotation_translation(glam::Quat::IDENTITY, glam::Vec3::ZERO); NUM_JOINTS];
            pose[3].rows[1][2] = if who == 7 && is_then(sim) { f32::NAN } else { 0.0 };
            Some(pose)
        };
        one(faults(RunAccess { pose, ..good }), "character 7: finite false");
    }
}
