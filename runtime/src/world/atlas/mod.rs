//! What planning knows of a world beforehand: least costs on open ground and within what is climbed or sat on.
//!
//! Tiles that fill a plane together are a *region*; costs between them are those of the endless plane without obstacles,
//! one table a patch. A region with corners consists of *rooms*, with doors from one to another. All else that overlaps
//! is a *district*, with costs between its cells and its ways in and out, one table for all districts that are alike.
//! All costs are bounds: no way costs less.

mod dial;
mod districts;
mod into;
mod plane;
mod regions;
mod rooms;
mod shape;

use super::WorldGraph;
use crate::patch::NONE;
use dial::Dial;
use districts::Districts;
pub(crate) use into::Into;
pub(crate) use plane::{Look, Plane, class};
use regions::Regions;
use shape::{Beyond, Plot, Shape};
use std::collections::BTreeMap;

/// A way into a part of the world.
#[derive(Clone, Copy, Debug)]
pub(crate) enum In {
    /// From cells of a class of a tile, into a district.
    Tile {
        /// The tile.
        tile: u32,
        /// See [`class`].
        class: u32,
    },
    /// From another district into a district.
    Out {
        /// The other one.
        from: u32,
        /// This one.
        to: u32,
    },
    /// From one room into another one, to cells of a class of a tile there.
    Door {
        /// The room that it leads from.
        from: u32,
        /// The tile.
        tile: u32,
        /// See [`class`].
        class: u32,
    },
}

impl In {
    /// The room that it leads from where it is a door, and the class of cells of a tile that it leads by; none where it
    /// leads from another district.
    pub fn tile(&self) -> Option<(Option<u32>, u32, u32)> {
        match *self {
            Self::Tile { tile, class } => Some((None, tile, class)),
            Self::Door { from, tile, class } => Some((Some(from), tile, class)),
            Self::Out { .. } => None,
        }
    }
}

/// A way out of a district.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Out {
    /// The district.
    pub district: u32,
    /// The tile whose links it leads along; none where it leads to another district.
    pub tile: Option<u32>,
    /// The other district.
    pub to: Option<u32>,
}

/// Costs of a world's parts, see the module.
#[derive(Clone, Debug)]
pub(crate) struct Atlas {
    planes: Vec<Option<Plane>>,
    /// Which tiles fill a plane together.
    pub regions: Regions,
    /// What else there is.
    pub districts: Districts,
    /// Which links lead into each cell.
    pub into: Into,
    shapes: Vec<Shape>,
    /// Shape of each district.
    shape_of: Vec<u32>,
    /// First way in and out of each district. [Size: districts + 1]
    first: Vec<[u32; 2]>,
    /// Ways into districts, and then the doors.
    pub ins: Vec<In>,
    /// Ways out of districts.
    pub outs: Vec<Out>,
    /// Ways out that lead to tiles of each room.
    pub room_outs: Vec<Vec<u32>>,
    /// Doors that lead into each room.
    pub room_doors: Vec<Vec<u32>>,
}

impl Atlas {
    /// Works it out, in a fraction of a second for worlds of a few thousand instances that are much alike.
    pub fn new(graph: &WorldGraph<'_>) -> Self {
        let patches = graph.patches();
        let planes: Vec<_> = (0..patches.patches.len()).map(|p| Plane::new(patches, p)).collect();
        let regions = Regions::new(graph, &planes);
        let districts = Districts::new(graph, &regions);
        let num_rooms = regions.num_rooms();
        let mut out = Self {
            planes,
            regions,
            districts,
            into: Into::new(patches),
            shapes: Vec::new(),
            shape_of: Vec::new(),
            first: vec![[0, 0]],
            ins: Vec::new(),
            outs: Vec::new(),
            room_outs: vec![Vec::new(); num_rooms],
            room_doors: vec![Vec::new(); num_rooms],
        };
        out.add_districts(graph);
        for tile in 0..graph.num_instances() as u32 {
            out.add_doors(graph, tile);
        }
        out
    }

    /// The plane of a room's tiles.
    pub fn plane(&self, room: u32) -> Option<&Plane> {
        self.planes[self.regions.patch(room) as usize].as_ref()
    }

    /// District of an instance, and the number of its first cell there; none for a tile of a region.
    pub fn district(&self, instance: u32) -> Option<(u32, u32)> {
        self.districts.of(instance).map(|d| (d, self.districts.first_cell(instance)))
    }

    /// Number of districts.
    pub fn num_districts(&self) -> usize {
        self.shape_of.len()
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

    fn add_districts(&mut self, graph: &WorldGraph<'_>) {
        let (planes, regions, districts) = (&self.planes, &self.regions, &self.districts);
        let plots: Vec<_> = (0..districts.members.len() as u32)
            .map(|district| Plot::new(graph, planes, regions, districts, district))
            .collect();
        let (mut known, mut kinds, mut shape_of) = (BTreeMap::new(), Vec::new(), Vec::new());
        for plot in &plots {
            shape_of.push(*known.entry(plot.key()).or_insert_with(|| {
                kinds.push(plot);
                kinds.len() as u32 - 1
            }));
        }
        let shapes = shapes(&kinds);
        let (mut ins, mut outs) = (Vec::new(), Vec::new());
        for (plot, &shape) in plots.iter().zip(&shape_of) {
            let shape = &shapes[shape as usize];
            for &k in &shape.outs {
                let beyond = plot.beyond[k as usize];
                if let Some(room) = beyond.tile().and_then(|t| regions.room(t)) {
                    self.room_outs[room as usize].push(outs.len() as u32);
                }
                outs.push(Out { district: plot.district, tile: beyond.tile(), to: beyond.district() });
            }
            ins.extend(shape.ins.iter().map(|&(k, class)| match plot.beyond[k as usize] {
                Beyond::Tile(tile) => In::Tile { tile, class },
                Beyond::District(from) => In::Out { from, to: plot.district },
            }));
            self.first.push([ins.len() as u32, outs.len() as u32]);
        }
        (self.shapes, self.shape_of, self.ins, self.outs) = (shapes, shape_of, ins, outs);
    }

    /// Adds the doors that lead to a tile.
    fn add_doors(&mut self, graph: &WorldGraph<'_>, tile: u32) {
        let Some(room) = self.regions.room(tile) else { return };
        let (r, patches) = (graph.instance(tile), graph.patches());
        for (class, edge) in (0u32..).zip(patches.edges_of(r.patch as usize)) {
            let other = graph.world().neighbours[(r.first_neighbour + class) as usize];
            if other == NONE || !graph.bounds.is_edge_open(graph.instance(other).first_neighbour + edge.opposite) {
                continue;
            }
            if let Some(from) = self.regions.room(other).filter(|f| *f != room) {
                self.room_doors[room as usize].push(self.ins.len() as u32);
                self.ins.push(In::Door { from, tile, class });
            }
        }
    }
}

/// The shapes of plots.
#[cfg(feature = "rayon")]
fn shapes(plots: &[&Plot<'_, '_>]) -> Vec<Shape> {
    use rayon::prelude::*;
    plots.par_iter().map_init(Dial::default, |search, plot| Shape::new(plot, search)).collect()
}

/// The shapes of plots.
#[cfg(not(feature = "rayon"))]
fn shapes(plots: &[&Plot<'_, '_>]) -> Vec<Shape> {
    let mut search = Dial::default();
    plots.iter().map(|plot| Shape::new(plot, &mut search)).collect()
}
