//! Edges: the graph within a cluster, with its entrances and exits.

use super::super::plane::class_of;
use super::{AdjacentPart, ClusterOutline};
use crate::{AdjacencyRecord, JointTableRecord, WorldNode, graph::JointCrossing};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_core::patch::{CellRecord, NONE};

/// End of an exit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct ExitLanding {
    /// Offset from the tile (copies); in another cluster, the number of the instance and 0.
    pub offset: [i32; 2],
    /// The cell there.
    pub cell: u32,
}

/// A step out of a cluster.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExitStep {
    /// The cell.
    pub from: u32,
    /// End of the step, as a number in [`ClusterEdges::exits`].
    pub to: u32,
    /// Length of the step (frames).
    pub frames: u16,
}

/// The graph within a cluster. Its nodes are its cells; those of blocks again, where a link must follow, as after a joint
/// between blocks; the cells beyond that entrances begin at. Exits are listed apart.
pub(super) struct ClusterEdges<'p, 'a> {
    outline: &'p ClusterOutline<'a>,
    /// Arcs from node to node, with their lengths (frames).
    pub arcs: Vec<(u32, u32, u16)>,
    /// Steps out.
    pub exit_steps: Vec<ExitStep>,
    /// Number of each start of an entrance, by the part of the world beyond, the class of the cell there and the cell.
    pub entrances: BTreeMap<(u32, u32, u32), u32>,
    /// Number of each end of an exit, by the part of the world beyond, the sector that it leads to and the cell.
    pub exits: BTreeMap<(u32, u32, ExitLanding), u32>,
}

impl<'p, 'a> ClusterEdges<'p, 'a> {
    /// Follows all that can be done from the cells of a cluster, and all that leads there.
    pub fn new(outline: &'p ClusterOutline<'a>) -> Self {
        let (arcs, exit_steps) = (Vec::new(), Vec::new());
        let mut out = Self { outline, arcs, exit_steps, entrances: BTreeMap::new(), exits: BTreeMap::new() };
        out.add_members();
        out
    }

    fn add_members(&mut self) {
        let graph = self.outline.graph;
        for &instance in &self.outline.clusters.members[self.outline.cluster as usize] {
            let tile = graph.is_tile(instance);
            for cell in 0..graph.num_cells(instance) {
                let node = WorldNode { instance, cell };
                if !graph.is_node(node) {
                    continue;
                }
                let from = self.cell(node);
                if tile {
                    graph.for_each_step(node, |s| self.add_exit(from, s.instance, s.to, s.num_frames() as u16));
                } else {
                    self.add_block_cell(node, from);
                }
            }
            for (_, a, t) in graph.adjacencies(instance) {
                if let Some(beyond) = self.outline.adjacent_part(a.other) {
                    self.add_entrances(instance, a, t, beyond);
                }
            }
        }
    }

    fn cell(&self, node: WorldNode) -> u32 {
        self.outline.clusters.first_cell[node.instance as usize] + node.cell
    }

    /// The cell of a block, where a link must follow.
    fn linked(&self, node: WorldNode) -> u32 {
        self.outline.num_cells + self.cell(node)
    }

    fn add_block_cell(&mut self, node: WorldNode, from: u32) {
        let (graph, linked) = (self.outline.graph, self.linked(node));
        self.arcs.push((from, linked, 0));
        for step in graph.whole_link_steps(node) {
            self.arcs.push((linked, self.cell(step.to), step.num_frames() as u16));
        }
        graph.for_each_crossing(node, |_, crossing| match crossing {
            JointCrossing::Link(s) => self.add_exit(from, s.instance, s.to, s.num_frames() as u16),
            JointCrossing::Cell(to) => match self.outline.adjacent_part(to.instance) {
                None => self.arcs.push((from, self.linked(to), 0)),
                Some(_) => {
                    for s in graph.whole_link_steps(to) {
                        self.add_exit(from, s.instance, s.to, s.num_frames() as u16);
                    }
                }
            },
        });
    }

    /// A step to a node, along a link of `through` where that is a tile.
    fn add_exit(&mut self, from: u32, through: u32, to: WorldNode, frames: u16) {
        let outline = self.outline;
        let Some(beyond) = outline.adjacent_part(to.instance) else {
            self.arcs.push((from, self.cell(to), frames));
            return;
        };
        let beyond = match beyond {
            AdjacentPart::Tile(_) => AdjacentPart::Tile(through),
            AdjacentPart::Cluster(_) => beyond,
        };
        let Some(&k) = outline.numbers.get(&beyond) else { return };
        let offset = match beyond {
            AdjacentPart::Tile(tile) => outline.floors.offset(tile, to.instance),
            AdjacentPart::Cluster(d) => [outline.clusters.instance_number(d, to.instance) as i32, 0],
        };
        let next = self.exits.len() as u32;
        let landing = ExitLanding { offset, cell: to.cell };
        let to = *self.exits.entry((k, self.sector(to), landing)).or_insert(next);
        self.exit_steps.push(ExitStep { from, to, frames });
    }

    /// Sector of an exit: the edge by which a tile is entered, or the heading inside of one.
    fn sector(&self, to: WorldNode) -> u32 {
        let graph = self.outline.graph;
        let p = &graph.patches().patches[graph.instance(to.instance).patch as usize];
        let cell = graph.cell(to);
        match class_of(cell, p.num_edges) {
            inside if inside == p.num_edges => {
                let quarters = (cell.placement.heading / std::f32::consts::FRAC_PI_2).round();
                inside + quarters.rem_euclid(4.0) as u32
            }
            edge => edge,
        }
    }

    /// Adds a step into the cluster, from the start of an entrance: the part of the world beyond, the class and the cell.
    fn add_entrance(&mut self, start: (u32, u32, u32), to: WorldNode, frames: u16) {
        let next = self.entrances.len() as u32;
        let from = 2 * self.outline.num_cells + *self.entrances.entry(start).or_insert(next);
        self.arcs.push((from, self.cell(to), frames));
    }

    /// Adds the steps into the cluster from an instance beyond.
    fn add_entrances(&mut self, instance: u32, a: &AdjacencyRecord, t: &JointTableRecord, beyond: AdjacentPart) {
        let (outline, graph) = (self.outline, self.outline.graph);
        let Some(&k) = outline.numbers.get(&beyond) else { return };
        let to_b = a.side == 1;
        let (cells, links) =
            (graph.patches().cells_of(t.patch_a as usize), graph.patches().links_of(t.patch_a as usize));
        let num_edges = graph.patches().patches[t.patch_a as usize].num_edges;
        for (_, j) in graph.joints(t).iter().enumerate().filter(|(n, _)| graph.can_go(a, *n, to_b)) {
            match (to_b, num_edges > 0) {
                // Out of a tile's link into the block, or into a tile's link out of it.
                (true, true) => {
                    let to = WorldNode { instance, cell: j.b };
                    let from: &CellRecord = &cells[links[j.a as usize].from as usize];
                    let tile = beyond.tile().is_some();
                    let class = if tile { class_of(from, num_edges) } else { 0 };
                    if graph.is_enabled(to) {
                        // What leads here from another cluster is counted there.
                        let frames = if tile { j.a_offset as u16 } else { 0 };
                        self.add_entrance((k, class, links[j.a as usize].from), to, frames);
                    }
                }
                (false, true) => {
                    let l = &links[j.a as usize];
                    if let Some(to) =
                        graph.end_node(instance, l).filter(|to| outline.adjacent_part(to.instance).is_none())
                    {
                        self.add_entrance((k, 0, NONE), to, 0);
                    }
                }
                (_, false) => {
                    let to = WorldNode { instance, cell: if to_b { j.b } else { j.a } };
                    for s in graph.whole_link_steps(to).filter(|_| graph.is_enabled(to)) {
                        self.add_entrance((k, 0, NONE), s.to, 0);
                    }
                }
            }
        }
    }
}
