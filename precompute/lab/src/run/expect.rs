//! Runs of a scene with several seeds, and whether they meet its expectations.

use super::report::{SceneRunConfig, config_error, run};
use rayon::prelude::*;
use serde::Serialize;
use throng_motion::error::Result;
use throng_simulation::Scene;
use throng_simulation::scenario::{ExpectationOutcome, WorstAgent};

/// Outcome of an expectation over several seeds.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ExpectationReport {
    /// Sentence of the expectation.
    pub name: String,
    /// Whether all seeds meet it.
    pub holds: bool,
    /// Figure of the median seed; null where it is infinite or nothing was measured.
    pub median: f64,
    /// Figure of the worst seed; null where it is infinite or nothing was measured.
    pub worst: f64,
    /// The worst seed.
    pub worst_seed: u64,
    /// Seeds that break it.
    pub broken_seeds: Vec<u64>,
    /// Least and greatest figure that were expected; null for no limit.
    pub bounds: [f64; 2],
    /// Agents with the worst values with the worst seed, at most three.
    pub agents: Vec<WorstAgent>,
}

/// Runs a scene with consecutive seeds from its own on, and evaluates its expectations.
///
/// # Errors
/// As [`run`]; [`BuildError::Config`](throng_motion::error::BuildError::Config) for a scene that expects nothing.
pub fn check_expectations(scene: &Scene, num_seeds: u64, config: &SceneRunConfig) -> Result<Vec<ExpectationReport>> {
    if scene.expect.is_empty() {
        return Err(config_error(format!("scene \"{}\" expects nothing: give it `[[expect]]`", scene.name)));
    }
    let outcomes = |k: u64| {
        let mut scene = scene.clone();
        scene.seed = scene.seed.wrapping_add(k);
        let compiled = scene.open().map_err(config_error)?;
        Ok((scene.seed, run(&compiled, config)?.0.expectations))
    };
    let all: Vec<(u64, Vec<ExpectationOutcome>)> =
        (0..num_seeds).into_par_iter().map(outcomes).collect::<Result<_>>()?;
    Ok((0..scene.expect.len()).map(|n| report(all.iter().map(|(seed, of)| (*seed, &of[n])))).collect())
}

fn report<'a>(all: impl Iterator<Item = (u64, &'a ExpectationOutcome)>) -> ExpectationReport {
    let mut all: Vec<_> = all.collect();
    // Nothing measured is worst of all.
    let excess = |one: &ExpectationOutcome| {
        let far = (one.bounds[0] - one.figure).max(one.figure - one.bounds[1]);
        if one.figure.is_nan() { f64::INFINITY } else { far }
    };
    all.sort_by(|a, b| excess(a.1).total_cmp(&excess(b.1)).then(b.0.cmp(&a.0)));
    let (worst_seed, worst) = all[all.len() - 1];
    let mut broken_seeds: Vec<u64> = all.iter().filter(|(_, one)| !one.holds).map(|(seed, _)| *seed).collect();
    broken_seeds.sort_unstable();
    ExpectationReport {
        name: worst.name.clone(),
        holds: broken_seeds.is_empty(),
        median: all[(all.len() - 1) / 2].1.figure,
        worst: worst.figure,
        worst_seed,
        broken_seeds,
        bounds: worst.bounds,
        agents: worst.worst.clone(),
    }
}
