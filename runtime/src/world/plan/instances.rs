//! The upper layer: what it costs at least to come from every instance to that of the target.
//!
//! A tile is entered by one of its edges or left from its inside, and turning in it may take longer than crossing
//! it, so its states are its edges and its inside; a block has one state.

use super::heap::Heap;
use crate::patch::{CellRecord, NONE};
use crate::world::{Node, WorldGraph};

/// How much further than the way found the layer looks, so that what lies beside it is judged too.
const BESIDE: f32 = 1.2;
/// The same, whatever the way's length. [Unit: frames]
const BESIDE_FRAMES: f32 = 90.0;

/// Memory of the upper layer, used again by every plan.
#[derive(Clone, Debug)]
pub(super) struct Instances {
    num_ports: u32,
    /// Instance of each neighbour slot.
    owners: Vec<u32>,
    /// Cost to the target, of states whose stamp is of this plan. [Unit: frames]
    costs: Vec<f32>,
    stamps: Vec<u32>,
    /// State that follows on the way to the target.
    next: Vec<u32>,
    heap: Heap,
    stamp: u32,
    /// No state that was not settled costs less. [Unit: frames]
    least_left: f32,
    /// States settled by the last plan.
    pub opened: usize,
}

impl Instances {
    pub fn new(graph: &WorldGraph<'_>) -> Self {
        let num_ports = graph.world().neighbours.len();
        let mut owners = Vec::with_capacity(num_ports);
        for (i, r) in graph.world().instances.iter().enumerate() {
            owners.extend((0..graph.patches().patches[r.patch as usize].num_edges).map(|_| i as u32));
        }
        let num_states = num_ports + graph.num_instances();
        Self {
            num_ports: num_ports as u32,
            owners,
            costs: vec![0.0; num_states],
            stamps: vec![0; num_states],
            next: vec![NONE; num_states],
            heap: Heap::new(num_states),
            stamp: 0,
            least_left: 0.0,
            opened: 0,
        }
    }

    /// The state of a node.
    pub fn state_of(&self, graph: &WorldGraph<'_>, node: Node) -> u32 {
        let cell = graph.cell(node);
        match cell.is(CellRecord::IS_ENTRY) {
            true => graph.instance(node.instance).first_neighbour + cell.edge,
            false => self.num_ports + node.instance,
        }
    }

    /// The state of what is inside of an instance: neither an entry nor an exit.
    pub fn inside_of(&self, instance: u32) -> u32 {
        self.num_ports + instance
    }

    /// Cost from a state to the target, or less. [Unit: frames]
    pub fn cost(&self, state: u32) -> f32 {
        let s = state as usize;
        if self.stamps[s] == self.stamp { self.costs[s].min(self.least_left) } else { self.least_left }
    }

    /// The instances on the way from a state to the target, that of the target last.
    pub fn way(&self, from: u32) -> impl Iterator<Item = u32> {
        let follow = |&state: &u32| Some(self.next[state as usize]).filter(|&n| n != NONE);
        std::iter::successors(Some(from), follow).map(|state| self.instance_of(state))
    }

    fn instance_of(&self, state: u32) -> u32 {
        if state < self.num_ports { self.owners[state as usize] } else { state - self.num_ports }
    }

    /// Dijkstra from the state of the target backwards. `toll` is what it costs beside to enter an instance.
    ///
    /// - returns false where `from` cannot be left for the target.
    pub fn run(&mut self, graph: &WorldGraph<'_>, target: u32, from: u32, toll: impl Fn(u32) -> f32) -> bool {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.stamps.fill(0);
            self.stamp = 1;
        }
        self.heap.clear();
        self.opened = 0;
        self.least_left = f32::INFINITY;
        self.reach(target, 0.0, NONE);
        let mut limit = f32::INFINITY;
        while let Some((cost, state)) = self.heap.pop() {
            if cost > limit {
                self.least_left = cost;
                break;
            }
            self.opened += 1;
            if state == from {
                limit = cost * BESIDE + BESIDE_FRAMES;
            }
            let entered = cost + toll(self.instance_of(state));
            if state < self.num_ports {
                self.reach_port(graph, state, entered)
            } else {
                self.inside(graph, state, entered)
            }
        }
        limit < f32::INFINITY
    }

    /// Notes a way from a state.
    fn reach(&mut self, state: u32, cost: f32, next: u32) {
        let s = state as usize;
        if cost == f32::INFINITY || self.stamps[s] == self.stamp && self.costs[s] <= cost {
            return;
        }
        self.stamps[s] = self.stamp;
        self.costs[s] = cost;
        self.next[s] = next;
        self.heap.push(state, cost);
    }

    /// What leads across an edge into a tile: what leads through the neighbour there.
    fn reach_port(&mut self, graph: &WorldGraph<'_>, state: u32, cost: f32) {
        let instance = self.owners[state as usize];
        let r = graph.instance(instance);
        let edges = graph.patches().edges_of(r.patch as usize);
        let neighbour = graph.world().neighbours[state as usize];
        if neighbour == NONE {
            return;
        }
        let exit = edges[(state - r.first_neighbour) as usize].opposite;
        let n = graph.instance(neighbour);
        if !graph.bounds.is_edge_open(n.first_neighbour + exit) {
            return;
        }
        self.through_tile(graph, neighbour, exit, cost, state);
    }

    /// What leads to the inside of an instance.
    fn inside(&mut self, graph: &WorldGraph<'_>, state: u32, cost: f32) {
        let instance = state - self.num_ports;
        if graph.is_tile(instance) {
            let num_edges = graph.patches().patches[graph.instance(instance).patch as usize].num_edges;
            self.through_tile(graph, instance, num_edges, cost, state);
            return;
        }
        for (k, a, _) in graph.adjacencies(instance) {
            if !graph.bounds.is_open_inwards(k) {
                continue;
            }
            // A block on side a has no edges: its one port is its inside.
            if a.side == 0 {
                self.reach(self.num_ports + a.other, cost + graph.bounds.out_of_b(a.table, 0), state);
                continue;
            }
            let o = graph.instance(a.other);
            let num_edges = graph.patches().patches[o.patch as usize].num_edges;
            for port in 0..=num_edges {
                let from = if port == num_edges { self.num_ports + a.other } else { o.first_neighbour + port };
                self.reach(from, cost + graph.bounds.towards_b(a.table, port), state);
            }
        }
    }

    /// What leads to where a tile is left by a port: its own ports, and the blocks that lead into its links.
    fn through_tile(&mut self, graph: &WorldGraph<'_>, tile: u32, exit: u32, cost: f32, state: u32) {
        let r = graph.instance(tile);
        let num_edges = graph.patches().patches[r.patch as usize].num_edges;
        for entry in 0..=num_edges {
            let through = cost + graph.bounds.across(r.patch, num_edges, entry, exit);
            let from = if entry == num_edges { self.num_ports + tile } else { r.first_neighbour + entry };
            if from != state {
                self.reach(from, through, state);
            }
        }
        // Blocks that lead into its links.
        for (k, a, _) in graph.adjacencies(tile) {
            if graph.bounds.is_open_inwards(k) {
                self.reach(self.num_ports + a.other, cost + graph.bounds.out_of_b(a.table, exit), state);
            }
        }
    }
}
