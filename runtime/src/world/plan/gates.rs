//! The upper layer: what it costs to go on to the target from every way into a district and out of one.

use super::Target;
use super::heap::Heap;
use super::near::{self, Near};
use crate::patch::NONE;
use crate::world::atlas::{Atlas, In, Look, Out, class};
use crate::world::{Node, WorldGraph};
use glam::{Vec3, Vec3Swizzles};
use std::ops::Range;

/// What is known of a tile: the ways on from it that cost least, one of which may be the way to the target itself.
const MAX_GATES: usize = 4;
/// Gates are looked at that cost at most this many times what the best way costs, and so much more. [Unit: frames]
const BESIDE: f32 = 1.05;
const BESIDE_FRAMES: f32 = 60.0;
/// What a frame counts within the target's district, where many ways are equally fast.
const HASTE: f32 = 3.0;
/// Ways that rise less are level. [Unit: m]
const MIN_RISE_M: f32 = 0.3;
/// Places are known but roughly.
const CAUTION: f32 = 0.9;

/// A way on from a tile. [Unit: frames]
#[derive(Clone, Copy, Debug, Default)]
struct Gate {
    look: Look,
    cost: f32,
}

/// The ways on from a tile, and the search that found them.
#[derive(Clone, Copy, Debug, Default)]
struct Gates {
    stamp: u32,
    /// True where the target is so near that the way to it is looked up elsewhere.
    near: bool,
    len: usize,
    list: [Gate; MAX_GATES],
}

/// What a metre costs at least. [Unit: frames/m]
#[derive(Clone, Copy, Debug, Default)]
struct Pace {
    along: f32,
    up: f32,
    down: f32,
}

impl Pace {
    /// On planes, and on top of that where districts lead up and down.
    fn new(graph: &WorldGraph<'_>, atlas: &Atlas) -> Self {
        let mut pace = Self { along: atlas.pace(), up: f32::INFINITY, down: f32::INFINITY };
        for district in 0..atlas.num_districts() as u32 {
            for (i, way_in) in atlas.ins_of(district).enumerate() {
                let In::Tile { tile, .. } = atlas.ins[way_in as usize] else { continue };
                for (o, out) in atlas.outs_of(district).enumerate() {
                    let Some(to) = atlas.outs[out as usize].tile else { continue };
                    let way = graph.centre(to) - graph.centre(tile);
                    let cost = atlas.shape(district).across(i as u32, o as u32) - pace.along * way.xz().length();
                    let least = if way.y > 0.0 { &mut pace.up } else { &mut pace.down };
                    if way.y.abs() > MIN_RISE_M {
                        *least = least.min((cost / way.y.abs()).max(0.0));
                    }
                }
            }
        }
        let known = |p: f32| if p < f32::INFINITY { CAUTION * p } else { 0.0 };
        Self { along: known(pace.along), up: known(pace.up), down: known(pace.down) }
    }

    /// Of a way from one place to another.
    fn cost(&self, from: Vec3, to: Vec3) -> f32 {
        let way = to - from;
        self.along * way.xz().length() + if way.y > 0.0 { self.up * way.y } else { -self.down * way.y }
    }
}

/// Memory of the upper layer, and what its last search found.
#[derive(Clone, Debug)]
pub(super) struct Upper {
    /// Where each state is: ways in, then ways out. [Unit: m]
    places: Vec<Vec3>,
    /// Costs of the states. [Unit: frames]
    costs: Vec<f32>,
    stamps: Vec<u32>,
    heap: Heap,
    stamp: u32,
    /// Where the search is to come to. [Unit: m]
    from: Vec3,
    pace: Pace,
    /// Ways in of a region that were opened: the first and the last, and the next of each.
    chains: Vec<[u32; 2]>,
    chain_stamps: Vec<u32>,
    next: Vec<u32>,
    next_stamps: Vec<u32>,
    /// By instance.
    gates: Vec<Gates>,
    end: End,
    near: Near,
    /// Largest cost that is settled; infinite where all are. [Unit: frames]
    pub limit: f32,
    /// States opened.
    pub opened: usize,
}

/// Where the target lies.
#[derive(Clone, Debug, Default)]
struct End {
    instance: u32,
    /// Classes of its cells, where it is in a region: one bit each.
    classes: u32,
    /// Its district.
    district: Option<u32>,
    /// There, least costs from each way in, and largest ones to each way out.
    from_in: Vec<f32>,
    to_out: Vec<f32>,
    /// The least of the former.
    nearest: f32,
}

impl Upper {
    /// Memory for a world.
    pub fn new(graph: &WorldGraph<'_>, atlas: &Atlas) -> Self {
        let num_states = atlas.ins.len() + atlas.outs.len();
        let most = |part: fn(&Atlas, u32) -> Range<u32>| {
            (0..atlas.num_districts() as u32).map(|d| part(atlas, d).len()).max().unwrap_or(0)
        };
        let inside = |district: u32| graph.centre(atlas.districts.members[district as usize][0]);
        let place_in = |i: &In| match *i {
            In::Tile { tile, .. } => graph.centre(tile),
            In::Out { to, .. } => inside(to),
        };
        let place_out = |o: &Out| o.tile.map_or_else(|| inside(o.district), |tile| graph.centre(tile));
        Self {
            places: atlas.ins.iter().map(place_in).chain(atlas.outs.iter().map(place_out)).collect(),
            from: Vec3::ZERO,
            pace: Pace::new(graph, atlas),
            next_stamps: vec![0; atlas.ins.len()],
            costs: vec![0.0; num_states],
            stamps: vec![0; num_states],
            heap: Heap::new(num_states),
            stamp: 0,
            chains: vec![[NONE; 2]; atlas.regions.len()],
            chain_stamps: vec![0; atlas.regions.len()],
            next: vec![NONE; atlas.ins.len()],
            gates: vec![Gates::default(); graph.num_instances()],
            end: End {
                from_in: Vec::with_capacity(most(Atlas::ins_of)),
                to_out: Vec::with_capacity(most(Atlas::outs_of)),
                ..End::default()
            },
            near: Near::new((0..graph.num_instances() as u32).map(|i| graph.num_cells(i)).max().unwrap_or(0)),
            limit: 0.0,
            opened: 0,
        }
    }

    /// A* from the target backwards, until more ways on would not help whoever begins at `from`; `all` leaves
    /// none out.
    ///
    /// - returns false where no way leads from there to the target.
    pub fn run(&mut self, graph: &WorldGraph<'_>, atlas: &Atlas, target: Target, from: Node, all: bool) -> bool {
        self.begin();
        self.from = graph.place(from).translation();
        if !self.find_end(graph, atlas, target) {
            return false;
        }
        self.reach_from_end(atlas);
        let mut least = f32::INFINITY;
        self.limit = f32::INFINITY;
        while let Some((key, state)) = self.heap.pop() {
            if key > self.limit {
                return true;
            }
            let cost = self.costs[state as usize];
            self.opened += 1;
            if (state as usize) < atlas.ins.len() {
                self.open_in(atlas, state, cost);
            } else {
                self.open_out(atlas, state - atlas.ins.len() as u32, cost);
            }
            least = least.min(self.estimate_by(atlas, from, state, cost));
            if !all {
                self.limit = least.min(self.estimate_direct(atlas, from)) * BESIDE + BESIDE_FRAMES;
            }
        }
        self.limit = f32::INFINITY;
        least.min(self.estimate_direct(atlas, from)) < f32::INFINITY
    }

    /// What it costs to go on from a node to the target; infinite where no way is known. [Unit: frames]
    pub fn estimate(&mut self, atlas: &Atlas, node: Node) -> f32 {
        if let Some((district, first)) = atlas.district(node.instance) {
            let within = self.within(atlas, district, first + node.cell);
            // What has come nearer to the target than its district's nearest way in goes on before others do.
            let inside = self.end.nearest + HASTE * (within - self.end.nearest);
            return inside.min(self.through(atlas, district, first + node.cell));
        }
        if self.gates[node.instance as usize].stamp != self.stamp {
            self.find_gates(atlas, node.instance);
        }
        let Some(plane) = atlas.regions.of(node.instance).and_then(|r| atlas.plane(r)) else { return f32::INFINITY };
        let gates = &self.gates[node.instance as usize];
        let costs = gates.list[..gates.len].iter().map(|g| plane.cost(g.look, node.cell) + g.cost);
        let near = gates.near.then(|| self.estimate_direct(atlas, node));
        costs.chain(near).fold(f32::INFINITY, f32::min)
    }

    /// District of the target; [`NONE`] where it is in none.
    pub fn district(&self) -> u32 {
        self.end.district.unwrap_or(NONE)
    }

    fn begin(&mut self) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.stamps.fill(0);
            self.chain_stamps.fill(0);
            self.next_stamps.fill(0);
            self.gates.fill(Gates::default());
            self.stamp = 1;
        }
        self.heap.clear();
        self.opened = 0;
    }

    /// Where the target lies; false where there is none.
    fn find_end(&mut self, graph: &WorldGraph<'_>, atlas: &Atlas, target: Target) -> bool {
        let end = &mut self.end;
        let instance = target.instance();
        (end.instance, end.classes, end.district) = (instance, 0, None);
        end.from_in.clear();
        end.to_out.clear();
        let nodes = (0..graph.num_cells(instance)).map(|cell| Node { instance, cell });
        let mut nodes = nodes.filter(|n| graph.is_node(*n) && target.is_at(graph, *n)).peekable();
        if nodes.peek().is_none() {
            return false;
        }
        let Some((district, first)) = atlas.district(instance) else {
            let num_edges = graph.patches().patches[graph.instance(instance).patch as usize].num_edges;
            nodes.for_each(|n| end.classes |= 1 << class(graph.cell(n), num_edges));
            let Some(plane) = atlas.regions.of(instance).and_then(|r| atlas.plane(r)) else { return false };
            let bits = end.classes;
            let cells = (0..graph.num_cells(instance)).filter(|&cell| {
                let node = Node { instance, cell };
                graph.is_node(node) && target.is_at(graph, node)
            });
            let least = |way, cell| near::least(plane, classes(bits), way, cell);
            self.near.run(plane, graph.num_cells(instance), cells, least);
            return true;
        };
        let shape = atlas.shape(district);
        end.district = Some(district);
        end.from_in.extend(atlas.ins_of(district).map(|_| f32::INFINITY));
        end.to_out.extend(atlas.outs_of(district).map(|_| 0.0));
        end.nearest = 0.0;
        for n in nodes {
            let cell = first + n.cell;
            end.from_in.iter_mut().enumerate().for_each(|(k, c)| *c = c.min(shape.reach(k as u32, cell)));
            end.to_out.iter_mut().enumerate().for_each(|(k, c)| *c = c.max(shape.to_out(k as u32, cell)));
        }
        let nearest = end.from_in.iter().copied().fold(f32::INFINITY, f32::min);
        end.nearest = if nearest < f32::INFINITY { nearest } else { 0.0 };
        true
    }

    fn reach_from_end(&mut self, atlas: &Atlas) {
        if let Some(district) = self.end.district {
            for (k, way_in) in atlas.ins_of(district).enumerate() {
                self.reach(way_in, self.end.from_in[k]);
            }
        } else if let Some(region) = atlas.regions.of(self.end.instance) {
            for class in classes(self.end.classes) {
                self.reach_outs(atlas, region, self.end.instance, class, self.near.beside);
            }
        }
    }

    /// Ways out to tiles of a region, from which one goes on to a class of cells of one of them.
    fn reach_outs(&mut self, atlas: &Atlas, region: u32, tile: u32, class: u32, cost: f32) {
        let Some(plane) = atlas.plane(region) else { return };
        let (mut last, mut look) = (NONE, Look::default());
        for &k in &atlas.region_outs[region as usize] {
            let out = &atlas.outs[k as usize];
            let Some(through) = out.tile else { continue };
            let s = atlas.ins.len() + k as usize;
            if self.stamps[s] == self.stamp && self.costs[s] <= cost {
                continue;
            }
            if last != through {
                (last, look) = (through, plane.look(class, atlas.regions.way(through, tile)));
            }
            let number = k - atlas.outs_of(out.district).start;
            self.reach(atlas.ins.len() as u32 + k, cost + atlas.shape(out.district).landing(number, look));
        }
    }

    fn reach(&mut self, state: u32, cost: f32) {
        let s = state as usize;
        if cost == f32::INFINITY || self.stamps[s] == self.stamp && self.costs[s] <= cost {
            return;
        }
        self.stamps[s] = self.stamp;
        self.costs[s] = cost;
        self.heap.push(state, cost + self.pace.cost(self.from, self.places[s]));
    }

    fn open_in(&mut self, atlas: &Atlas, way_in: u32, cost: f32) {
        match atlas.ins[way_in as usize] {
            In::Out { out: None, .. } => {}
            In::Out { out: Some(out), .. } => self.reach(atlas.ins.len() as u32 + out, cost),
            In::Tile { tile, class } => {
                let Some(region) = atlas.regions.of(tile) else { return };
                if self.next_stamps[way_in as usize] != self.stamp {
                    self.chain(region, way_in);
                }
                self.reach_outs(atlas, region, tile, class, cost);
            }
        }
    }

    /// Adds a way in to those of its region.
    fn chain(&mut self, region: u32, way_in: u32) {
        let r = region as usize;
        (self.next[way_in as usize], self.next_stamps[way_in as usize]) = (NONE, self.stamp);
        if self.chain_stamps[r] == self.stamp {
            self.next[self.chains[r][1] as usize] = way_in;
            self.chains[r][1] = way_in;
        } else {
            (self.chain_stamps[r], self.chains[r]) = (self.stamp, [way_in; 2]);
        }
    }

    fn open_out(&mut self, atlas: &Atlas, out: u32, cost: f32) {
        let district = atlas.outs[out as usize].district;
        let number = out - atlas.outs_of(district).start;
        let shape = atlas.shape(district);
        let tile = atlas.outs[out as usize].tile;
        for (k, way_in) in atlas.ins_of(district).enumerate() {
            // Nobody goes in to come out where it was before: costs from the best of its cells would be too low.
            let back = matches!(atlas.ins[way_in as usize], In::Tile { tile: t, .. } if Some(t) == tile);
            if !back {
                self.reach(way_in, cost + shape.across(k as u32, number));
            }
        }
    }

    /// What it costs to go on from a node by one of the ways in or out.
    fn estimate_by(&self, atlas: &Atlas, node: Node, state: u32, cost: f32) -> f32 {
        let here = atlas.district(node.instance);
        let Some(out) = (state as usize).checked_sub(atlas.ins.len()) else {
            let In::Tile { tile, class } = atlas.ins[state as usize] else { return f32::INFINITY };
            let (region, None) = (atlas.regions.of(tile), here) else { return f32::INFINITY };
            if region != atlas.regions.of(node.instance) {
                return f32::INFINITY;
            }
            let Some(plane) = region.and_then(|r| atlas.plane(r)) else { return f32::INFINITY };
            return cost + plane.cost(plane.look(class, atlas.regions.way(node.instance, tile)), node.cell);
        };
        let district = atlas.outs[out].district;
        let number = out as u32 - atlas.outs_of(district).start;
        match here {
            Some((d, first)) if d == district => cost + atlas.shape(d).to_out(number, first + node.cell),
            _ => f32::INFINITY,
        }
    }

    /// What it costs to go to the target without coming through another part of the world.
    fn estimate_direct(&self, atlas: &Atlas, node: Node) -> f32 {
        if let Some((district, first)) = atlas.district(node.instance) {
            return self.within(atlas, district, first + node.cell);
        }
        let (here, there) = (atlas.regions.of(node.instance), atlas.regions.of(self.end.instance));
        let Some(plane) = here.filter(|_| here == there).and_then(|r| atlas.plane(r)) else { return f32::INFINITY };
        let way = atlas.regions.way(node.instance, self.end.instance);
        self.near
            .cost(way, node.cell)
            .unwrap_or_else(|| near::least(plane, classes(self.end.classes), way, node.cell) + self.near.beside)
    }

    /// What it costs at least from a cell of the target's district to the target: the ways in and out are landmarks
    /// (Goldberg and Harrelson 2005).
    fn within(&self, atlas: &Atlas, district: u32, cell: u32) -> f32 {
        if self.end.district != Some(district) {
            return f32::INFINITY;
        }
        let (shape, mut least) = (atlas.shape(district), 0f32);
        for (k, &end) in self.end.to_out.iter().enumerate().filter(|(_, e)| **e < f32::INFINITY) {
            least = least.max(shape.to_out(k as u32, cell) - end);
        }
        for (k, &end) in self.end.from_in.iter().enumerate() {
            let here = shape.reach(k as u32, cell);
            least = if here < f32::INFINITY { least.max(end - here) } else { least };
        }
        least
    }

    /// What it costs from a cell of a district by the ways out of it.
    fn through(&self, atlas: &Atlas, district: u32, cell: u32) -> f32 {
        let (shape, first) = (atlas.shape(district), atlas.ins.len() + atlas.outs_of(district).start as usize);
        let mut least = f32::INFINITY;
        for k in 0..atlas.outs_of(district).len() {
            if self.stamps[first + k] == self.stamp {
                least = least.min(self.costs[first + k] + shape.to_out(k as u32, cell));
            }
        }
        least
    }

    /// The best ways on from a tile: by what they cost from the best of its cells.
    fn find_gates(&mut self, atlas: &Atlas, tile: u32) {
        let mut found = Gates { stamp: self.stamp, ..Gates::default() };
        let mut costs = [f32::INFINITY; MAX_GATES];
        let region = atlas.regions.of(tile);
        let Some((r, plane)) = region.and_then(|r| Some((r, atlas.plane(r)?))) else { return };
        let mut add = |class: u32, to: u32, cost: f32| {
            if cost >= costs[MAX_GATES - 1] {
                return;
            }
            let look = plane.look(class, atlas.regions.way(tile, to));
            let total = cost + plane.least(look);
            let at = costs[..found.len].partition_point(|&c| c <= total);
            if at < MAX_GATES && total < f32::INFINITY {
                found.len = (found.len + 1).min(MAX_GATES);
                costs[at..found.len].rotate_right(1);
                found.list[at..found.len].rotate_right(1);
                (costs[at], found.list[at]) = (total, Gate { look, cost });
            }
        };
        let mut near = false;
        if atlas.regions.of(self.end.instance) == region {
            near = self.near.cost(atlas.regions.way(tile, self.end.instance), 0).is_some();
            if !near {
                classes(self.end.classes).for_each(|class| add(class, self.end.instance, self.near.beside));
            }
        }
        let mut way_in = if self.chain_stamps[r as usize] == self.stamp { self.chains[r as usize][0] } else { NONE };
        while way_in != NONE {
            if let In::Tile { tile: to, class } = atlas.ins[way_in as usize] {
                add(class, to, self.costs[way_in as usize]);
            }
            way_in = self.next[way_in as usize];
        }
        found.near = near;
        self.gates[tile as usize] = found;
    }
}

/// Numbers of the bits that are set.
fn classes(bits: u32) -> impl Iterator<Item = u32> {
    (0..u32::BITS).filter(move |c| bits >> c & 1 == 1)
}
