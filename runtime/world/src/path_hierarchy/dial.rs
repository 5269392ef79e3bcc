//! Searches over whole frames: arcs by where they begin, and Dijkstra with buckets in place of a heap (Dial 1969).

use crate::queue::Buckets;
use serde::{Deserialize, Serialize};

/// Marks a state that no path reaches.
pub(super) const UNREACHED: u16 = u16::MAX;
/// Largest cost that is stored; longer ones count as this, which is still a lower bound (frames).
const LONGEST: u32 = UNREACHED as u32 - 1;

/// Frames of a cost.
pub(super) fn frames(cost: u16) -> f32 {
    if cost == UNREACHED { f32::INFINITY } else { f32::from(cost) }
}

/// Whole frames, as few as there are at least.
pub(super) fn whole(cost: f32) -> u16 {
    if cost == f32::INFINITY { UNREACHED } else { cost.floor().clamp(0.0, f32::from(UNREACHED) - 1.0) as u16 }
}

/// Arcs of a graph, sorted by where they begin: where each leads, and its frames.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Arcs<T> {
    #[serde(with = "crate::pod")]
    first: Vec<u32>,
    list: Vec<(T, u16)>,
}

impl<T: Copy> Arcs<T> {
    /// Sorts arcs; they keep their order otherwise (each begins below `num_nodes`).
    pub fn new(num_nodes: usize, arcs: impl Iterator<Item = (u32, T, u16)>) -> Self {
        let mut list: Vec<(u32, T, u16)> = arcs.collect();
        list.sort_by_key(|a| a.0);
        let mut first = vec![0u32; num_nodes + 1];
        list.iter().for_each(|a| first[a.0 as usize + 1] += 1);
        for n in 0..num_nodes {
            first[n + 1] += first[n];
        }
        Self { first, list: list.into_iter().map(|(_, to, frames)| (to, frames)).collect() }
    }

    /// Number of nodes.
    pub fn num_nodes(&self) -> usize {
        self.first.len().saturating_sub(1)
    }

    /// True where every arc of a file can be followed: to nodes that exist, in no more frames than `longest`.
    pub fn is_sound(&self, node: impl Fn(&T) -> u32, longest: u32) -> bool {
        let ascends = self.first.windows(2).all(|w| w[0] <= w[1]);
        let ends = self.first.last().is_none_or(|&end| end as usize == self.list.len()) && !self.first.is_empty();
        let exists = |(to, frames): &(T, u16)| (node(to) as usize) < self.num_nodes() && u32::from(*frames) <= longest;
        ascends && ends && self.list.iter().all(exists)
    }

    /// Arcs that begin at a node.
    pub fn arcs_from(&self, node: u32) -> &[(T, u16)] {
        &self.list[self.first[node as usize] as usize..self.first[node as usize + 1] as usize]
    }
}

/// Memory of searches.
#[derive(Debug)]
pub(crate) struct Dial {
    costs: Vec<u32>,
    /// States by cost.
    queue: Buckets,
    /// Cost of the state that is visited.
    cost: u32,
}

impl Default for Dial {
    fn default() -> Self {
        Self { costs: Vec::new(), queue: Buckets::new(0, LONGEST), cost: 0 }
    }
}

impl Dial {
    /// Least costs from any of the sources, which have costs of their own, to all states. `visit` calls
    /// [`Dial::reach_state`] for every state that the given one leads to.
    pub fn run(&mut self, n: usize, sources: impl Iterator<Item = (u32, u16)>, mut visit: impl FnMut(&mut Self, u32)) {
        self.costs.clear();
        self.costs.resize(n, u32::MAX);
        self.queue.clear();
        self.queue.grow(n);
        self.cost = 0;
        for (state, cost) in sources {
            self.reach_state(state, cost);
        }
        while let Some((cost, state)) = self.queue.pop() {
            self.cost = cost;
            visit(self, state);
        }
    }

    /// Notes an arc of so many frames from the visited state to another one.
    pub fn reach_state(&mut self, to: u32, frames: u16) {
        let total = (self.cost + u32::from(frames)).min(LONGEST);
        if total < self.costs[to as usize] {
            self.costs[to as usize] = total;
            self.queue.push(to, total);
        }
    }

    /// Cost of a state after the last search; the largest value stands for larger ones as well.
    pub fn cost(&self, state: u32) -> u16 {
        u16::try_from(self.costs[state as usize]).unwrap_or(UNREACHED)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_too_long_to_be_told_are_ways_still() {
        let mut search = Dial::default();
        // A chain of links, each of them 40000 frames.
        search.run(5, [(0, 0)].into_iter(), |search, at| {
            if at < 3 {
                search.reach_state(at + 1, 40_000);
            }
        });
        let costs: Vec<_> = (0..5).map(|s| search.cost(s)).collect();
        assert_eq!(costs, [0, 40_000, UNREACHED - 1, UNREACHED - 1, UNREACHED]);
    }
}
