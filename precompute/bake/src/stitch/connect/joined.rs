//! Graph of a whole world: cells of instances, connected by links, by joints and across the edges of tiles. An instance
//! stores only bits; edges are looked up in its patch and in tables.

use super::{crossing::CrossingJoints, situation::PatchSituation};
use crate::components::SuccessorGraph;
use crate::stitch::sets::rows::{num_words, set_bit};
use std::sync::Arc;
use throng_core::patch::{CellRecord, NONE, PatchRecord, PatchTables};

/// An instance in the graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::stitch) struct GraphInstance {
    /// Number of its patch.
    pub patch: u32,
    /// Node of its first cell.
    pub first_node: u32,
    /// Word of its first cell, in sets of cells as bits.
    pub first_word: u32,
    /// Number of its situation.
    pub situation: u32,
    /// Index of the neighbours across its edges.
    pub first_neighbour: u32,
    /// Index of its first overlap.
    pub first_overlap: u32,
    /// Number of overlaps.
    pub num_overlaps: u32,
}

/// Overlap of two instances, seen from one of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::stitch) struct InstanceOverlap {
    /// The other instance.
    pub other: u32,
    /// Side of the owner: 0 for side a, 1 for side b.
    pub side: u32,
    /// Number of the pair.
    pub pair: u32,
    /// Number of the usable joints.
    pub crossing: u32,
}

/// All possible motion of a world before the component is chosen.
#[derive(Clone, Debug)]
pub(in crate::stitch) struct JoinedGraph {
    /// The patches.
    pub patches: PatchTables,
    /// Bits of the exits of every patch.
    pub exits: Vec<Vec<u64>>,
    /// The instances.
    pub parts: Vec<GraphInstance>,
    /// Instance across each edge of each tile.
    pub neighbours: Vec<u32>,
    /// Situations, each with the unobstructed motion of instances.
    pub situations: Vec<Arc<PatchSituation>>,
    /// Overlaps of all instances.
    pub overlaps: Vec<InstanceOverlap>,
    /// Usable joints of pairs.
    pub crossings: Vec<Arc<CrossingJoints>>,
    /// Number of the usable joints of each pair; [`NONE`] without joints (pairs).
    pub crossing_of: Vec<u32>,
    /// True for pairs of a tile and a block whose motion uses its panel (pairs).
    pub shares_floor: Vec<bool>,
    /// Number of nodes.
    pub num_nodes: usize,
    /// Number of words in a set of nodes; each instance begins with a word of its own.
    pub num_words: usize,
}

/// Position in the enumeration of a node's successors: its links, then the joints of each overlap.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::stitch) struct NodeCursor {
    part: u32,
    overlap: u32,
    at: u32,
}

/// Bits of the exits of every patch.
pub(in crate::stitch) fn exits(patches: &PatchTables) -> Vec<Vec<u64>> {
    let of_patch = |(p, record): (usize, &PatchRecord)| {
        let mut words = vec![0; num_words(record.num_cells as usize)];
        let cells = (0u32..).zip(patches.cells_of(p));
        cells.filter(|(_, c)| c.has_flags(CellRecord::IS_EXIT)).for_each(|(c, _)| set_bit(&mut words, c));
        words
    };
    patches.patches.iter().enumerate().map(of_patch).collect()
}

impl JoinedGraph {
    /// Instance and cell of a node.
    pub fn instance_of(&self, node: u32) -> (u32, u32) {
        let part = self.parts.partition_point(|p| p.first_node <= node) - 1;
        (part as u32, node - self.parts[part].first_node)
    }

    /// Cells of an instance.
    pub fn cells(&self, part: u32) -> &[CellRecord] {
        self.patches.cells_of(self.parts[part as usize].patch as usize)
    }

    /// Words of an instance's cells in a set.
    pub fn words(&self, part: u32) -> std::ops::Range<usize> {
        let p = &self.parts[part as usize];
        let first = p.first_word as usize;
        first..first + self.exits[p.patch as usize].len()
    }

    /// The instance across an edge of a tile.
    pub fn neighbour(&self, part: u32, edge: u32) -> Option<u32> {
        let other = self.neighbours[(self.parts[part as usize].first_neighbour + edge) as usize];
        (other != NONE).then_some(other)
    }

    /// Node of a cell: for an exit the entry across the edge, if there is a neighbour.
    pub fn node(&self, part: u32, cell: u32) -> Option<u32> {
        let c = &self.cells(part)[cell as usize];
        if !c.has_flags(CellRecord::IS_EXIT) {
            return Some(self.parts[part as usize].first_node + cell);
        }
        self.neighbour(part, c.edge).map(|other| self.parts[other as usize].first_node + c.twin)
    }

    /// Overlaps of an instance.
    pub fn overlaps_of(&self, part: u32) -> &[InstanceOverlap] {
        let p = &self.parts[part as usize];
        &self.overlaps[p.first_overlap as usize..(p.first_overlap + p.num_overlaps) as usize]
    }

    /// The joints of an overlap.
    pub fn crossing(&self, overlap: &InstanceOverlap) -> &CrossingJoints {
        &self.crossings[overlap.crossing as usize]
    }

    /// Situation of an instance.
    pub fn situation(&self, part: u32) -> &Arc<PatchSituation> {
        &self.situations[self.parts[part as usize].situation as usize]
    }

    fn next_link(&self, part: u32, cell: u32, at: &mut u32) -> Option<u32> {
        let out = &self.situation(part).out;
        std::iter::from_fn(|| out.next(cell, at)).find_map(|to| self.node(part, to))
    }

    /// Joints of cells do not follow each other without motion: they lead to the cell's second node, which has links
    /// only.
    fn next_joint(&self, cell: u32, overlap: &InstanceOverlap, at: &mut u32) -> Option<u32> {
        let crossing = self.crossing(overlap);
        let out = &crossing.out[overlap.side as usize];
        std::iter::from_fn(|| out.next(cell, at)).find_map(|to| match crossing.between_cells {
            true => Some(self.parts[overlap.other as usize].first_node + to + self.num_nodes as u32),
            false => self.node(overlap.other, to),
        })
    }
}

impl SuccessorGraph for JoinedGraph {
    type Cursor = NodeCursor;

    /// Two nodes a cell: reached by motion, then reached by a joint.
    fn num_nodes(&self) -> usize {
        2 * self.num_nodes
    }

    fn next(&self, node: u32, cursor: &mut NodeCursor) -> Option<u32> {
        let joined = node as usize >= self.num_nodes;
        let node = if joined { node - self.num_nodes as u32 } else { node };
        if cursor.overlap == 0 && cursor.at == 0 {
            cursor.part = self.instance_of(node).0;
        }
        let cell = node - self.parts[cursor.part as usize].first_node;
        if cursor.overlap == 0 {
            if let Some(next) = self.next_link(cursor.part, cell, &mut cursor.at) {
                return Some(next);
            }
            (cursor.overlap, cursor.at) = (1, 0);
        }
        if joined {
            return None;
        }
        while let Some(overlap) = self.overlaps_of(cursor.part).get(cursor.overlap as usize - 1) {
            if let Some(next) = self.next_joint(cell, overlap, &mut cursor.at) {
                return Some(next);
            }
            (cursor.overlap, cursor.at) = (cursor.overlap + 1, 0);
        }
        None
    }
}
