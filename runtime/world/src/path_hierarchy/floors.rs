//! Floors: tiles that fill a plane together, with what stands where among them, and the regions that they consist of.

use super::{plane::TilePlane, regions};
use crate::WorldGraph;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_core::patch::NONE;

/// No tile stands farther from the first one of its floor (copies).
const MAX_PLACE: i32 = 1 << 24;

/// Floors of a world.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Floors {
    /// Floor of each instance; [`NONE`] for blocks and for tiles that fill no plane (instances).
    #[serde(with = "crate::pod")]
    of: Vec<u32>,
    /// Region of each instance, as its floor (instances).
    #[serde(with = "crate::pod")]
    regions: Vec<u32>,
    /// Position of each tile in its floor (copies, instances).
    #[serde(with = "crate::pod")]
    pub places: Vec<[i32; 2]>,
    /// Patch of each region's tiles.
    #[serde(with = "crate::pod")]
    pub patches: Vec<u32>,
}

impl Floors {
    /// Follows neighbours from tile to tile.
    pub fn new(graph: &WorldGraph, planes: &[Option<TilePlane>]) -> Self {
        let n = graph.num_instances();
        let mut out = Self { of: vec![NONE; n], regions: vec![NONE; n], places: vec![[0, 0]; n], patches: Vec::new() };
        let (mut tiles, mut floor) = (Vec::new(), 0);
        for first in 0..n as u32 {
            let patch = graph.instance(first).patch;
            let (NONE, Some(plane)) = (out.of[first as usize], &planes[patch as usize]) else { continue };
            out.of[first as usize] = floor;
            tiles.clear();
            tiles.push(first);
            let mut next = 0;
            while let Some(&i) = tiles.get(next) {
                next += 1;
                let [u, v] = out.places[i as usize];
                let first = graph.instance(i).first_neighbour as usize;
                for (&o, [du, dv]) in graph.world().neighbours[first..].iter().zip(&plane.steps) {
                    if o != NONE && out.of[o as usize] == NONE {
                        out.of[o as usize] = floor;
                        out.places[o as usize] = [u + du, v + dv];
                        tiles.push(o);
                    }
                }
            }
            out.part(patch, &tiles);
            floor += 1;
        }
        out
    }

    /// True where every instance has a place, and regions consist of tiles of one patch that fills a plane.
    pub fn is_sound(&self, graph: &WorldGraph, planes: &[Option<TilePlane>]) -> bool {
        let n = graph.num_instances();
        let patch_of = |r: u32| self.patches.get(r as usize).copied();
        let region = |(i, &r): (u32, &u32)| r == NONE || patch_of(r) == Some(graph.instance(i).patch);
        [self.of.len(), self.regions.len(), self.places.len()] == [n; 3]
            && self.patches.iter().all(|&p| planes.get(p as usize).is_some_and(Option::is_some))
            && (0u32..).zip(&self.regions).all(region)
            // The least number has no positive counterpart.
            && self.places.iter().flatten().all(|p| (-MAX_PLACE..=MAX_PLACE).contains(p))
    }

    /// Number of regions.
    pub fn num_regions(&self) -> usize {
        self.patches.len()
    }

    /// Floor of an instance; none where it is part of a cluster.
    pub fn floor_of(&self, instance: u32) -> Option<u32> {
        Some(self.of[instance as usize]).filter(|r| *r != NONE)
    }

    /// Region of an instance; none where it is part of a cluster.
    pub fn region(&self, instance: u32) -> Option<u32> {
        Some(self.regions[instance as usize]).filter(|r| *r != NONE)
    }

    /// Offset to another tile of the same floor (copies).
    pub fn offset(&self, from: u32, to: u32) -> [i32; 2] {
        let (a, b) = (self.places[from as usize], self.places[to as usize]);
        [b[0] - a[0], b[1] - a[1]]
    }

    /// Parts a floor into regions.
    fn part(&mut self, patch: u32, tiles: &[u32]) {
        let places: BTreeMap<[i32; 2], u32> = tiles.iter().map(|&t| (self.places[t as usize], t)).collect();
        for region in regions::part_into_regions(places.keys().copied().collect()) {
            region.iter().for_each(|place| self.regions[places[place] as usize] = self.patches.len() as u32);
            self.patches.push(patch);
        }
        // Of two tiles in one place, the second one is a region of its own.
        for &tile in tiles {
            if self.regions[tile as usize] == NONE {
                self.regions[tile as usize] = self.patches.len() as u32;
                self.patches.push(patch);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{Tile, places};

    #[test]
    fn places_that_are_too_far_are_refused_to_the_last_number() {
        let tile = Tile::crossed_in(20, 16);
        let world = tile.floor(&places([3, 4, 2]));
        let graph = WorldGraph::new(&tile.patches(), &world.tables()).unwrap();
        let n = graph.num_instances();
        let far = [MAX_PLACE + 1, -MAX_PLACE - 1, i32::MAX, i32::MIN];
        for (place, is_near) in [0, MAX_PLACE, -MAX_PLACE].map(|p| (p, true)).into_iter().chain(far.map(|p| (p, false)))
        {
            let floors =
                Floors { of: vec![0; n], regions: vec![NONE; n], places: vec![[0, place]; n], patches: Vec::new() };
            assert_eq!(floors.is_sound(&graph, &[]), is_near, "{place}");
        }
    }
}
