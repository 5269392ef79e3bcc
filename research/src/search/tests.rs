use super::*;
use crate::quality::{QualityConfig, measure_policy};
use glam::Vec3;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use throng_bake::policy::made_up::SyntheticProblem;
use throng_bake::policy::{
    ActionModel, Approach, BehaviourSpec, GridConfig, PolicyBehaviour, PolicyBehaviourConfig, PolicyConfig,
    PolicySolver, PolicyTables, SegmentMotion, collect_rewards, segment_records,
};
use throng_core::Planar;
use throng_core::base::SingleRank;
use throng_core::policy::{COMBINE_SUM, KERNEL_WITHIN, Reward, RewardRecord, SegmentRecord, TargetGrid};
use throng_motion::progress::Silent;

/// Two blows an action, at made-up places of different heights.
struct Blows;

impl PolicyBehaviour for Blows {
    fn spec(&self) -> BehaviourSpec<'_> {
        let grid = TargetGrid::cylinder([6, 5, 3], Vec3::new(-1.0, 0.3, 1.2), Vec3::new(1.2, 1.4, 1.7), 0.3);
        let record = RewardRecord { offset: 0.1, ..RewardRecord::new(COMBINE_SUM, KERNEL_WITHIN, 0.3) };
        BehaviourSpec::new("blows", grid.expect("a valid grid"), Reward::new(record).expect("a valid reward"), 0.97)
    }

    fn sample(&self, segment: usize, motion: &SegmentMotion, record: &mut SegmentRecord) {
        let (d, n) = (motion.displacement, segment as f32);
        record.inner = [0.3 * (n * 1.7).sin(), 0.8 + 0.2 * n.sin(), d.x, d.z + 0.9];
        record.heights = [1.2 + 0.1 * (n % 6.0), 1.4];
        record.weights = [0.0, 0.8, 0.5, 0.0];
    }
}

/// Settings of an `approach` that plays actions as captured, as bounds know them.
fn unbent() -> PolicyBehaviourConfig {
    PolicyBehaviourConfig { bend_rad_per_m: Some(0.0), ..PolicyBehaviourConfig::default() }
}

fn solved(model: ActionModel, behaviour: &dyn PolicyBehaviour) -> PolicyTables {
    let mut rng = Pcg64::seed_from_u64(1);
    let cfg = PolicyConfig { compare_samples: 1, ..PolicyConfig::default() };
    PolicySolver { model: &model, cfg: &cfg, progress: &Silent, comm: &SingleRank }
        .solve_all(&[behaviour], &mut rng)
        .expect("it converges")
}

fn made_up(seed: u64) -> (PolicyTables, PolicyTables) {
    let small = SyntheticProblem { states: 5, actions: 4, rings: 7, angles: 9, seed };
    let grid = GridConfig::polar(small.rings, small.angles, 3.0, 0.25, 1.0);
    let approach = Approach::new(&PolicyBehaviourConfig { grid, transition_cost_s: Some(3.0), ..unbent() }, 30.0, None)
        .expect("a valid grid");
    (solved(small.model(), &approach), solved(small.model(), &Blows))
}

/// One state: step ahead by half a metre, or stand, for ten frames each.
fn line() -> ActionModel {
    let segment = |length: f32| SegmentMotion {
        end: 0,
        num_frames: 10,
        displacement: Planar::new(0.0, length, 0.0),
        path: (0..=10).map(|f| Planar::new(0.0, length * f as f32 / 10.0, 0.0)).collect(),
    };
    ActionModel {
        rate_hz: 30.0,
        segments: vec![segment(0.5), segment(0.0)],
        action_offsets: vec![0, 2],
        action_segments: vec![0, 1],
        action_errors: vec![0.0, 0.0],
        action_traits: Vec::new(),
    }
}

/// Every sequence one by one, in double precision, from the definitions.
fn every_sequence(table: &PolicyTable, at: PolicySituation, left: usize) -> f64 {
    if left == 0 {
        let grid = table.grid();
        let (height, ratio) = grid.height_interval(at.target.y);
        let stencil = grid.stencil(at.target.x, at.target.z);
        let plane = |h: u32| {
            let values = &table.values_of(at.state)[h as usize * grid.num_plane_cells()..][..grid.num_plane_cells()];
            f64::from(stencil.interpolate(values, grid.record().num_angles))
        };
        let low = plane(height);
        return if ratio > 0.0 { low + (plane(height + 1) - low) * f64::from(ratio) } else { low };
    }
    let of = |action: usize| {
        let played = play(table, at, action as u8);
        f64::from(played.reward) + f64::from(played.discount) * every_sequence(table, played.then, left - 1)
    };
    (0..table.actions().segments_of(at.state).len()).map(of).fold(f64::NEG_INFINITY, f64::max)
}

/// The place at (angle, distance, height), each from 0 to 1 over the grid.
fn place(grid: &TargetGrid, at: [f32; 3]) -> Vec3 {
    let r = grid.record();
    let sectors = if grid.is_polar() { r.num_angles } else { r.num_angles - 1 };
    let angle = r.angle_start + at[0] * r.angle_spacing * sectors as f32;
    let distance = r.ring_start + at[1] * (grid.radius() - r.ring_start);
    let height = r.height_start + at[2] * r.height_spacing * (r.num_heights - 1) as f32;
    Vec3::new(distance * angle.sin(), height, distance * angle.cos())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn finds_what_trying_every_sequence_finds(
        seed in 0u64..1000, state in 0u32..5, at in prop::array::uniform3(0.0f32..1.0), depth in 1usize..5,
    ) {
        let (approach, blows) = made_up(seed);
        for tables in [&approach, &blows] {
            let table = tables.table(0).expect("sound tables");
            let from = PolicySituation { state, target: place(table.grid(), at) };
            let whole = PolicySearch::new(&table, depth, None).best(from);
            let expected = every_sequence(&table, from, depth);
            prop_assert!((f64::from(whole.score) - expected).abs() < 2e-6, "{} {}", whole.score, expected);
            let bounds = ValueBounds::new(&table, depth, [from.target.y - 0.05, from.target.y + 0.05]);
            let pruned = PolicySearch::new(&table, depth, Some(&bounds)).best(from);
            prop_assert_eq!(pruned.score, whole.score);
            prop_assert!(pruned.look_aheads <= whole.look_aheads);
        }
    }

    #[test]
    fn bounds_hold_wherever_the_target_stands(
        seed in 0u64..1000, state in 0u32..5, at in prop::array::uniform3(0.0f32..1.0), left in 1usize..4,
    ) {
        let (approach, blows) = made_up(seed);
        for tables in [&approach, &blows] {
            let table = tables.table(0).expect("sound tables");
            let r = table.grid().record();
            let top = r.height_start + r.height_spacing * (r.num_heights - 1) as f32;
            let bounds = ValueBounds::new(&table, 4, [r.height_start, top]);
            let from = PolicySituation { state, target: place(table.grid(), at) };
            let best = PolicySearch::new(&table, left, None).best(from).score;
            prop_assert!(best <= bounds.upper_bound(left, from) + 1e-5, "{} {}", best, bounds.upper_bound(left, from));
        }
    }
}

#[test]
fn bounds_leave_out_most_of_what_there_is_to_try() {
    let (approach, _) = made_up(3);
    let table = approach.table(0).expect("sound tables");
    let bounds = ValueBounds::new(&table, 4, [0.0, 0.0]);
    let from = PolicySituation { state: 2, target: Vec3::new(0.4, 0.0, 1.5) };
    let whole = PolicySearch::new(&table, 4, None).best(from);
    let pruned = PolicySearch::new(&table, 4, Some(&bounds)).best(from);
    assert_eq!(whole.look_aheads, 1 + 4 + 16 + 64);
    assert!(pruned.look_aheads < whole.look_aheads * 2 / 3, "{} of {}", pruned.look_aheads, whole.look_aheads);
}

#[test]
fn walks_to_the_target_and_stands_there() {
    let config = unbent();
    let tables = solved(line(), &Approach::new(&config, 30.0, None).expect("a valid behaviour"));
    let table = tables.table(0).expect("sound tables");
    let found = PolicySearch::new(&table, 4, None).best(PolicySituation { state: 0, target: Vec3::new(0.0, 0.0, 1.0) });
    assert_eq!(found.actions[..4], [0, 0, 1, 1]);
    // Two steps, then standing on the target for ever, which is worth 1.
    let records = segment_records(&Approach::new(&config, 30.0, None).expect("a valid behaviour"), &line().segments);
    let reward = |z: f32| {
        let [_, _, end] = records[0].target_after(Vec3::new(0.0, 0.0, z));
        let kernel = table.reward().kernel(z);
        f64::from(table.reward().of_segment::<true>(&records[0], Vec3::new(0.0, 0.0, z), kernel, end))
    };
    let step = 0.996f64.powi(10);
    let exact = reward(1.0) + step * (reward(0.5) + step);
    assert!((f64::from(found.score) - exact).abs() < 2e-4, "{} {exact}", found.score);
}

#[test]
fn following_the_policy_collects_what_was_worked_out_by_hand() {
    let tables = solved(line(), &Approach::new(&unbent(), 30.0, None).expect("a valid behaviour"));
    let table = tables.table(0).expect("sound tables");
    let from = [
        PolicySituation { state: 0, target: Vec3::ZERO },
        PolicySituation { state: 0, target: Vec3::new(0.0, 0.0, -2.0) },
    ];
    let sums = collect_rewards(&table, &from, 1e-6, |_, ranked| ranked.choose(0.0, 0.0));
    // Standing on the target is worth 1; with the target behind, all there is to do is to stand two metres away.
    assert!((sums[0] - 1.0).abs() < 1e-5, "{}", sums[0]);
    assert!((sums[1] - f64::from(-2.0f32 / 1.5).exp()).abs() < 1e-5, "{}", sums[1]);
}

#[test]
fn a_policy_on_a_fine_grid_collects_nearly_all_there_is() {
    let fine = GridConfig::polar(65, 64, 4.0, 0.0625, 2.5);
    let config = PolicyBehaviourConfig { grid: fine, ..unbent() };
    let tables = solved(line(), &Approach::new(&config, 30.0, None).expect("a valid behaviour"));
    let asked = QualityConfig { pairs: 200, ..QualityConfig::default() };
    let q = measure_policy(&tables.table(0).expect("sound tables"), "approach", &asked);
    assert_eq!((q.asked, q.pairs), (200, 200));
    assert!((q.ratio_mean - 1.0).abs() < 5e-3 && q.ratio_p05 > 0.98, "{q:?}");
    assert!(q.realised_ratio_mean > 0.998 && q.realised_ratio_mean <= 1.0, "{q:?}");
    let of = |t: f32| q.temperatures.iter().find(|x| x.temperature == t).expect("that temperature").ratio_mean;
    assert_eq!(of(0.0), q.ratio_mean);
    assert!(of(0.5) < of(0.05) && of(0.05) < of(0.0), "{q:?}");
}
