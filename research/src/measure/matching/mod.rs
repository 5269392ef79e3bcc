//! What do policies gain over motion matching, in time to reach, hits and time a query?

mod movers;
mod trials;

use crate::matching::{BoxSearch, Database, FeatureWeights, KdTree, Nearest, Row, brute_force};
use serde::Serialize;
use std::hint::black_box;
use throng_core::Bundle;
use throng_core::base::limits::MEASURING_S;
use throng_lab::measure::timing::{QueryBatch, fail, median_ns, random_queries, run_in_pool};
use throng_lab::trial::TrialConfig;
use throng_motion::error::BuildError;
use trials::Scene;

/// What is measured, and how the baseline is set.
#[derive(Clone, Debug, PartialEq)]
pub struct MatchingConfig {
    /// Characters that go to a target, and a quarter as many that hit one.
    pub characters: usize,
    /// Time in which a target is to be reached (s).
    pub reach_s: f32,
    /// A target counts as reached within this distance (m).
    pub reach_m: f32,
    /// Nearest and farthest a target stands at the start (m).
    pub distances: [f32; 2],
    /// Time in which hits are counted (s).
    pub hits_s: f32,
    /// How fast the target of hits moves (m/s).
    pub target_mps: f32,
    /// Queries whose time is measured, at most.
    pub queries: usize,
    /// Characters that look up at once.
    pub batch: usize,
    /// Time given to each figure (s).
    pub seconds: f64,
    /// Seed of places and targets.
    pub seed: u64,
    /// What matching compares.
    pub weights: FeatureWeights,
    /// What the policy for hits counts beside the one that approaches, which never stops paying (>= 0).
    pub hit_weight: f32,
    /// Share of the database's frames that are slower than matching wants to go (0 to 1).
    pub speed_share: f32,
}

impl Default for MatchingConfig {
    /// Distances and reach as in [`TrialConfig`].
    fn default() -> Self {
        let trial = TrialConfig::default();
        Self {
            characters: 256,
            reach_s: trial.seconds,
            reach_m: trial.reach_m,
            distances: trial.distances,
            hits_s: 60.0,
            target_mps: 0.1,
            queries: 2000,
            batch: 10_000,
            seconds: 0.5,
            seed: 1,
            weights: FeatureWeights::default(),
            hit_weight: 2.0,
            speed_share: 0.95,
        }
    }
}

/// Policies against matching, on the same bundle with the same targets. Times are of one thread.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct MatchingFigures {
    /// Names of the policies: the one that approaches, then the one for hits.
    pub policies: Vec<String>,
    /// Frames that matching looks through.
    pub frames: usize,
    /// One search through boxes around 16 and 64 frames, for the queries of the trial.
    pub query_ns: f64,
    /// The same through a k-d tree.
    pub kd_tree_query_ns: f64,
    /// The same by looking at every frame.
    pub brute_force_query_ns: f64,
    /// One look-ahead in a batch.
    pub lookahead_ns: f64,
    /// One single-load look-up in a batch.
    pub single_load_ns: f64,
    /// How many look-aheads a search takes.
    pub query_over_lookahead: f64,
    /// How many single-load look-ups a search takes.
    pub query_over_single_load: f64,
    /// Share of the targets that the policy reaches.
    pub policy_reached_fraction: f64,
    /// Share of the targets that matching reaches.
    pub matching_reached_fraction: f64,
    /// Mean time in which the policy reaches a target, of those reached; none where none is.
    pub policy_time_to_reach_s: Option<f64>,
    /// The same of matching.
    pub matching_time_to_reach_s: Option<f64>,
    /// Hits of the policies that land on a slowly moving target; none where the bundle has no policy for hits.
    pub policy_hits_per_minute: Option<f64>,
    /// The same of matching.
    pub matching_hits_per_minute: Option<f64>,
    /// Share of the policies' hits that land.
    pub policy_landed_fraction: Option<f64>,
    /// The same of matching.
    pub matching_landed_fraction: Option<f64>,
    /// Mean distance of hips, feet and fists where the policies go over to another frame, which nothing blends here.
    /// (m)
    pub policy_gap_m: Option<f64>,
    /// The same of matching (m).
    pub matching_gap_m: Option<f64>,
}

/// Measures a bundle's policies against matching over its frames.
///
/// # Errors
/// [`BuildError::Stage`] where the bundle has no behaviour that approaches, or no frames that could be matched.
pub fn matching(tables: &Bundle, config: &MatchingConfig) -> Result<MatchingFigures, BuildError> {
    if config.characters == 0 || config.batch == 0 || config.queries == 0 {
        return Err(fail("numbers of characters and queries must be at least 1"));
    }
    MEASURING_S.check("seconds", None, config.seconds).map_err(|e| fail(e.to_string()))?;
    let database = Database::new(tables, &config.weights);
    if database.rows().is_empty() {
        return Err(fail("no run of usable frames is long enough to be matched: 21 frames at least"));
    }
    let boxes = BoxSearch::new(database.rows());
    let scene = Scene::new(tables, &database, &boxes, config)?;
    let (by_policy, by_matching, queries) = scene.reach();
    let sparring = scene.spar();
    let times = run_in_pool(1, || times(&scene, &queries, config))??;
    let [query_ns, kd_tree_query_ns, brute_force_query_ns, lookahead_ns, single_load_ns] = times;
    Ok(MatchingFigures {
        policies: scene.names.clone(),
        frames: database.rows().len(),
        query_ns,
        kd_tree_query_ns,
        brute_force_query_ns,
        lookahead_ns,
        single_load_ns,
        query_over_lookahead: query_ns / lookahead_ns,
        query_over_single_load: query_ns / single_load_ns,
        policy_reached_fraction: by_policy.reached_fraction(),
        matching_reached_fraction: by_matching.reached_fraction(),
        policy_time_to_reach_s: by_policy.mean_s(),
        matching_time_to_reach_s: by_matching.mean_s(),
        policy_hits_per_minute: sparring.map(|s| s[0].landed_per_minute()),
        matching_hits_per_minute: sparring.map(|s| s[1].landed_per_minute()),
        policy_landed_fraction: sparring.and_then(|s| s[0].landed_fraction()),
        matching_landed_fraction: sparring.and_then(|s| s[1].landed_fraction()),
        policy_gap_m: sparring.and_then(|s| s[0].gap_m()),
        matching_gap_m: sparring.and_then(|s| s[1].gap_m()),
    })
}

/// Nanoseconds of a search through boxes, through a tree, through everything; of a look-ahead and a single load.
fn times(scene: &Scene<'_>, queries: &[(Row, Nearest)], config: &MatchingConfig) -> Result<[f64; 5], BuildError> {
    let rows = scene.database.rows();
    let tree = KdTree::new(rows);
    let step = queries.len().div_ceil(config.queries).max(1);
    let asked: Vec<(Row, Nearest)> = queries.iter().copied().step_by(step).collect();
    let of = |find: &dyn Fn(&Row, Nearest) -> Nearest, asked: &[(Row, Nearest)]| {
        let round = || {
            for (query, from) in asked {
                black_box(find(black_box(query), *from));
            }
        };
        median_ns(config.seconds, round) / asked.len() as f64
    };
    let by_boxes = of(&|q, from| scene.boxes.find(q, from), &asked);
    let by_tree = of(&|q, from| tree.find(q, from), &asked);
    // Every frame of a large database takes long: a few queries tell as much.
    let few = asked.len().min(50);
    let by_all = of(&|q, from| brute_force(rows, q, from), &asked[..few]);
    let policy = scene.policy();
    let (states, targets) = random_queries(policy, config.batch);
    let batch = QueryBatch { policy, states: &states, targets: &targets, seconds: config.seconds };
    let n = config.batch as f64;
    Ok([by_boxes, by_tree, by_all, batch.look_ahead_ns()? / n, batch.single_load_ns()? / n])
}
