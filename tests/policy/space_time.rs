//! Evading: values over place and time left, against a plain iteration in f64.

use super::naive::{ARITHMETIC, Naive, random_model, solved};
use glam::{DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use throng_core::policy::{
    KERNEL_EXPONENTIAL, MAX_ACTIONS, PATH_POINTS, PathRecord, Reward, RewardRecord, SegmentRecord, TargetGrid,
};
use throng_precompute::policy::{ActionModel, BehaviourSpec, PolicyBehaviour, PolicyConfig, SegmentMotion};

/// Being hit at a height of 1.6 m costs; the guarded point goes random ways.
struct Dodge {
    paths: Vec<PathRecord>,
    discount: f64,
}

impl Dodge {
    fn new(model: &ActionModel, rng: &mut Pcg64) -> Self {
        let path = |s: &SegmentMotion| {
            let mut at = Vec3::new(0.0, 1.6, 0.1);
            let points = std::array::from_fn(|_| {
                at += Vec3::new(rng.random_range(-0.1..0.1), rng.random_range(-0.1..0.1), rng.random_range(-0.1..0.1));
                at.to_array()
            });
            PathRecord { points, duration_s: s.num_frames as f32 / model.rate_hz as f32 }
        };
        Self { paths: model.segments.iter().map(path).collect(), discount: 0.95 }
    }
}

impl PolicyBehaviour for Dodge {
    fn spec(&self) -> BehaviourSpec<'_> {
        let grid = TargetGrid::space_time([4, 8, 6], 1.2, 0.75, 0.3).expect("a valid grid");
        let record = RewardRecord { gain: -1.0, height: 1.6, ..RewardRecord::new(1, KERNEL_EXPONENTIAL, 0.2) };
        BehaviourSpec::new("dodge", grid, Reward::new(record).expect("a valid reward"), self.discount)
    }

    fn sample(&self, _: usize, _: &SegmentMotion, _: &mut SegmentRecord) {}

    fn paths(&self) -> &[PathRecord] {
        &self.paths
    }
}

/// Score of an action for a target (x, time left, z), given what a (state, cell) is worth.
fn score(naive: &Naive<'_>, dodge: &Dodge, segment: usize, target: DVec3, values: &[f64]) -> f64 {
    let (motion, path) = (&naive.model.segments[segment], &dodge.paths[segment]);
    let duration = f64::from(motion.num_frames) / naive.model.rate_hz;
    if target.y < f64::from(path.duration_s) {
        let t = target.y / duration * (PATH_POINTS - 1) as f64;
        let i = (t as usize).min(PATH_POINTS - 2);
        let [a, b] = [i, i + 1].map(|k| Vec3::from(path.points[k]).as_dvec3());
        let distance = a.lerp(b, t - i as f64).distance(DVec3::new(target.x, 1.6, target.z));
        return -dodge.discount.powf(target.y * naive.model.rate_hz) * (-distance / 0.2).exp();
    }
    let d = motion.displacement;
    let (dx, dz) = (target.x - f64::from(d.x), target.z - f64::from(d.z));
    let (sin, cos) = f64::from(d.heading).sin_cos();
    let grid = naive.grid.record();
    let time = (target.y - duration) / f64::from(grid.height_spacing);
    let low = (time as usize).min(grid.num_heights as usize - 2);
    let (plane, cells) = (naive.grid.num_plane_cells(), naive.grid.num_cells());
    let weights = naive.weights(cos * dx - sin * dz, sin * dx + cos * dz);
    let at = |height: usize| -> f64 {
        weights.iter().map(|&(c, w)| w * values[motion.end as usize * cells + height * plane + c]).sum()
    };
    let next = at(low) + (at(low + 1) - at(low)) * (time - low as f64);
    dodge.discount.powi(motion.num_frames as i32) * next
}

/// Optimal values, by iteration until nothing changes.
fn exact(naive: &Naive<'_>, dodge: &Dodge) -> Vec<f64> {
    let cells = naive.grid.num_cells();
    let mut values = vec![0.0; naive.model.num_states() * cells];
    loop {
        let best = |i: usize| {
            let c = naive.grid.cell_coordinates(i % cells).as_dvec3();
            let target = DVec3::new(c.y * c.x.sin(), c.z, c.y * c.x.cos());
            let scores = naive.segments_of(i / cells).iter().map(|&s| score(naive, dodge, s as usize, target, &values));
            scores.fold(f64::NEG_INFINITY, f64::max)
        };
        let next: Vec<f64> = (0..values.len()).map(best).collect();
        if next.iter().zip(&values).all(|(a, b)| (a - b).abs() < 1e-9) {
            return values;
        }
        values = next;
    }
}

#[test]
fn values_over_the_time_left_are_those_of_brute_force() {
    for seed in 0..4 {
        let mut rng = Pcg64::seed_from_u64(300 + seed);
        let model = random_model(&mut rng, 4);
        let dodge = Dodge::new(&model, &mut rng);
        let tables = solved(&model, &dodge, &PolicyConfig::default());
        let naive = Naive::new(&model, &dodge);
        let exact = exact(&naive, &dodge);
        let errors = exact.iter().zip(&tables.policies[0].values).map(|(a, &b)| (a - f64::from(b)).abs());
        let worst = errors.fold(0.0, f64::max);
        assert!(worst < 1e-4 + ARITHMETIC, "seed {seed}: {worst:e}");
        assert!(exact.iter().any(|v| *v < -0.01), "some blow would hit");
        // Between cells, scores of the look-ahead are those of the definition.
        let table = tables.table(0).expect("sound tables");
        let mut scores = [0.0; MAX_ACTIONS];
        for _ in 0..200 {
            let state = rng.random_range(0..model.num_states() as u32);
            let target =
                Vec3::new(rng.random_range(-0.8..0.8), rng.random_range(0.0..0.75), rng.random_range(-0.8..0.8));
            let n = table.action_scores(state, target, &mut scores).expect("a state that exists");
            for (&segment, got) in naive.segments_of(state as usize).iter().zip(&scores[..n]) {
                let wanted = score(&naive, &dodge, segment as usize, target.as_dvec3(), &exact);
                assert!((f64::from(*got) - wanted).abs() < 2e-4, "{target}: {got} {wanted}");
            }
        }
    }
}
