//! Loss of an adaptive policy, compared with uniform grids of equal size.

use super::super::behaviour::{BehaviourSpec, PolicyBehaviour};
use super::super::model::{ActionModel, SegmentMotion};
use super::super::solve::{PolicySolver, Solution};
use super::{super::compare::random_target, bytes_per_cell, fit::GridShapes, solution_bytes, with_shapes};
use glam::Vec3;
use rand::RngExt;
use rand_pcg::Pcg64;
use throng_base::SingleRank;
use throng_core::policy::{MAX_ACTIONS, PolicyTable, SegmentRecord, TargetGrid};
use throng_motion::{Result, Silent};

/// Three ways to store a policy in equal memory, each compared with the policy on the finest grid everywhere.
///
/// Errors and losses are over random states and targets within the grid, angles, distances and heights uniform.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct AdaptiveReport {
    /// Bytes of values and best actions with the finest grid everywhere.
    pub finest_bytes: usize,
    /// Number of (state, target) queries.
    pub samples: u32,
    /// Mean size of a value on the finest grid, as a scale for errors.
    pub mean_value: f64,
    /// One grid per state, with values fitted to the finest: the stored policy.
    pub adaptive: Approximation,
    /// One grid for all states, at least as large, solved separately.
    pub uniform: Approximation,
    /// One grid for all states, with values fitted to the finest.
    pub uniform_fitted: Approximation,
}

/// A policy stored in less memory.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Approximation {
    /// Bytes of values, best actions and state grids.
    pub bytes: usize,
    /// Mean rings, angles and heights of a state.
    pub counts: [f64; 3],
    /// Mean distance from the values on the finest grid.
    pub mean_error: f64,
    /// 95th percentile of that distance.
    pub p95_error: f64,
    /// Largest such distance.
    pub max_error: f64,
    /// Share of queries with another best action than on the finest grid.
    pub changed_share: f64,
    /// Loss by those actions in the look-ahead on the finest grid, as a share of the best scores' sum.
    pub mean_loss: f64,
}

impl AdaptiveReport {
    /// - `finest`: solved and baked.
    /// - `adapted`: the adaptive policy.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Stage`] if the uniform grid's values do not converge.
    pub(in crate::policy) fn new(
        solver: &PolicySolver<'_>,
        behaviour: &dyn PolicyBehaviour,
        finest: &Solution,
        adapted: &Solution,
        rng: &mut Pcg64,
    ) -> Result<Self> {
        let (grid, model, cfg) = (behaviour.spec().grid, solver.model, solver.cfg);
        let num_states = model.num_states().max(1);
        let counts = uniform_counts(&grid, solution_bytes(adapted).div_ceil(bytes_per_cell(adapted) * num_states));
        let uniform = RegriddedBehaviour { behaviour, grid: grid.with_counts(counts) };
        let alone = PolicySolver { progress: &Silent, comm: &SingleRank, ..*solver };
        let mut uniform = alone.value_iteration(&uniform)?;
        uniform.record.num_choices = finest.record.num_choices;
        let fitted = with_shapes(finest, &GridShapes::single(&grid, counts), &vec![0; num_states]);
        let queries = RandomQueries::new(model, finest, cfg.compare_samples, rng)?;
        Ok(Self {
            finest_bytes: solution_bytes(finest),
            samples: cfg.compare_samples,
            mean_value: queries.values.iter().map(|v| f64::from(v.abs())).sum::<f64>()
                / queries.values.len().max(1) as f64,
            adaptive: queries.approximation(model, adapted)?,
            uniform: queries.approximation(model, &uniform)?,
            // One record would do for all states, so records are not counted.
            uniform_fitted: Approximation { bytes: solution_bytes(&uniform), ..queries.approximation(model, &fitted)? },
        })
    }
}

/// Counts in about the proportions of a grid, nearest to a number of cells and not below it.
fn uniform_counts(grid: &TargetGrid, num_cells: usize) -> [u32; 3] {
    let finest = grid.counts();
    let axes = finest.iter().filter(|&&n| n > 1).count().max(1) as f64;
    let even = (num_cells as f64 / grid.num_cells() as f64).powf(1.0 / axes);
    let mut best = (f64::INFINITY, finest);
    for rings in 2..=finest[0] {
        for angles in 2..=finest[1] {
            let heights = (num_cells as u64).div_ceil(u64::from(rings * angles)).max(1) as u32;
            if heights > finest[2] {
                continue;
            }
            let counts = [rings, angles, heights];
            let cells: f64 = counts.iter().map(|&n| f64::from(n)).product();
            let skew =
                |k: usize| if finest[k] > 1 { (f64::from(counts[k]) / f64::from(finest[k]) / even).ln() } else { 0.0 };
            let excess = 5.0 * (cells / num_cells as f64).ln();
            let cost = (0..3).map(|k| skew(k).powi(2)).sum::<f64>() + excess * excess;
            if cost < best.0 {
                best = (cost, counts);
            }
        }
    }
    best.1
}

/// Random queries, with the scores of the policy on the finest grid.
struct RandomQueries {
    at: Vec<(u32, Vec3)>,
    values: Vec<f32>,
    /// Scores of all actions of all queries, one after the other.
    scores: Vec<f32>,
}

impl RandomQueries {
    fn new(model: &ActionModel, finest: &Solution, samples: u32, rng: &mut Pcg64) -> Result<Self> {
        let best = first_actions(finest);
        let table = finest.table(model, &best)?;
        let num_states = model.num_states() as u32;
        let query = |_| (rng.random_range(0..num_states), random_target(&table, rng));
        let at: Vec<(u32, Vec3)> = (0..samples).map(query).collect();
        let values = at.iter().map(|&(state, target)| table.value(state, target)).collect();
        let mut scores = Vec::new();
        let mut buffer = [0.0; MAX_ACTIONS];
        at.iter().for_each(|&query| scores.extend_from_slice(score(&table, query, &mut buffer)));
        Ok(Self { at, values, scores })
    }

    /// Compares a policy with less memory with that on the finest grid.
    fn approximation(&self, model: &ActionModel, solution: &Solution) -> Result<Approximation> {
        let first = first_actions(solution);
        let table = solution.table(model, &first)?;
        let (mut changed, mut lost, mut sum) = (0u32, 0.0, 0.0);
        let mut buffer = [0.0; MAX_ACTIONS];
        let mut finest = &*self.scores;
        for &query in &self.at {
            let scores = score(&table, query, &mut buffer);
            let (own, rest) = finest.split_at(scores.len());
            finest = rest;
            let most = own.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            let first_best = (0..scores.len()).fold(0, |best, a| if scores[a] > scores[best] { a } else { best });
            let loss = f64::from(most - own[first_best]);
            changed += u32::from(loss > 0.0);
            (lost, sum) = (lost + loss, sum + f64::from(most.abs()));
        }
        let error = |(&(state, target), v): (&(u32, Vec3), &f32)| f64::from((table.value(state, target) - v).abs());
        let mut errors: Vec<f64> = self.at.iter().zip(&self.values).map(error).collect();
        errors.sort_by(f64::total_cmp);
        let n = errors.len().max(1);
        let states = 0..model.num_states() as u32;
        let counts = states.map(|s| table.grid_of(s).counts().map(f64::from));
        let total = counts.fold([0.0; 3], |sum: [f64; 3], c| [0, 1, 2].map(|k| sum[k] + c[k]));
        Ok(Approximation {
            bytes: solution_bytes(solution),
            counts: total.map(|sum| sum / model.num_states().max(1) as f64),
            mean_error: errors.iter().sum::<f64>() / n as f64,
            p95_error: errors.get(n * 95 / 100).copied().unwrap_or(0.0),
            max_error: errors.last().copied().unwrap_or(0.0),
            changed_share: f64::from(changed) / n as f64,
            mean_loss: lost / f64::max(sum, 1e-12),
        })
    }
}

/// The first action everywhere, as best actions are not used here.
fn first_actions(solution: &Solution) -> Vec<u8> {
    vec![0; solution.values.len() * solution.record.num_choices as usize]
}

fn score<'a>(table: &PolicyTable, (state, target): (u32, Vec3), buffer: &'a mut [f32; MAX_ACTIONS]) -> &'a [f32] {
    let n = table.action_scores(state, target, buffer).expect("the state exists and the target is finite");
    &buffer[..n]
}

/// A behaviour moved to another grid over the same region.
pub(super) struct RegriddedBehaviour<'a> {
    pub behaviour: &'a dyn PolicyBehaviour,
    pub grid: TargetGrid,
}

impl PolicyBehaviour for RegriddedBehaviour<'_> {
    fn spec(&self) -> BehaviourSpec<'_> {
        BehaviourSpec { grid: self.grid, ..self.behaviour.spec() }
    }

    fn sample(&self, segment: usize, motion: &SegmentMotion, record: &mut SegmentRecord) {
        self.behaviour.sample(segment, motion, record);
    }
}
