//! Models, behaviours and the naive reference that the policy tests share.

use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use throng_core::Planar;
use throng_core::base::SingleRank;
use throng_core::policy::{COMBINE_MAX, KERNEL_LINEAR, KERNEL_WITHIN, Reward, RewardRecord, SegmentRecord, TargetGrid};
use throng_precompute::policy::{
    ActionModel, Approach, BehaviourSpec, CostsConfig, GridConfig, PolicyBehaviour, PolicyBehaviourConfig,
    PolicyConfig, PolicySolver, PolicyTables, RewardForm, SegmentMotion, segment_records,
};
use throng_precompute::progress::Silent;

/// A second behaviour: an impulsive hit (Lee and Lee 2004, equations 2 and 6) on a grid of angle, distance and height.
pub struct Hit {
    pub discount: f64,
    /// Segment, frame, place and force of each blow.
    pub blows: Vec<(usize, u32, Vec3, f64)>,
    pub radius: f32,
    /// Of its reward (1/rad).
    pub transition_cost: f32,
}

impl PolicyBehaviour for Hit {
    fn spec(&self) -> BehaviourSpec<'_> {
        let grid = TargetGrid::cylinder([5, 4, 3], Vec3::new(-1.0, 0.4, 1.2), Vec3::new(1.0, 1.3, 1.6), 0.1);
        let record = RewardRecord::new(COMBINE_MAX, KERNEL_WITHIN, self.radius);
        let reward = Reward::new(RewardRecord { transition_cost: self.transition_cost, ..record });
        BehaviourSpec::new("hit", grid.expect("a valid grid"), reward.expect("a valid reward"), self.discount)
    }

    fn sample(&self, segment: usize, _: &SegmentMotion, record: &mut SegmentRecord) {
        for (k, (_, frame, place, force)) in self.blows.iter().filter(|b| b.0 == segment).take(2).enumerate() {
            (record.inner[2 * k], record.inner[2 * k + 1], record.heights[k]) = (place.x, place.z, place.y);
            record.weights[1 + k] = (self.discount.powi(*frame as i32) * force) as f32;
        }
    }
}

pub fn segment(end: u32, num_frames: u32, displacement: Planar) -> SegmentMotion {
    let d = displacement;
    let ratios = (0..=num_frames).map(|f| f as f32 / num_frames as f32);
    let path = ratios.map(|t| Planar::new(t * d.x, t * d.z, t * d.heading)).collect();
    SegmentMotion { end, num_frames, displacement, path }
}

/// Of a state's actions the first goes on in its clip; the others are transitions, ever farther.
pub fn model(offsets: &[u32], actions: &[u32], segments: Vec<SegmentMotion>) -> ActionModel {
    let errors = offsets.windows(2).flat_map(|w| (0..w[1].saturating_sub(w[0])).map(|a| 0.15 * a as f32));
    ActionModel {
        rate_hz: 30.0,
        action_offsets: offsets.to_vec(),
        action_segments: actions.to_vec(),
        action_errors: errors.collect(),
        action_traits: Vec::new(),
        segments,
    }
}

/// Few states with several actions each, some of which share segments.
pub fn random_model(rng: &mut Pcg64, num_states: u32) -> ActionModel {
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
    let action_traits = actions.iter().map(|_| std::array::from_fn(|_| rng.random_range(0.0..0.4))).collect();
    ActionModel { action_traits, ..model(&offsets, &actions, segments) }
}

/// Costs in the order of traits (s).
const COSTS: [f64; 8] = [2.0, 0.7, 0.4, 0.9, 1.5, 0.3, 0.6, 1.1];

pub fn approach(rings: u32, angles: u32, reward: RewardForm, discount: f64) -> Approach {
    let reward = Some(reward);
    let grid = GridConfig::polar(rings, angles, 3.0, 0.4, 1.0);
    let [backwards, sideways, gesture, carrying, manner_change_s, standing_change_s, made, running] = COSTS;
    let costs =
        CostsConfig { backwards, sideways, gesture, carrying, manner_change_s, standing_change_s, made, running };
    let config = PolicyBehaviourConfig {
        grid,
        reward,
        discount: Some(discount),
        transition_cost_s: Some(3.0),
        costs: Some(costs),
        ..PolicyBehaviourConfig::default()
    };
    Approach::new(&config, 30.0, None).expect("valid")
}

/// The backup in f64, written down again from the definitions and sharing no code with the solver.
pub struct Naive<'a> {
    pub model: &'a ActionModel,
    pub grid: TargetGrid,
    pub reward: RewardRecord,
    pub records: Vec<SegmentRecord>,
    pub discount: f64,
    /// Logarithm of what is lost with an action, for its transition and its traits (num_actions).
    costs: Vec<f64>,
}

impl<'a> Naive<'a> {
    pub fn new(model: &'a ActionModel, behaviour: &dyn PolicyBehaviour) -> Self {
        let records = segment_records(behaviour, &model.segments);
        let (grid, reward) = (behaviour.spec().grid, *behaviour.spec().reward.record());
        let discount = behaviour.spec().discount;
        // Only behaviours of `approach` have costs beside those of transitions.
        let cost = |a: usize| {
            let traits = model.action_traits.get(a).copied().unwrap_or_default();
            let delay_s: f64 = traits.iter().zip(COSTS).map(|(t, c)| f64::from(*t) * c).sum();
            let delay_s = if reward.own_errors == 0 { 0.0 } else { delay_s };
            f64::from(reward.transition_cost) * f64::from(model.action_errors[a]).powi(2)
                - 30.0 * discount.ln() * delay_s
        };
        let costs = (0..model.action_errors.len()).map(cost).collect();
        Self { model, grid, reward, records, discount, costs }
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
            let ratio = (d - f64::from(self.reward.offset)).abs() / f64::from(self.reward.scale);
            let kernel = match self.reward.kernel {
                KERNEL_WITHIN => f64::from(ratio <= 1.0),
                KERNEL_LINEAR => (1.0 - ratio).max(0.0),
                _ => (-ratio).exp(),
            };
            f64::from(w) * kernel
        });
        let together = if self.reward.combine == COMBINE_MAX { terms.fold(0.0, f64::max) } else { terms.sum() };
        f64::from(self.reward.gain) * together
    }

    /// Cells of one height and their weights.
    pub fn weights(&self, x: f64, z: f64) -> Vec<(usize, f64)> {
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

    /// Turn by which a segment is bent towards a target that is seen so from its end (rad).
    fn bend(&self, record: &SegmentRecord, [x, z]: [f64; 2]) -> f64 {
        if !self.grid.is_polar() {
            return 0.0;
        }
        let [most, per_m] = record.heights.map(f64::from);
        let most = (most * (x.hypot(z) * per_m - 1.0).clamp(0.0, 1.0)).atan();
        // Nearly straight ahead is straight.
        let aside = x / z.max(x.abs());
        (aside - aside.clamp(-0.03, 0.03)).atan().clamp(-most, most)
    }

    /// Score of an action, given what a (state, cell) is worth.
    fn score(&self, action: usize, cell: usize, value: &mut dyn FnMut(u32, usize) -> f64) -> f64 {
        let segment = self.model.action_segments[action] as usize;
        let c = self.grid.cell_coordinates(cell).as_dvec3();
        let target = [c.y * c.x.sin(), if self.grid.is_polar() { 0.0 } else { c.z }, c.y * c.x.cos()];
        let d = self.model.segments[segment].displacement;
        let (heading, record) = (f64::from(d.heading), &self.records[segment]);
        let seen_turned = |[x, z]: [f64; 2], by: f64| {
            let (sin, cos) = by.sin_cos();
            [cos * x - sin * z, sin * x + cos * z]
        };
        let seen_at_end = |x: f64, z: f64| seen_turned([x - f64::from(d.x), z - f64::from(d.z)], heading);
        // Bent so that it ends facing the target, within its limit: half of the turn at the start, half at the end.
        let half = 0.5 * self.bend(record, seen_at_end(target[0], target[2]));
        let [x, z] = seen_turned([target[0], target[2]], half);
        let target = [x, target[1], z];
        let plane = self.grid.num_plane_cells();
        let height = cell / plane * plane;
        let [x, z] = seen_turned(seen_at_end(x, z), half);
        let next = self.weights(x, z);
        let next: f64 = next.iter().map(|&(c, w)| w * value(self.model.segments[segment].end, height + c)).sum();
        let discount = self.discount.powi(self.model.segments[segment].num_frames as i32);
        (-self.costs[action]).exp() * (self.reward(record, target) + discount * next)
    }

    pub fn segments_of(&self, state: usize) -> &[u32] {
        &self.model.action_segments[self.actions_of(state)]
    }

    /// Indices of a state's actions.
    pub fn actions_of(&self, state: usize) -> std::ops::Range<usize> {
        let o = &self.model.action_offsets;
        o[state] as usize..o[state + 1] as usize
    }

    pub fn best(&self, state: usize, cell: usize, value: &mut dyn FnMut(u32, usize) -> f64) -> f64 {
        self.actions_of(state).map(|a| self.score(a, cell, value)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Optimal values, by Bellman's iteration to 1e-9.
    pub fn solve(&self) -> Vec<f64> {
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
    pub fn search(&self, state: usize, cell: usize, depth: u32) -> f64 {
        if depth == 0 {
            return 0.0;
        }
        self.best(state, cell, &mut |s, c| self.search(s as usize, c, depth - 1))
    }
}

pub fn solved(model: &ActionModel, behaviour: &dyn PolicyBehaviour, cfg: &PolicyConfig) -> PolicyTables {
    PolicySolver { model, cfg, progress: &Silent, comm: &SingleRank }
        .solve_all(&[behaviour], &mut Pcg64::seed_from_u64(3))
        .expect("it converges")
}

/// Angles of reward and geometry are within 4e-6 rad, exponentials within 1e-5: what that makes of values.
pub const ARITHMETIC: f64 = 2e-5;

pub fn largest_error(model: &ActionModel, behaviour: &dyn PolicyBehaviour, cfg: &PolicyConfig) -> f64 {
    let tables = solved(model, behaviour, cfg);
    let exact = Naive::new(model, behaviour).solve();
    let errors = exact.iter().zip(&tables.policies[0].values).map(|(a, &b)| (a - f64::from(b)).abs());
    errors.fold(0.0, f64::max)
}
