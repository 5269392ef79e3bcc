//! What planning knows of a world beforehand: least costs on open ground and within what is climbed or sat on.
//!
//! Tiles that fill a plane together are a *region*; costs between them are those of the endless plane without obstacles,
//! one table a patch. A region with corners consists of *rooms*, with doors from one to another. All else that overlaps
//! is a *district*, with costs between its cells and its ways in and out, one table for all districts that are alike.
//! All costs are bounds: no way costs less.

mod dial;
mod districts;
mod landmarks;
mod plane;
mod regions;
mod roads;
mod rooms;
mod shape;

use super::WorldGraph;
use crate::patch::NONE;
use dial::Dial;
use districts::Districts;
pub(crate) use landmarks::{Landmarks, ToLandmarks};
pub(crate) use plane::{Look, Plane, Spot, class};
use regions::Regions;
use roads::Roads;
use shape::{Beyond, Plot, Shape};
use std::collections::{BTreeMap, BTreeSet};

/// A way into a part of the world.
#[derive(Clone, Copy, Debug)]
pub(crate) enum In {
    /// From some cells of a tile, into a district.
    Tile {
        /// The tile.
        tile: u32,
        /// The cells, see [`Plane`].
        goal: u32,
    },
    /// From another district into a district.
    Out {
        /// The other one.
        from: u32,
        /// This one.
        to: u32,
    },
    /// From one room into another one, to cells of a tile there that are entered across an edge.
    Door {
        /// The room that it leads from.
        from: u32,
        /// The tile.
        tile: u32,
        /// The cells, see [`Plane`].
        goal: u32,
    },
}

impl In {
    /// The room that it leads from where it is a door, and the tile and its cells that it leads by; none where it leads
    /// from another district.
    pub fn tile(&self) -> Option<(Option<u32>, u32, u32)> {
        match *self {
            Self::Tile { tile, goal } => Some((None, tile, goal)),
            Self::Door { from, tile, goal } => Some((Some(from), tile, goal)),
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
    shapes: Vec<Shape>,
    /// Shape of each district.
    shape_of: Vec<u32>,
    /// First way in and out of each district. [Size: districts + 1]
    first: Vec<[u32; 2]>,
    /// Ways into districts, and then the doors.
    pub ins: Vec<In>,
    /// Ways out of districts.
    pub outs: Vec<Out>,
    /// Ways out that lead to tiles of each room, by the tile that they lead through.
    pub room_outs: Vec<Vec<u32>>,
    /// Doors that lead into each room.
    pub room_doors: Vec<Vec<u32>>,
    /// Costs from the latter to the former.
    pub roads: Roads,
    /// Costs to some ways in from all ways in and out.
    pub landmarks: Landmarks,
}

impl Atlas {
    /// Works it out, in a fraction of a second for worlds of a few thousand instances that are much alike.
    pub fn new(graph: &WorldGraph<'_>) -> Self {
        let patches = graph.patches();
        let mut search = Dial::default();
        let planes: Vec<_> = (0..patches.patches.len()).map(|p| Plane::new(patches, p, &mut search)).collect();
        let regions = Regions::new(graph, &planes);
        let districts = Districts::new(graph, &regions);
        let num_rooms = regions.num_rooms();
        let mut out = Self {
            planes,
            regions,
            districts,
            shapes: Vec::new(),
            shape_of: Vec::new(),
            first: vec![[0, 0]],
            ins: Vec::new(),
            outs: Vec::new(),
            room_outs: vec![Vec::new(); num_rooms],
            room_doors: vec![Vec::new(); num_rooms],
            roads: Roads::default(),
            landmarks: Landmarks::default(),
        };
        out.add_districts(graph);
        for outs in &mut out.room_outs {
            outs.sort_by_key(|&o| out.outs[o as usize].tile);
        }
        for tile in 0..graph.num_instances() as u32 {
            out.add_doors(graph, tile);
        }
        out.roads = Roads::new(&out);
        out.landmarks = Landmarks::new(graph, &out);
        out
    }

    /// The plane of a room's tiles.
    pub fn plane(&self, room: u32) -> Option<&Plane> {
        self.planes[self.regions.patch(room) as usize].as_ref()
    }

    /// The room that a way in leads from, and the tile and its cells that it leads by; none where it leads from another
    /// district.
    pub fn leads_from(&self, way_in: u32) -> Option<(u32, u32, u32)> {
        let (from, tile, goal) = self.ins[way_in as usize].tile()?;
        Some((from.or_else(|| self.regions.room(tile))?, tile, goal))
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
        let (regions, districts) = (&self.regions, &self.districts);
        let plots: Vec<_> = (0..districts.members.len() as u32)
            .map(|district| Plot::new(graph, regions, districts, district))
            .collect();
        let (mut known, mut kinds) = (BTreeMap::new(), Vec::new());
        for plot in &plots {
            self.shape_of.push(*known.entry(plot.key()).or_insert_with(|| {
                kinds.push(plot);
                kinds.len() as u32 - 1
            }));
        }
        self.shapes = each(&kinds, |plot, search| Shape::new(plot, search));
        let mut goals = ways_in(graph, &kinds, &self.shapes);
        let planes = (0u32..).zip(&self.planes).filter_map(|(patch, plane)| Some((patch, plane.as_ref()?)));
        goals.extend(planes.flat_map(|(patch, p)| p.rests().into_iter().map(move |r| (patch, r))));
        add_goals(&mut self.planes, goals);
        for (plot, &shape) in plots.iter().zip(&self.shape_of) {
            let shape = &self.shapes[shape as usize];
            for &k in &shape.outs {
                let beyond = plot.beyond[k as usize];
                if let Some(room) = beyond.tile().and_then(|t| regions.room(t)) {
                    self.room_outs[room as usize].push(self.outs.len() as u32);
                }
                self.outs.push(Out { district: plot.district, tile: beyond.tile(), to: beyond.district() });
            }
            for (k, cells) in &shape.ins {
                self.ins.push(match plot.beyond[*k as usize] {
                    Beyond::Tile(tile) => {
                        let plane = self.planes[graph.instance(tile).patch as usize].as_ref();
                        In::Tile { tile, goal: plane.and_then(|p| p.goal(cells)).unwrap_or(0) }
                    }
                    Beyond::District(from) => In::Out { from, to: plot.district },
                });
            }
            self.first.push([self.ins.len() as u32, self.outs.len() as u32]);
        }
    }

    /// Adds the doors that lead to a tile.
    fn add_doors(&mut self, graph: &WorldGraph<'_>, tile: u32) {
        let Some(room) = self.regions.room(tile) else { return };
        let (r, patches) = (graph.instance(tile), graph.patches());
        for (goal, edge) in (0u32..).zip(patches.edges_of(r.patch as usize)) {
            let other = graph.world().neighbours[(r.first_neighbour + goal) as usize];
            if other == NONE || !graph.bounds.is_edge_open(graph.instance(other).first_neighbour + edge.opposite) {
                continue;
            }
            if let Some(from) = self.regions.room(other).filter(|f| *f != room) {
                self.room_doors[room as usize].push(self.ins.len() as u32);
                self.ins.push(In::Door { from, tile, goal });
            }
        }
    }
}

/// Patches with the cells that ways into districts begin in.
fn ways_in(graph: &WorldGraph<'_>, plots: &[&Plot<'_, '_>], shapes: &[Shape]) -> BTreeSet<(u32, Vec<Spot>)> {
    let mut goals = BTreeSet::new();
    for (plot, shape) in plots.iter().zip(shapes) {
        for (beyond, cells) in &shape.ins {
            let Some(tile) = plot.beyond[*beyond as usize].tile() else { continue };
            goals.insert((graph.instance(tile).patch, cells.clone()));
        }
    }
    goals
}

/// Adds cells of patches to the goals of their planes.
fn add_goals(planes: &mut [Option<Plane>], goals: BTreeSet<(u32, Vec<Spot>)>) {
    let goals: Vec<_> = goals.into_iter().filter(|(p, _)| planes[*p as usize].is_some()).collect();
    let cells: BTreeSet<_> = goals.iter().flat_map(|(p, cells)| cells.iter().map(|c| (*p, c.0))).collect();
    let cells: Vec<_> = cells.into_iter().collect();
    let rows = each(&cells, |&(p, cell), search| planes[p as usize].as_ref().map(|plane| plane.rows_to(cell, search)));
    let rows: BTreeMap<_, _> = cells.into_iter().zip(rows).filter_map(|(c, r)| Some((c, r?))).collect();
    for (patch, cells) in goals {
        let parts: Vec<_> = cells.iter().filter_map(|c| Some((rows.get(&(patch, c.0))?, c.1))).collect();
        if let Some(plane) = planes[patch as usize].as_mut().filter(|p| p.goal(&cells).is_none()) {
            let joined = plane.join(&parts);
            plane.add(joined);
        }
    }
}

/// What searches find for each of a list.
#[cfg(feature = "rayon")]
fn each<T: Sync, R: Send>(list: &[T], find: impl Fn(&T, &mut Dial) -> R + Sync) -> Vec<R> {
    use rayon::prelude::*;
    list.par_iter().map_init(Dial::default, |search, item| find(item, search)).collect()
}

/// What searches find for each of a list.
#[cfg(not(feature = "rayon"))]
fn each<T, R>(list: &[T], find: impl Fn(&T, &mut Dial) -> R) -> Vec<R> {
    let mut search = Dial::default();
    list.iter().map(|item| find(item, &mut search)).collect()
}
