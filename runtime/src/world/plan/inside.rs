//! What it costs within the target's district to come to the target: Dijkstra backwards, only as far as it is asked for.

use super::heap::Heap;
use crate::patch::{LinkRecord, NONE};
use crate::world::atlas::Atlas;
use crate::world::{Node, WorldGraph};

/// Costs of the cells of one district; memory of the search for them.
///
/// Its states are the cells, and then the cells again where a link must follow, as after a joint between blocks.
#[derive(Clone, Debug)]
pub(super) struct Inside {
    district: u32,
    /// [Unit: frames] [Size: 2 * cells of the largest district]
    costs: Vec<f32>,
    /// What `costs` is of, and whether a state was opened.
    stamps: Vec<u32>,
    opened: Vec<u32>,
    stamp: u32,
    num_cells: u32,
    heap: Heap,
}

impl Inside {
    /// Memory for districts of at most so many cells.
    pub fn new(num_cells: u32) -> Self {
        let num_states = 2 * num_cells as usize;
        Self {
            district: 0,
            costs: vec![0.0; num_states],
            stamps: vec![0; num_states],
            opened: vec![0; num_states],
            stamp: 0,
            num_cells,
            heap: Heap::new(num_states),
        }
    }

    /// Begins a search from cells of a district, by their numbers there.
    pub fn begin(&mut self, district: u32, targets: impl Iterator<Item = u32>) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.stamps.fill(0);
            self.opened.fill(0);
            self.stamp = 1;
        }
        self.district = district;
        self.heap.clear();
        targets.for_each(|cell| self.reach(cell, 0.0));
    }

    /// Cost from a cell of the district, without leaving it; infinite where no way leads on. [Unit: frames]
    pub fn cost(&mut self, graph: &WorldGraph<'_>, atlas: &Atlas, cell: u32) -> f32 {
        while self.opened[cell as usize] != self.stamp {
            let Some((cost, state)) = self.heap.pop() else { return f32::INFINITY };
            self.opened[state as usize] = self.stamp;
            let (linked, number) = (state >= self.num_cells, state % self.num_cells);
            let Some(at) = self.node(atlas, number) else { continue };
            match (linked, graph.is_tile(at.instance)) {
                (true, _) => self.open_linked(graph, atlas, at, cost),
                (false, true) => self.open_tile(graph, atlas, at, cost),
                (false, false) => self.open_block(graph, atlas, at, cost),
            }
        }
        self.costs[cell as usize]
    }

    /// The node with a number within the district.
    fn node(&self, atlas: &Atlas, number: u32) -> Option<Node> {
        let members = &atlas.districts.members[self.district as usize];
        let at = members.partition_point(|&m| atlas.districts.first_cell(m) <= number);
        let instance = *members.get(at.checked_sub(1)?)?;
        Some(Node { instance, cell: number - atlas.districts.first_cell(instance) })
    }

    /// Number of a node within the district; none where it is not part of it.
    fn number(&self, graph: &WorldGraph<'_>, atlas: &Atlas, node: Node) -> Option<u32> {
        let (district, first) = atlas.district(node.instance)?;
        (district == self.district && graph.is_node(node)).then_some(first + node.cell)
    }

    /// What leads to a cell of a block where a link follows: being there, and joints of other blocks.
    fn open_linked(&mut self, graph: &WorldGraph<'_>, atlas: &Atlas, at: Node, cost: f32) {
        if let Some(number) = self.number(graph, atlas, at) {
            self.reach(number, cost);
        }
        for (_, a, t) in graph.adjacencies(at.instance) {
            let tile = a.side == 1 && graph.is_tile(a.other);
            for (k, j) in graph.joints_at(a, t, at.cell).filter(|_| !tile) {
                let from = Node { instance: a.other, cell: if a.side == 0 { j.b } else { j.a } };
                if let Some(number) = self.number(graph, atlas, from).filter(|_| graph.may_go(a, k, a.side == 1)) {
                    self.reach(number, cost);
                }
            }
        }
    }

    /// What leads to a cell of a block: links, and links of tiles that are left for it.
    fn open_block(&mut self, graph: &WorldGraph<'_>, atlas: &Atlas, at: Node, cost: f32) {
        for &link in atlas.into.of(graph.instance(at.instance).patch, at.cell) {
            let l = &graph.links(at.instance)[link as usize];
            let from = self.number(graph, atlas, Node { instance: at.instance, cell: l.from });
            if let Some(number) = from.filter(|_| graph.is_link_enabled(at.instance, link)) {
                self.reach(self.num_cells + number, cost + f32::from(l.num_frames));
            }
        }
        for (_, a, t) in graph.adjacencies(at.instance).filter(|(_, a, _)| a.side == 1 && graph.is_tile(a.other)) {
            for (k, j) in graph.joints_at(a, t, at.cell) {
                let l = &graph.links(a.other)[j.a as usize];
                let from = self.number(graph, atlas, Node { instance: a.other, cell: l.from });
                if let Some(number) = from.filter(|_| graph.may_go(a, k, true)) {
                    self.reach(number, cost + j.a_offset as f32);
                }
            }
        }
    }

    /// What leads to a cell of a tile: its links, and those of the neighbour whose exit it is.
    fn open_tile(&mut self, graph: &WorldGraph<'_>, atlas: &Atlas, at: Node, cost: f32) {
        let cell = graph.cell(at);
        self.open_links(graph, atlas, at.instance, at.cell, at, cost);
        if cell.edge != NONE {
            let slot = graph.instance(at.instance).first_neighbour + cell.edge;
            let other = graph.world().neighbours[slot as usize];
            if other != NONE {
                self.open_links(graph, atlas, other, cell.twin, at, cost);
            }
        }
    }

    /// Links of a tile that end in a cell and lead to a node, and what comes into them from blocks.
    fn open_links(&mut self, graph: &WorldGraph<'_>, atlas: &Atlas, tile: u32, cell: u32, to: Node, cost: f32) {
        for &link in atlas.into.of(graph.instance(tile).patch, cell) {
            let l: &LinkRecord = &graph.links(tile)[link as usize];
            if graph.end_node(tile, l) != Some(to) {
                continue;
            }
            let from = self.number(graph, atlas, Node { instance: tile, cell: l.from });
            if let Some(number) = from.filter(|_| graph.is_link_enabled(tile, link)) {
                self.reach(number, cost + f32::from(l.num_frames));
            }
            for (_, a, t) in graph.adjacencies(tile).filter(|(_, a, _)| a.side == 0) {
                for (k, j) in graph.joints_at(a, t, link) {
                    let from = self.number(graph, atlas, Node { instance: a.other, cell: j.b });
                    if let Some(number) = from.filter(|_| graph.may_go(a, k, false)) {
                        self.reach(number, cost + f32::from(l.num_frames) - j.a_offset as f32);
                    }
                }
            }
        }
    }

    fn reach(&mut self, state: u32, cost: f32) {
        let s = state as usize;
        if self.stamps[s] != self.stamp || cost < self.costs[s] {
            self.stamps[s] = self.stamp;
            self.costs[s] = cost;
            self.heap.push(state, cost);
        }
    }
}
