//! Upper layer: lower bounds of the cost to the target from every entrance into a part of the world and every exit.

#[cfg(test)]
mod tests;

use super::PlanTarget;
use super::next_entrances::{NextEntrance, NextEntrances};
use super::target_location::TargetLocation;
use crate::path_hierarchy::{CellCost, Entrance, Landmarks, PathHierarchy, ToLandmarks};
use crate::queue::Heap;
use crate::{WorldGraph, WorldNode};
use throng_core::patch::NONE;

/// Factor on the cost of the best path, and addition to it, up to which the search opens other paths (frames).
const BESIDE: f32 = 1.02;
const BESIDE_FRAMES: f32 = 30.0;
/// Costs that are compared at once.
const WIDE: usize = 32;
/// Marks an unknown cost.
const UNKNOWN: i32 = i32::MAX;

/// Memory of the upper layer, and what its last search found.
#[derive(Clone, Debug)]
pub(super) struct UpperSearch {
    /// Costs of the states (frames).
    costs: Vec<f32>,
    stamps: Vec<u32>,
    /// Costs of those that regions are entered by, in whole frames at least; beside each other, to be compared soon.
    known: Vec<i32>,
    heap: Heap,
    stamp: u32,
    /// Costs to landmarks from the start of the search's path.
    from: ToLandmarks,
    /// Opened paths on from a region: the first and the last, and the next of each.
    chains: Vec<[u32; 2]>,
    chain_stamps: Vec<u32>,
    next: Vec<u32>,
    next_stamps: Vec<u32>,
    /// Next entrances, by instance.
    next_entrances: Vec<NextEntrances>,
    end: TargetLocation,
    /// No path that the search left out costs less (frames).
    pub limit: f32,
    /// States opened.
    pub opened: usize,
}

impl UpperSearch {
    /// Memory for a world.
    pub fn new(graph: &WorldGraph, hierarchy: &PathHierarchy) -> Self {
        let num_states = hierarchy.entrances.len() + hierarchy.exits.len();
        let num_regions = hierarchy.floors.num_regions();
        Self {
            from: Landmarks::UNKNOWN_DISTANCES,
            costs: vec![0.0; num_states],
            stamps: vec![0; num_states],
            known: vec![UNKNOWN; hierarchy.region_costs.states.len()],
            heap: Heap::new(num_states),
            stamp: 0,
            chains: vec![[NONE; 2]; num_regions],
            chain_stamps: vec![0; num_regions],
            next: vec![NONE; hierarchy.entrances.len()],
            next_stamps: vec![0; hierarchy.entrances.len()],
            next_entrances: vec![NextEntrances::default(); graph.num_instances()],
            end: TargetLocation::new(graph, hierarchy),
            limit: 0.0,
            opened: 0,
        }
    }

    /// A* from the target backwards, until more paths would hardly improve the estimate from `from`, nor be part of any
    /// path that costs less than `most`.
    ///
    /// - returns false where no path leads from there to the target.
    pub fn run(&mut self, graph: &WorldGraph, target: PlanTarget, from: WorldNode, most: f32) -> bool {
        let hierarchy = graph.hierarchy();
        self.begin();
        self.meet_landmarks(hierarchy, from);
        if !self.end.locate_target(graph, hierarchy, target) {
            return false;
        }
        let mut least = self.end.cost(hierarchy, from);
        let limit = |least: f32| most.max(least * BESIDE + BESIDE_FRAMES);
        self.limit = limit(least);
        if let Some(cluster) = self.end.cluster {
            for (k, entrance) in hierarchy.entrances_of(cluster).enumerate() {
                self.reach(hierarchy, entrance, self.end.from_entrance[k]);
            }
        } else if let Some(region) = hierarchy.floors.region(self.end.instance) {
            self.reach_end(hierarchy, region);
        }
        while let Some((key, state)) = self.heap.pop() {
            self.limit = limit(least);
            if key > self.limit {
                return true;
            }
            let cost = self.costs[state as usize];
            self.opened += 1;
            match state.checked_sub(hierarchy.entrances.len() as u32) {
                None => self.open_entrance(hierarchy, state, cost),
                Some(out) => self.open_exit(hierarchy, out, cost),
            }
            least = least.min(self.cost_by(hierarchy, from, state, cost));
        }
        self.limit = f32::INFINITY;
        least < f32::INFINITY
    }

    /// Lower bound of the cost from a node to the target; infinite where no path is known (frames).
    pub fn estimate(&mut self, hierarchy: &PathHierarchy, node: WorldNode) -> f32 {
        let direct = self.end.cost(hierarchy, node);
        if let Some((cluster, first)) = hierarchy.cluster(node.instance) {
            return direct.min(self.through(hierarchy, cluster, first + node.cell)).max(0.0);
        }
        if self.next_entrances[node.instance as usize].stamp != self.stamp {
            self.find_next_entrances(hierarchy, node.instance);
        }
        let Some((_, plane)) = hierarchy.region_and_plane(node.instance) else { return f32::INFINITY };
        self.next_entrances[node.instance as usize].cost(plane, node.cell, direct)
    }

    fn begin(&mut self) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.stamps.fill(0);
            self.chain_stamps.fill(0);
            self.next_stamps.fill(0);
            self.next_entrances.fill(NextEntrances::default());
            self.stamp = 1;
        }
        self.known.fill(UNKNOWN);
        self.heap.clear();
        self.opened = 0;
    }

    /// Finds out what it costs from a node to landmarks.
    fn meet_landmarks(&mut self, hierarchy: &PathHierarchy, from: WorldNode) {
        self.from = Landmarks::UNKNOWN_DISTANCES;
        if let Some((cluster, first)) = hierarchy.cluster(from.instance) {
            for (k, out) in (0..).zip(hierarchy.exits_of(cluster)) {
                let cost = hierarchy.costs_in(cluster).to_exit(k, first + from.cell);
                hierarchy.landmarks.note_distance(&mut self.from, hierarchy.entrances.len() as u32 + out, cost);
            }
            return;
        }
        let Some((region, plane)) = hierarchy.region_and_plane(from.instance) else { return };
        for &entrance in &hierarchy.region_costs.leaving[region as usize] {
            let Some((_, tile, goal)) = hierarchy.leads_from(entrance) else { continue };
            let cost = plane.cost(plane.lookup(goal, hierarchy.floors.offset(from.instance, tile)), from.cell);
            hierarchy.landmarks.note_distance(&mut self.from, entrance, cost);
        }
    }

    /// Reaches all states that lead to the target's region.
    fn reach_end(&mut self, hierarchy: &PathHierarchy, region: u32) {
        let instance = self.end.instance;
        let offset = |tile| hierarchy.floors.offset(tile, instance);
        for &k in &hierarchy.region_exits[region as usize] {
            let (out, state) = (&hierarchy.exits[k as usize], hierarchy.entrances.len() as u32 + k);
            let Some(offset) = out.tile.map(offset) else { continue };
            let spots = hierarchy.costs_in(out.cluster).exit_landings(k - hierarchy.exits_of(out.cluster).start);
            let costs = spots.map(|([u, v], cell, part)| {
                part + self.end.cost_at(hierarchy, region, [offset[0] - u, offset[1] - v], cell)
            });
            let cost = costs.fold(f32::INFINITY, f32::min);
            self.reach(hierarchy, state, cost);
        }
        for &portal in &hierarchy.region_portals[region as usize] {
            let (Entrance::Portal { tile, goal, .. }, Some(plane)) =
                (hierarchy.entrances[portal as usize], hierarchy.plane(region))
            else {
                continue;
            };
            let offset = hierarchy.floors.offset(tile, self.end.instance);
            let cost = |&(cell, part): &CellCost| f32::from(part) + self.end.cost_at(hierarchy, region, offset, cell);
            let costs = plane.cells(goal).iter().map(cost);
            let cost = costs.fold(f32::INFINITY, f32::min);
            self.reach(hierarchy, portal, cost);
        }
    }

    /// Reaches all states that lead to a region, which is left by an entrance.
    fn reach_region(&mut self, hierarchy: &PathHierarchy, region: u32, entrance: u32, cost: f32) {
        // So that no cost of a row brings it beyond what can be counted.
        let whole = (cost as i32).min(i32::MAX - i32::from(u16::MAX));
        let region_costs = &hierarchy.region_costs;
        let list = region_costs.list(region);
        let Some(row) = region_costs.row(entrance, region) else {
            for place in list {
                let frames = region_costs.cost(hierarchy, entrance, place);
                self.reach_along(hierarchy, region_costs.states[place], cost, frames);
            }
            return;
        };
        for (first, row) in list.step_by(WIDE).zip(row.chunks(WIDE)) {
            let known = &self.known[first..first + row.len()];
            // Hardly any cost less: so all of them are asked at once.
            if row.iter().zip(known).fold(false, |any, (r, k)| any | (whole + i32::from(*r) < *k)) {
                for (place, &frames) in (first..).zip(row) {
                    self.reach_along(hierarchy, region_costs.states[place], cost, frames);
                }
            }
        }
    }

    fn reach_along(&mut self, hierarchy: &PathHierarchy, state: u32, cost: f32, frames: u16) {
        if frames != u16::MAX {
            self.reach(hierarchy, state, cost + f32::from(frames));
        }
    }

    fn reach(&mut self, hierarchy: &PathHierarchy, state: u32, cost: f32) {
        let s = state as usize;
        let is_known = self.stamps[s] == self.stamp && self.costs[s] <= cost;
        if cost == f32::INFINITY || is_known {
            return;
        }
        self.stamps[s] = self.stamp;
        self.costs[s] = cost;
        if let Some(place) = hierarchy.region_costs.place(state) {
            self.known[place] = cost.ceil() as i32;
        }
        let left = hierarchy.landmarks.least_cost(&self.from, state);
        self.heap.push(state, cost + left);
    }

    fn open_entrance(&mut self, hierarchy: &PathHierarchy, state: u32, cost: f32) {
        let entrance = hierarchy.entrances[state as usize];
        if let Entrance::Cluster { from, to } = entrance {
            for out in hierarchy.exits_of(from).filter(|&o| hierarchy.exits[o as usize].to == Some(to)) {
                self.reach(hierarchy, hierarchy.entrances.len() as u32 + out, cost);
            }
            return;
        }
        let Some((region, ..)) = hierarchy.leads_from(state) else { return };
        if self.next_stamps[state as usize] != self.stamp {
            if self.is_dominated(hierarchy, state, cost) {
                return;
            }
            self.chain(region, state);
        }
        self.reach_region(hierarchy, region, state, cost);
    }

    /// True where another entrance costs no more from any of the cells that this one begins at.
    fn is_dominated(&self, hierarchy: &PathHierarchy, state: u32, cost: f32) -> bool {
        let is_less = |&(other, most): &(u32, u16)| {
            let o = other as usize;
            self.next_stamps[o] == self.stamp && self.costs[o] + f32::from(most) <= cost
        };
        hierarchy.region_costs.substitutes(state).iter().any(is_less)
    }

    /// Adds an entrance to those from a region.
    fn chain(&mut self, region: u32, state: u32) {
        let r = region as usize;
        (self.next[state as usize], self.next_stamps[state as usize]) = (NONE, self.stamp);
        if self.chain_stamps[r] == self.stamp {
            self.next[self.chains[r][1] as usize] = state;
            self.chains[r][1] = state;
        } else {
            (self.chain_stamps[r], self.chains[r]) = (self.stamp, [state; 2]);
        }
    }

    fn open_exit(&mut self, hierarchy: &PathHierarchy, out: u32, cost: f32) {
        let cluster = hierarchy.exits[out as usize].cluster;
        let number = out - hierarchy.exits_of(cluster).start;
        let costs_in = hierarchy.costs_in(cluster);
        for (k, entrance) in hierarchy.entrances_of(cluster).enumerate() {
            self.reach(hierarchy, entrance, cost + costs_in.cost_across(k as u32, number));
        }
    }

    /// Cost from a node by one of the entrances or exits.
    fn cost_by(&self, hierarchy: &PathHierarchy, node: WorldNode, state: u32, cost: f32) -> f32 {
        let Some(out) = state.checked_sub(hierarchy.entrances.len() as u32) else {
            let Some((region, tile, goal)) = hierarchy.leads_from(state) else { return f32::INFINITY };
            let here = hierarchy.region_and_plane(node.instance).filter(|(r, _)| *r == region);
            let Some((_, plane)) = here else { return f32::INFINITY };
            return cost + plane.cost(plane.lookup(goal, hierarchy.floors.offset(node.instance, tile)), node.cell);
        };
        let cluster = hierarchy.exits[out as usize].cluster;
        let number = out - hierarchy.exits_of(cluster).start;
        match hierarchy.cluster(node.instance) {
            Some((d, first)) if d == cluster => cost + hierarchy.costs_in(d).to_exit(number, first + node.cell),
            _ => f32::INFINITY,
        }
    }

    /// Cost from a cell of a cluster by one of its exits.
    fn through(&self, hierarchy: &PathHierarchy, cluster: u32, cell: u32) -> f32 {
        let (costs_in, exits) = (hierarchy.costs_in(cluster), hierarchy.exits_of(cluster));
        let first = hierarchy.entrances.len() + exits.start as usize;
        let reached = (0..exits.len()).filter(|k| self.stamps[first + k] == self.stamp);
        let costs = reached.map(|k| self.costs[first + k] + costs_in.to_exit(k as u32, cell));
        costs.fold(f32::INFINITY, f32::min)
    }

    /// Best entrances from a tile.
    fn find_next_entrances(&mut self, hierarchy: &PathHierarchy, tile: u32) {
        let mut found = NextEntrances::new(self.stamp);
        let Some((region, plane)) = hierarchy.region_and_plane(tile) else { return };
        let r = region as usize;
        let mut state = if self.chain_stamps[r] == self.stamp { self.chains[r][0] } else { NONE };
        while state != NONE {
            if let Some((_, to, goal)) = hierarchy.entrances[state as usize].tile() {
                let lookup = plane.lookup(goal, hierarchy.floors.offset(tile, to));
                found.add(plane, NextEntrance { lookup, cost: self.costs[state as usize] });
            }
            state = self.next[state as usize];
        }
        self.next_entrances[tile as usize] = found;
    }
}
