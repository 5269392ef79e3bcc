//! Regions: tiles that fill a plane together, with what stands where among them, and the rooms that they consist of.

use super::plane::Plane;
use super::rooms;
use crate::patch::NONE;
use crate::world::WorldGraph;
use std::collections::BTreeMap;

/// Regions of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct Regions {
    /// Region of each instance; [`NONE`] for blocks and for tiles that fill no plane. [Size: instances]
    of: Vec<u32>,
    /// Room of each instance, as its region. [Size: instances]
    rooms: Vec<u32>,
    /// Where each stands in its region. [Unit: copies] [Size: instances]
    places: Vec<[i32; 2]>,
    /// Patch of each room's tiles.
    patches: Vec<u32>,
}

impl Regions {
    /// Follows neighbours from tile to tile.
    pub fn new(graph: &WorldGraph<'_>, planes: &[Option<Plane>]) -> Self {
        let n = graph.num_instances();
        let mut out = Self { of: vec![NONE; n], rooms: vec![NONE; n], places: vec![[0, 0]; n], patches: Vec::new() };
        let (mut tiles, mut region) = (Vec::new(), 0);
        for first in 0..n as u32 {
            let patch = graph.instance(first).patch;
            let (NONE, Some(plane)) = (out.of[first as usize], &planes[patch as usize]) else { continue };
            out.of[first as usize] = region;
            tiles.clear();
            tiles.push(first);
            let mut next = 0;
            while let Some(&i) = tiles.get(next) {
                next += 1;
                let [u, v] = out.places[i as usize];
                let first = graph.instance(i).first_neighbour as usize;
                for (&o, [du, dv]) in graph.world().neighbours[first..].iter().zip(&plane.steps) {
                    if o != NONE && out.of[o as usize] == NONE {
                        out.of[o as usize] = region;
                        out.places[o as usize] = [u + du, v + dv];
                        tiles.push(o);
                    }
                }
            }
            out.part(patch, &tiles);
            region += 1;
        }
        out
    }

    /// Number of rooms.
    pub fn num_rooms(&self) -> usize {
        self.patches.len()
    }

    /// Region of an instance; none where it is part of a district.
    pub fn of(&self, instance: u32) -> Option<u32> {
        Some(self.of[instance as usize]).filter(|r| *r != NONE)
    }

    /// Room of an instance; none where it is part of a district.
    pub fn room(&self, instance: u32) -> Option<u32> {
        Some(self.rooms[instance as usize]).filter(|r| *r != NONE)
    }

    /// Patch of a room's tiles.
    pub fn patch(&self, room: u32) -> u32 {
        self.patches[room as usize]
    }

    /// Where a tile stands in its region. [Unit: copies]
    pub fn place(&self, tile: u32) -> [i32; 2] {
        self.places[tile as usize]
    }

    /// How many copies away another tile of the same region stands.
    pub fn way(&self, from: u32, to: u32) -> [i32; 2] {
        let (a, b) = (self.places[from as usize], self.places[to as usize]);
        [b[0] - a[0], b[1] - a[1]]
    }

    /// Parts a region into rooms.
    fn part(&mut self, patch: u32, tiles: &[u32]) {
        let places: BTreeMap<[i32; 2], u32> = tiles.iter().map(|&t| (self.places[t as usize], t)).collect();
        for room in rooms::part(places.keys().copied().collect()) {
            room.iter().for_each(|place| self.rooms[places[place] as usize] = self.patches.len() as u32);
            self.patches.push(patch);
        }
        // Where two stand in one place, the other one is a room of its own.
        for &tile in tiles {
            if self.rooms[tile as usize] == NONE {
                self.rooms[tile as usize] = self.patches.len() as u32;
                self.patches.push(patch);
            }
        }
    }
}
