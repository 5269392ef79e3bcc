//! What it costs within the target's district to come to the target: Dijkstra backwards, only as far as it is asked for.

use super::buckets::Buckets;
use crate::world::WorldGraph;
use crate::world::atlas::Atlas;

/// Costs of the cells of one district; memory of the search for them. Its states are those that the shape's links lead
/// back to, see `Shape::back`.
#[derive(Clone, Debug)]
pub(super) struct Inside {
    district: u32,
    /// [Unit: frames] [Size: states of the largest district]
    costs: Vec<u32>,
    /// What `costs` is of, an even number, and 1 more where a state was opened.
    stamps: Vec<u32>,
    stamp: u32,
    queue: Buckets,
}

impl Inside {
    /// Memory for the districts of a world.
    pub fn new(graph: &WorldGraph<'_>, atlas: &Atlas) -> Self {
        let num_states = (0..atlas.num_districts() as u32).map(|d| atlas.shape(d).num_states()).max().unwrap_or(0);
        let longest = graph.patches().links.iter().map(|l| u32::from(l.num_frames)).max().unwrap_or(0);
        Self {
            district: 0,
            costs: vec![0; num_states],
            stamps: vec![0; num_states],
            stamp: 0,
            queue: Buckets::new(num_states, longest),
        }
    }

    /// Begins a search from cells of a district, by their numbers there.
    pub fn begin(&mut self, district: u32, targets: impl Iterator<Item = u32>) {
        self.stamp = self.stamp.wrapping_add(2);
        if self.stamp == 0 {
            self.stamps.fill(0);
            self.stamp = 2;
        }
        self.district = district;
        self.queue.clear();
        targets.for_each(|cell| self.reach(cell, 0));
    }

    /// Cost from a state of the district, without leaving it; infinite where no way leads on. [Unit: frames]
    pub fn cost(&mut self, atlas: &Atlas, state: u32) -> f32 {
        let shape = atlas.shape(self.district);
        while self.stamps[state as usize] != self.stamp + 1 {
            let Some((cost, next)) = self.queue.pop() else { return f32::INFINITY };
            self.stamps[next as usize] = self.stamp + 1;
            for &(from, frames) in shape.back(next) {
                self.reach(from, cost + u32::from(frames));
            }
        }
        self.costs[state as usize] as f32
    }

    /// The same from a way into the district. What lies at its cells may be below 0. [Unit: frames]
    pub fn cost_from(&mut self, atlas: &Atlas, way_in: u32) -> f32 {
        let starts = atlas.shape(self.district).starts(way_in);
        starts.iter().map(|&(state, part)| self.cost(atlas, state) - f32::from(part)).fold(f32::INFINITY, f32::min)
    }

    fn reach(&mut self, state: u32, cost: u32) {
        let s = state as usize;
        if self.stamps[s] & !1 != self.stamp || cost < self.costs[s] {
            self.stamps[s] = self.stamp;
            self.costs[s] = cost;
            self.queue.push(state, cost);
        }
    }
}
