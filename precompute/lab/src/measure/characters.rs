//! Cost of a query, a joint and a character, beside copying the same bytes.

use super::BundleMeasureConfig;
use super::timing::{
    QueryBatch, fail, median_ns, random_order, random_queries, random_starts, run_in_pool, share_of_task,
};
use crate::trial::{self, TrialConfig};
use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::Serialize;
use std::hint::black_box;
use throng_core::base::limits::THREADS;
use throng_core::characters::{
    ActionChoice, AvoidConfig, Characters, CharactersConfig, MotionSet, PolicyOrder, SampleJob,
};
use throng_core::{Bundle, CharacterGroup, Error, Executor, Inline, Mat3x4, NUM_JOINTS, Rayon};
use throng_motion::error::Result;

/// Medians over many rounds; nanoseconds of wall time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct CharactersFigures {
    /// Number of characters.
    pub characters: usize,
    /// Number of threads.
    pub threads: usize,
    /// Single-load query of a random state and target, in a batch.
    pub control_ns_per_query: f64,
    /// Look-ahead over the actions of a random state of this bundle, in a batch.
    pub lookahead_ns_per_query: f64,
    /// Actions such a look-ahead weighs, mean.
    pub lookahead_actions: f64,
    /// Sampling between two rows at a random place, and model matrices.
    pub sample_ns_per_joint: f64,
    /// A full step at 60 Hz: control, sampling, transition, foot lock, model matrices of 22 joints.
    pub step_ns_per_character: f64,
    /// A full step at 60 Hz with single-load control.
    pub step_single_load_ns_per_character: f64,
    /// A full step of people who walk among and avoid each other.
    pub step_avoiding_ns_per_character: f64,
    /// Time of that step over that of the same people without avoidance.
    pub avoiding_ratio: f64,
    /// Copying as many bytes as the model matrices take.
    pub memcpy_ns_per_character: f64,
    /// Steps a second of all characters.
    pub steps_per_second: f64,
}

/// Measures queries, sampling and steps.
///
/// # Errors
/// [`throng_motion::error::BuildError::Stage`] where the bundle has no behaviour, a number is out of range, or a
/// thread pool cannot be had.
pub fn characters(tables: &Bundle, config: &BundleMeasureConfig) -> Result<Vec<CharactersFigures>> {
    config.check(tables)?;
    config.threads.iter().try_for_each(|&n| THREADS.check_count("threads", n)).map_err(|e| fail(e.to_string()))?;
    let motion_set = MotionSet::new(tables);
    let mut results = Vec::new();
    let (motion_set, seconds) = (&motion_set, config.seconds);
    for &threads in &config.threads {
        for &characters in &config.characters {
            let bench = CharacterBench { tables, motion_set, characters, seconds };
            results.push(run_in_pool(threads, || bench.run(threads))??);
        }
    }
    Ok(results)
}

/// Benchmark of one number of characters, inside a thread pool.
struct CharacterBench<'a> {
    tables: &'a Bundle,
    motion_set: &'a MotionSet,
    characters: usize,
    seconds: f64,
}

impl CharacterBench<'_> {
    fn run(&self, threads: usize) -> Result<CharactersFigures> {
        let n = self.characters as f64;
        let Some(policy) = self.motion_set.policy(0) else { return Err(fail("the bundle has no behaviour")) };
        let (states, targets) = random_queries(policy, self.characters);
        let queries = QueryBatch { policy, states: &states, targets: &targets, seconds: self.seconds };
        let single = CharactersConfig { choice: ActionChoice::BestAction, ..CharactersConfig::default() };
        let step = self.measure_step(CharactersConfig::default())?;
        let avoiding = self.measure_avoiding_step(Some(AvoidConfig::default()))?;
        Ok(CharactersFigures {
            step_avoiding_ns_per_character: avoiding / n,
            avoiding_ratio: avoiding / self.measure_avoiding_step(None)?,
            characters: self.characters,
            threads,
            control_ns_per_query: queries.single_load_ns()? / n,
            lookahead_ns_per_query: queries.look_ahead_ns()? / n,
            lookahead_actions: queries.actions_weighed(),
            sample_ns_per_joint: self.measure_sampling()? / (n * NUM_JOINTS as f64),
            step_ns_per_character: step / n,
            step_single_load_ns_per_character: self.measure_step(single)? / n,
            memcpy_ns_per_character: self.measure_copy() / n,
            steps_per_second: 1e9 / step,
        })
    }

    /// Time of sampling all characters at random places.
    fn measure_sampling(&self) -> Result<f64> {
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        let (n, share) = (self.characters, share_of_task(self.characters));
        let segments = &self.motion_set.graph().segments;
        let place = |_| {
            let s = &segments[rng.random_range(0..segments.len())];
            (s.start + rng.random_range(0..s.num_frames), rng.random_range(0.0..1.0f32))
        };
        let (frames, ratios): (Vec<u32>, Vec<f32>) = (0..n).map(place).unzip();
        let motion_set = self.motion_set;
        let mut matrices = vec![Mat3x4::default(); n * NUM_JOINTS];
        let ns = median_ns(self.seconds, || {
            let parts = frames.par_chunks(share).zip(ratios.par_chunks(share));
            parts.zip(matrices.par_chunks_mut(share * NUM_JOINTS)).for_each(|((frames, ratios), matrices)| {
                black_box(SampleJob { motion_set, frames, ratios, matrices }.run().is_ok());
            });
        });
        black_box(&matrices);
        Ok(ns)
    }

    /// Time of a full step, averaged over a second of simulated time a round.
    fn measure_step(&self, config: CharactersConfig) -> Result<f64> {
        const STEPS: usize = 60;
        let mut rng = Pcg64Mcg::seed_from_u64(4);
        let starts = random_starts(self.motion_set, self.characters, 50.0, &mut rng);
        let mut characters = Characters::new(self.motion_set, config, &starts).map_err(|e| fail(e.to_string()))?;
        let mut orders = vec![PolicyOrder::IDLE; self.characters];
        let run: &dyn Executor = if rayon::current_num_threads() == 1 { &Inline } else { &Rayon };
        let mut failed = None;
        let ns = median_ns(self.seconds.max(0.5), || {
            // Targets move every second, so that no character comes to rest.
            orders.fill_with(|| random_order(&mut rng));
            for _ in 0..STEPS {
                let done = characters.step_on(self.motion_set, 1.0 / STEPS as f32, &orders, run);
                failed = failed.take().or(done.err());
            }
        });
        black_box(characters.model_matrices());
        failed.map_or(Ok(ns / STEPS as f64), |e| Err(fail(e.to_string())))
    }

    /// Time of a full step of people two metres apart who walk to places up to six metres away, and on to the next ones.
    fn measure_avoiding_step(&self, avoid: Option<AvoidConfig>) -> Result<f64> {
        const STEPS: usize = 60;
        let wrong = |e: Error| fail(e.to_string());
        let motion = CharactersConfig { avoid, ..CharactersConfig::default() };
        let config = TrialConfig { characters: self.characters, motion, ..TrialConfig::default() };
        let (mut group, targets) = trial::scatter_characters(self.tables, &config).map_err(wrong)?;
        let mut rng = Pcg64Mcg::seed_from_u64(5);
        let mut failed = None;
        let run: &dyn Executor = if rayon::current_num_threads() == 1 { &Inline } else { &Rayon };
        let ids = group.ids().to_vec();
        let ns = median_ns(self.seconds.max(0.5), || {
            for (&id, home) in ids.iter().zip(&targets) {
                let by = Vec3::new(rng.random_range(-6.0..6.0), 0.0, rng.random_range(-6.0..6.0));
                failed = failed.take().or(group.order(id, PolicyOrder::towards(0, *home + by)).err());
            }
            for _ in 0..STEPS {
                failed = failed.take().or(group.step(1.0 / STEPS as f32, run).err());
            }
        });
        failed.map_or(Ok(ns / STEPS as f64), |e| Err(wrong(e)))
    }

    /// Time to copy all model matrices.
    fn measure_copy(&self) -> f64 {
        let (n, share) = (self.characters * NUM_JOINTS, share_of_task(self.characters) * NUM_JOINTS);
        let from = vec![Mat3x4 { rows: [[1.0; 4]; 3] }; n];
        let mut to = vec![Mat3x4::default(); n];
        let ns = median_ns(self.seconds, || {
            let parts = black_box(&from).par_chunks(share).zip(to.par_chunks_mut(share));
            parts.for_each(|(from, to)| to.copy_from_slice(from));
        });
        black_box(&to);
        ns
    }
}
