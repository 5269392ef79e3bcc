//! Paths to rest, for which a character needs no more than the units of its instance.

use super::{WorldGraph, WorldNode};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use throng_core::patch::{CellRecord, NONE};

/// For each node the link that leads towards the nearest rest cell of its instance, in frames; [`NONE`] where none does.
pub(super) fn links_to_rest(graph: &WorldGraph) -> Vec<u32> {
    let mut out = vec![NONE; graph.num_nodes()];
    let mut search = RestSearch::default();
    for instance in 0..graph.num_instances() as u32 {
        let first = graph.index(WorldNode { instance, cell: 0 });
        let num_cells = graph.num_cells(instance) as usize;
        search.run(graph, instance, &mut out[first..first + num_cells]);
    }
    out
}

/// Memory that one instance after the other uses.
#[derive(Default)]
struct RestSearch {
    /// Links that end in each cell: the first of a chain, then the next of each link.
    last_into: Vec<u32>,
    before: Vec<u32>,
    frames: Vec<u32>,
    heap: BinaryHeap<Reverse<(u32, u32)>>,
}

impl RestSearch {
    /// Dijkstra backwards from all rest cells of an instance.
    fn run(&mut self, graph: &WorldGraph, instance: u32, out: &mut [u32]) {
        let (cells, links) = (graph.cells(instance), graph.links(instance));
        if !cells.iter().any(|c| c.has_flags(CellRecord::IS_REST)) {
            return;
        }
        self.frames.clear();
        self.frames.resize(cells.len(), u32::MAX);
        self.last_into.clear();
        self.last_into.resize(cells.len(), NONE);
        self.before.clear();
        self.before.resize(links.len(), NONE);
        self.heap.clear();
        for (k, l) in links.iter().enumerate() {
            let inside = |cell| graph.is_node(WorldNode { instance, cell });
            if l.is_for_two() || !graph.is_link_enabled(instance, k as u32) || !inside(l.from) || !inside(l.to) {
                continue;
            }
            if l.from == l.to && cells[l.from as usize].has_flags(CellRecord::IS_REST) {
                if out[l.from as usize] == NONE {
                    out[l.from as usize] = k as u32;
                    self.frames[l.from as usize] = 0;
                    self.heap.push(Reverse((0, l.from)));
                }
                continue;
            }
            self.before[k] = self.last_into[l.to as usize];
            self.last_into[l.to as usize] = k as u32;
        }
        while let Some(Reverse((frames, cell))) = self.heap.pop() {
            let mut k = self.last_into[cell as usize];
            while frames == self.frames[cell as usize] && k != NONE {
                let l = &links[k as usize];
                let through = frames + u32::from(l.num_frames);
                if through < self.frames[l.from as usize] {
                    self.frames[l.from as usize] = through;
                    out[l.from as usize] = k;
                    self.heap.push(Reverse((through, l.from)));
                }
                k = self.before[k as usize];
            }
        }
    }
}
