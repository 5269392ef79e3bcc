//! Shapes: least costs within districts, found once for all that are alike.

use super::dial::{Arcs, Dial, UNREACHED};
use super::districts::Districts;
use super::plane::{Look, Plane, class, offsets};
use super::regions::Regions;
use crate::patch::CellRecord;
use crate::world::graph::Crossing;
use crate::world::{AdjacencyRecord, JointTableRecord, Node, WorldGraph};
use std::collections::BTreeMap;

/// How far away the tiles are by which places are compared. [Unit: copies]
const AROUND: i32 = 3;
/// Most that one place is counted worse than another one. [Unit: frames]
const MAX_HANDICAP: f32 = 1e3;

/// What a district overlaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Beyond {
    /// A tile of a region.
    Tile(u32),
    /// Another district.
    District(u32),
}

impl Beyond {
    /// The tile, where it is one.
    pub fn tile(self) -> Option<u32> {
        if let Self::Tile(t) = self { Some(t) } else { None }
    }
}

/// Costs within districts that are alike: from where they are entered, to where they are left.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    num_cells: u32,
    num_ins: u32,
    /// Ways in: what each leads from, as a number in [`Plot::beyond`], and the class of cell there.
    pub ins: Vec<(u32, u32)>,
    /// Ways out: what each leads to.
    pub outs: Vec<u32>,
    /// Least frames to leave by each way out, from each cell and then from each way in; with handicaps, see
    /// [`Plot::handicaps`]. [Size: outs * (cells + ins)]
    to_out: Vec<u16>,
    /// Where each of those ways ends, from each cell, as a number among the spots of the way out. [Size: outs * cells]
    ends: Vec<u16>,
    /// Where ways out end, and where those of each begin.
    spots: Vec<Spot>,
    first_spot: Vec<u32>,
    /// Least frames from each way in to each cell. [Size: ins * cells]
    from_in: Vec<u16>,
    /// For each way out to a tile, least frames from where it leads to on to each class of cell at each offset from the
    /// tile, less the handicaps. [Size: outs * classes * offsets]
    landings: Vec<f32>,
    /// Where each way out's part of the landings begins.
    first_landing: Vec<u32>,
}

impl Shape {
    /// Least frames from a cell to a way out.
    pub fn to_out(&self, out: u32, cell: u32) -> f32 {
        frames(self.to_out[(out * (self.num_cells + self.num_ins) + cell) as usize])
    }

    /// Where the fastest way out from a cell ends, and its frames; none where there is no such way.
    pub fn leap(&self, out: u32, cell: u32) -> Option<(&Spot, u16)> {
        let frames = self.to_out[(out * (self.num_cells + self.num_ins) + cell) as usize];
        let end = self.ends[(out * self.num_cells + cell) as usize];
        let spot = self.spots.get(self.first_spot[out as usize] as usize + end as usize)?;
        (frames != UNREACHED).then(|| (spot, frames - spot.handicap))
    }

    /// What the way out that ends somewhere is counted worse; none where it does not end there.
    pub fn handicap(&self, out: u32, way: [i32; 2], cell: u32) -> Option<u16> {
        let first = self.first_spot[out as usize] as usize;
        let end = self.first_spot.get(out as usize + 1).map_or(self.spots.len(), |&e| e as usize);
        self.spots[first..end].iter().find(|s| (s.way, s.cell) == (way, cell)).map(|s| s.handicap)
    }

    /// Least frames from a way in to a way out.
    pub fn across(&self, way_in: u32, out: u32) -> f32 {
        self.to_out(out, self.num_cells + way_in)
    }

    /// Least frames from a way in to a cell.
    pub fn reach(&self, way_in: u32, cell: u32) -> f32 {
        frames(self.from_in[(way_in * self.num_cells + cell) as usize])
    }

    /// Least frames from where a way out leads to, see [`Plane::look`] from the tile that it leads through.
    pub fn landing(&self, out: u32, look: Look) -> f32 {
        self.landings[(self.first_landing[out as usize] + look.row) as usize] + look.more
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
        let mut out = Self { graph, planes, regions, districts, district, beyond, numbers, num_cells };
        for &m in members {
            for (_, a, _) in graph.adjacencies(m) {
                let Some(beyond) = out.beyond(a.other) else { continue };
                if out.numbers.contains_key(&beyond) {
                    continue;
                }
                out.numbers.insert(beyond, out.beyond.len() as u32);
                out.beyond.push(beyond);
            }
        }
        out
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
                if let Some(beyond) = self.beyond(a.other) {
                    if let Beyond::District(d) = beyond {
                        key.push(self.districts.number(d, a.other).into());
                    }
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
        let mut draft =
            Draft { plot: self, arcs: Vec::new(), leaps: Vec::new(), ins: BTreeMap::new(), outs: BTreeMap::new() };
        draft.add_members();
        let Draft { arcs, leaps, ins, outs, .. } = draft;
        let mut out = Shape { num_cells: self.num_cells, num_ins: ins.len() as u32, ..Shape::default() };
        let num_nodes = 2 * self.num_cells + out.num_ins;
        out.ins = vec![(0, 0); ins.len()];
        ins.iter().for_each(|(key, &n)| out.ins[(n - 2 * self.num_cells) as usize] = *key);
        out.outs = vec![0; outs.len()];
        outs.iter().for_each(|(key, &n)| out.outs[n as usize] = key.0);
        let landings = self.handicaps(&leaps, &out.outs);
        let on = Arcs::new(num_nodes as usize, arcs.iter().copied());
        let back = Arcs::new(num_nodes as usize, arcs.iter().map(|&(from, to, frames)| (to, from, frames)));
        drop(arcs);
        for k in 0..outs.len() as u32 {
            let landings = &landings[k as usize];
            let numbers: BTreeMap<Landing, u16> = landings.keys().zip(0..).map(|(l, n)| (*l, n)).collect();
            let sources = leaps.iter().filter(|l| l.out == k);
            let sources = sources.map(|l| (l.from, l.frames + landings[&l.to], numbers[&l.to]));
            search.run(num_nodes as usize, sources, |search, node| {
                back.of(node).iter().for_each(|&(from, frames)| search.reach(from, frames));
            });
            out.to_out.extend((0..self.num_cells).map(|c| search.cost(c)));
            out.to_out.extend((2 * self.num_cells..num_nodes).map(|n| search.cost(n)));
            out.ends.extend((0..self.num_cells).map(|c| search.origin(c)));
            out.first_spot.push(out.spots.len() as u32);
            out.spots.extend(landings.iter().map(|(l, &handicap)| Spot { way: l.way, cell: l.cell, handicap }));
            self.add_landing(k, landings, &mut out);
        }
        for node in 2 * self.num_cells..num_nodes {
            search.run(num_nodes as usize, [(node, 0, 0)].into_iter(), |search, node| {
                on.of(node).iter().for_each(|&(to, frames)| search.reach(to, frames));
            });
            out.from_in.extend((0..self.num_cells).map(|c| search.cost(c)));
        }
        out
    }

    /// For each way out to a tile, where it leads to, and how much later the character is on its way from there than from
    /// the best of those places, on average over all directions. Where this is counted as part of the way out, the
    /// fastest way out is the one that is fastest in the end.
    fn handicaps(&self, leaps: &[Leap], outs: &[u32]) -> Vec<BTreeMap<Landing, u16>> {
        let mut out = vec![BTreeMap::new(); outs.len()];
        for l in leaps {
            out[l.out as usize].insert(l.to, 0);
        }
        for (landings, &beyond) in out.iter_mut().zip(outs) {
            let Beyond::Tile(tile) = self.beyond[beyond as usize] else { continue };
            let Some(plane) = self.plane(tile) else { continue };
            let means: Vec<f32> = landings.keys().map(|l| l.mean(plane)).collect();
            let least = means.iter().copied().fold(f32::INFINITY, f32::min);
            for (handicap, mean) in landings.values_mut().zip(means) {
                *handicap = (mean - least).min(MAX_HANDICAP) as u16;
            }
        }
        out
    }

    fn add_landing(&self, k: u32, landings: &BTreeMap<Landing, u16>, out: &mut Shape) {
        out.first_landing.push(out.landings.len() as u32);
        let Beyond::Tile(tile) = self.beyond[out.outs[k as usize] as usize] else { return };
        let Some(plane) = self.plane(tile) else { return };
        for class in 0..plane.num_classes() {
            for way in offsets() {
                let cost = |(l, &handicap): (&Landing, &u16)| l.cost(plane, class, way) - f32::from(handicap);
                out.landings.push(landings.iter().map(cost).fold(f32::INFINITY, f32::min).max(0.0));
            }
        }
    }
}

/// Where a way out ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Spot {
    /// How many copies away from the tile; in another district, the number of the member and nothing.
    pub way: [i32; 2],
    /// The cell there.
    pub cell: u32,
    /// How much later it is counted than it is. [Unit: frames]
    pub handicap: u16,
}

/// Where a way out leads to, as in [`Spot`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Landing {
    way: [i32; 2],
    cell: u32,
}

impl Landing {
    /// Least frames to a class of cells so many copies away from the tile.
    fn cost(&self, plane: &Plane, class: u32, [du, dv]: [i32; 2]) -> f32 {
        plane.cost(plane.look(class, [du - self.way[0], dv - self.way[1]]), self.cell)
    }

    /// Least frames to tiles all around, on average.
    fn mean(&self, plane: &Plane) -> f32 {
        let around = || offsets().filter(|o| o[0].abs().max(o[1].abs()) == AROUND);
        let least = |way| (0..plane.num_classes()).map(|c| self.cost(plane, c, way)).fold(f32::INFINITY, f32::min);
        around().map(least).sum::<f32>() / around().count() as f32
    }
}

/// A step out of a district.
#[derive(Clone, Copy, Debug)]
struct Leap {
    from: u32,
    out: u32,
    frames: u16,
    to: Landing,
}

/// The graph within a district. Its nodes are its cells; its cells again, as they are come to over a joint between
/// blocks, so that a link must follow; the ways in; the ways out.
struct Draft<'p, 'a, 'w> {
    plot: &'p Plot<'a, 'w>,
    arcs: Vec<(u32, u32, u16)>,
    leaps: Vec<Leap>,
    /// Ways in by what lies beyond and the class of cell there, and the node of each.
    ins: BTreeMap<(u32, u32), u32>,
    /// Ways out by what lies beyond and the sector that they lead to, and the number of each.
    outs: BTreeMap<(u32, u32), u32>,
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
        let out = *self.outs.entry((k, self.sector(to))).or_insert(next);
        self.leaps.push(Leap { from, out, frames, to: Landing { way, cell: to.cell } });
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

    /// Node of a way in.
    fn way_in(&mut self, beyond: u32, class: u32) -> u32 {
        let next = 2 * self.plot.num_cells + self.ins.len() as u32;
        *self.ins.entry((beyond, class)).or_insert(next)
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
                        let arc = (self.way_in(k, class), self.cell(to), frames);
                        self.arcs.push(arc);
                    }
                }
                (false, true) => {
                    let l = &links[j.a as usize];
                    if let Some(to) = graph.end_node(instance, l).filter(|to| plot.beyond(to.instance).is_none()) {
                        let arc = (self.way_in(k, 0), self.cell(to), 0);
                        self.arcs.push(arc);
                    }
                }
                (_, false) => {
                    let to = Node { instance, cell: if to_b { j.b } else { j.a } };
                    let cell = graph.cell(to);
                    let links = cell.first_link..cell.first_link + cell.num_links;
                    for s in links.filter(|_| graph.is_enabled(to)).filter_map(|l| graph.step_along(instance, l)) {
                        let arc = (self.way_in(k, 0), self.cell(s.to), 0);
                        self.arcs.push(arc);
                    }
                }
            }
        }
    }
}
