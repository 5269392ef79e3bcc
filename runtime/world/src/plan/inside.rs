//! Costs within the target's cluster to reach the target: Dijkstra backwards, only as far as needed.

use crate::{WorldGraph, path_hierarchy::PathHierarchy, queue::Buckets};

/// Costs of the cells of one cluster; memory of the search for them. Its states are those that the costs_in's links lead
/// back to, see `ClusterCosts::arcs_into`.
#[derive(Clone, Debug)]
pub(super) struct ClusterSearch {
    cluster: u32,
    /// (frames, states of the largest cluster)
    costs: Vec<u32>,
    /// Search that each of `costs` is from, an even number, and 1 more where the state was opened.
    stamps: Vec<u32>,
    stamp: u32,
    queue: Buckets,
}

impl ClusterSearch {
    /// Memory for the clusters of a world.
    pub fn new(graph: &WorldGraph, hierarchy: &PathHierarchy) -> Self {
        let num_states =
            (0..hierarchy.num_clusters() as u32).map(|d| hierarchy.costs_in(d).num_states()).max().unwrap_or(0);
        let queue = Buckets::new(num_states, graph.max_link_frames());
        Self { cluster: 0, costs: vec![0; num_states], stamps: vec![0; num_states], stamp: 0, queue }
    }

    /// Begins a search from cells of a cluster, by their numbers there.
    pub fn begin(&mut self, cluster: u32, targets: impl Iterator<Item = u32>) {
        self.stamp = self.stamp.wrapping_add(2);
        if self.stamp == 0 {
            self.stamps.fill(0);
            self.stamp = 2;
        }
        self.cluster = cluster;
        self.queue.clear();
        targets.for_each(|cell| self.reach_state(cell, 0));
    }

    /// Cost from a state of the cluster, without leaving it; infinite where no path leads on (frames).
    pub fn cost(&mut self, hierarchy: &PathHierarchy, state: u32) -> f32 {
        let costs_in = hierarchy.costs_in(self.cluster);
        while self.stamps[state as usize] != self.stamp + 1 {
            let Some((cost, next)) = self.queue.pop() else { return f32::INFINITY };
            self.stamps[next as usize] = self.stamp + 1;
            for &(from, frames) in costs_in.arcs_into(next) {
                self.reach_state(from, cost + u32::from(frames));
            }
        }
        self.costs[state as usize] as f32
    }

    /// Cost from an entrance of the cluster. The additional costs of its cells may be negative (frames).
    pub fn cost_from(&mut self, hierarchy: &PathHierarchy, entrance: u32) -> f32 {
        let starts = &hierarchy.costs_in(self.cluster).starts[entrance as usize];
        starts.iter().map(|&(state, part)| self.cost(hierarchy, state) - f32::from(part)).fold(f32::INFINITY, f32::min)
    }

    fn reach_state(&mut self, state: u32, cost: u32) {
        let s = state as usize;
        if self.stamps[s] & !1 != self.stamp || cost < self.costs[s] {
            self.stamps[s] = self.stamp;
            self.costs[s] = cost;
            self.queue.push(state, cost);
        }
    }
}
