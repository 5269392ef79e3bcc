//! Runs scenes in turns for as long as one likes, and checks every step.

mod pools;
mod stock;
mod turn;

pub use pools::Pools;
pub use stock::scenes;
pub use turn::{hash_at_end, turn};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;
use std::time::Instant;
use throng_motion::error::BuildError;
use throng_motion::memory::resident_bytes;
use throng_simulation::Scene;

/// Rounds over all scenes after which memory must not grow.
const WARM_UP_ROUNDS: u64 = 3;
/// Memory that may come on top of what there was then: share, and bytes.
const GROWTH: (f64, u64) = (0.1, 16 << 20);
/// Most faults that are reported; all are counted.
const MAX_REPORTED: usize = 20;

/// How long, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoakConfig {
    /// Wall time after which no more runs begin; every scene runs at least once (s).
    pub seconds: f64,
    /// Simulated time of a run (s, above 0).
    pub run_s: f64,
    /// Steps a simulated second (Hz, at least 1).
    pub step_hz: f64,
    /// Of the seeds of scenes and of the moments of snapshots.
    pub seed: u64,
}

impl Default for SoakConfig {
    fn default() -> Self {
        Self { seconds: 60.0, run_s: 20.0, step_hz: 30.0, seed: 1 }
    }
}

/// What was run and found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SoakReport {
    /// Runs of a scene.
    pub runs: u64,
    /// Steps of single characters.
    pub character_steps: u64,
    /// Simulated time of all runs (s).
    pub simulated_s: f64,
    /// Things that were checked: numbers and bounds of each character at each step; of each run overlaps, hashes after a
    /// restored snapshot and on several threads, memory.
    pub checks: u64,
    /// Those that were not as they should be.
    pub failed: u64,
    /// Wall time (s).
    pub seconds: f64,
    /// The worst that was seen.
    pub worst: Worst,
    /// Memory in use after the first rounds; left out where the system does not tell, or the time was too short (bytes).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warm_bytes: Option<u64>,
    /// Most memory in use after a later run (bytes).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most_bytes: Option<u64>,
    /// The first things that were not as they should be.
    pub faults: Vec<String>,
}

/// The worst figures of all runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Worst {
    /// Farthest that anybody was from its start (m).
    pub farthest_m: f64,
    /// Fastest that a root moved in a step (m/s).
    pub fastest_mps: f64,
    /// Farthest of a joint from its root, over the ground (m).
    pub reach_m: f64,
    /// Longest time of a step of all characters of a scene (ms).
    pub step_ms: f64,
    /// Deepest overlap of two agents (m).
    pub agent_overlap_m: f64,
    /// Deepest overlap of the trunks of two people in a world (m).
    pub people_overlap_m: f64,
    /// Deepest that somebody was in a unit of a world (m).
    pub penetration_m: f64,
    /// 95th percentile of the speed of planted feet of a run (m/s).
    pub foot_slip_p95_mps: f64,
}

impl SoakReport {
    /// Counts a check.
    pub(crate) fn check(&mut self, is_right: bool, what: impl FnOnce() -> String) {
        self.checks += 1;
        if !is_right {
            self.failed += 1;
            if self.faults.len() < MAX_REPORTED {
                self.faults.push(what());
            }
        }
    }
}

/// What the runtime says, as precompute does.
fn fault(e: throng_core::Error) -> BuildError {
    BuildError::Config { message: e.to_string() }
}

/// Runs scenes in turns, each time with another seed.
///
/// # Errors
/// [`BuildError::Config`] for a config out of range, and for scenes that cannot be opened or stepped.
pub fn soak(scenes: &[Scene], config: &SoakConfig) -> Result<SoakReport, BuildError> {
    let in_range =
        config.seconds >= 0.0 && config.run_s > 0.0 && config.run_s <= 1e5 && (1.0..1e5).contains(&config.step_hz);
    if !in_range || scenes.is_empty() {
        let message = format!("expected scenes, times above 0 and at least 1 step a second, found {config:?}");
        return Err(BuildError::Config { message });
    }
    let begin = Instant::now();
    let mut rng = Pcg64Mcg::seed_from_u64(config.seed);
    let (pools, mut report) = (Pools::new()?, SoakReport::default());
    let mut round = 0;
    while round == 0 || begin.elapsed().as_secs_f64() < config.seconds {
        for scene in scenes {
            if round > 0 && begin.elapsed().as_secs_f64() >= config.seconds {
                break;
            }
            let mut scene = scene.clone();
            scene.seed = rng.random_range(0..1 << 32);
            turn(&scene, config, &pools, &mut rng, &mut report)?;
            remember(&mut report, round);
        }
        round += 1;
    }
    report.seconds = begin.elapsed().as_secs_f64();
    Ok(report)
}

/// Compares memory with what it was after the first rounds.
fn remember(report: &mut SoakReport, round: u64) {
    let Some(now) = resident_bytes() else { return };
    if round < WARM_UP_ROUNDS {
        return;
    }
    // The first round after the warm-up has the largest scene once more.
    if round == WARM_UP_ROUNDS {
        report.warm_bytes = Some(report.warm_bytes.unwrap_or(0).max(now));
        return;
    }
    let warm = report.warm_bytes.unwrap_or(now);
    report.most_bytes = Some(report.most_bytes.unwrap_or(0).max(now));
    let limit = warm + (GROWTH.0 * warm as f64) as u64 + GROWTH.1;
    let run = report.runs;
    report.check(now <= limit, || format!("run {run}: {now} bytes in use, {warm} after the first rounds"));
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_lab::run::built_in_scene;

    #[test]
    fn crowds_soak_without_a_fault_and_the_same_seed_runs_the_same() {
        let scenes: Vec<Scene> =
            ["circle", "flock"].iter().filter_map(|n| built_in_scene(n).unwrap()).map(|s| s.resized(30)).collect();
        let config = SoakConfig { seconds: 0.0, run_s: 3.0, ..SoakConfig::default() };
        let first = soak(&scenes, &config).unwrap();
        assert_eq!((first.runs, first.failed, &first.faults[..]), (2, 0, &[][..]));
        assert_eq!(first.character_steps, 2 * 30 * 90);
        assert!(first.checks > first.character_steps && first.worst.farthest_m > 1.0, "{first:?}");
        let again = soak(&scenes, &config).unwrap();
        assert_eq!((first.checks, first.worst.farthest_m), (again.checks, again.worst.farthest_m));
    }

    #[test]
    fn what_is_wrong_is_counted_and_told() {
        let mut report = SoakReport::default();
        report.check(true, || unreachable!("nothing to tell"));
        (0..30).for_each(|k| report.check(false, || format!("fault {k}")));
        assert_eq!((report.checks, report.failed, report.faults.len()), (31, 30, MAX_REPORTED));
        let scene = built_in_scene("circle").unwrap().unwrap().resized(10);
        for config in [
            SoakConfig { run_s: 0.0, ..SoakConfig::default() },
            SoakConfig { step_hz: f64::NAN, ..SoakConfig::default() },
        ] {
            assert!(soak(std::slice::from_ref(&scene), &config).is_err(), "{config:?}");
        }
    }

    #[test]
    fn memory_that_grows_is_a_fault() {
        let Some(now) = resident_bytes() else { return };
        let mut report = SoakReport { warm_bytes: Some(now), ..SoakReport::default() };
        remember(&mut report, WARM_UP_ROUNDS + 1);
        assert_eq!((report.checks, report.failed), (1, 0));
        let kept = vec![1u8; 3 * GROWTH.1 as usize + now as usize / 5];
        assert!(kept.iter().map(|&b| u64::from(b)).sum::<u64>() > GROWTH.1, "every page is touched");
        remember(&mut report, WARM_UP_ROUNDS + 1);
        assert_eq!((report.checks, report.failed), (2, 1));
    }
}
