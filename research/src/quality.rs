//! Quality of a policy relative to the best that search finds.

use crate::search::{BestSequence, PolicySearch, ValueBounds};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde::Serialize;
use std::time::Instant;
use throng_bake::policy::{PolicySituation, collect_rewards, play, random_target};
use throng_core::Bundle;
use throng_core::base::limits::Limit;
use throng_core::policy::{BestActionJob, PolicyTable, RankedActions};
use throng_lab::measure::timing::fail;
use throng_motion::error::BuildError;

/// Numbers of pairs that may be asked for.
pub static PAIRS: Limit = Limit { quantity: "number of pairs", least: 1.0, most: 10_000_000.0, range: "1 to 10000000" };

/// Settings of the measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct QualityConfig {
    /// Number of random (state, target) pairs: states uniform, targets uniform over the grid's angles, distances and
    /// heights.
    pub pairs: usize,
    /// Length of the action sequences in the search (1 to 8).
    pub depth: usize,
    /// Best score up to which a pair is left out, as too small for a ratio.
    pub least_best: f64,
    /// Discount below which further rewards are ignored (> 0, < 1).
    pub negligible: f64,
    /// Temperatures of the choice among the best few actions.
    pub temperatures: Vec<f32>,
    /// Seed of pairs and choices.
    pub seed: u64,
}

impl Default for QualityConfig {
    fn default() -> Self {
        let temperatures = vec![0.0, 0.02, 0.05, 0.1, 0.2, 0.5];
        Self { pairs: 1000, depth: 4, least_best: 1e-3, negligible: 1e-4, temperatures, seed: 1 }
    }
}

/// Ratio of the discounted reward that a policy collects to the best that search finds.
///
/// Collected: by following the policy in the exact model, with targets at their true places. Best: the most of all
/// sequences of a few actions, with exact rewards and the stored value of their end. That value is interpolated between
/// cells and may be a little more or less than can be had, so ratios above 1 are possible. The *realised* best carries
/// out the search's actions and then follows the policy; the ratio to it is at most 1. Without a pair that counts,
/// ratios are not numbers, null in JSON.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Quality {
    /// Name of the behaviour.
    pub policy: String,
    /// Number of pairs.
    pub asked: usize,
    /// Number of pairs that count: their best is not negligible.
    pub pairs: usize,
    /// Mean ratio of the collected reward.
    pub ratio_mean: f64,
    /// 5th percentile of that ratio.
    pub ratio_p05: f64,
    /// Share of the pairs with a ratio above 0.99.
    pub near_best_fraction: f64,
    /// Mean ratio to the realised best.
    pub realised_ratio_mean: f64,
    /// Mean difference of the best and the collected reward, over all pairs.
    pub regret_mean: f64,
    /// Mean ratio for following the stored best action of the nearest cell.
    pub single_load_ratio_mean: f64,
    /// Ratios for random choices among the best few actions.
    pub temperatures: Vec<TemperatureQuality>,
    /// Number of look-aheads of the search.
    pub look_aheads: u64,
    /// Wall time of the search (s).
    pub search_s: f64,
    /// Total wall time (s).
    pub seconds: f64,
}

/// Ratio for random choices at one temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct TemperatureQuality {
    /// See [`throng_core::policy::RankedActions::choose`].
    pub temperature: f32,
    /// Mean ratio of the collected reward.
    pub ratio_mean: f64,
}

/// Number of bands of heights, each with its own bounds: a target out of reach high up may be near further down.
const BANDS: usize = 4;

/// Measures what the policies of a bundle collect against what search finds, on the current rayon pool.
///
/// # Errors
/// [`BuildError::Stage`] where the bundle has no behaviour or a number is out of range.
pub fn quality(tables: &Bundle, config: &QualityConfig) -> Result<Vec<Quality>, BuildError> {
    if tables.policies().is_empty() {
        return Err(fail("the bundle has no behaviour"));
    }
    PAIRS.check_count("pairs", config.pairs).map_err(|e| fail(e.to_string()))?;
    let names = &tables.meta().behaviours;
    Ok(names.iter().enumerate().map(|(i, name)| measure_policy(&tables.policies()[i], name, config)).collect())
}

/// Measures a policy on the current rayon pool. The same config gives the same figures at any number of threads.
pub fn measure_policy(table: &PolicyTable, name: &str, config: &QualityConfig) -> Quality {
    let begin = Instant::now();
    let mut rng = Pcg64::seed_from_u64(config.seed);
    let pairs = random_pairs(table, config.pairs, &mut rng);
    let found = search_all(table, &pairs, config.depth);
    let search_s = begin.elapsed().as_secs_f64();
    let mut follow = |temperature: f32| {
        let pick = |_, ranked: &RankedActions| ranked.choose(temperature, rng.random());
        collect_rewards(table, &pairs, config.negligible, pick)
    };
    let collected = follow(0.0);
    let single_load = collect_rewards(table, &pairs, config.negligible, |at, _| load_best_action(table, at));
    let random: Vec<Vec<f64>> = config
        .temperatures
        .iter()
        .map(|&temperature| if temperature > 0.0 { follow(temperature) } else { collected.clone() })
        .collect();
    let realised = realise(table, &pairs, &found, config);
    let counted: Vec<usize> = (0..pairs.len()).filter(|&i| f64::from(found[i].score) > config.least_best).collect();
    let ratios = |sums: &[f64]| counted.iter().map(|&i| sums[i] / f64::from(found[i].score)).collect::<Vec<f64>>();
    let mut ascending = ratios(&collected);
    let ratio_mean = mean(&ascending);
    ascending.sort_by(f64::total_cmp);
    let near_best = ascending.iter().filter(|&&r| r > 0.99).count();
    let to_realised: Vec<f64> =
        counted.iter().map(|&i| collected[i] / realised[i].max(collected[i]).max(1e-9)).collect();
    let regrets: Vec<f64> = found.iter().zip(&collected).map(|(f, c)| f64::from(f.score) - c).collect();
    Quality {
        policy: name.to_owned(),
        asked: pairs.len(),
        pairs: counted.len(),
        ratio_mean,
        ratio_p05: ascending.get(ascending.len() / 20).copied().unwrap_or(f64::NAN),
        near_best_fraction: near_best as f64 / counted.len() as f64,
        realised_ratio_mean: mean(&to_realised),
        regret_mean: mean(&regrets),
        single_load_ratio_mean: mean(&ratios(&single_load)),
        temperatures: config
            .temperatures
            .iter()
            .zip(&random)
            .map(|(&temperature, sums)| TemperatureQuality { temperature, ratio_mean: mean(&ratios(sums)) })
            .collect(),
        look_aheads: found.iter().map(|f| f.look_aheads).sum(),
        search_s,
        seconds: begin.elapsed().as_secs_f64(),
    }
}

/// Mean; NaN for an empty slice.
fn mean(v: &[f64]) -> f64 {
    v.iter().sum::<f64>() / v.len() as f64
}

fn random_pairs(table: &PolicyTable, count: usize, rng: &mut Pcg64) -> Vec<PolicySituation> {
    let num_states = table.actions().num_states() as u32;
    (0..count)
        .map(|_| PolicySituation { state: rng.random_range(0..num_states), target: random_target(table, rng) })
        .collect()
}

/// Number of look-aheads of a whole search above which bounds, which take some seconds, pay off.
const WORTH_BOUNDS: f64 = 3e7;

/// Best sequence of every pair.
fn search_all(table: &PolicyTable, pairs: &[PolicySituation], depth: usize) -> Vec<BestSequence> {
    let actions = table.actions();
    let branching = actions.num_actions() as f64 / actions.num_states() as f64;
    let look_aheads = pairs.len() as f64 * branching.powi(depth as i32 - 1);
    // Bounds know actions as captured.
    let bends = table.grid().is_polar() && table.segments().iter().any(|s| s.heights[0] > 0.0);
    // Events of a space-time grid happen after an action or two.
    if look_aheads < WORTH_BOUNDS || table.grid().is_space_time() || bends {
        let search = PolicySearch::new(table, depth, None);
        return pairs.par_iter().map(|&pair| search.best(pair)).collect();
    }
    search_with_bounds(table, pairs, depth)
}

/// Best sequence of every pair, found with bounds of every band of heights.
fn search_with_bounds(table: &PolicyTable, pairs: &[PolicySituation], depth: usize) -> Vec<BestSequence> {
    let r = table.grid().record();
    let bands = if r.num_heights > 1 { BANDS } else { 1 };
    let height = r.height_spacing * (r.num_heights - 1) as f32 / bands as f32;
    let edge = |band: usize| r.height_start + band as f32 * height;
    let band_of = |s: &PolicySituation| (((s.target.y - r.height_start) / height.max(1e-6)) as usize).min(bands - 1);
    let mut found: Vec<Option<BestSequence>> = vec![None; pairs.len()];
    for band in 0..bands {
        // A margin around the band, so that rounding loses no situation.
        let bounds = ValueBounds::new(table, depth, [edge(band) - 1e-3, edge(band + 1) + 1e-3]);
        let search = PolicySearch::new(table, depth, Some(&bounds));
        let of_band = found.par_iter_mut().zip(pairs).filter(|(_, s)| bands == 1 || band_of(s) == band);
        of_band.for_each(|(found, &pair)| *found = Some(search.best(pair)));
    }
    found.into_iter().flatten().collect()
}

/// The stored best action of the nearest cell.
fn load_best_action(table: &PolicyTable, at: PolicySituation) -> u8 {
    let mut actions = [0];
    let job =
        BestActionJob { policy: table, states: &[at.state], targets: &[at.target], choice: 0, actions: &mut actions };
    job.run().unwrap_or_else(|e| unreachable!("states come from the table, targets are near: {e}"));
    actions[0]
}

/// Reward for carrying out the search's actions and then following the policy.
fn realise(table: &PolicyTable, pairs: &[PolicySituation], found: &[BestSequence], config: &QualityConfig) -> Vec<f64> {
    let mut sums = vec![0.0; pairs.len()];
    let mut discounts = vec![1.0f64; pairs.len()];
    let mut at = pairs.to_vec();
    for (i, f) in found.iter().enumerate() {
        for &action in &f.actions[..config.depth] {
            let played = play(table, at[i], action);
            sums[i] += discounts[i] * f64::from(played.reward);
            discounts[i] *= f64::from(played.discount);
            at[i] = played.then;
        }
    }
    let rest = collect_rewards(table, &at, config.negligible, |_, ranked| ranked.choose(0.0, 0.0));
    (0..pairs.len()).map(|i| sums[i] + discounts[i] * rest[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_bake::policy::made_up::SyntheticProblem;
    use throng_bake::policy::{Approach, PolicyConfig, PolicySolver};
    use throng_core::base::SingleRank;
    use throng_motion::progress::Silent;

    /// The policy of a behaviour in a made-up problem.
    fn solved(small: &SyntheticProblem, behaviour: &Approach) -> PolicyTable {
        let cfg = PolicyConfig { compare_samples: 1, ..PolicyConfig::default() };
        let mut rng = Pcg64::seed_from_u64(1);
        let tables = PolicySolver { model: &small.model(), cfg: &cfg, progress: &Silent, comm: &SingleRank }
            .solve_all(&[behaviour], &mut rng);
        tables.expect("it converges").table(0).expect("sound tables")
    }

    #[test]
    fn bounds_change_nothing_but_the_time() {
        let small = SyntheticProblem { states: 6, actions: 5, rings: 12, angles: 9, seed: 4 };
        let table = solved(&small, &small.behaviour().expect("a valid grid"));
        let pairs = random_pairs(&table, 40, &mut Pcg64::seed_from_u64(1));
        let (plain, bounded) = (search_all(&table, &pairs, 4), search_with_bounds(&table, &pairs, 4));
        for (a, b) in plain.iter().zip(&bounded) {
            assert_eq!(a.score, b.score);
        }
        let count = |all: &[BestSequence]| all.iter().map(|f| f.look_aheads).sum::<u64>();
        assert!(count(&bounded) < count(&plain), "{} {}", count(&bounded), count(&plain));
    }

    #[test]
    fn ratios_of_nothing_are_no_numbers() {
        let small = SyntheticProblem { states: 3, actions: 2, rings: 12, angles: 9, seed: 4 };
        let table = solved(&small, &small.behaviour().expect("a valid grid"));
        let config = QualityConfig { pairs: 5, least_best: 10.0, ..QualityConfig::default() };
        let q = measure_policy(&table, "approach", &config);
        assert_eq!((q.asked, q.pairs), (5, 0));
        assert!(q.ratio_mean.is_nan() && q.near_best_fraction.is_nan() && q.regret_mean.is_finite());
        assert_eq!(serde_json::to_value(&q).expect("it serialises")["ratio_mean"], serde_json::Value::Null);
    }
}
