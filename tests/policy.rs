//! Policies are the optimal ones: value iteration against hand-solved, brute-force and exhaustive answers.

use glam::{Vec2, Vec3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use throng_precompute::policy::made_up::MadeUp;
use throng_precompute::policy::{
    ActionModel, Approach, Behaviour, BehaviourConfig, GridConfig, PolicyConfig, PolicyTables, RewardForm,
    SegmentMotion, bake, segment_records, solve_behaviours, value_iteration,
};
use throng_precompute::progress::Silent;
use throng_runtime::Planar;
use throng_runtime::policy::{
    ActionTable, BestActionJob, COMBINE_MAX, Goal, KERNEL_WITHIN, LookAheadJob, NO_ACTION, PolicyRecord, PolicySlices,
    PolicyTable, RankedActions, Reward, RewardRecord, SegmentRecord, TargetGrid,
};

/// A second behaviour: an impulsive hit (003 eq. 2 and 6) on a grid of angle, distance and height.
struct Hit {
    discount: f64,
    /// Segment, frame, place and force of each blow.
    blows: Vec<(usize, u32, Vec3, f64)>,
    radius: f32,
}

impl Behaviour for Hit {
    fn name(&self) -> &str {
        "hit"
    }

    fn grid(&self) -> TargetGrid {
        TargetGrid::cylinder([5, 4, 3], Vec3::new(-1.0, 0.4, 1.2), Vec3::new(1.0, 1.3, 1.6), 0.1).expect("a valid grid")
    }

    fn reward(&self) -> Reward {
        let record = RewardRecord::new(COMBINE_MAX, KERNEL_WITHIN, self.radius);
        Reward::new(record).expect("a valid reward")
    }

    fn discount(&self) -> f64 {
        self.discount
    }

    fn sample(&self, segment: usize, _: &SegmentMotion, record: &mut SegmentRecord) {
        for (k, (_, frame, place, force)) in self.blows.iter().filter(|b| b.0 == segment).take(2).enumerate() {
            (record.inner[2 * k], record.inner[2 * k + 1], record.heights[k]) = (place.x, place.z, place.y);
            record.weights[1 + k] = (self.discount.powi(*frame as i32) * force) as f32;
        }
    }
}

fn segment(end: u32, num_frames: u32, displacement: Planar) -> SegmentMotion {
    let d = displacement;
    let ratios = (0..=num_frames).map(|f| f as f32 / num_frames as f32);
    let path = ratios.map(|t| Planar::new(t * d.x, t * d.z, t * d.heading)).collect();
    SegmentMotion { end, num_frames, displacement, path }
}

fn model(offsets: &[u32], actions: &[u32], segments: Vec<SegmentMotion>) -> ActionModel {
    ActionModel { rate_hz: 30.0, action_offsets: offsets.to_vec(), action_segments: actions.to_vec(), segments }
}

/// Few states with several actions each, some of which share segments.
fn random_model(rng: &mut Pcg64, num_states: u32) -> ActionModel {
    let num_segments = num_states * 2 + 1;
    let segments = (0..num_segments).map(|_| {
        let d = Planar::new(rng.random_range(-0.5..0.5), rng.random_range(-0.3..1.0), rng.random_range(-1.5..1.5));
        segment(rng.random_range(0..num_states), rng.random_range(3..20), d)
    });
    let segments: Vec<_> = segments.collect();
    let mut offsets = vec![0];
    let mut actions = Vec::new();
    for _ in 0..num_states {
        (0..rng.random_range(1..5)).for_each(|_| actions.push(rng.random_range(0..num_segments)));
        offsets.push(actions.len() as u32);
    }
    model(&offsets, &actions, segments)
}

fn approach(rings: u32, angles: u32, reward: RewardForm, discount: f64) -> Approach {
    let reward = Some(reward);
    let grid = GridConfig::polar(rings, angles, 3.0, 0.4, 1.0);
    Approach::new(&BehaviourConfig { grid, reward, discount, ..BehaviourConfig::default() }, 30.0, None).expect("valid")
}

/// The backup in f64, written down again from the definitions and sharing no code with the solver.
struct Naive<'a> {
    model: &'a ActionModel,
    grid: TargetGrid,
    reward: RewardRecord,
    records: Vec<SegmentRecord>,
    discount: f64,
}

impl<'a> Naive<'a> {
    fn new(model: &'a ActionModel, behaviour: &dyn Behaviour) -> Self {
        let records = segment_records(behaviour, &model.segments);
        let (grid, reward) = (behaviour.grid(), *behaviour.reward().record());
        Self { model, grid, reward, records, discount: behaviour.discount() }
    }

    fn reward(&self, r: &SegmentRecord, target: [f64; 3]) -> f64 {
        let inner = r.inner.map(f64::from);
        let end = [f64::from(r.displacement[2]), f64::from(r.displacement[3])];
        let height = |k: usize| if self.grid.is_polar() { target[1] } else { f64::from(r.heights[k]) };
        let places = [
            [0.0, target[1], 0.0],
            [inner[0], height(0), inner[1]],
            [inner[2], height(1), inner[3]],
            [end[0], target[1], end[1]],
        ];
        let terms = places.iter().zip(r.weights).map(|(p, w)| {
            let d = ((target[0] - p[0]).powi(2) + (target[1] - p[1]).powi(2) + (target[2] - p[2]).powi(2)).sqrt();
            let ratio = d / f64::from(self.reward.scale);
            let kernel = if self.reward.kernel == KERNEL_WITHIN { f64::from(ratio <= 1.0) } else { (-ratio).exp() };
            f64::from(w) * kernel
        });
        if self.reward.combine == COMBINE_MAX { terms.fold(0.0, f64::max) } else { terms.sum() }
    }

    /// Cells of one height and their weights.
    fn weights(&self, x: f64, z: f64) -> Vec<(usize, f64)> {
        let g = self.grid.record();
        let (rings, angles) = (g.num_rings as usize, g.num_angles as usize);
        let radius = |k: usize| {
            f64::from(g.ring_start) + k as f64 * (f64::from(g.ring_spacing) + f64::from(g.ring_growth) * k as f64)
        };
        let distance = x.hypot(z);
        let mut beyond = (distance - radius(rings - 1)).max(0.0);
        let inside = distance.clamp(radius(0), radius(rings - 1));
        let ring = (0..rings - 1).rfind(|&k| radius(k) <= inside).unwrap_or(0);
        // Between rings the ring *number* is what is linear.
        let (mut low, mut high) = (ring as f64, ring as f64 + 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let at = f64::from(g.ring_start) + middle * (f64::from(g.ring_spacing) + f64::from(g.ring_growth) * middle);
            if at < inside { low = middle } else { high = middle }
        }
        let far = low - ring as f64;
        let angle = x.atan2(z);
        let (angle_low, angle_high, ratio);
        if self.grid.is_polar() {
            let t = angle.rem_euclid(std::f64::consts::TAU) / (std::f64::consts::TAU / angles as f64);
            (angle_low, angle_high, ratio) = (t as usize % angles, (t as usize + 1) % angles, t.fract());
        } else {
            beyond += (radius(0) - distance).max(0.0);
            let spacing = f64::from(g.angle_spacing);
            let t = (angle - f64::from(g.angle_start)) / spacing;
            let clamped = t.clamp(0.0, (angles - 1) as f64);
            beyond += (t - clamped).abs() * spacing * distance;
            angle_low = (clamped as usize).min(angles - 2);
            (angle_high, ratio) = (angle_low + 1, clamped - angle_low as f64);
        }
        let u = beyond / f64::from(g.falloff);
        let scale = 1.0 / (1.0 + u + 0.5 * u * u);
        vec![
            (ring * angles + angle_low, scale * (1.0 - far) * (1.0 - ratio)),
            (ring * angles + angle_high, scale * (1.0 - far) * ratio),
            ((ring + 1) * angles + angle_low, scale * far * (1.0 - ratio)),
            ((ring + 1) * angles + angle_high, scale * far * ratio),
        ]
    }

    /// Score of an action, given what a (state, cell) is worth.
    fn score(&self, segment: usize, cell: usize, value: &mut dyn FnMut(u32, usize) -> f64) -> f64 {
        let c = self.grid.cell_coordinates(cell).as_dvec3();
        let target = [c.y * c.x.sin(), if self.grid.is_polar() { 0.0 } else { c.z }, c.y * c.x.cos()];
        let d = self.model.segments[segment].displacement;
        let (dx, dz) = (target[0] - f64::from(d.x), target[2] - f64::from(d.z));
        let (sin, cos) = f64::from(d.heading).sin_cos();
        let plane = self.grid.num_plane_cells();
        let height = cell / plane * plane;
        let next = self.weights(cos * dx - sin * dz, sin * dx + cos * dz);
        let next: f64 = next.iter().map(|&(c, w)| w * value(self.model.segments[segment].end, height + c)).sum();
        let discount = self.discount.powi(self.model.segments[segment].num_frames as i32);
        self.reward(&self.records[segment], target) + discount * next
    }

    fn segments_of(&self, state: usize) -> &[u32] {
        let o = &self.model.action_offsets;
        &self.model.action_segments[o[state] as usize..o[state + 1] as usize]
    }

    fn best(&self, state: usize, cell: usize, value: &mut dyn FnMut(u32, usize) -> f64) -> f64 {
        self.segments_of(state).iter().map(|&s| self.score(s as usize, cell, value)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Optimal values, by Bellman's iteration to 1e-9.
    fn solve(&self) -> Vec<f64> {
        let cells = self.grid.num_cells();
        let mut values = vec![0.0; self.model.num_states() * cells];
        loop {
            let next: Vec<f64> = (0..values.len())
                .map(|i| self.best(i / cells, i % cells, &mut |s, c| values[s as usize * cells + c]))
                .collect();
            let change = next.iter().zip(&values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            values = next;
            if change < 1e-9 {
                return values;
            }
        }
    }

    /// Value by exhaustive search of all action sequences up to a depth.
    fn search(&self, state: usize, cell: usize, depth: u32) -> f64 {
        if depth == 0 {
            return 0.0;
        }
        self.best(state, cell, &mut |s, c| self.search(s as usize, c, depth - 1))
    }
}

fn solved(model: &ActionModel, behaviour: &dyn Behaviour, cfg: &PolicyConfig) -> PolicyTables {
    solve_behaviours(model.clone(), &[behaviour], cfg, &mut Pcg64::seed_from_u64(3), &Silent).expect("it converges")
}

/// Angles of reward and geometry are within 4e-6 rad, exponentials within 1e-5: what that makes of values.
const ARITHMETIC: f64 = 2e-5;

fn largest_error(model: &ActionModel, behaviour: &dyn Behaviour, cfg: &PolicyConfig) -> f64 {
    let tables = solved(model, behaviour, cfg);
    let exact = Naive::new(model, behaviour).solve();
    let errors = exact.iter().zip(&tables.policies[0].values).map(|(a, &b)| (a - f64::from(b)).abs());
    errors.fold(0.0, f64::max)
}

#[test]
fn chain_of_three_states_has_the_values_worked_out_by_hand() {
    // 0 -> 1 in 10 frames, 1 -> 2 in 5, 0 -> 2 in 12, 2 -> 0 in 3 with a blow in frame 1. Nothing moves.
    let still = Planar::IDENTITY;
    let segments = vec![segment(1, 10, still), segment(2, 5, still), segment(2, 12, still), segment(0, 3, still)];
    let model = model(&[0, 2, 3, 4], &[0, 2, 1, 3], segments);
    let grid = Hit { discount: 0.9, blows: vec![], radius: 0.1 }.grid();
    let (target, d) = (25, 0.9f64);
    let hit = Hit { discount: d, blows: vec![(3, 1, grid.cell_centre(target), 0.8)], radius: 0.1 };
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
fn hits_in_three_dimensions_are_within_epsilon_of_brute_force() {
    for seed in 0..4 {
        let mut rng = Pcg64::seed_from_u64(100 + seed);
        let model = random_model(&mut rng, 4);
        let grid = Hit { discount: 0.95, blows: vec![], radius: 0.2 }.grid();
        let blows = (0..model.segments.len()).map(|s| {
            let cell = rng.random_range(0..grid.num_cells());
            let place = grid.cell_centre(cell) + Vec3::new(0.03, 0.05, -0.04);
            (s, rng.random_range(0..model.segments[s].num_frames), place, rng.random_range(0.3..1.0))
        });
        let hit = Hit { discount: 0.95, blows: blows.collect(), radius: 0.2 };
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
        model.action_offsets = vec![0, 1, 2, 3];
        let extra: Vec<u32> = (0..3).map(|_| rng.random_range(0..model.segments.len() as u32)).collect();
        let own = model.action_segments.clone();
        model.action_segments = vec![own[0], extra[0], own[1], extra[1], own[2], extra[2]];
        model.action_offsets = vec![0, 2, 4, 6];
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
    let problem = MadeUp { states: 30, actions: 9, ..MadeUp::default() };
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
        let goals = [Goal { policy: table, weights: &weights, targets: &targets }];
        LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run().expect("a sound batch");
        let mut actions = vec![0; n];
        let job = BestActionJob { policy: table, states: &states, targets: &targets, choice: 0, actions: &mut actions };
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
    let grid = Hit { discount: 0.95, blows: vec![], radius: 0.5 }.grid();
    let blows = (0..model.segments.len()).map(|s| (s, 2, grid.cell_centre(s), 1.0)).collect();
    let hit = Hit { discount: 0.95, blows, radius: 0.5 };
    let cfg = PolicyConfig::default();
    let tables = solve_behaviours(model, &[&come, &hit], &cfg, &mut rng, &Silent).expect("it converges");
    let policies = [tables.table(0).expect("sound tables"), tables.table(1).expect("sound tables")];
    let (states, weights, none) = ([3u32, 3], [0.3, 0.3], [2.0, 0.0]);
    let targets = [[Vec3::new(0.5, 1.0, 2.0); 2], [Vec3::new(0.2, 1.35, 0.8); 2]];
    let goals = [
        Goal { policy: policies[0], weights: &weights, targets: &targets[0] },
        Goal { policy: policies[1], weights: &none, targets: &targets[1] },
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
    let problem = MadeUp { states: 10, actions: 5, rings: 8, angles: 9, seed: 2 };
    let cfg = PolicyConfig { max_sweeps: 1, ..PolicyConfig::default() };
    let behaviour = problem.behaviour().expect("a valid behaviour");
    let message = value_iteration(&problem.model(), &behaviour, &cfg, &Silent).expect_err("too few").to_string();
    assert!(message.contains("after 1 sweeps") && message.contains("max_sweeps"), "{message}");
    let mut solution =
        value_iteration(&problem.model(), &behaviour, &PolicyConfig::default(), &Silent).expect("enough");
    assert!(bake(&problem.model(), &mut solution, &PolicyConfig { choices: 5, ..PolicyConfig::default() }).is_err());
}

#[test]
fn configuration_refuses_unknown_keys_and_takes_the_paper_s() {
    let text = "name = \"a\"\nreward = \"max\"\ngrid = { rings = 5, angles = 13, radius = 2.0, inner_spacing = 0.5 }";
    let config: BehaviourConfig = toml::from_str(text).expect("a valid behaviour");
    assert_eq!(
        (config.grid, config.reward),
        (GridConfig { falloff: None, ..GridConfig::paper() }, Some(RewardForm::Max))
    );
    assert!(toml::from_str::<BehaviourConfig>("discont = 0.9").is_err());
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
    let behaviour = Approach::new(&BehaviourConfig::default(), 30.0, None).expect("a valid behaviour");
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
            let goals = [Goal { policy: table, weights: &[1.0], targets: &[local] }];
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

/// Sound tables, to be spoilt.
fn sound() -> Parts {
    let mut rng = Pcg64::seed_from_u64(8);
    let tables = solved(&random_model(&mut rng, 3), &approach(4, 5, RewardForm::Max, 0.9), &PolicyConfig::default());
    let p = tables.policies.into_iter().next().expect("one policy");
    (p.record, tables.action_offsets, tables.action_segments, p.segments, p.values, p.best)
}

/// What is spoilt, and how.
type Change<'a> = (&'a str, &'a dyn Fn(&mut Parts));
type Parts = (PolicyRecord, Vec<u32>, Vec<u32>, Vec<SegmentRecord>, Vec<f32>, Vec<u8>);

fn opens(parts: &Parts) -> bool {
    let (record, offsets, actions, segments, values, best) = parts;
    let Ok(actions) = ActionTable::new(offsets, actions, segments.len()) else { return false };
    PolicyTable::new(record, actions, PolicySlices { segments, values, best, ..PolicySlices::default() }).is_ok()
}

#[test]
fn spoilt_tables_are_refused() {
    let good = sound();
    assert!(opens(&good));
    let spoilt = |f: &dyn Fn(&mut Parts)| {
        let mut parts = good.clone();
        f(&mut parts);
        !opens(&parts)
    };
    let changes: [Change; 16] = [
        ("value missing", &|p| p.4.truncate(1)),
        ("value too many", &|p| p.4.push(0.0)),
        ("value not finite", &|p| p.4[7] = f32::NAN),
        ("best missing", &|p| p.5.truncate(1)),
        ("best beyond the actions", &|p| p.5[0] = 200),
        ("no best at all", &|p| p.5[0] = NO_ACTION),
        ("segment missing", &|p| p.3.truncate(1)),
        ("end beyond the states", &|p| p.3[0].end = 3),
        ("weight negative", &|p| p.3[1].weights[2] = -1.0),
        ("discount one", &|p| p.3[1].discount = 1.0),
        ("action beyond the segments", &|p| p.2[0] = 7),
        ("offset descending", &|p| p.1[1] = 0),
        ("offsets empty", &|p| p.1.clear()),
        ("first offset not zero", &|p| p.1[0] = 1),
        ("states", &|p| p.0.num_states = 4),
        ("choices", &|p| p.0.num_choices = 0),
    ];
    for (what, change) in changes {
        assert!(spoilt(change), "{what}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_bytes_are_refused_or_answer_without_a_panic(
        at in 0usize..96, byte in any::<u8>(), in_segment in any::<bool>(), target in any::<[f32; 3]>(), state in 0u32..5,
    ) {
        let mut parts = sound();
        if in_segment {
            bytemuck::cast_slice_mut::<SegmentRecord, u8>(&mut parts.3)[at] = byte;
        } else {
            bytemuck::bytes_of_mut(&mut parts.0)[at] = byte;
        }
        let (record, offsets, actions, segments, values, best) = &parts;
        let actions = ActionTable::new(offsets, actions, segments.len()).expect("untouched");
        if let Ok(policy) = PolicyTable::new(record, actions, PolicySlices { segments, values, best, ..PolicySlices::default() }) {
            let (states, targets) = ([state], [Vec3::from_array(target)]);
            let mut ranked = [RankedActions::NONE];
            let goals = [Goal { policy, weights: &[1.0], targets: &targets }];
            let looked = LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run();
            let mut action = [0];
            let job = BestActionJob { policy, states: &states, targets: &targets, choice: 3, actions: &mut action };
            let loaded = job.run();
            prop_assert_eq!(looked.is_ok(), loaded.is_ok());
            if looked.is_ok() {
                let n = actions.segments_of(state).len();
                prop_assert!(usize::from(ranked[0].best()) < n && usize::from(action[0]) < n);
            }
        }
    }
}
