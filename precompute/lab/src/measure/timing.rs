//! Timing: medians of rounds, and batches of policy queries.

use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use std::{f32::consts::TAU, hint::black_box, time::Instant};
use throng_base::maths::quantile;
use throng_core::Planar;
use throng_core::characters::{CharacterStart, MotionSet, PolicyOrder};
use throng_core::policy::{BestActionJob, LookAheadGoal, LookAheadJob, PolicyTable, RankedActions};
use throng_motion::error::{BuildError, Result};

/// An error of a measurement, with a message.
pub fn fail(message: impl Into<String>) -> BuildError {
    BuildError::Stage { stage: "bench", message: message.into(), help: "See `throng bench --help`".into() }
}

/// Runs `work` on a pool of its own.
///
/// # Errors
/// [`BuildError::Stage`] where the pool's threads cannot be had.
pub fn run_in_pool<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| fail(e.to_string()))?;
    Ok(pool.install(work))
}

/// Median time of a round, over as many rounds as fit into `seconds` (ns).
pub fn median_ns(seconds: f64, mut round: impl FnMut()) -> f64 {
    round();
    let begin = Instant::now();
    let mut times = Vec::new();
    while times.len() < 5 || begin.elapsed().as_secs_f64() < seconds {
        let t = Instant::now();
        round();
        times.push(t.elapsed().as_secs_f64() * 1e9);
    }
    quantile(times, [1, 2]).unwrap_or_default()
}

/// Random states of a policy, and targets around them at 0.2 to 6 m.
pub fn random_queries(policy: &PolicyTable, count: usize) -> (Vec<u32>, Vec<Vec3>) {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    let num_states = policy.actions().num_states() as u32;
    let states = (0..count).map(|_| rng.random_range(0..num_states)).collect();
    let target = |_| {
        let (angle, distance) = (rng.random_range(0.0..TAU), rng.random_range(0.2..6.0f32));
        Vec3::new(distance * angle.sin(), 0.0, distance * angle.cos())
    };
    (states, (0..count).map(target).collect())
}

/// Random starts of `n` characters in a square whose sides are `half_m` away (m).
pub(super) fn random_starts(motions: &MotionSet, n: usize, half_m: f32, rng: &mut Pcg64Mcg) -> Vec<CharacterStart> {
    let num_states = motions.graph().states.len() as u32;
    let start = |_| {
        let [x, z] = [(); 2].map(|()| rng.random_range(-half_m..half_m));
        let root = Planar::new(x, z, rng.random_range(0.0..TAU));
        CharacterStart { root, state: rng.random_range(0..num_states) }
    };
    (0..n).map(start).collect()
}

/// An order to go to a random target within 50 m along each axis.
pub(super) fn random_order(rng: &mut Pcg64Mcg) -> PolicyOrder {
    PolicyOrder::towards(0, Vec3::new(rng.random_range(-50.0..50.0), 0.0, rng.random_range(-50.0..50.0)))
}

/// Number of `n` characters that one task handles; all of them on one thread.
pub(super) fn share_of_task(n: usize) -> usize {
    n.div_ceil(rayon::current_num_threads()).max(1)
}

/// Queries of many characters at once, split over the threads of the current pool.
pub struct QueryBatch<'a> {
    /// Policy that is asked.
    pub policy: &'a PolicyTable,
    /// State of each character.
    pub states: &'a [u32],
    /// Target of each character in its own frame (m, states.len()).
    pub targets: &'a [Vec3],
    /// Time to spend on each figure (s).
    pub seconds: f64,
}

impl QueryBatch<'_> {
    /// Time of single-load queries of the batch (ns).
    ///
    /// # Errors
    /// [`BuildError::Stage`] where states or targets do not fit the policy.
    pub fn single_load_ns(&self) -> Result<f64> {
        let (policy, share) = (self.policy, share_of_task(self.states.len()));
        let mut actions = vec![0u8; self.states.len()];
        let job =
            BestActionJob { policy, states: self.states, targets: self.targets, choice: 0, actions: &mut actions };
        job.run().map_err(|e| fail(e.to_string()))?;
        let ns = median_ns(self.seconds, || {
            let parts = self.states.par_chunks(share).zip(self.targets.par_chunks(share));
            parts.zip(actions.par_chunks_mut(share)).for_each(|((states, targets), actions)| {
                black_box(BestActionJob { policy, states, targets, choice: 0, actions }.run().is_ok());
            });
        });
        black_box(&actions);
        Ok(ns)
    }

    /// Time of look-aheads of the batch (ns).
    ///
    /// # Errors
    /// [`BuildError::Stage`] where states or targets do not fit the policy.
    pub fn look_ahead_ns(&self) -> Result<f64> {
        let (policy, share) = (self.policy, share_of_task(self.states.len()));
        let weights = vec![1.0; self.states.len()];
        let mut ranked = vec![RankedActions::NONE; self.states.len()];
        let goals = [LookAheadGoal { policy, weights: &weights, targets: self.targets }];
        let job = LookAheadJob { goals: &goals, states: self.states, ranked: &mut ranked };
        job.run().map_err(|e| fail(e.to_string()))?;
        let ns = median_ns(self.seconds, || {
            let parts = self.states.par_chunks(share).zip(self.targets.par_chunks(share));
            let parts = parts.zip(weights.par_chunks(share)).zip(ranked.par_chunks_mut(share));
            parts.for_each(|(((states, targets), weights), ranked)| {
                let goals = [LookAheadGoal { policy, weights, targets }];
                black_box(LookAheadJob { goals: &goals, states, ranked }.run().is_ok());
            });
        });
        black_box(&ranked);
        Ok(ns)
    }

    /// Mean number of actions that a look-ahead weighs.
    pub fn actions_weighed(&self) -> f64 {
        let weighed: usize = self.states.iter().map(|&s| self.policy.actions().segments_of(s).len()).sum();
        weighed as f64 / self.states.len() as f64
    }
}
