//! The graph of a whole world: cells of instances, joined by links, by joints and across the edges of tiles. Only
//! bits belong to an instance; where a node leads is looked up in its patch and in tables.

use super::component::{Standing, Ways, largest};
use super::situation::Situation;
use super::table::JointTable;
use std::sync::Arc;
use throng_runtime::patch::{CellRecord, NONE, Patches};
use throng_runtime::world::is_set;

/// An instance in the graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    /// Number of its patch.
    pub patch: u32,
    /// Node of its first cell.
    pub first_node: u32,
    /// Number of its situation.
    pub situation: u32,
    /// Its edges' neighbours.
    pub first_neighbour: u32,
    /// Its first overlap.
    pub first_overlap: u32,
    /// Number of overlaps.
    pub num_overlaps: u32,
}

/// Two instances that overlap, from one of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Overlap {
    /// The other instance.
    pub other: u32,
    /// Number of the table.
    pub table: u32,
    /// 0 where the owner is side a, 1 where it is side b.
    pub side: u32,
    /// First word of the joints' bits, two a joint.
    pub first_word: u32,
}

/// All that is possible in a world before the component is chosen.
#[derive(Clone, Debug)]
pub(super) struct Joined<'a> {
    /// The patches.
    pub patches: Patches<'a>,
    /// The instances.
    pub parts: Vec<Part>,
    /// Instance across each edge of each tile.
    pub neighbours: Vec<u32>,
    /// What is left of their motion.
    pub situations: Vec<Arc<Situation>>,
    /// Overlaps of all instances.
    pub overlaps: Vec<Overlap>,
    /// Joint tables.
    pub tables: Vec<Arc<JointTable>>,
    /// Joints that nothing is in the way of.
    pub joint_words: Vec<u64>,
    /// Number of nodes.
    pub num_nodes: usize,
}

/// How far the ways of a node have been enumerated: its links, then the joints of each overlap.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    part: u32,
    overlap: u32,
    at: u32,
}

impl Joined<'_> {
    /// The instance a node belongs to, and its cell.
    pub fn part_of(&self, node: u32) -> (u32, u32) {
        let part = self.parts.partition_point(|p| p.first_node <= node) - 1;
        (part as u32, node - self.parts[part].first_node)
    }

    /// Cells of an instance.
    pub fn cells(&self, part: u32) -> &[CellRecord] {
        self.patches.cells_of(self.parts[part as usize].patch as usize)
    }

    /// The node of a cell: for an exit the entry across the edge, where there is a neighbour.
    pub fn node(&self, part: u32, cell: u32) -> Option<u32> {
        let p = &self.parts[part as usize];
        let c = &self.cells(part)[cell as usize];
        if !c.is(CellRecord::IS_EXIT) {
            return Some(p.first_node + cell);
        }
        match self.neighbours[(p.first_neighbour + c.edge) as usize] {
            NONE => None,
            other => Some(self.parts[other as usize].first_node + c.twin),
        }
    }

    /// The node where a link of an instance ends.
    pub fn end_of(&self, part: u32, link: u32) -> Option<u32> {
        let patch = self.parts[part as usize].patch as usize;
        self.node(part, self.patches.links_of(patch)[link as usize].to)
    }

    /// Overlaps of an instance.
    pub fn overlaps_of(&self, part: u32) -> &[Overlap] {
        let p = &self.parts[part as usize];
        &self.overlaps[p.first_overlap as usize..(p.first_overlap + p.num_overlaps) as usize]
    }

    /// What is left of an instance's motion.
    pub fn situation(&self, part: u32) -> &Situation {
        &self.situations[self.parts[part as usize].situation as usize]
    }

    fn next_link(&self, part: u32, cell: u32, at: &mut u32) -> Option<u32> {
        let p = &self.parts[part as usize];
        let ends = self.situation(part).ends_of(cell);
        while let Some(end) = ends.get(*at as usize) {
            *at += 1;
            if end.edge == NONE {
                return Some(p.first_node + end.cell);
            }
            let other = self.neighbours[(p.first_neighbour + end.edge) as usize];
            if other != NONE {
                return Some(self.parts[other as usize].first_node + end.cell);
            }
        }
        None
    }

    /// Joints of cells do not follow each other without motion: they lead to the cell's second node, which has links
    /// alone.
    fn next_joint(&self, cell: u32, overlap: &Overlap, at: &mut u32) -> Option<u32> {
        let table = &self.tables[overlap.table as usize];
        let starts = if overlap.side == 0 { &table.a_starts } else { &table.b_starts };
        let (first, end) = (starts[cell as usize], starts[cell as usize + 1]);
        while first + *at < end {
            let place = first + *at;
            *at += 1;
            let joint = if overlap.side == 0 { place } else { table.by_b[place as usize] };
            if !is_set(&self.joint_words, overlap.first_word, 2 * joint + overlap.side) {
                continue;
            }
            let next = match self.joined_cell(overlap, joint) {
                Some(joined) => Some(self.second_node(overlap.other, joined)),
                None => self.end_of_joint(overlap, joint),
            };
            if next.is_some() {
                return next;
            }
        }
        None
    }

    /// The node of a cell that was come to by a joint.
    fn second_node(&self, part: u32, cell: u32) -> u32 {
        self.parts[part as usize].first_node + cell + self.num_nodes as u32
    }

    /// The cell of the other instance where a joint is one between cells.
    fn joined_cell(&self, overlap: &Overlap, joint: u32) -> Option<u32> {
        let j = &self.tables[overlap.table as usize].joints[joint as usize];
        (j.a_offset == NONE).then_some(if overlap.side == 0 { j.b } else { j.a })
    }

    /// What every cell is to the largest component; none where there is no component.
    ///
    /// A cell that joints lead to, but no motion, belongs to it as well: its links do, and nothing that belongs to the
    /// component ends there.
    pub fn settle(&self) -> Option<Vec<Standing>> {
        let all = largest(self)?;
        let (moved, joined) = all.split_at(self.num_nodes);
        let either = |(m, j): (&Standing, &Standing)| if *j == Standing::Inside { *j } else { *m };
        Some(moved.iter().zip(joined).map(either).collect())
    }

    /// The node where a joint leads that an instance takes to another one.
    pub fn end_of_joint(&self, overlap: &Overlap, joint: u32) -> Option<u32> {
        let j = &self.tables[overlap.table as usize].joints[joint as usize];
        match (overlap.side, j.a_offset) {
            (0, _) => self.node(overlap.other, j.b),
            (_, NONE) => self.node(overlap.other, j.a),
            _ => self.end_of(overlap.other, j.a),
        }
    }
}

impl Ways for Joined<'_> {
    type Cursor = Place;

    /// Two a cell: come to by motion, then come to by a joint.
    fn num_nodes(&self) -> usize {
        2 * self.num_nodes
    }

    fn next(&self, node: u32, cursor: &mut Place) -> Option<u32> {
        let joined = node as usize >= self.num_nodes;
        let node = if joined { node - self.num_nodes as u32 } else { node };
        if cursor.overlap == 0 && cursor.at == 0 {
            cursor.part = self.part_of(node).0;
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
