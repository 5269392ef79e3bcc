//! Drafts: the graph within a district, with its ways in and out.

use super::super::plane::class;
use super::{Beyond, Plot};
use crate::patch::{CellRecord, NONE};
use crate::world::graph::Crossing;
use crate::world::{AdjacencyRecord, JointTableRecord, Node};
use std::collections::BTreeMap;

/// Where a way out ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Landing {
    /// How many copies away from the tile; in another district, the number of the member and nothing.
    pub way: [i32; 2],
    /// The cell there.
    pub cell: u32,
}

/// A step out of a district.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leap {
    /// The cell.
    pub from: u32,
    /// Where it leads to, as a number in [`Draft::outs`].
    pub to: u32,
    /// What it takes.
    pub frames: u16,
}

/// The graph within a district. Its nodes are its cells; those of blocks again, where a link must follow, as after a joint
/// between blocks; the cells beyond that ways in begin at. Ways out are listed apart.
pub(super) struct Draft<'p, 'a, 'w> {
    plot: &'p Plot<'a, 'w>,
    /// From node to node, in so many frames.
    pub arcs: Vec<(u32, u32, u16)>,
    /// Steps out.
    pub leaps: Vec<Leap>,
    /// Where ways in begin, by what lies beyond, the class of the cell there and the cell, and the number of each.
    pub ins: BTreeMap<(u32, u32, u32), u32>,
    /// Where ways out end, by what lies beyond, the sector that they lead to and the cell, and the number of each.
    pub outs: BTreeMap<(u32, u32, Landing), u32>,
}

impl<'p, 'a, 'w> Draft<'p, 'a, 'w> {
    /// Follows all that can be done from the cells of a district, and all that leads there.
    pub fn new(plot: &'p Plot<'a, 'w>) -> Self {
        let mut out = Self { plot, arcs: Vec::new(), leaps: Vec::new(), ins: BTreeMap::new(), outs: BTreeMap::new() };
        out.add_members();
        out
    }

    fn add_members(&mut self) {
        let graph = self.plot.graph;
        for &instance in &self.plot.districts.members[self.plot.district as usize] {
            let tile = graph.is_tile(instance);
            for cell in 0..graph.num_cells(instance) {
                let node = Node { instance, cell };
                if !graph.is_node(node) {
                    continue;
                }
                let from = self.cell(node);
                if tile {
                    graph.for_each_step(node, |s| self.add_out(from, s.instance, s.to, s.num_frames() as u16));
                } else {
                    self.add_block_cell(node, from);
                }
            }
            for (_, a, t) in graph.adjacencies(instance) {
                if let Some(beyond) = self.plot.beyond(a.other) {
                    self.add_ins(instance, a, t, beyond);
                }
            }
        }
    }

    fn cell(&self, node: Node) -> u32 {
        self.plot.districts.first_cell(node.instance) + node.cell
    }

    /// The cell of a block, where a link must follow.
    fn linked(&self, node: Node) -> u32 {
        self.plot.num_cells + self.cell(node)
    }

    fn add_block_cell(&mut self, node: Node, from: u32) {
        let (graph, cell, linked) = (self.plot.graph, self.plot.graph.cell(node), self.linked(node));
        self.arcs.push((from, linked, 0));
        for link in cell.first_link..cell.first_link + cell.num_links {
            if let Some(step) = graph.step_along(node.instance, link) {
                self.arcs.push((linked, self.cell(step.to), step.num_frames() as u16));
            }
        }
        graph.for_each_crossing(node, |_, crossing| match crossing {
            Crossing::Link(s) => self.add_out(from, s.instance, s.to, s.num_frames() as u16),
            Crossing::Cell(to) => match self.plot.beyond(to.instance) {
                None => self.arcs.push((from, self.linked(to), 0)),
                Some(_) => {
                    let cell = graph.cell(to);
                    let links = cell.first_link..cell.first_link + cell.num_links;
                    for s in links.filter_map(|l| graph.step_along(to.instance, l)) {
                        self.add_out(from, s.instance, s.to, s.num_frames() as u16);
                    }
                }
            },
        });
    }

    /// A step to a node, along a link of `through` where that is a tile.
    fn add_out(&mut self, from: u32, through: u32, to: Node, frames: u16) {
        let plot = self.plot;
        let Some(beyond) = plot.beyond(to.instance) else {
            self.arcs.push((from, self.cell(to), frames));
            return;
        };
        let beyond = match beyond {
            Beyond::Tile(_) => Beyond::Tile(through),
            Beyond::District(_) => beyond,
        };
        let Some(&k) = plot.numbers.get(&beyond) else { return };
        let way = match beyond {
            Beyond::Tile(tile) => plot.regions.way(tile, to.instance),
            Beyond::District(d) => [plot.districts.number(d, to.instance) as i32, 0],
        };
        let next = self.outs.len() as u32;
        let landing = Landing { way, cell: to.cell };
        let to = *self.outs.entry((k, self.sector(to), landing)).or_insert(next);
        self.leaps.push(Leap { from, to, frames });
    }

    /// Ways out are told apart by the edge that a tile is entered by, or inside of one by heading.
    fn sector(&self, to: Node) -> u32 {
        let graph = self.plot.graph;
        let p = &graph.patches().patches[graph.instance(to.instance).patch as usize];
        let cell = graph.cell(to);
        match class(cell, p.num_edges) {
            inside if inside == p.num_edges => {
                let quarters = (cell.placement.heading / std::f32::consts::FRAC_PI_2).round();
                inside + quarters.rem_euclid(4.0) as u32
            }
            edge => edge,
        }
    }

    /// Node of a cell that a way in begins at.
    fn way_in(&mut self, beyond: u32, class: u32, cell: u32) -> u32 {
        let next = self.ins.len() as u32;
        2 * self.plot.num_cells + *self.ins.entry((beyond, class, cell)).or_insert(next)
    }

    /// What leads into a member from an instance beyond.
    fn add_ins(&mut self, instance: u32, a: &AdjacencyRecord, t: &JointTableRecord, beyond: Beyond) {
        let (plot, graph) = (self.plot, self.plot.graph);
        let Some(&k) = plot.numbers.get(&beyond) else { return };
        let to_b = a.side == 1;
        let (cells, links) =
            (graph.patches().cells_of(t.patch_a as usize), graph.patches().links_of(t.patch_a as usize));
        let num_edges = graph.patches().patches[t.patch_a as usize].num_edges;
        for (_, j) in graph.joints(t).iter().enumerate().filter(|(n, _)| graph.may_go(a, *n, to_b)) {
            match (to_b, num_edges > 0) {
                // Out of a tile's link into the block, or into a tile's link out of it.
                (true, true) => {
                    let to = Node { instance, cell: j.b };
                    let from: &CellRecord = &cells[links[j.a as usize].from as usize];
                    let tile = beyond.tile().is_some();
                    let class = if tile { class(from, num_edges) } else { 0 };
                    if graph.is_enabled(to) {
                        // What leads here from another district is counted there.
                        let frames = if tile { j.a_offset as u16 } else { 0 };
                        let arc = (self.way_in(k, class, links[j.a as usize].from), self.cell(to), frames);
                        self.arcs.push(arc);
                    }
                }
                (false, true) => {
                    let l = &links[j.a as usize];
                    if let Some(to) = graph.end_node(instance, l).filter(|to| plot.beyond(to.instance).is_none()) {
                        let arc = (self.way_in(k, 0, NONE), self.cell(to), 0);
                        self.arcs.push(arc);
                    }
                }
                (_, false) => {
                    let to = Node { instance, cell: if to_b { j.b } else { j.a } };
                    let cell = graph.cell(to);
                    let links = cell.first_link..cell.first_link + cell.num_links;
                    for s in links.filter(|_| graph.is_enabled(to)).filter_map(|l| graph.step_along(instance, l)) {
                        let arc = (self.way_in(k, 0, NONE), self.cell(s.to), 0);
                        self.arcs.push(arc);
                    }
                }
            }
        }
    }
}
