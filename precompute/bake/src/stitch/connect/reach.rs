//! Cells of a world reachable from one cell, or from which it is reachable: cells are bits, and one step handles all
//! new cells of an instance.

use super::joined::JoinedGraph;
use crate::stitch::sets::rows::{BitRows, set_bits};
use std::collections::VecDeque;
use throng_core::patch::CellRecord;

/// Direction of a search along edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::stitch) enum SearchDirection {
    /// Along edges.
    Forth,
    /// Against edges.
    Back,
}

/// A set of nodes as bits. The bit of an exit is that of the entry across the edge.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::stitch) struct ReachedNodes {
    /// Cells reached by motion (words of the graph).
    pub moved: Vec<u64>,
    /// Cells reached by joints from other cells (words of the graph).
    pub joined: Vec<u64>,
}

impl ReachedNodes {
    /// An empty set for a graph with that many words.
    pub fn empty(num_words: usize) -> Self {
        Self { moved: vec![0; num_words], joined: vec![0; num_words] }
    }

    /// Intersection of two sets.
    pub fn intersection(&self, other: &Self) -> Self {
        let both = |a: &[u64], b: &[u64]| a.iter().zip(b).map(|(a, b)| a & b).collect();
        Self { moved: both(&self.moved, &other.moved), joined: both(&self.joined, &other.joined) }
    }
}

/// A search from a node.
pub(in crate::stitch) struct ReachSearch<'j> {
    graph: &'j JoinedGraph,
    direction: SearchDirection,
    /// Nodes found so far.
    found: ReachedNodes,
    /// Nodes whose edges have been followed.
    done: ReachedNodes,
    /// Queue of instances with nodes still to be followed.
    open: VecDeque<u32>,
    is_open: Vec<bool>,
}

/// New nodes of 64 cells.
#[derive(Clone, Copy)]
struct NewNodes {
    first_cell: u32,
    moved: u64,
    joined: u64,
    /// Bits of cells whose links are to be followed.
    links: u64,
}

impl<'j> ReachSearch<'j> {
    /// A search without nodes.
    pub fn new(graph: &'j JoinedGraph, direction: SearchDirection) -> Self {
        let [found, done] = [0; 2].map(|_| ReachedNodes::empty(graph.num_words));
        Self { graph, direction, found, done, open: VecDeque::new(), is_open: vec![false; graph.parts.len()] }
    }

    /// Runs the search to its end.
    pub fn run(mut self) -> ReachedNodes {
        while let Some(part) = self.open.pop_front() {
            self.is_open[part as usize] = false;
            self.follow_new(part);
        }
        self.found
    }

    /// Begins at a cell reached by motion.
    pub fn start(&mut self, part: u32, cell: u32) {
        self.add(part, cell);
        // An entry and the exit that leads there are one node.
        if self.graph.cells(part)[cell as usize].has_flags(CellRecord::IS_ENTRY) {
            self.cross_edge(part, cell);
        }
    }

    fn add(&mut self, part: u32, cell: u32) {
        let word = &mut self.found.moved[self.graph.words(part).start + cell as usize / 64];
        if *word & 1 << (cell % 64) == 0 {
            *word |= 1 << (cell % 64);
            self.queue_instance(part);
        }
    }

    /// Queues an instance with found nodes that are not followed.
    fn queue_instance(&mut self, part: u32) {
        if !std::mem::replace(&mut self.is_open[part as usize], true) {
            self.open.push_back(part);
        }
    }

    /// Moves from an exit of a tile to the entry across the edge, or back.
    fn cross_edge(&mut self, part: u32, cell: u32) {
        let c = &self.graph.cells(part)[cell as usize];
        if let Some(other) = self.graph.neighbour(part, c.edge) {
            self.add(other, c.twin);
        }
    }

    /// Follows the edges of all new nodes of an instance, until none within it is new.
    fn follow_new(&mut self, part: u32) {
        let is_tile = !self.graph.patches.edges_of(self.graph.parts[part as usize].patch as usize).is_empty();
        loop {
            let mut any = false;
            for word in self.graph.words(part) {
                let Some(new) = self.take_new(part, word) else { continue };
                any = true;
                self.follow_links(part, new);
                self.follow_joints(part, new);
                if is_tile {
                    self.follow_edges(part, new);
                }
            }
            if !any {
                return;
            }
        }
    }

    /// Takes the new nodes of one word, marking them as followed.
    fn take_new(&mut self, part: u32, word: usize) -> Option<NewNodes> {
        let (moved, joined) = (&mut self.done.moved[word], &mut self.done.joined[word]);
        let before = *moved | *joined;
        let new = [self.found.moved[word] & !*moved, self.found.joined[word] & !*joined];
        *moved |= new[0];
        *joined |= new[1];
        let links = match self.direction {
            SearchDirection::Forth => (new[0] | new[1]) & !before,
            // Links end in cells reached by motion.
            SearchDirection::Back => new[0],
        };
        let first_cell = 64 * (word - self.graph.words(part).start) as u32;
        (new != [0; 2]).then_some(NewNodes { first_cell, moved: new[0], joined: new[1], links })
    }

    fn follow_links(&mut self, part: u32, new: NewNodes) {
        let (situation, words) = (self.graph.situation(part), self.graph.words(part));
        let rows = match self.direction {
            SearchDirection::Forth => &situation.out,
            SearchDirection::Back => &situation.into,
        };
        add_rows(rows, new.first_cell, new.links, &mut self.found.moved[words.clone()]);
        // Links begin in cells reached either way.
        if self.direction == SearchDirection::Back {
            add_rows(rows, new.first_cell, new.links, &mut self.found.joined[words]);
        }
    }

    fn follow_joints(&mut self, part: u32, new: NewNodes) {
        let graph = self.graph;
        for overlap in graph.overlaps_of(part) {
            let (crossing, words) = (graph.crossing(overlap), graph.words(overlap.other));
            // Joints begin in cells reached by motion; those from cell to cell end in cells reached by joints.
            let (rows, cells, joined) = match self.direction {
                SearchDirection::Forth => (&crossing.out, new.moved, crossing.between_cells),
                SearchDirection::Back if crossing.between_cells => (&crossing.into, new.joined, false),
                SearchDirection::Back => (&crossing.into, new.moved, false),
            };
            let to = if joined { &mut self.found.joined[words] } else { &mut self.found.moved[words] };
            if add_rows(&rows[overlap.side as usize], new.first_cell, cells, to) {
                self.queue_instance(overlap.other);
            }
        }
    }

    fn follow_edges(&mut self, part: u32, new: NewNodes) {
        let flag = match self.direction {
            SearchDirection::Forth => CellRecord::IS_EXIT,
            SearchDirection::Back => CellRecord::IS_ENTRY,
        };
        for cell in set_bits(new.moved).map(|bit| new.first_cell + bit) {
            if self.graph.cells(part)[cell as usize].has_flags(flag) {
                self.cross_edge(part, cell);
            }
        }
    }
}

/// Adds rows to a set; true if any number was new.
fn add_rows(rows: &BitRows, first_row: u32, which: u64, set: &mut [u64]) -> bool {
    let mut more = 0;
    for bit in set_bits(which) {
        for word in rows.words_of(first_row + bit) {
            let to = &mut set[word.index as usize];
            more |= word.bits & !*to;
            *to |= word.bits;
        }
    }
    more != 0
}
