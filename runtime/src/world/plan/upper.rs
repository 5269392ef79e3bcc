//! The upper layer: what it costs at least to go on to the target from every way into a part of the world and out of one.

#[cfg(test)]
mod tests;

use super::Target;
use super::end::End;
use super::gates::{Gate, Gates};
use super::heap::Heap;
use crate::patch::NONE;
use crate::world::atlas::{Atlas, In, Landmarks, Spot, ToLandmarks};
use crate::world::{Node, WorldGraph};

/// The search goes on to ways that cost this many times what the best one does, and so much more. [Unit: frames]
const BESIDE: f32 = 1.02;
const BESIDE_FRAMES: f32 = 30.0;
/// Costs that are compared at once.
const WIDE: usize = 32;
/// Stands for a cost that is not known.
const UNKNOWN: i32 = i32::MAX;

/// Memory of the upper layer, and what its last search found.
#[derive(Clone, Debug)]
pub(super) struct Upper {
    /// Costs of the states. [Unit: frames]
    costs: Vec<f32>,
    stamps: Vec<u32>,
    /// Costs of those that rooms are entered by, in whole frames at least; beside each other, to be compared soon.
    known: Vec<i32>,
    heap: Heap,
    stamp: u32,
    /// What it costs to landmarks from where the search is to come to.
    from: ToLandmarks,
    /// Ways on from a room that were opened: the first and the last, and the next of each.
    chains: Vec<[u32; 2]>,
    chain_stamps: Vec<u32>,
    next: Vec<u32>,
    next_stamps: Vec<u32>,
    /// By instance.
    gates: Vec<Gates>,
    end: End,
    /// No way that the search left out costs less. [Unit: frames]
    pub limit: f32,
    /// States opened.
    pub opened: usize,
}

impl Upper {
    /// Memory for a world.
    pub fn new(graph: &WorldGraph<'_>, atlas: &Atlas) -> Self {
        let num_states = atlas.ins.len() + atlas.outs.len();
        let num_rooms = atlas.regions.num_rooms();
        Self {
            from: Landmarks::none(),
            costs: vec![0.0; num_states],
            stamps: vec![0; num_states],
            known: vec![UNKNOWN; atlas.roads.states.len()],
            heap: Heap::new(num_states),
            stamp: 0,
            chains: vec![[NONE; 2]; num_rooms],
            chain_stamps: vec![0; num_rooms],
            next: vec![NONE; atlas.ins.len()],
            next_stamps: vec![0; atlas.ins.len()],
            gates: vec![Gates::default(); graph.num_instances()],
            end: End::new(graph, atlas),
            limit: 0.0,
            opened: 0,
        }
    }

    /// A* from the target backwards, until more ways on would hardly help whoever begins at `from`, nor be part of any way
    /// that costs less than `most`.
    ///
    /// - returns false where no way leads from there to the target.
    pub fn run(&mut self, graph: &WorldGraph<'_>, atlas: &Atlas, target: Target, from: Node, most: f32) -> bool {
        self.begin();
        self.meet_landmarks(atlas, from);
        if !self.end.find(graph, atlas, target) {
            return false;
        }
        let mut least = self.end.cost(atlas, from);
        let limit = |least: f32| most.max(least * BESIDE + BESIDE_FRAMES);
        self.limit = limit(least);
        self.reach_from_end(atlas);
        while let Some((key, state)) = self.heap.pop() {
            self.limit = limit(least);
            if key > self.limit {
                return true;
            }
            let cost = self.costs[state as usize];
            self.opened += 1;
            match state.checked_sub(atlas.ins.len() as u32) {
                None => self.open_in(atlas, state, cost),
                Some(out) => self.open_out(atlas, out, cost),
            }
            least = least.min(self.cost_by(atlas, from, state, cost));
        }
        self.limit = f32::INFINITY;
        least < f32::INFINITY
    }

    /// What it costs at least to go on from a node to the target; infinite where no way is known. [Unit: frames]
    pub fn estimate(&mut self, atlas: &Atlas, node: Node) -> f32 {
        let direct = self.end.cost(atlas, node);
        if let Some((district, first)) = atlas.district(node.instance) {
            return direct.min(self.through(atlas, district, first + node.cell)).max(0.0);
        }
        if self.gates[node.instance as usize].stamp != self.stamp {
            self.find_gates(atlas, node.instance);
        }
        let plane = atlas.regions.room(node.instance).and_then(|r| atlas.plane(r));
        plane.map_or(f32::INFINITY, |plane| self.gates[node.instance as usize].cost(plane, node.cell, direct))
    }

    fn begin(&mut self) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.stamps.fill(0);
            self.chain_stamps.fill(0);
            self.next_stamps.fill(0);
            self.gates.fill(Gates::default());
            self.stamp = 1;
        }
        self.known.fill(UNKNOWN);
        self.heap.clear();
        self.opened = 0;
    }

    /// Finds out what it costs from a node to landmarks.
    fn meet_landmarks(&mut self, atlas: &Atlas, from: Node) {
        self.from = Landmarks::none();
        if let Some((district, first)) = atlas.district(from.instance) {
            for (k, out) in (0..).zip(atlas.outs_of(district)) {
                let cost = atlas.shape(district).to_out(k, first + from.cell);
                atlas.landmarks.meet(&mut self.from, atlas.ins.len() as u32 + out, cost);
            }
            return;
        }
        let Some((room, plane)) = atlas.regions.room(from.instance).and_then(|r| Some((r, atlas.plane(r)?))) else {
            return;
        };
        for &way_in in &atlas.roads.leaving[room as usize] {
            let Some((_, tile, goal)) = atlas.leads_from(way_in) else { continue };
            let cost = plane.cost(plane.look(goal, atlas.regions.way(from.instance, tile)), from.cell);
            atlas.landmarks.meet(&mut self.from, way_in, cost);
        }
    }

    fn reach_from_end(&mut self, atlas: &Atlas) {
        if let Some(district) = self.end.district {
            for (k, way_in) in atlas.ins_of(district).enumerate() {
                self.reach(atlas, way_in, self.end.from_in[k]);
            }
        } else if let Some(room) = atlas.regions.room(self.end.instance) {
            self.reach_end(atlas, room);
        }
    }

    /// All that leads to the target's room.
    fn reach_end(&mut self, atlas: &Atlas, room: u32) {
        let instance = self.end.instance;
        let way = |tile| atlas.regions.way(tile, instance);
        for &k in &atlas.room_outs[room as usize] {
            let (out, state) = (&atlas.outs[k as usize], atlas.ins.len() as u32 + k);
            let Some(way) = out.tile.map(way) else { continue };
            let spots = atlas.shape(out.district).spots(k - atlas.outs_of(out.district).start);
            let costs =
                spots.map(|([u, v], cell, part)| part + self.end.cost_at(atlas, room, [way[0] - u, way[1] - v], cell));
            let cost = costs.fold(f32::INFINITY, f32::min);
            self.reach(atlas, state, cost);
        }
        for &door in &atlas.room_doors[room as usize] {
            let (In::Door { tile, goal, .. }, Some(plane)) = (atlas.ins[door as usize], atlas.plane(room)) else {
                continue;
            };
            let way = atlas.regions.way(tile, self.end.instance);
            let cost = |&(cell, part): &Spot| f32::from(part) + self.end.cost_at(atlas, room, way, cell);
            let costs = plane.cells(goal).iter().map(cost);
            let cost = costs.fold(f32::INFINITY, f32::min);
            self.reach(atlas, door, cost);
        }
    }

    /// All that leads to a room, from which one goes on by a way in.
    fn reach_room(&mut self, atlas: &Atlas, room: u32, way_in: u32, cost: f32) {
        let (roads, whole) = (&atlas.roads, cost as i32);
        let list = roads.list(room);
        let Some(row) = roads.row(way_in, room) else {
            for place in list {
                self.reach_along(atlas, roads.states[place], cost, roads.cost(atlas, way_in, place));
            }
            return;
        };
        for (first, row) in list.step_by(WIDE).zip(row.chunks(WIDE)) {
            let known = &self.known[first..first + row.len()];
            // Hardly any cost less: so all of them are asked at once.
            if row.iter().zip(known).fold(false, |any, (r, k)| any | (whole + i32::from(*r) < *k)) {
                for (place, &frames) in (first..).zip(row) {
                    self.reach_along(atlas, roads.states[place], cost, frames);
                }
            }
        }
    }

    fn reach_along(&mut self, atlas: &Atlas, state: u32, cost: f32, frames: u16) {
        if frames != u16::MAX {
            self.reach(atlas, state, cost + f32::from(frames));
        }
    }

    /// True where a state is known to cost no more.
    fn is_known(&self, state: u32, cost: f32) -> bool {
        self.stamps[state as usize] == self.stamp && self.costs[state as usize] <= cost
    }

    fn reach(&mut self, atlas: &Atlas, state: u32, cost: f32) {
        if cost == f32::INFINITY || self.is_known(state, cost) {
            return;
        }
        let s = state as usize;
        self.stamps[s] = self.stamp;
        self.costs[s] = cost;
        if let Some(place) = atlas.roads.place(state) {
            self.known[place] = cost.ceil() as i32;
        }
        let left = atlas.landmarks.least(&self.from, state);
        self.heap.push(state, cost + left);
    }

    fn open_in(&mut self, atlas: &Atlas, state: u32, cost: f32) {
        let way_in = atlas.ins[state as usize];
        if let In::Out { from, to } = way_in {
            for out in atlas.outs_of(from).filter(|&o| atlas.outs[o as usize].to == Some(to)) {
                self.reach(atlas, atlas.ins.len() as u32 + out, cost);
            }
            return;
        }
        let Some((room, ..)) = atlas.leads_from(state) else { return };
        if self.next_stamps[state as usize] != self.stamp {
            if self.is_needless(atlas, state, cost) {
                return;
            }
            self.chain(room, state);
        }
        self.reach_room(atlas, room, state, cost);
    }

    /// True where another way on from a room costs no more from any of the cells that one begins at: who comes to them
    /// might take that one as well.
    fn is_needless(&self, atlas: &Atlas, state: u32, cost: f32) -> bool {
        let is_less = |&(other, most): &(u32, u16)| {
            let o = other as usize;
            self.next_stamps[o] == self.stamp && self.costs[o] + f32::from(most) <= cost
        };
        atlas.roads.others(state).iter().any(is_less)
    }

    /// Adds a way on to those from a room.
    fn chain(&mut self, room: u32, state: u32) {
        let r = room as usize;
        (self.next[state as usize], self.next_stamps[state as usize]) = (NONE, self.stamp);
        if self.chain_stamps[r] == self.stamp {
            self.next[self.chains[r][1] as usize] = state;
            self.chains[r][1] = state;
        } else {
            (self.chain_stamps[r], self.chains[r]) = (self.stamp, [state; 2]);
        }
    }

    /// The first way on from a room.
    fn first_of(&self, room: u32) -> u32 {
        if self.chain_stamps[room as usize] == self.stamp { self.chains[room as usize][0] } else { NONE }
    }

    fn open_out(&mut self, atlas: &Atlas, out: u32, cost: f32) {
        let district = atlas.outs[out as usize].district;
        let number = out - atlas.outs_of(district).start;
        let shape = atlas.shape(district);
        for (k, way_in) in atlas.ins_of(district).enumerate() {
            self.reach(atlas, way_in, cost + shape.across(k as u32, number));
        }
    }

    /// What it costs to go on from a node by one of the ways in or out.
    fn cost_by(&self, atlas: &Atlas, node: Node, state: u32, cost: f32) -> f32 {
        let Some(out) = state.checked_sub(atlas.ins.len() as u32) else {
            let Some((room, tile, goal)) = atlas.leads_from(state) else { return f32::INFINITY };
            let Some(plane) = atlas.plane(room).filter(|_| atlas.regions.room(node.instance) == Some(room)) else {
                return f32::INFINITY;
            };
            return cost + plane.cost(plane.look(goal, atlas.regions.way(node.instance, tile)), node.cell);
        };
        let district = atlas.outs[out as usize].district;
        let number = out - atlas.outs_of(district).start;
        match atlas.district(node.instance) {
            Some((d, first)) if d == district => cost + atlas.shape(d).to_out(number, first + node.cell),
            _ => f32::INFINITY,
        }
    }

    /// What it costs from a cell of a district by the ways out of it.
    fn through(&self, atlas: &Atlas, district: u32, cell: u32) -> f32 {
        let (shape, first) = (atlas.shape(district), atlas.ins.len() + atlas.outs_of(district).start as usize);
        let mut least = f32::INFINITY;
        for k in 0..atlas.outs_of(district).len() {
            if self.stamps[first + k] == self.stamp {
                least = least.min(self.costs[first + k] + shape.to_out(k as u32, cell));
            }
        }
        least
    }

    /// The best ways on from a tile.
    fn find_gates(&mut self, atlas: &Atlas, tile: u32) {
        let mut found = Gates::new(self.stamp);
        let Some((room, plane)) = atlas.regions.room(tile).and_then(|r| Some((r, atlas.plane(r)?))) else { return };
        let mut state = self.first_of(room);
        while state != NONE {
            if let Some((_, to, goal)) = atlas.ins[state as usize].tile() {
                let look = plane.look(goal, atlas.regions.way(tile, to));
                found.add(plane, Gate { look, cost: self.costs[state as usize] });
            }
            state = self.next[state as usize];
        }
        self.gates[tile as usize] = found;
    }
}
