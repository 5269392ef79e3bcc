//! What planning knows of a world beforehand: least costs on open ground and within what is climbed or sat on.
//!
//! Tiles that fill a plane together are a *region*; costs between them are those of the endless plane without obstacles,
//! one table a patch. All else that overlaps is a *district*, with costs between its cells and its ways in and out, one
//! table for all districts that are alike. All costs are whole frames, so that they are the same everywhere.

mod dial;
mod districts;
mod plane;
mod regions;
mod shape;

use super::{Node, WorldGraph};
use dial::Dial;
use districts::Districts;
pub(crate) use plane::{Look, Plane, class};
use regions::Regions;
use shape::Plot;
pub(crate) use shape::{Beyond, Shape};
use std::collections::BTreeMap;

/// A way into a district.
#[derive(Clone, Copy, Debug)]
pub(crate) enum In {
    /// From cells of a class of a tile.
    Tile {
        /// The tile.
        tile: u32,
        /// See [`class`].
        class: u32,
    },
    /// From another district.
    Out {
        /// The other one.
        from: u32,
        /// This one.
        to: u32,
        /// The way out of the other one; none where it does not lead here.
        out: Option<u32>,
    },
}

/// A way out of a district.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Out {
    /// The district.
    pub district: u32,
    /// The tile whose links it leads along; none where it leads to another district.
    pub tile: Option<u32>,
    /// What it leads to.
    pub beyond: Beyond,
}

/// Costs of a world's parts, see the module.
#[derive(Clone, Debug)]
pub(crate) struct Atlas {
    planes: Vec<Option<Plane>>,
    /// Which tiles fill a plane together.
    pub regions: Regions,
    pub districts: Districts,
    shapes: Vec<Shape>,
    /// Shape of each district.
    shape_of: Vec<u32>,
    /// First way in and out of each district. [Size: districts + 1]
    first: Vec<[u32; 2]>,
    /// Ways into districts.
    pub ins: Vec<In>,
    /// Ways out of districts.
    pub outs: Vec<Out>,
    /// Ways out that lead to tiles of each region.
    pub region_outs: Vec<Vec<u32>>,
}

impl Atlas {
    /// Works it out, in a fraction of a second for worlds of a few thousand instances that are much alike.
    pub fn new(graph: &WorldGraph<'_>) -> Self {
        let patches = graph.patches();
        let planes: Vec<_> = (0..patches.patches.len()).map(|p| Plane::new(patches, p)).collect();
        let regions = Regions::new(graph, &planes);
        let districts = Districts::new(graph, &regions);
        let mut out = Self {
            region_outs: vec![Vec::new(); regions.len()],
            planes,
            regions,
            districts,
            shapes: Vec::new(),
            shape_of: Vec::new(),
            first: vec![[0, 0]],
            ins: Vec::new(),
            outs: Vec::new(),
        };
        let (mut known, mut search, mut between) = (BTreeMap::new(), Dial::default(), BTreeMap::new());
        for district in 0..out.districts.members.len() as u32 {
            let plot = Plot::new(graph, &out.planes, &out.regions, &out.districts, district);
            let shape = *known.entry(plot.key()).or_insert_with(|| {
                out.shapes.push(plot.shape(&mut search));
                out.shapes.len() as u32 - 1
            });
            out.shape_of.push(shape);
            let (shape, first) = (&out.shapes[shape as usize], [out.ins.len() as u32, out.outs.len() as u32]);
            for (n, &k) in shape.outs.iter().enumerate() {
                let tile = plot.beyond[k as usize].tile();
                if let Beyond::District(d) = plot.beyond[k as usize] {
                    between.insert((district, d), first[1] + n as u32);
                }
                if let Some(region) = tile.and_then(|t| out.regions.of(t)) {
                    out.region_outs[region as usize].push(first[1] + n as u32);
                }
                out.outs.push(Out { district, tile, beyond: plot.beyond[k as usize] });
            }
            for &(k, class) in &shape.ins {
                out.ins.push(match plot.beyond[k as usize] {
                    Beyond::Tile(tile) => In::Tile { tile, class },
                    Beyond::District(from) => In::Out { from, to: district, out: None },
                });
            }
            out.first.push([out.ins.len() as u32, out.outs.len() as u32]);
        }
        for way_in in &mut out.ins {
            if let In::Out { from, to, out } = way_in {
                *out = between.get(&(*from, *to)).copied();
            }
        }
        out
    }

    /// What a metre costs at least where one walks far; nothing is known where there is no plane. [Unit: frames/m]
    pub fn pace(&self) -> f32 {
        let least = self.planes.iter().flatten().map(|p| p.pace).fold(f32::INFINITY, f32::min);
        if least < f32::INFINITY { least } else { 0.0 }
    }

    /// The plane of a region's tiles.
    pub fn plane(&self, region: u32) -> Option<&Plane> {
        self.planes[self.regions.patch(region) as usize].as_ref()
    }

    /// District of an instance, and the number of its first cell there; none for a tile of a region.
    pub fn district(&self, instance: u32) -> Option<(u32, u32)> {
        self.districts.of(instance).map(|d| (d, self.districts.first_cell(instance)))
    }

    /// Number of districts.
    pub fn num_districts(&self) -> usize {
        self.shape_of.len()
    }

    /// Where the fastest way from a cell of a district by one of its ways out ends, and its frames; none where there is
    /// no such way.
    pub fn leap(&self, graph: &WorldGraph<'_>, out: u32, cell: u32) -> Option<(Node, u16)> {
        let way_out = &self.outs[out as usize];
        let number = out - self.outs_of(way_out.district).start;
        let (spot, frames) = self.shape(way_out.district).leap(number, cell)?;
        let instance = match way_out.beyond {
            Beyond::District(d) => *self.districts.members[d as usize].get(spot.way[0] as usize)?,
            Beyond::Tile(tile) => self.regions.tile_at(graph, self, tile, spot.way)?,
        };
        let node = Node { instance, cell: spot.cell };
        graph.is_node(node).then_some((node, frames))
    }

    /// Costs within a district.
    pub fn shape(&self, district: u32) -> &Shape {
        &self.shapes[self.shape_of[district as usize] as usize]
    }

    /// Ways into a district.
    pub fn ins_of(&self, district: u32) -> std::ops::Range<u32> {
        self.first[district as usize][0]..self.first[district as usize + 1][0]
    }

    /// Ways out of a district.
    pub fn outs_of(&self, district: u32) -> std::ops::Range<u32> {
        self.first[district as usize][1]..self.first[district as usize + 1][1]
    }
}
