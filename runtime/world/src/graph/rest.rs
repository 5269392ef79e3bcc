//! Paths to rest, for which a character needs no more than the units of its instance.

use super::{WorldGraph, WorldNode};
use std::{cmp::Reverse, collections::BinaryHeap};
use throng_core::patch::{CellRecord, NONE};

/// For each node the link that leads towards the nearest rest cell of its instance, in frames; [`NONE`] where none does.
pub(super) fn links_to_rest(graph: &WorldGraph) -> Vec<u32> {
    let mut out = vec![NONE; graph.num_nodes()];
    for instance in 0..graph.num_instances() as u32 {
        let first = graph.index(WorldNode { instance, cell: 0 });
        let num_cells = graph.num_cells(instance) as usize;
        find_links(graph, instance, &mut out[first..first + num_cells]);
    }
    out
}

/// Dijkstra backwards from all rest cells of an instance.
fn find_links(graph: &WorldGraph, instance: u32, out: &mut [u32]) {
    let (cells, links) = (graph.cells(instance), graph.links(instance));
    if !cells.iter().any(|c| c.has_flags(CellRecord::IS_REST)) {
        return;
    }
    let (mut frames_of, mut heap) = (vec![u32::MAX; cells.len()], BinaryHeap::new());
    // Links that end in each cell: the first of a chain, then the next of each link.
    let (mut last_into, mut before) = (vec![NONE; cells.len()], vec![NONE; links.len()]);
    for (k, l) in links.iter().enumerate() {
        let inside = |cell| graph.is_node(WorldNode { instance, cell });
        if l.is_for_two() || !graph.is_link_enabled(instance, k as u32) || !inside(l.from) || !inside(l.to) {
            continue;
        }
        if l.from == l.to && cells[l.from as usize].has_flags(CellRecord::IS_REST) {
            if out[l.from as usize] == NONE {
                out[l.from as usize] = k as u32;
                frames_of[l.from as usize] = 0;
                heap.push(Reverse((0, l.from)));
            }
            continue;
        }
        before[k] = last_into[l.to as usize];
        last_into[l.to as usize] = k as u32;
    }
    while let Some(Reverse((frames, cell))) = heap.pop() {
        let mut k = last_into[cell as usize];
        while frames == frames_of[cell as usize] && k != NONE {
            let l = &links[k as usize];
            let through = frames + u32::from(l.num_frames);
            if through < frames_of[l.from as usize] {
                frames_of[l.from as usize] = through;
                out[l.from as usize] = k;
                heap.push(Reverse((through, l.from)));
            }
            k = before[k as usize];
        }
    }
}
