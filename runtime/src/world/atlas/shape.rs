//! Shapes: least costs within districts, found once for all that are alike.

use super::dial::{Arcs, Dial, UNREACHED};
use super::districts::Districts;
use super::plane::{Look, NUM_OFFSETS, Plane, RADIUS, class};
use super::regions::Regions;
use crate::patch::CellRecord;
use crate::world::graph::Crossing;
use crate::world::{AdjacencyRecord, JointTableRecord, Node, WorldGraph};
use std::collections::{BTreeMap, BTreeSet};

/// What a district overlaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Beyond {
    /// A tile of a region.
    Tile(u32),
    /// Another district.
    District(u32),
}

/// Costs within districts that are alike: from where they are entered, to where they are left.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    num_cells: u32,
    num_ins: u32,
    /// Least frames to leave by each way out, from each cell and then from each way in. [Size: outs * (cells + ins)]
    to_out: Vec<u16>,
    /// Least frames from each way in to each cell. [Size: ins * cells]
    from_in: Vec<u16>,
    /// For each way out to a tile, least frames from where it leads to on to each class of cell at each offset from the
    /// tile. [Size: outs * classes * offsets]
    landings: Vec<u16>,
    /// Where each way out's part of the landings begins.
    first_landing: Vec<u32>,
}

impl Shape {
    /// Least frames from a cell to a way out.
    pub fn to_out(&self, out: u32, cell: u32) -> f32 {
        frames(self.to_out[(out * (self.num_cells + self.num_ins) + cell) as usize])
    }

    /// Least frames from a way in to a way out.
    pub fn across(&self, way_in: u32, out: u32) -> f32 {
        self.to_out(out, self.num_cells + way_in)
    }

    /// Least frames from a way in to a cell.
    pub fn from_in(&self, way_in: u32, cell: u32) -> f32 {
        frames(self.from_in[(way_in * self.num_cells + cell) as usize])
    }

    /// Least frames from where a way out leads to, see [`Plane::look`] from the tile that it leads through.
    pub fn landing(&self, out: u32, look: Look) -> f32 {
        frames(self.landings[(self.first_landing[out as usize] + look.row) as usize]) + look.more
    }
}

fn frames(cost: u16) -> f32 {
    if cost == UNREACHED { f32::INFINITY } else { f32::from(cost) }
}

/// One district, and what its parts are numbered by.
pub(super) struct Plot<'a, 'w> {
    pub graph: &'a WorldGraph<'w>,
    pub planes: &'a [Option<Plane>],
    pub regions: &'a Regions,
    pub districts: &'a Districts,
    pub district: u32,
    /// What it overlaps, in the order in which its members do.
    pub beyond: Vec<Beyond>,
    numbers: BTreeMap<Beyond, u32>,
    /// First way in from each; one from another district, and one from each class of cell of a tile.
    pub first_in: Vec<u32>,
    num_cells: u32,
}

impl<'a, 'w> Plot<'a, 'w> {
    pub fn new(
        graph: &'a WorldGraph<'w>,
        planes: &'a [Option<Plane>],
        regions: &'a Regions,
        districts: &'a Districts,
        district: u32,
    ) -> Self {
        let members = &districts.members[district as usize];
        let num_cells = members.iter().map(|&m| graph.num_cells(m)).sum();
        let (beyond, numbers) = (Vec::new(), BTreeMap::new());
        let mut out =
            Self { graph, planes, regions, districts, district, beyond, numbers, first_in: vec![0], num_cells };
        for &m in members {
            for (_, a, _) in graph.adjacencies(m) {
                let Some(beyond) = out.beyond(a.other) else { continue };
                if out.numbers.contains_key(&beyond) {
                    continue;
                }
                out.numbers.insert(beyond, out.beyond.len() as u32);
                out.beyond.push(beyond);
                out.first_in.push(out.first_in[out.first_in.len() - 1] + out.num_classes(beyond));
            }
        }
        out
    }

    /// Ways in from what lies beyond.
    pub fn num_classes(&self, beyond: Beyond) -> u32 {
        match beyond {
            Beyond::District(_) => 1,
            Beyond::Tile(t) => self.plane(t).map_or(1, Plane::num_classes),
        }
    }

    fn plane(&self, tile: u32) -> Option<&'a Plane> {
        self.planes[self.graph.instance(tile).patch as usize].as_ref()
    }

    /// What an instance is to the district; none for a member.
    fn beyond(&self, instance: u32) -> Option<Beyond> {
        match self.districts.of(instance) {
            None => Some(Beyond::Tile(instance)),
            Some(d) => (d != self.district).then_some(Beyond::District(d)),
        }
    }

    /// All that its costs depend on: districts with the same key have the same shape.
    pub fn key(&self) -> Vec<u64> {
        let (graph, world) = (self.graph, self.graph.world());
        let members = &self.districts.members[self.district as usize];
        let number = |i: u32| match self.beyond(i) {
            None => members.partition_point(|&m| m < i) as u64,
            Some(beyond) => u64::MAX - u64::from(self.numbers.get(&beyond).copied().unwrap_or(u32::MAX)),
        };
        let mut key = Vec::new();
        for &m in members {
            let r = graph.instance(m);
            let p = &graph.patches().patches[r.patch as usize];
            key.push(r.patch.into());
            key.extend(&world.cell_words[r.first_cell_word as usize..][..p.num_cells.div_ceil(64) as usize]);
            key.extend(&world.link_words[r.first_link_word as usize..][..p.num_links.div_ceil(64) as usize]);
            let neighbours = &world.neighbours[r.first_neighbour as usize..][..p.num_edges as usize];
            key.extend(neighbours.iter().map(|&n| if n == crate::patch::NONE { u64::MAX } else { number(n) }));
            for (_, a, t) in graph.adjacencies(m) {
                key.extend([number(a.other), a.table.into(), a.side.into()]);
                let words = (2 * t.num_joints).div_ceil(64) as usize;
                key.extend(&world.joint_words[a.first_word as usize..][..words]);
                if self.beyond(a.other).is_some() {
                    let o = graph.instance(a.other);
                    let words = graph.num_cells(a.other).div_ceil(64) as usize;
                    key.extend(&world.cell_words[o.first_cell_word as usize..][..words]);
                }
            }
        }
        key
    }

    /// Searches from every way in and to every way out.
    pub fn shape(&self, search: &mut Dial) -> Shape {
        let num_ins = self.first_in[self.beyond.len()];
        let num_nodes = (2 * self.num_cells + num_ins) as usize + self.beyond.len();
        let mut draft = Draft { plot: self, arcs: Vec::new(), landings: vec![BTreeSet::new(); self.beyond.len()] };
        draft.add_members();
        let Draft { arcs, landings, .. } = draft;
        let on = Arcs::new(num_nodes, arcs.iter().copied());
        let back = Arcs::new(num_nodes, arcs.iter().map(|&(from, to, frames)| (to, from, frames)));
        drop(arcs);
        let mut out = Shape { num_cells: self.num_cells, num_ins, ..Shape::default() };
        for k in 0..self.beyond.len() as u32 {
            search.run(num_nodes, [(self.out(k), 0)].into_iter(), |search, node| {
                back.of(node).iter().for_each(|&(from, frames)| search.reach(from, frames));
            });
            out.to_out.extend((0..self.num_cells).map(|c| search.cost(c)));
            out.to_out.extend((0..num_ins).map(|k| search.cost(2 * self.num_cells + k)));
            self.add_landing(k, &landings[k as usize], &mut out);
        }
        for k in 0..num_ins {
            search.run(num_nodes, [(2 * self.num_cells + k, 0)].into_iter(), |search, node| {
                on.of(node).iter().for_each(|&(to, frames)| search.reach(to, frames));
            });
            out.from_in.extend((0..self.num_cells).map(|c| search.cost(c)));
        }
        out
    }

    /// Number of a way out among all nodes.
    fn out(&self, k: u32) -> u32 {
        2 * self.num_cells + self.first_in[self.beyond.len()] + k
    }

    fn add_landing(&self, k: u32, landings: &BTreeSet<([i32; 2], u32)>, out: &mut Shape) {
        out.first_landing.push(out.landings.len() as u32);
        let Beyond::Tile(tile) = self.beyond[k as usize] else { return };
        let Some(plane) = self.plane(tile) else { return };
        for class in 0..plane.num_classes() {
            for n in 0..NUM_OFFSETS as i32 {
                let side = 2 * RADIUS + 1;
                let [du, dv] = [n / side - RADIUS, n % side - RADIUS];
                let cost = |&([u, v], cell): &([i32; 2], u32)| plane.cost(plane.look(class, [du - u, dv - v]), cell);
                let least = landings.iter().map(cost).fold(f32::INFINITY, f32::min);
                out.landings.push(if least < f32::from(UNREACHED) { least as u16 } else { UNREACHED });
            }
        }
    }
}

/// The graph within a district. Its nodes are its cells; its cells again, as they are come to over a joint between
/// blocks, so that a link must follow; the ways in; the ways out.
struct Draft<'p, 'a, 'w> {
    plot: &'p Plot<'a, 'w>,
    arcs: Vec<(u32, u32, u16)>,
    /// For each way out to a tile, where it leads to: how many copies away, and which cell.
    landings: Vec<BTreeSet<([i32; 2], u32)>>,
}

impl Draft<'_, '_, '_> {
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

    fn joined(&self, node: Node) -> u32 {
        self.plot.num_cells + self.cell(node)
    }

    fn add_block_cell(&mut self, node: Node, from: u32) {
        let (graph, cell) = (self.plot.graph, self.plot.graph.cell(node));
        for link in cell.first_link..cell.first_link + cell.num_links {
            if let Some(step) = graph.step_along(node.instance, link) {
                let (to, frames) = (self.cell(step.to), step.num_frames() as u16);
                self.arcs.push((from, to, frames));
                self.arcs.push((self.joined(node), to, frames));
            }
        }
        graph.for_each_crossing(node, |_, crossing| match crossing {
            Crossing::Link(s) => self.add_out(from, s.instance, s.to, s.num_frames() as u16),
            Crossing::Cell(to) => match self.plot.beyond(to.instance) {
                None => self.arcs.push((from, self.joined(to), 0)),
                Some(_) => self.add_out(from, to.instance, to, 0),
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
        self.arcs.push((from, plot.out(k), frames));
        if let Beyond::Tile(tile) = beyond {
            self.landings[k as usize].insert((plot.regions.way(tile, to.instance), to.cell));
        }
    }

    /// What leads into a member from an instance beyond.
    fn add_ins(&mut self, instance: u32, a: &AdjacencyRecord, t: &JointTableRecord, beyond: Beyond) {
        let (plot, graph) = (self.plot, self.plot.graph);
        let Some(&k) = plot.numbers.get(&beyond) else { return };
        let first = 2 * plot.num_cells + plot.first_in[k as usize];
        let to_b = a.side == 1;
        let (cells, links) =
            (graph.patches().cells_of(t.patch_a as usize), graph.patches().links_of(t.patch_a as usize));
        let num_edges = graph.patches().patches[t.patch_a as usize].num_edges;
        for (n, j) in graph.joints(t).iter().enumerate().filter(|(n, _)| graph.may_go(a, *n, to_b)) {
            match (to_b, num_edges > 0) {
                // Out of a tile's link into the block, or into a tile's link out of it.
                (true, true) => {
                    let to = Node { instance, cell: j.b };
                    let from: &CellRecord = &cells[links[j.a as usize].from as usize];
                    let class = if matches!(beyond, Beyond::Tile(_)) { class(from, num_edges) } else { 0 };
                    if graph.is_enabled(to) {
                        self.arcs.push((first + class, self.cell(to), j.a_offset as u16));
                    }
                }
                (false, true) => {
                    let l = &links[j.a as usize];
                    if let Some(to) = graph.end_node(instance, l).filter(|to| plot.beyond(to.instance).is_none()) {
                        self.arcs.push((first, self.cell(to), l.num_frames - j.a_offset as u16));
                    }
                }
                (_, false) => {
                    let to = Node { instance, cell: if to_b { j.b } else { j.a } };
                    if graph.is_enabled(to) {
                        self.arcs.push((first, self.joined(to), 0));
                    }
                }
            }
        }
    }
}
