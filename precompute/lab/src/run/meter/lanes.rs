//! Measures how far agents sort themselves into lanes by direction.

use glam::Vec2;
use throng_simulation::scene::LanesConfig;

/// Least number of others in an agent's band for it to count.
const MIN_NEIGHBOURS: usize = 2;

/// The order of lanes over time.
#[derive(Clone, Debug)]
pub struct LaneMeter {
    along: Vec2,
    width_m: f32,
    reach_m: f32,
    /// Time and order of each sample (s, 0 to 1).
    pub order: Vec<(f64, f64)>,
}

impl LaneMeter {
    /// A meter without samples.
    pub fn new(config: &LanesConfig) -> Self {
        let along = Vec2::from(config.along);
        // Also for lengths whose squares overflow.
        let along = along.try_normalize().unwrap_or_else(|| (along / along.abs().max_element()).normalize());
        Self { along, width_m: config.width_m, reach_m: config.reach_m, order: Vec::new() }
    }

    /// Observes all agents; nothing is added unless the groups overlap.
    ///
    /// - `agents`: position (m), and whether the agent goes along the corridor rather than against it.
    pub fn observe(&mut self, time_s: f64, agents: &[(Vec2, bool)]) {
        self.order.extend(lane_order(agents, self.along, self.width_m, self.reach_m).map(|order| (time_s, order)));
    }

    /// Mean order over the last quarter of the samples: 0 as mixed as by chance, 1 all agents in lanes.
    pub fn final_order(&self) -> Option<f64> {
        let last = &self.order[self.order.len() - self.order.len().div_ceil(4)..];
        (!last.is_empty()).then(|| last.iter().map(|o| o.1).sum::<f64>() / last.len() as f64)
    }
}

/// Order of lanes: the squared difference of the shares of both directions in an agent's band (the order parameter of Rex and
/// Loewen 2007, as Nowak and Schadschneider 2012 use it for pedestrians), mean over agents, beside what chance gives in bands
/// as full: 0 for a mixture, 1 for lanes. Only agents where the groups overlap count. `None` where they do not.
fn lane_order(agents: &[(Vec2, bool)], along: Vec2, width_m: f32, reach_m: f32) -> Option<f64> {
    let across = along.perp();
    let at: Vec<(f32, f32, bool)> = agents.iter().map(|(p, f)| (p.dot(along), p.dot(across), *f)).collect();
    let (low, high) = overlap_range(&at)?;
    let mut inside: Vec<_> = at.into_iter().filter(|m| (low..=high).contains(&m.0)).collect();
    inside.sort_by(|a, b| a.0.total_cmp(&b.0));
    let with = inside.iter().filter(|m| m.2).count() as f64 / inside.len().max(1) as f64;
    let (mut order, mut chance, mut num) = (0.0, 0.0, 0usize);
    for (i, m) in inside.iter().enumerate() {
        let near = |o: &&(f32, f32, bool)| (o.1 - m.1).abs() <= 0.5 * width_m;
        let before = inside[..i].iter().rev().take_while(|o| m.0 - o.0 <= reach_m).filter(near);
        let behind = inside[i + 1..].iter().take_while(|o| o.0 - m.0 <= reach_m).filter(near);
        let (mut same, mut all) = (0usize, 0usize);
        before.chain(behind).for_each(|o| {
            same += usize::from(o.2);
            all += 1;
        });
        if all >= MIN_NEIGHBOURS {
            let n = all as f64;
            order += ((2.0 * same as f64 - n) / n).powi(2);
            chance += 4.0 * with * (1.0 - with) / n + (1.0 - 2.0 * with).powi(2);
            num += 1;
        }
    }
    let (order, chance) = (order / num.max(1) as f64, chance / num.max(1) as f64);
    (num >= 20 && chance < 0.9).then(|| (order - chance) / (1.0 - chance))
}

/// Range along the corridor in which the groups overlap, without their foremost and hindmost twentieths.
fn overlap_range(at: &[(f32, f32, bool)]) -> Option<(f32, f32)> {
    let range = |which: bool| {
        let mut all: Vec<f32> = at.iter().filter(|m| m.2 == which).map(|m| m.0).collect();
        all.sort_by(f32::total_cmp);
        let twentieth = all.len() / 20;
        Some((*all.get(twentieth)?, *all.get(all.len().checked_sub(twentieth + 1)?)?))
    };
    let (a, b) = (range(true)?, range(false)?);
    let (low, high) = (a.0.max(b.0), a.1.min(b.1));
    (low < high).then_some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Agents on a field of 40 x 8 m whose direction is chosen by `choose`.
    fn field(choose: impl Fn(Vec2, &mut Pcg64Mcg) -> bool) -> Vec<(Vec2, bool)> {
        let mut rng = Pcg64Mcg::seed_from_u64(5);
        (0..600)
            .map(|_| {
                let at = Vec2::new(rng.random_range(0.0..8.0), rng.random_range(0.0..40.0));
                (at, choose(at, &mut rng))
            })
            .collect()
    }

    fn order(agents: &[(Vec2, bool)]) -> Option<f64> {
        lane_order(agents, Vec2::Y, 1.0, 5.0)
    }

    #[test]
    fn chance_is_no_order_and_lanes_are_order() {
        let mixed = order(&field(|_, rng| rng.random_range(0.0..1.0) < 0.5)).unwrap();
        assert!(mixed.abs() < 0.05, "{mixed}");
        let uneven = order(&field(|_, rng| rng.random_range(0.0..1.0) < 0.7)).unwrap();
        assert!(uneven.abs() < 0.05, "{uneven}");
        let two = order(&field(|at, _| at.x < 4.0)).unwrap();
        assert!(two > 0.9, "{two}");
        let four = order(&field(|at, _| (at.x / 2.0) as i32 % 2 == 0)).unwrap();
        assert!(four > 0.7 && four < two, "{four}");
    }

    #[test]
    fn a_direction_may_have_any_length() {
        for length in [1e-40, 1e-30, 1.0, 1e30] {
            let meter = LaneMeter::new(&LanesConfig { along: [0.0, length], width_m: 1.0, reach_m: 5.0 });
            assert_eq!(meter.along, Vec2::Y, "{length}");
        }
    }

    #[test]
    fn groups_that_have_not_met_have_no_order() {
        assert_eq!(order(&field(|at, _| at.y < 20.0)), None);
        assert_eq!(order(&[]), None);
    }
}
