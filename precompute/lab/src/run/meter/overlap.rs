//! Measures overlaps of agents.

use throng_crowd::{Obstacle, Space};
use throng_geometry::distance_to_segment;

/// Overlaps of pairs, counted over frames.
#[derive(Clone, Debug, Default)]
pub struct DiscOverlapMeter {
    /// Pairs that overlapped by more than 1 mm, over all frames.
    pub over_1mm: u64,
    /// Pairs that overlapped by more than 1 cm, over all frames.
    pub over_1cm: u64,
    /// Deepest overlap (m).
    pub max_m: f64,
    /// Sum of the numbers of agents over all frames.
    pub agent_frames: u64,
    cells: OverlapGrid,
}

/// Agents by cells of a grid over their first two coordinates; a cell holds those from its start to that of the next.
#[derive(Clone, Debug, Default)]
struct OverlapGrid {
    starts: Vec<u32>,
    agents: Vec<u32>,
}

impl DiscOverlapMeter {
    /// Observes one frame.
    ///
    /// - `places`: centres and radii of all agents that have not left (m).
    pub fn observe<V: Space>(&mut self, places: &[(V, f32)]) {
        self.agent_frames += places.len() as u64;
        let widest = places.iter().map(|p| p.1).fold(0.0, f32::max);
        let mut found = [0u64; 2];
        let mut deepest = self.max_m;
        self.cells.for_each_near(places, 2.0 * widest, |a, b| {
            // In f64, so that the difference of two near places is more exact than the least counted depth.
            let between = (a.0 - b.0).coordinates().map(f64::from);
            let apart = between.iter().map(|c| c * c).sum::<f64>().sqrt();
            let deep = f64::from(a.1) + f64::from(b.1) - apart;
            found[0] += u64::from(deep > 1e-3);
            found[1] += u64::from(deep > 1e-2);
            deepest = deepest.max(deep);
        });
        self.over_1mm += found[0];
        self.over_1cm += found[1];
        self.max_m = deepest;
    }

    /// Observes overlaps with obstacles, in the same frame.
    pub fn observe_solids<V: Space>(&mut self, places: &[(V, f32)], obstacles: &[Obstacle<V>]) {
        let all = places.iter().flat_map(|&(at, radius)| obstacles.iter().map(move |o| overlap_depth(at, radius, o)));
        for deep in all.filter(|d| *d > 0.0) {
            self.over_1mm += u64::from(deep > 1e-3);
            self.over_1cm += u64::from(deep > 1e-2);
            self.max_m = self.max_m.max(deep);
        }
    }
}

/// Depth of a disc or ball in a static obstacle; below zero outside (m).
fn overlap_depth<V: Space>(at: V, radius: f32, obstacle: &Obstacle<V>) -> f64 {
    let apart = match obstacle {
        &Obstacle::Ball { centre, radius } => (at - centre).length() - radius,
        &Obstacle::Wall { from, to, radius } => distance_to_segment(at, [from, to]) - radius,
        &Obstacle::Box { min, max } => (at - Space::min(Space::max(at, min), max)).length(),
        Obstacle::Polygon { corners } => {
            let next = corners.iter().cycle().skip(1);
            corners.iter().zip(next).map(|(&a, &b)| distance_to_segment(at, [a, b])).fold(f32::INFINITY, f32::min)
        }
        _ => f32::INFINITY,
    };
    f64::from(radius) - f64::from(apart)
}

impl OverlapGrid {
    /// Calls `f` once with every pair that may be nearer than `reach`.
    fn for_each_near<V: Space>(&mut self, places: &[(V, f32)], reach: f32, mut f: impl FnMut(&(V, f32), &(V, f32))) {
        let Some(first) = places.first() else { return };
        let wide = |(l, h): (V, V), p: &(V, f32)| (l.min(p.0), h.max(p.0));
        let (low, high) = places.iter().fold((first.0, first.0), wide);
        let (low, size) = (low.coordinates(), (high - low).coordinates());
        // No more cells than four times the agents, however far apart they are.
        let side = reach.max((size[0] * size[1] / (4.0 * places.len() as f32)).sqrt()).max(size[0].max(size[1]) / 4e4);
        let side = side.max(1e-3);
        let [nx, ny] = [0, 1].map(|i| (size[i] / side) as usize + 1);
        let cell = |p: &V| {
            let [x, y, _] = p.coordinates();
            let [i, j] = [(x - low[0], nx), (y - low[1], ny)].map(|(v, n)| ((v / side) as usize).min(n - 1));
            j * nx + i
        };
        self.sort_into_cells(places, nx * ny, cell);
        for j in 0..ny {
            for i in 0..nx {
                let here = self.agents_in_cell(j * nx + i);
                // This cell, the next one, and three of the next row: every pair of cells once.
                let next_row = (j + 1 < ny).then(|| (j + 1) * nx);
                let row = next_row.map(|r| self.agents_in_range(r + i.saturating_sub(1), r + (i + 1).min(nx - 1)));
                let beside = if i + 1 < nx { self.agents_in_cell(j * nx + i + 1) } else { &[] };
                for (k, &a) in here.iter().enumerate() {
                    for &b in here[k + 1..].iter().chain(beside).chain(row.unwrap_or_default()) {
                        f(&places[a as usize], &places[b as usize]);
                    }
                }
            }
        }
    }

    fn sort_into_cells<V: Space>(&mut self, places: &[(V, f32)], num: usize, cell: impl Fn(&V) -> usize) {
        self.starts.clear();
        self.starts.resize(num + 1, 0);
        self.agents.resize(places.len(), 0);
        places.iter().for_each(|p| self.starts[cell(&p.0) + 1] += 1);
        (0..num).for_each(|c| self.starts[c + 1] += self.starts[c]);
        let mut next = self.starts.clone();
        for (m, p) in places.iter().enumerate() {
            let at = &mut next[cell(&p.0)];
            self.agents[*at as usize] = m as u32;
            *at += 1;
        }
    }

    fn agents_in_cell(&self, cell: usize) -> &[u32] {
        self.agents_in_range(cell, cell)
    }

    fn agents_in_range(&self, first: usize, last: usize) -> &[u32] {
        &self.agents[self.starts[first] as usize..self.starts[last + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;

    fn brute<V: Space>(places: &[(V, f32)], more: f32) -> u64 {
        let pairs = (0..places.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let deep = |i: usize, j: usize| places[i].1 + places[j].1 - (places[i].0 - places[j].0).length();
        pairs.filter(|&(i, j)| deep(i, j) > more).count() as u64
    }

    proptest! {
        #[test]
        fn every_pair_counts_once(
            flat in prop::collection::vec(([-9.0f32..9.0, -3.0f32..3.0], 0.1f32..0.6), 0..120),
            high in prop::collection::vec(([-9.0f32..9.0, -3.0f32..3.0, -4.0f32..4.0], 0.1f32..0.6), 0..120),
        ) {
            let flat: Vec<(Vec2, f32)> = flat.into_iter().map(|(p, r)| (p.into(), r)).collect();
            let mut meter = DiscOverlapMeter::default();
            meter.observe(&flat);
            // A hair of difference between f32 and f64 decides few pairs.
            let (low, high_count) = (brute(&flat, 1e-3 + 1e-5), brute(&flat, 1e-3 - 1e-5));
            prop_assert!((low..=high_count).contains(&meter.over_1mm), "{} {low} {high_count}", meter.over_1mm);
            let high: Vec<(Vec3, f32)> = high.into_iter().map(|(p, r)| (p.into(), r)).collect();
            let mut meter = DiscOverlapMeter::default();
            meter.observe(&high);
            prop_assert!((brute(&high, 1e-2 + 1e-5)..=brute(&high, 1e-2 - 1e-5)).contains(&meter.over_1cm));
        }
    }

    #[test]
    fn depth_is_exact_far_from_the_origin_and_far_apart() {
        let mut meter = DiscOverlapMeter::default();
        let places = [[0.0, 0.0], [0.5, 0.0], [9e4, 9e4]].map(|p| (Vec2::from(p), 0.3));
        meter.observe(&places);
        meter.observe(&places[..1]);
        assert_eq!([meter.over_1mm, meter.over_1cm, meter.agent_frames], [1, 1, 4]);
        assert!((meter.max_m - 0.1).abs() < 1e-6, "{}", meter.max_m);
        meter.observe::<Vec2>(&[]);
    }
}
