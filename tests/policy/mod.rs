//! Policies are the optimal ones: value iteration against hand-solved, brute-force and exhaustive answers.

mod adaptive;
mod damage;
mod naive;
mod space_time;

use glam::{Vec2, Vec3};
use naive::{ARITHMETIC, Hit, Naive, approach, largest_error, model, random_model, segment, solved};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use throng_core::Planar;
use throng_core::base::SingleRank;
use throng_core::policy::{BestActionJob, LookAheadGoal, LookAheadJob, NO_ACTION, RankedActions};
use throng_precompute::policy::made_up::SyntheticProblem;
use throng_precompute::policy::{
    ActionModel, Approach, CostsConfig, GridConfig, PolicyBehaviour, PolicyBehaviourConfig, PolicyConfig, PolicySolver,
    RewardForm, bake,
};
use throng_precompute::progress::Silent;

#[test]
fn chain_of_three_states_has_the_values_worked_out_by_hand() {
    // 0 -> 1 in 10 frames, 1 -> 2 in 5, 0 -> 2 in 12, 2 -> 0 in 3 with a blow in frame 1. Nothing moves.
    let still = Planar::IDENTITY;
    let segments = vec![segment(1, 10, still), segment(2, 5, still), segment(2, 12, still), segment(0, 3, still)];
    let model = model(&[0, 2, 3, 4], &[0, 2, 1, 3], segments);
    let grid = Hit { discount: 0.9, blows: vec![], radius: 0.1, transition_cost: 0.0 }.spec().grid;
    let (target, d) = (25, 0.9f64);
    let hit =
        Hit { discount: d, blows: vec![(3, 1, grid.cell_centre(target), 0.8)], radius: 0.1, transition_cost: 0.0 };
    let tables = solved(&model, &hit, &PolicyConfig { epsilon: 1e-6, ..PolicyConfig::default() });
    // The direct way from 0 to 2 takes 12 frames instead of 15: a round is 15 frames.
    let v2 = 0.8 * d / (1.0 - d.powi(15));
    let n = grid.num_cells();
    let values = &tables.policies[0].values;
    for (state, expected) in [(0, d.powi(12) * v2), (1, d.powi(5) * v2), (2, v2)] {
        assert!((f64::from(values[state * n + target]) - expected).abs() < 2e-6, "state {state}");
        assert_eq!(values[state * n + target + 1], 0.0, "no blow reaches the next cell");
    }
    let table = tables.table(0).expect("sound tables");
    assert_eq!(table.best_of(0, target), [1, 0, NO_ACTION, NO_ACTION]);
}

#[test]
fn a_transition_is_taken_where_it_pays_for_its_cost() {
    // Where the clip goes on, a blow is worth 0.5; a transition at a distance of 0.15 leads to one that is worth 1.
    let segments = vec![segment(0, 10, Planar::IDENTITY), segment(0, 10, Planar::IDENTITY)];
    let model = model(&[0, 2], &[0, 1], segments);
    let grid = Hit { discount: 0.9, blows: vec![], radius: 0.1, transition_cost: 0.0 }.spec().grid;
    let (target, d) = (25, 0.9f64.powi(10));
    for (transition_cost, best) in [(0.0, 1), (15.0, 1), (30.0, 0)] {
        let blows = [(0, 0.5), (1, 1.0)].map(|(s, force)| (s, 0, grid.cell_centre(target), force)).to_vec();
        let hit = Hit { discount: 0.9, blows, radius: 0.1, transition_cost };
        let tables = solved(&model, &hit, &PolicyConfig { epsilon: 1e-6, ..PolicyConfig::default() });
        let left = (-0.15 * 0.15 * f64::from(transition_cost)).exp();
        let expected = (0.5 / (1.0 - d)).max(left / (1.0 - left * d));
        let table = tables.table(0).expect("sound tables");
        assert!((f64::from(tables.policies[0].values[target]) - expected).abs() < 1e-5, "cost {transition_cost}");
        assert_eq!(table.best_of(0, target)[0], best, "cost {transition_cost}");
    }
}

#[test]
fn a_trait_is_shown_where_it_pays_for_its_delay() {
    // A step of half a second to the target walks backwards; one ahead is longer by so many frames.
    for (trait_at, cost_s) in (0..8).flat_map(|t| [(t, 0.0), (t, 2.0)]) {
        let mut costs = [0.0; 8];
        costs[trait_at] = cost_s;
        let [backwards, sideways, gesture, carrying, manner_change_s, standing_change_s, made, running] = costs;
        let costs =
            CostsConfig { backwards, sideways, gesture, carrying, manner_change_s, standing_change_s, made, running };
        for transition_cost_s in [0.0, 1.0] {
            for longer in [15, 150] {
                let step = Planar::new(0.0, 2.0, 0.0);
                let segments =
                    vec![segment(1, 15, step), segment(1, 15 + longer, step), segment(1, 10, Planar::IDENTITY)];
                let mut model = model(&[0, 2, 3], &[0, 1, 2], segments);
                model.action_errors = vec![0.1; 3];
                model.action_traits = vec![[0.0; 8]; 3];
                model.action_traits[0][trait_at] = 0.5;
                let grid = GridConfig::polar(9, 9, 4.0, 0.4, 1.0);
                let config = PolicyBehaviourConfig {
                    grid,
                    transition_cost_s: Some(transition_cost_s),
                    costs: Some(costs),
                    ..PolicyBehaviourConfig::default()
                };
                let behaviour = Approach::new(&config, 30.0, None).expect("a valid behaviour");
                let table = solved(&model, &behaviour, &PolicyConfig::default()).table(0).expect("sound tables");
                let cell = table.nearest_cell(0, 2.0 * Vec3::Z);
                // A delay of one second outweighs half a second on the way, which is worth something, and not five.
                let best = u8::from(cost_s > 0.0 && longer == 15);
                let what = format!("trait {trait_at}, {cost_s} s, {longer} frames longer");
                assert_eq!(table.best_of(0, cell)[0], best, "{what}");
            }
        }
    }
}

#[test]
fn values_are_within_epsilon_of_brute_force() {
    for seed in 0..6 {
        let mut rng = Pcg64::seed_from_u64(seed);
        let model = random_model(&mut rng, 4);
        let reward = if seed % 2 == 0 { RewardForm::Integral } else { RewardForm::Max };
        let behaviour = approach(5, 9, reward, 0.95);
        for epsilon in [1e-2, 1e-4] {
            let cfg = PolicyConfig { epsilon, ..PolicyConfig::default() };
            let error = largest_error(&model, &behaviour, &cfg);
            assert!(error <= epsilon + ARITHMETIC, "seed {seed}: {error:e} for {epsilon:e}");
        }
    }
}

#[test]
fn offsets_and_gains_are_within_epsilon_of_brute_force() {
    for (seed, offset, gain) in [(1, 0.8, 1.0), (2, 0.0, -1.0), (3, 1.5, -0.5), (4, 0.3, 3.0)] {
        let model = random_model(&mut Pcg64::seed_from_u64(400 + seed), 4);
        let config = PolicyBehaviourConfig {
            grid: GridConfig::polar(5, 9, 3.0, 0.4, 1.0),
            reward: Some(if seed % 2 == 0 { RewardForm::Integral } else { RewardForm::Max }),
            discount: Some(0.95),
            offset,
            gain: Some(gain),
            costs: Some(CostsConfig::NONE),
            ..PolicyBehaviourConfig::default()
        };
        let behaviour = Approach::new(&config, 30.0, None).expect("a valid behaviour");
        let error = largest_error(&model, &behaviour, &PolicyConfig::default());
        assert!(error <= 1e-4 + ARITHMETIC * gain.abs().max(1.0), "offset {offset}, gain {gain}: {error:e}");
    }
}

#[test]
fn hits_in_three_dimensions_are_within_epsilon_of_brute_force() {
    for seed in 0..4 {
        let mut rng = Pcg64::seed_from_u64(100 + seed);
        let model = random_model(&mut rng, 4);
        let grid = Hit { discount: 0.95, blows: vec![], radius: 0.2, transition_cost: 4.0 }.spec().grid;
        let blows = (0..model.segments.len()).map(|s| {
            let cell = rng.random_range(0..grid.num_cells());
            let place = grid.cell_centre(cell) + Vec3::new(0.03, 0.05, -0.04);
            (s, rng.random_range(0..model.segments[s].num_frames), place, rng.random_range(0.3..1.0))
        });
        let hit = Hit { discount: 0.95, blows: blows.collect(), radius: 0.2, transition_cost: 4.0 };
        let error = largest_error(&model, &hit, &PolicyConfig::default());
        assert!(error <= 1e-4 + ARITHMETIC, "seed {seed}: {error:e}");
    }
}

#[test]
fn values_are_those_of_an_exhaustive_search() {
    // With a discount of 0.5 a frame, what comes after five actions of 3 and more frames counts less than 0.5^15.
    for seed in 0..3 {
        let mut rng = Pcg64::seed_from_u64(200 + seed);
        let mut model = random_model(&mut rng, 3);
        model.action_segments.truncate(3);
        let extra: Vec<u32> = (0..3).map(|_| rng.random_range(0..model.segments.len() as u32)).collect();
        let own = model.action_segments.clone();
        model.action_segments = vec![own[0], extra[0], own[1], extra[1], own[2], extra[2]];
        model.action_offsets = vec![0, 2, 4, 6];
        model.action_errors = vec![0.0, 0.3, 0.0, 0.2, 0.4, 0.1];
        model.action_traits = (0..6).map(|a| std::array::from_fn(|k| 0.05 * ((a + 2 * k) % 5) as f32)).collect();
        let behaviour = approach(4, 7, RewardForm::Integral, 0.5);
        let tables = solved(&model, &behaviour, &PolicyConfig { epsilon: 1e-5, ..PolicyConfig::default() });
        let naive = Naive::new(&model, &behaviour);
        let n = naive.grid.num_cells();
        for cell in (0..n).step_by(3) {
            let (found, got) = (naive.search(1, cell, 5), f64::from(tables.policies[0].values[n + cell]));
            assert!((found - got).abs() < 1e-5 + 0.5f64.powi(15) + ARITHMETIC, "cell {cell}: {found} {got}");
        }
    }
}

#[test]
fn residual_is_that_of_the_stored_values() {
    let mut rng = Pcg64::seed_from_u64(9);
    let model = random_model(&mut rng, 6);
    let behaviour = approach(5, 9, RewardForm::Integral, 0.97);
    let tables = solved(&model, &behaviour, &PolicyConfig::default());
    let policy = &tables.policies[0];
    let naive = Naive::new(&model, &behaviour);
    let n = naive.grid.num_cells();
    let value = |s: u32, c: usize| f64::from(policy.values[s as usize * n + c]);
    let residual = (0..policy.values.len())
        .map(|i| (naive.best(i / n, i % n, &mut { value }) - value((i / n) as u32, i % n)).abs())
        .fold(0.0, f64::max);
    let printed = f64::from(policy.report.residual);
    assert!((residual - printed).abs() < ARITHMETIC, "{residual:e} {printed:e}");
    assert!(policy.report.error_bound <= 1e-4 && policy.record.residual == policy.report.residual);
}

#[test]
fn same_tables_at_any_thread_count() {
    let problem = SyntheticProblem { states: 30, actions: 9, ..SyntheticProblem::default() };
    let at = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let behaviour = problem.behaviour().expect("a valid behaviour");
        let tables = pool.install(|| solved(&problem.model(), &behaviour, &PolicyConfig::default()));
        let p = &tables.policies[0];
        let bits: Vec<u32> = p.values.iter().map(|v| v.to_bits()).collect();
        (bits, p.best.clone(), bytemuck::bytes_of(&p.record).to_vec(), p.report.comparison)
    };
    let one = at(1);
    assert!(one == at(1) && one == at(2) && one == at(8));
}

#[test]
fn stored_actions_are_those_of_the_look_ahead_at_cell_centres() {
    let mut rng = Pcg64::seed_from_u64(4);
    let model = random_model(&mut rng, 8);
    let behaviour = approach(6, 11, RewardForm::Integral, 0.97);
    let tables = solved(&model, &behaviour, &PolicyConfig::default());
    let table = tables.table(0).expect("sound tables");
    let n = table.grid().num_cells();
    for state in 0..8 {
        let targets: Vec<Vec3> = (0..n).map(|c| table.grid().cell_centre(c)).collect();
        let (states, weights) = (vec![state; n], vec![1.0; n]);
        let mut ranked = vec![RankedActions::NONE; n];
        let goals = [LookAheadGoal { policy: &table, weights: &weights, targets: &targets }];
        LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run().expect("a sound batch");
        let mut actions = vec![0; n];
        let job =
            BestActionJob { policy: &table, states: &states, targets: &targets, choice: 0, actions: &mut actions };
        job.run().expect("a sound batch");
        for cell in 0..n {
            assert_eq!(table.best_of(state, cell), ranked[cell].actions);
            // Cells of ring 0 share one place, and the nearest cell to it is the first of them.
            let ring_0 = cell < table.grid().record().num_angles as usize;
            assert!(ring_0 || actions[cell] == ranked[cell].actions[0], "state {state}, cell {cell}");
        }
    }
}

#[test]
fn weighted_behaviours_are_the_weighted_sum_of_their_scores() {
    let mut rng = Pcg64::seed_from_u64(5);
    let model = random_model(&mut rng, 5);
    let come = approach(6, 11, RewardForm::Integral, 0.97);
    let grid = Hit { discount: 0.95, blows: vec![], radius: 0.5, transition_cost: 4.0 }.spec().grid;
    let blows = (0..model.segments.len()).map(|s| (s, 2, grid.cell_centre(s), 1.0)).collect();
    let hit = Hit { discount: 0.95, blows, radius: 0.5, transition_cost: 4.0 };
    let cfg = PolicyConfig::default();
    let tables = PolicySolver { model: &model, cfg: &cfg, progress: &Silent, comm: &SingleRank }
        .solve_all(&[&come, &hit], &mut rng)
        .expect("it converges");
    let policies = [tables.table(0).expect("sound tables"), tables.table(1).expect("sound tables")];
    let (states, weights, none) = ([3u32, 3], [0.3, 0.3], [2.0, 0.0]);
    let targets = [[Vec3::new(0.5, 1.0, 2.0); 2], [Vec3::new(0.2, 1.35, 0.8); 2]];
    let goals = [
        LookAheadGoal { policy: &policies[0], weights: &weights, targets: &targets[0] },
        LookAheadGoal { policy: &policies[1], weights: &none, targets: &targets[1] },
    ];
    let mut ranked = [RankedActions::NONE; 2];
    LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run().expect("a sound batch");
    let mut scores = [[0.0; 255]; 2];
    let n = policies[0].action_scores(3, targets[0][0], &mut scores[0]).expect("sound");
    policies[1].action_scores(3, targets[1][0], &mut scores[1]).expect("sound");
    let best_of = |weight: f32| (0..n).map(|a| 0.3 * scores[0][a] + weight * scores[1][a]).fold(f32::MIN, f32::max);
    assert!((ranked[0].scores[0] - best_of(2.0)).abs() < 1e-6);
    assert!((ranked[1].scores[0] - best_of(0.0)).abs() < 1e-6);
}

#[test]
fn sweeps_that_do_not_suffice_are_an_error_with_the_residual() {
    let problem = SyntheticProblem { states: 10, actions: 5, rings: 8, angles: 9, seed: 2 };
    let cfg = PolicyConfig { max_sweeps: 1, ..PolicyConfig::default() };
    let behaviour = problem.behaviour().expect("a valid behaviour");
    let message = PolicySolver { model: &problem.model(), cfg: &cfg, progress: &Silent, comm: &SingleRank }
        .value_iteration(&behaviour)
        .expect_err("too few")
        .to_string();
    assert!(message.contains("after 1 sweeps") && message.contains("max_sweeps"), "{message}");
    let mut solution =
        PolicySolver { model: &problem.model(), cfg: &PolicyConfig::default(), progress: &Silent, comm: &SingleRank }
            .value_iteration(&behaviour)
            .expect("enough");
    assert!(
        bake(&problem.model(), &mut solution, &PolicyConfig { choices: 5, ..PolicyConfig::default() }, &SingleRank)
            .is_err()
    );
}

#[test]
fn configuration_refuses_unknown_keys_and_takes_those_of_lee_and_lee() {
    let text = "name = \"a\"\nreward = \"max\"\ngrid = { rings = 5, angles = 13, radius = 2.0, inner_spacing = 0.5 }";
    let config: PolicyBehaviourConfig = toml::from_str(text).expect("a valid behaviour");
    assert_eq!(
        (config.grid, config.reward),
        (GridConfig { falloff: None, ..GridConfig::polar(5, 13, 2.0, 0.5, 2.5) }, Some(RewardForm::Max))
    );
    assert!(toml::from_str::<PolicyBehaviourConfig>("discont = 0.9").is_err());
    assert!(toml::from_str::<PolicyConfig>("epsilon = 1e-3\nsweeps = 4").is_err());
}

/// A character that stands, turns on the spot, starts, walks straight and in curves, and stops.
fn walker() -> ActionModel {
    let turn = |heading| Planar::new(0.0, 0.0, heading);
    let step = |z, heading: f32| Planar::new(0.5 * z * heading, z, heading);
    let segments = vec![
        segment(0, 15, Planar::IDENTITY),
        segment(0, 20, turn(0.8)),
        segment(0, 20, turn(-0.8)),
        segment(1, 12, step(0.35, 0.0)),
        segment(1, 16, step(0.65, 0.0)),
        segment(1, 16, step(0.6, 0.5)),
        segment(1, 16, step(0.6, -0.5)),
        segment(0, 12, step(0.3, 0.0)),
    ];
    model(&[0, 4, 8], &[0, 1, 2, 3, 4, 5, 6, 7], segments)
}

#[test]
fn approach_comes_to_the_target_from_anywhere_and_stands_there() {
    let model = walker();
    let behaviour = Approach::new(&PolicyBehaviourConfig::default(), 30.0, None).expect("a valid behaviour");
    let tables = solved(&model, &behaviour, &PolicyConfig::default());
    let table = tables.table(0).expect("sound tables");
    let mut rng = Pcg64::seed_from_u64(6);
    let mut arrived = 0;
    for _ in 0..200 {
        let (angle, distance) = (rng.random_range(0.0..std::f32::consts::TAU), rng.random_range(2.0..6.0f32));
        let target = Vec2::new(distance * angle.sin(), distance * angle.cos());
        let (mut state, mut root, mut frames) = (0u32, Planar::IDENTITY, 0);
        let mut last = 0;
        while frames < 450 {
            let local = root.inverse_transform_point(target);
            let local = Vec3::new(local.x, 0.0, local.y);
            let mut ranked = [RankedActions::NONE];
            let goals = [LookAheadGoal { policy: &table, weights: &[1.0], targets: &[local] }];
            LookAheadJob { goals: &goals, states: &[state], ranked: &mut ranked }.run().expect("a sound batch");
            last = table.actions().segments_of(state)[usize::from(ranked[0].best())];
            let played = &model.segments[last as usize];
            root = root.compose(played.displacement);
            (state, frames) = (played.end, frames + played.num_frames);
        }
        let near = Vec2::new(root.x, root.z).distance(target) < 0.5;
        arrived += u32::from(near && last == 0);
    }
    assert!(arrived >= 195, "{arrived} of 200 stand within 0.5 m of their target after 15 s");
}
