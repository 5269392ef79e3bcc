//! Promised and collected rewards of a policy: values are interpolated between cells, and may promise more than any
//! action gives.

use super::{PolicySituation, collect_rewards, random_target};
use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use throng_base::maths::quantile;
use throng_core::policy::{KERNEL_EXPONENTIAL, MAX_ACTIONS, PolicyTable};

/// Number of roll-outs of a policy.
const ROLLOUTS: usize = 800;
/// Discount below which further rewards are ignored.
const NEGLIGIBLE: f64 = 1e-3;
/// Share of the greatest promise below which one is too small for a ratio.
const LEAST_SHARE: f64 = 0.05;
/// Fewest roll-outs of a part of the grid.
const LEAST_ROLLOUTS: usize = 20;
/// Least kept share of a trusted policy.
pub const ENOUGH_KEPT: f64 = 0.8;
/// Kept share at the 5th percentile of single roll-outs below which a verdict reports that next to nothing is kept.
pub const LEAST_KEPT: f64 = 0.1;
/// Number of parts of the grid's distances.
const RINGS: usize = 3;

/// Ratio of the reward that a greedy policy collects from random states and targets to the promised value there.
///
/// For negative values, which are to be avoided, it is the ratio of the promised to the real loss. Ratios are of sums,
/// so that no small promise counts for much; the percentile is of single roll-outs.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Promise {
    /// Number of roll-outs with a promise that is not negligible.
    pub rollouts: usize,
    /// Kept share of all promises; `None` without promises.
    pub kept: Option<f64>,
    /// 5th percentile of the kept share of a roll-out; `None` without promises.
    pub kept_p05: Option<f64>,
    /// Kept shares by distance and direction of the target at the start; parts with few roll-outs are left out.
    pub parts: Vec<PromisePart>,
    /// Warning about a kept share too low to be trusted: what, where, and what to change.
    pub warning: Option<String>,
}

/// Kept share for targets in one part of the grid.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct PromisePart {
    /// Range of the targets' distances (m).
    pub distance_m: [f64; 2],
    /// `ahead`, `left`, `right` or `behind`.
    pub direction: String,
    /// Roll-outs.
    pub rollouts: usize,
    /// See [`Promise::kept`].
    pub kept: f64,
    /// See [`Promise::kept_p05`].
    pub kept_p05: f64,
}

/// One roll-out.
#[derive(Clone, Copy)]
struct Rollout {
    ring: usize,
    direction: usize,
    promised: f64,
    realised: f64,
}

const DIRECTIONS: [&str; 4] = ["ahead", "left", "behind", "right"];

/// Rolls a greedy policy out in the exact model. Deterministic for a given table.
///
/// - `name`: of the policy, for the warning.
pub fn promise(table: &PolicyTable, name: &str) -> Promise {
    let mut rng = Pcg64::seed_from_u64(1);
    let num_states = table.actions().num_states() as u32;
    let starts: Vec<PolicySituation> = (0..ROLLOUTS)
        .map(|_| PolicySituation { state: rng.random_range(0..num_states), target: random_target(table, &mut rng) })
        .collect();
    let realised = collect_rewards(table, &starts, NEGLIGIBLE, |_, ranked| ranked.best());
    let rollout = |(s, realised): (&PolicySituation, f64)| {
        let [ring, direction] = grid_part_of(table, s.target);
        Rollout { ring, direction, promised: promised_rewards(table, *s), realised }
    };
    let mut rollouts: Vec<Rollout> = starts.iter().zip(realised).map(rollout).collect();
    let greatest = rollouts.iter().map(|r| r.promised.abs()).fold(0.0, f64::max);
    rollouts.retain(|r| r.promised.abs() > LEAST_SHARE * greatest);
    let [first, last] = [table.grid().record().ring_start, table.grid().radius()].map(f64::from);
    let edge = |ring: usize| first + (last - first) * ring as f64 / RINGS as f64;
    let mut parts = Vec::new();
    for ring in 0..RINGS {
        for (direction, name) in DIRECTIONS.iter().enumerate() {
            let of: Vec<Rollout> =
                rollouts.iter().filter(|r| (r.ring, r.direction) == (ring, direction)).copied().collect();
            if let (Some((kept, kept_p05)), true) = (kept_share(&of), of.len() >= LEAST_ROLLOUTS) {
                let (distance_m, direction) = ([edge(ring), edge(ring + 1)], (*name).to_owned());
                parts.push(PromisePart { distance_m, direction, rollouts: of.len(), kept, kept_p05 });
            }
        }
    }
    let (kept, kept_p05) = kept_share(&rollouts).unzip();
    let promise = Promise { rollouts: rollouts.len(), kept, kept_p05, parts, warning: None };
    Promise { warning: promise.warning(name, table), ..promise }
}

/// Value of the best action, as in the runtime.
fn promised_rewards(table: &PolicyTable, from: PolicySituation) -> f64 {
    let mut scores = [0.0; MAX_ACTIONS];
    let n = table.action_scores(from.state, from.target, &mut scores);
    let n = n.unwrap_or_else(|e| unreachable!("the state exists and the target is finite: {e}"));
    scores[..n].iter().copied().fold(f32::NEG_INFINITY, f32::max).into()
}

/// Part of the grid with a target: ring and direction.
fn grid_part_of(table: &PolicyTable, target: Vec3) -> [usize; 2] {
    let place = target - table.centre();
    let (first, last) = (table.grid().record().ring_start, table.grid().radius());
    let share = (place.x.hypot(place.z) - first) / (last - first).max(1e-6);
    let quarter = (place.x.atan2(place.z) / std::f32::consts::FRAC_PI_2).round() as i32;
    let ring = ((share * RINGS as f32) as usize).min(RINGS - 1);
    [ring, quarter.rem_euclid(4) as usize]
}

/// Kept share of the sum of promises, and the 5th percentile of single roll-outs; `None` without roll-outs.
fn kept_share(rollouts: &[Rollout]) -> Option<(f64, f64)> {
    /// Largest kept share that counts, as excess in one roll-out does not make up for losses in others.
    const MOST: f64 = 10.0;
    let ratio = |promised: f64, realised: f64| {
        let ratio = if promised > 0.0 { realised / promised } else { promised / realised.min(-1e-9) };
        ratio.clamp(-MOST, MOST)
    };
    let [promised, realised] =
        [|r: &Rollout| r.promised, |r: &Rollout| r.realised].map(|of| rollouts.iter().map(of).sum::<f64>());
    let p05 = quantile(rollouts.iter().map(|r| ratio(r.promised, r.realised)), [1, 20])?;
    Some((ratio(promised, realised), p05))
}

impl Promise {
    fn warning(&self, name: &str, table: &PolicyTable) -> Option<String> {
        let kept = self.kept.filter(|&kept| kept < ENOUGH_KEPT)?;
        let worst = self.parts.iter().min_by(|a, b| a.kept.total_cmp(&b.kept));
        let at = worst.map_or(String::new(), |p| {
            let [from, to] = p.distance_m;
            format!(", least for targets {from:.1} to {to:.1} m away, {}: {:.0} %", p.direction, 100.0 * p.kept)
        });
        Some(format!(
            "policy \"{name}\": what it collects is {:.0} % of what its values promise{at}; {}",
            100.0 * kept,
            help(table)
        ))
    }
}

/// Advice for a policy that keeps more of its promises: the widest step between cells, compared with the width of the
/// reward, shows what to refine.
pub fn help(table: &PolicyTable) -> String {
    let (r, reward) = (table.grid().record(), table.reward().record());
    let rings = table.grid().radius() - r.ring_start;
    let middle = r.ring_start + 0.5 * rings;
    let steps = [
        ("rings", rings / (r.num_rings.max(2) - 1) as f32),
        ("angles", r.angle_spacing * middle),
        ("heights", if r.num_heights > 1 && !table.grid().is_space_time() { r.height_spacing } else { 0.0 }),
    ];
    let (axis, step) = steps.into_iter().fold(("", 0.0), |widest, s| if s.1 > widest.1 { s } else { widest });
    if step > reward.scale {
        let kernel = if reward.kernel == KERNEL_EXPONENTIAL { "" } else { ", or `kernel = \"linear\"`" };
        return format!(
            "its cells are {step:.2} m apart where a reward reaches {:.2} m: set more `grid.{axis}`, a larger `scale`{kernel}",
            reward.scale
        );
    }
    "few actions lead near enough to such targets: add motion of the kind, or make the grid smaller".into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::config::{GridConfig, PolicyBehaviourConfig};
    use crate::policy::made_up::SyntheticProblem;

    fn of(small: &SyntheticProblem, edit: impl FnOnce(&mut PolicyBehaviourConfig)) -> Promise {
        let mut config = PolicyBehaviourConfig::default();
        config.grid = GridConfig { rings: Some(small.rings), angles: Some(small.angles), ..config.grid };
        edit(&mut config);
        let behaviour = crate::policy::Approach::new(&config, 30.0, None).expect("a valid behaviour");
        promise(&small.solve_timed(&behaviour), "approach")
    }

    #[test]
    fn fine_grids_keep_what_they_promise_and_coarse_ones_are_told() {
        let fine = SyntheticProblem { states: 6, actions: 5, rings: 40, angles: 48, seed: 4 };
        let promise = of(&fine, |_| {});
        let kept = promise.kept.expect("something is promised");
        assert!((0.95..1.05).contains(&kept) && promise.warning.is_none(), "{promise:?}");
        assert!(promise.parts.len() >= 8 && promise.rollouts > 400, "{promise:?}");
        // Rewards within 0.2 m on cells that are metres apart: interpolation promises what is not there.
        let coarse = SyntheticProblem { rings: 4, angles: 5, ..fine };
        let promise = of(&coarse, |c| {
            c.scale = Some(0.2);
            c.reward = Some(crate::policy::RewardForm::Max);
        });
        let text = promise.warning.as_deref().expect("little is kept");
        assert!(promise.kept.is_some_and(|k| k < ENOUGH_KEPT) && text.contains("grid."), "{promise:?}");
    }

    #[test]
    fn losses_are_kept_where_no_more_is_lost() {
        let rollout = |promised, realised| Rollout { ring: 0, direction: 0, promised, realised };
        let many = |r: Rollout| vec![r; 40];
        assert_eq!(kept_share(&many(rollout(-0.5, -0.5))), Some((1.0, 1.0)));
        let (more, _) = kept_share(&many(rollout(-0.5, -1.0))).unwrap();
        assert!((more - 0.5).abs() < 1e-9);
        let (less, _) = kept_share(&many(rollout(2.0, 1.0))).unwrap();
        assert!((less - 0.5).abs() < 1e-9);
        assert_eq!(kept_share(&[]), None);
        let mut mixed = many(rollout(1.0, 1.0));
        mixed[7].realised = 0.2;
        mixed[8].realised = 0.2;
        mixed[9].realised = 0.2;
        assert_eq!(kept_share(&mixed).map(|(_, p05)| p05), Some(0.2));
    }

    #[test]
    fn directions_are_quarters() {
        let small = SyntheticProblem { states: 3, actions: 2, rings: 4, angles: 5, seed: 1 };
        let table = small.solve_timed(&small.behaviour().expect("a valid grid"));
        let direction = |x: f32, z: f32| DIRECTIONS[grid_part_of(&table, Vec3::new(x, 0.0, z))[1]];
        assert_eq!(direction(0.1, 1.0), "ahead");
        assert_eq!(direction(1.0, 0.1), "left");
        assert_eq!(direction(0.1, -1.0), "behind");
        assert_eq!(direction(-0.1, -1.0), "behind");
        assert_eq!(direction(-1.0, -0.1), "right");
    }
}
