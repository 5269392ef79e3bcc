//! A resolution for every state: memory is kept to, cells go where they lower the error, and queries answer alike.

use super::naive::{Hit, random_model};
use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use throng_core::Joint;
use throng_core::base::SingleRank;
use throng_core::policy::{
    BestActionJob, LookAheadGoal, LookAheadJob, MAX_ACTIONS, PolicyTable, RankedActions, SegmentRecord, TargetGrid,
};
use throng_precompute::policy::made_up::SyntheticProblem;
use throng_precompute::policy::{
    ActionModel, AdaptiveConfig, Approach, BehaviourKind, BehaviourSpec, GridConfig, PolicyBehaviour,
    PolicyBehaviourConfig, PolicyConfig, PolicySolver, PolicyTables, SegmentHit, SegmentMotion, Solution, ThrowPunches,
    adapt, bake,
};
use throng_precompute::progress::Silent;

/// Another behaviour's rewards on a grid that may be adaptive.
struct Compact<'a> {
    behaviour: &'a dyn PolicyBehaviour,
    grid: TargetGrid,
    adaptive: Option<AdaptiveConfig>,
}

impl PolicyBehaviour for Compact<'_> {
    fn spec(&self) -> BehaviourSpec<'_> {
        BehaviourSpec { grid: self.grid, adaptive: self.adaptive, ..self.behaviour.spec() }
    }

    fn sample(&self, segment: usize, motion: &SegmentMotion, record: &mut SegmentRecord) {
        self.behaviour.sample(segment, motion, record);
    }
}

const STATES: u32 = 6;

/// Blows at random places, and a grid that is fine enough to be thinned out.
fn blows(rng: &mut Pcg64) -> (ActionModel, Hit, TargetGrid) {
    let model = random_model(rng, STATES);
    let grid = TargetGrid::cylinder([12, 11, 6], Vec3::new(-1.0, 0.4, 1.2), Vec3::new(1.0, 1.3, 1.6), 0.2)
        .expect("a valid grid");
    let places = (0..model.segments.len()).map(|s| {
        let place = grid.cell_centre(rng.random_range(0..grid.num_cells()));
        (s, rng.random_range(0..model.segments[s].num_frames), place, rng.random_range(0.3..1.0))
    });
    let hit = Hit { discount: 0.97, blows: places.collect(), radius: 0.25, transition_cost: 4.0 };
    (model, hit, grid)
}

/// The policy on the finest grid everywhere.
fn finest(model: &ActionModel, behaviour: &dyn PolicyBehaviour) -> Solution {
    let cfg = PolicyConfig::default();
    let mut solution = PolicySolver { model, cfg: &cfg, progress: &Silent, comm: &SingleRank }
        .value_iteration(behaviour)
        .expect("it converges");
    bake(model, &mut solution, &cfg, &SingleRank).expect("it converges");
    solution
}

fn tables(model: &ActionModel, behaviour: &dyn PolicyBehaviour) -> PolicyTables {
    let cfg = PolicyConfig { compare_samples: 500, ..PolicyConfig::default() };
    PolicySolver { model, cfg: &cfg, progress: &Silent, comm: &SingleRank }
        .solve_all(&[behaviour], &mut Pcg64::seed_from_u64(3))
        .expect("it converges")
}

/// Root mean square distance of what is interpolated at the finest cells from the values there.
fn error(model: &ActionModel, finest: &Solution, adapted: &Solution, state: u32) -> f64 {
    let n = finest.record.num_choices as usize;
    let best = [finest, adapted].map(|s| vec![0; s.values.len() * n]);
    let (a, b) = (finest.table(model, &best[0]).expect("sound"), adapted.table(model, &best[1]).expect("sound"));
    let cells = 0..a.grid().num_cells();
    let squares =
        cells.map(|c| f64::from(b.value(state, a.grid().cell_centre(c) + a.centre()) - a.values_of(state)[c]).powi(2));
    (squares.sum::<f64>() / a.grid().num_cells() as f64).sqrt()
}

fn bytes(s: &Solution) -> usize {
    s.values.len() * (4 + s.record.num_choices as usize) + size_of_val(&*s.state_grids)
}

#[test]
fn memory_stays_within_the_share_and_more_of_it_never_makes_values_worse() {
    let (model, hit, grid) = blows(&mut Pcg64::seed_from_u64(1));
    let polar = TargetGrid::polar(9, 16, 3.0, 0.25, 1.0).expect("a valid grid");
    let made_up = SyntheticProblem { states: STATES, actions: 5, ..SyntheticProblem::default() };
    let approach = made_up.behaviour().expect("a valid behaviour");
    for (model, behaviour, grid) in [(&model, &hit as &dyn PolicyBehaviour, grid), (&made_up.model(), &approach, polar)]
    {
        let behaviour = Compact { behaviour, grid, adaptive: None };
        let whole = finest(model, &behaviour);
        let mut last = f64::INFINITY;
        for share in [0.09, 0.15, 0.3, 0.6, 0.9, 1.0] {
            let config = AdaptiveConfig { share, ..AdaptiveConfig::default() };
            let adapted = adapt(model, &whole, &behaviour, &config).expect("the coarsest fit");
            let records = if share == 1.0 { size_of_val(&*adapted.state_grids) } else { 0 };
            assert!(bytes(&adapted) as f64 <= share * bytes(&whole) as f64 + records as f64, "{share}");
            let all: f64 = (0..STATES).map(|s| error(model, &whole, &adapted, s).powi(2)).sum();
            assert!(all <= last * 1.0001 + 1e-9, "share {share}: {all:e} after {last:e}");
            last = all;
        }
        assert!(last < 1e-9, "the whole memory holds all values: {last:e}");
    }
}

#[test]
fn with_all_the_memory_scores_are_those_of_the_uniform_policy() {
    let (model, hit, grid) = blows(&mut Pcg64::seed_from_u64(2));
    let whole = AdaptiveConfig { share: 1.0, ..AdaptiveConfig::default() };
    let uniform = tables(&model, &Compact { behaviour: &hit, grid, adaptive: None });
    let adaptive = tables(&model, &Compact { behaviour: &hit, grid, adaptive: Some(whole) });
    let (u, a) = (uniform.table(0).expect("sound"), adaptive.table(0).expect("sound"));
    assert!(a.is_adaptive() && !u.is_adaptive());
    let mut rng = Pcg64::seed_from_u64(4);
    let (mut one, mut other) = ([0.0; MAX_ACTIONS], [0.0; MAX_ACTIONS]);
    for _ in 0..300 {
        let target = Vec3::new(rng.random_range(-1.5..1.5), rng.random_range(1.0..1.8), rng.random_range(-0.5..1.6));
        let state = rng.random_range(0..STATES);
        let n = u.action_scores(state, target, &mut one).expect("sound");
        assert_eq!(n, a.action_scores(state, target, &mut other).expect("sound"));
        let apart = one[..n].iter().zip(&other[..n]).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
        assert!(apart < 1e-6, "{state} {target}: {apart:e}");
    }
}

#[test]
fn states_that_are_good_enough_stay_coarse() {
    let (model, hit, grid) = blows(&mut Pcg64::seed_from_u64(5));
    let behaviour = Compact { behaviour: &hit, grid, adaptive: None };
    let whole = finest(&model, &behaviour);
    let mut last = bytes(&whole);
    for tolerance in [0.03, 0.1] {
        let adapted =
            adapt(&model, &whole, &behaviour, &AdaptiveConfig { share: 1.0, tolerance }).expect("the coarsest fit");
        assert!(bytes(&adapted) < last, "{tolerance}: {} after {last}", bytes(&adapted));
        last = bytes(&adapted);
        for state in 0..STATES {
            let left = error(&model, &whole, &adapted, state);
            assert!(left <= tolerance * 1.001, "state {state}: {left} with {tolerance}");
        }
    }
}

#[test]
fn memory_that_is_too_little_is_refused_with_what_it_takes() {
    let (model, hit, grid) = blows(&mut Pcg64::seed_from_u64(6));
    let behaviour = Compact { behaviour: &hit, grid, adaptive: None };
    let config = AdaptiveConfig { share: 1e-4, ..AdaptiveConfig::default() };
    let message = adapt(&model, &finest(&model, &behaviour), &behaviour, &config).expect_err("too little").to_string();
    // 2 x 2 x 1 cells of 8 bytes and a record of 16 bytes, of 792 cells.
    assert!(message.contains("grid.adaptive.share") && message.contains("0.008"), "{message}");
}

#[test]
fn stored_actions_are_those_of_the_look_ahead_at_the_centres_of_a_state_s_own_cells() {
    let (model, hit, grid) = blows(&mut Pcg64::seed_from_u64(7));
    let adaptive = Some(AdaptiveConfig { share: 0.3, ..AdaptiveConfig::default() });
    let tables = tables(&model, &Compact { behaviour: &hit, grid, adaptive });
    let table = tables.table(0).expect("sound");
    for state in 0..STATES {
        let own = table.grid_of(state);
        for cell in 0..own.num_cells() {
            let target = own.cell_centre(cell) + table.centre();
            let mut ranked = [RankedActions::NONE];
            let goals = [LookAheadGoal { policy: &table, weights: &[1.0], targets: &[target] }];
            LookAheadJob { goals: &goals, states: &[state], ranked: &mut ranked }.run().expect("a sound batch");
            assert_eq!(table.best_of(state, cell), ranked[0].actions);
            let mut action = [0];
            let (states, targets) = ([state], [target]);
            let policy = &table;
            let job = BestActionJob { policy, states: &states, targets: &targets, choice: 0, actions: &mut action };
            job.run().expect("a sound batch");
            assert_eq!((table.nearest_cell(state, target), action[0]), (cell, ranked[0].best()));
        }
    }
}

/// Mean and 95th percentile of the distance between the values of two policies on a lattice of targets.
fn apart(a: &PolicyTable, b: &PolicyTable) -> (f64, f64) {
    let mut errors = Vec::new();
    for state in 0..STATES {
        for k in 0..2000 {
            let t = |of: f32| (k as f32 * of).fract();
            let (angle, distance, height) =
                (2.0 * t(0.618_034) - 1.0, 0.4 + 0.9 * t(0.754_877), 1.2 + 0.4 * t(0.569_84));
            let target = Vec3::new(distance * angle.sin(), height, distance * angle.cos());
            errors.push(f64::from((a.value(state, target) - b.value(state, target)).abs()));
        }
    }
    errors.sort_by(f64::total_cmp);
    (errors.iter().sum::<f64>() / errors.len() as f64, errors[errors.len() * 95 / 100])
}

#[test]
fn the_report_says_what_the_values_say() {
    let (model, hit, grid) = blows(&mut Pcg64::seed_from_u64(8));
    let adaptive = Some(AdaptiveConfig { share: 0.2, ..AdaptiveConfig::default() });
    let cfg = PolicyConfig { compare_samples: 20_000, ..PolicyConfig::default() };
    let solve = |behaviour: &dyn PolicyBehaviour| {
        let mut rng = Pcg64::seed_from_u64(3);
        PolicySolver { model: &model, cfg: &cfg, progress: &Silent, comm: &SingleRank }
            .solve_all(&[behaviour], &mut rng)
            .expect("it converges")
    };
    let compact = solve(&Compact { behaviour: &hit, grid, adaptive });
    let whole = solve(&Compact { behaviour: &hit, grid, adaptive: None });
    let report = compact.policies[0].report.adaptive.clone().expect("an adaptive policy");
    let (mean, p95) = apart(&compact.table(0).expect("sound"), &whole.table(0).expect("sound"));
    assert!((report.adaptive.mean_error / mean - 1.0).abs() < 0.05, "{report:?}: {mean}");
    assert!((report.adaptive.p95_error / p95 - 1.0).abs() < 0.1, "{report:?}: {p95}");
    assert!(report.adaptive.max_error > report.adaptive.p95_error);
    assert!(whole.policies[0].report.adaptive.is_none());
    // The uniform grid has as much memory at least, and what it solves is what it would be by itself.
    assert!(report.uniform.bytes >= report.adaptive.bytes && report.uniform.bytes < report.finest_bytes / 3);
    let counts = report.uniform.counts.map(|n| n as u32);
    let alone = solve(&Compact { behaviour: &hit, grid: grid.with_counts(counts), adaptive: None });
    let (mean, _) = apart(&alone.table(0).expect("sound"), &whole.table(0).expect("sound"));
    assert!((report.uniform.mean_error / mean - 1.0).abs() < 0.05, "{report:?}: {mean}");
    assert!(report.adaptive.mean_error < report.uniform_fitted.mean_error, "{report:?}");
}

#[test]
fn same_grids_at_any_thread_count() {
    let (model, hit, grid) = blows(&mut Pcg64::seed_from_u64(9));
    let adaptive = Some(AdaptiveConfig::default());
    let at = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let tables = pool.install(|| tables(&model, &Compact { behaviour: &hit, grid, adaptive }));
        let p = &tables.policies[0];
        let bits: Vec<u32> = p.values.iter().map(|v| v.to_bits()).collect();
        (bits, p.state_grids.clone(), p.best.clone(), p.report.adaptive.clone())
    };
    let one = at(1);
    assert!(one == at(2) && one == at(8));
}

#[test]
fn configuration_says_what_is_wrong_with_it() {
    let read = |text: &str| toml::from_str::<PolicyBehaviourConfig>(text);
    let text = "kind = \"throw_punches\"\ngrid = { rings = 20, adaptive = { share = 0.125 } }";
    let config = read(text).expect("a valid behaviour");
    assert_eq!(config.grid.adaptive, Some(AdaptiveConfig { share: 0.125, tolerance: 0.0 }));
    assert!(read("grid.adaptive = { shares = 0.1 }").is_err());
    let place = Vec3::new(0.0, 1.4, 0.6);
    let hit =
        SegmentHit { frame: 3, kind: "punch".into(), joint: Joint::LeftHand, place, own_place: place, force: 1.0 };
    let punches = |adaptive| {
        let grid = GridConfig { adaptive: Some(adaptive), ..GridConfig::default() };
        let config =
            PolicyBehaviourConfig { kind: BehaviourKind::ThrowPunches, grid, ..PolicyBehaviourConfig::default() };
        ThrowPunches::new(&config, 30.0, &[vec![hit.clone()]]).map(|b| b.spec().adaptive)
    };
    let good = AdaptiveConfig::default();
    assert_eq!(punches(good).expect("a valid behaviour"), Some(good));
    for share in [0.0, -1.0, 1.5, f64::NAN] {
        let message = punches(AdaptiveConfig { share, ..good }).expect_err("no share").to_string();
        assert!(message.contains("grid.adaptive.share"), "{message}");
    }
    let message = punches(AdaptiveConfig { tolerance: -0.1, ..good }).expect_err("no tolerance").to_string();
    assert!(message.contains("grid.adaptive.tolerance"), "{message}");
    let grid = GridConfig { adaptive: Some(AdaptiveConfig { share: 2.0, ..good }), ..GridConfig::default() };
    assert!(Approach::new(&PolicyBehaviourConfig { grid, ..PolicyBehaviourConfig::default() }, 30.0, None).is_err());
    let grid = GridConfig { adaptive: Some(good), ..GridConfig::default() };
    let message = grid.make_space_time().expect_err("one resolution").to_string();
    assert!(message.contains("grid.adaptive") && message.contains("evade"), "{message}");
}
