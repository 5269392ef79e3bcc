//! Regions: tiles that fill a plane together, with what stands where among them.

use super::plane::Plane;
use crate::patch::NONE;
use crate::world::WorldGraph;

/// Regions of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct Regions {
    /// Region of each instance; [`NONE`] for blocks and for tiles that fill no plane. [Size: instances]
    of: Vec<u32>,
    /// Where each stands in its region. [Unit: copies] [Size: instances]
    places: Vec<[i32; 2]>,
    /// Patch of each region.
    patches: Vec<u32>,
}

impl Regions {
    /// Follows neighbours from tile to tile.
    pub fn new(graph: &WorldGraph<'_>, planes: &[Option<Plane>]) -> Self {
        let n = graph.num_instances();
        let mut out = Self { of: vec![NONE; n], places: vec![[0, 0]; n], patches: Vec::new() };
        let mut queue = Vec::new();
        for first in 0..n as u32 {
            let patch = graph.instance(first).patch;
            let (NONE, Some(plane)) = (out.of[first as usize], &planes[patch as usize]) else { continue };
            let region = out.patches.len() as u32;
            out.patches.push(patch);
            out.of[first as usize] = region;
            queue.push(first);
            while let Some(i) = queue.pop() {
                let [u, v] = out.places[i as usize];
                let first = graph.instance(i).first_neighbour as usize;
                for (&o, [du, dv]) in graph.world().neighbours[first..].iter().zip(&plane.steps) {
                    if o != NONE && out.of[o as usize] == NONE {
                        out.of[o as usize] = region;
                        out.places[o as usize] = [u + du, v + dv];
                        queue.push(o);
                    }
                }
            }
        }
        out
    }

    /// Number of regions.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    /// Region of an instance; none where it is part of a district.
    pub fn of(&self, instance: u32) -> Option<u32> {
        Some(self.of[instance as usize]).filter(|r| *r != NONE)
    }

    /// Patch of a region's tiles.
    pub fn patch(&self, region: u32) -> u32 {
        self.patches[region as usize]
    }

    /// A tile, or the neighbour so many copies away.
    pub fn tile_at(&self, graph: &WorldGraph<'_>, atlas: &super::Atlas, tile: u32, way: [i32; 2]) -> Option<u32> {
        if way == [0, 0] {
            return Some(tile);
        }
        let edge = atlas.plane(self.of(tile)?)?.steps.iter().position(|s| *s == way)?;
        let slot = graph.instance(tile).first_neighbour as usize + edge;
        Some(graph.world().neighbours[slot]).filter(|n| *n != NONE)
    }

    /// How many copies away another tile of the same region stands.
    pub fn way(&self, from: u32, to: u32) -> [i32; 2] {
        let (a, b) = (self.places[from as usize], self.places[to as usize]);
        [b[0] - a[0], b[1] - a[1]]
    }
}
