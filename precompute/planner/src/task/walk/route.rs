//! Paths on the ground past obstacles.

use crate::rotation::Rigid;
use glam::{DVec2, DVec3};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use throng_geometry::{Segment, SolidShape};

/// Side of a cell of the ground (m).
const CELL_M: f64 = 0.1;
/// Heights between which a thing is an obstacle (m).
const HEIGHTS_M: [f64; 2] = [0.2, 1.6];
/// Half width of the path that a walker needs, and half width at both ends (m).
const ROOM_M: f64 = 0.32;
const NARROW_M: f64 = 0.16;
/// Distance from its ends from which a path has its full width (m).
const NEAR_M: f64 = 0.6;
/// Largest detour beyond the ends of a path (m).
const DETOUR_M: f64 = 4.0;
/// Most cells that are searched.
const MOST_CELLS: usize = 200_000;
/// Number of times that corners are cut, and distances from a corner, of which the first that stays free is taken (m).
const CUTS: u32 = 4;
const CUTS_M: [f64; 3] = [0.6, 0.3, 0.15];
/// Width beside what is needed that is searched for, so that corners can be cut (m).
const SPARE_M: f64 = 0.15;

/// Obstacles on the ground.
pub(super) struct RouteObstacles {
    pub things: Vec<(SolidShape, Rigid)>,
    /// Discs that no path enters: middle and radius (m).
    pub discs: Vec<(DVec2, f64)>,
}

impl RouteObstacles {
    /// The shortest free path, with its corners cut; `None` where there is none.
    ///
    /// # Source
    /// Hart, Nilsson and Raphael 1968 (A*); Chaikin 1974 (corners).
    pub fn find_path(&self, from: DVec2, to: DVec2) -> Option<Vec<DVec2>> {
        let corners = [SPARE_M, 0.0].into_iter().find_map(|spare_m| {
            RouteSearch { ground: self, ends: [from, to], spare_m, cells: HashMap::new() }.find_path()
        })?;
        let is_free = |path: &Vec<DVec2>| path.windows(2).all(|w| self.is_line_free(w[0], w[1], [from, to], 0.0));
        let smooth = CUTS_M.into_iter().map(|most| cut_corners(&corners, most)).find(is_free);
        Some(smooth.unwrap_or(corners))
    }

    fn is_free(&self, p: DVec2, ends: [DVec2; 2], spare_m: f64) -> bool {
        let near = ends.into_iter().map(|e| e.distance(p)).fold(f64::INFINITY, f64::min);
        // Half of the width that a path needs there (m).
        let room = NARROW_M + (ROOM_M + spare_m - NARROW_M) * (near / NEAR_M).min(1.0);
        let [low, high] = HEIGHTS_M.map(|y| DVec3::new(p.x, y, p.y));
        self.discs.iter().all(|(at, radius)| at.distance(p) >= radius + room)
            && self.things.iter().all(|(shape, place)| {
                let column = Segment::new(place.local_point(low), place.local_point(high));
                !shape.is_nearer(&column, room)
            })
    }

    fn is_line_free(&self, a: DVec2, b: DVec2, ends: [DVec2; 2], spare_m: f64) -> bool {
        let steps = (a.distance(b) / (0.5 * CELL_M)).ceil().max(1.0) as usize;
        (0..=steps).all(|i| self.is_free(a.lerp(b, i as f64 / steps as f64), ends, spare_m))
    }
}

type Cell = (i32, i32);

struct RouteSearch<'a> {
    ground: &'a RouteObstacles,
    ends: [DVec2; 2],
    spare_m: f64,
    /// Whether cells are free, as far as they were tested.
    cells: HashMap<Cell, bool>,
}

impl RouteSearch<'_> {
    fn cell_position(&self, cell: Cell) -> DVec2 {
        self.ends[0] + CELL_M * DVec2::new(f64::from(cell.0), f64::from(cell.1))
    }

    fn is_free(&mut self, cell: Cell) -> bool {
        let (p, ends, spare_m) = (self.cell_position(cell), self.ends, self.spare_m);
        let around = ends[0].min(ends[1]) - DETOUR_M..=ends[0].max(ends[1]) + DETOUR_M;
        let inside = p.cmpge(*around.start()).all() && p.cmple(*around.end()).all();
        let ground = self.ground;
        inside && *self.cells.entry(cell).or_insert_with(|| ground.is_free(p, ends, spare_m))
    }

    fn is_line_free(&self, a: DVec2, b: DVec2) -> bool {
        self.ground.is_line_free(a, b, self.ends, self.spare_m)
    }

    fn find_path(mut self) -> Option<Vec<DVec2>> {
        let [from, to] = self.ends;
        if self.is_line_free(from, to) {
            return Some(vec![from, to]);
        }
        let estimate = |s: &Self, c: Cell| (1e6 * s.cell_position(c).distance(to)) as u64;
        let mut open = BinaryHeap::from([Reverse((estimate(&self, (0, 0)), 0u64, (0, 0)))]);
        let mut best: HashMap<Cell, (u64, Cell)> = HashMap::from([((0, 0), (0, (0, 0)))]);
        while let Some(Reverse((_, cost, cell))) = open.pop() {
            if best[&cell].0 < cost {
                continue;
            }
            if self.cell_position(cell).distance(to) < 1.5 * CELL_M && self.is_line_free(self.cell_position(cell), to) {
                return Some(self.shortened_path(&best, cell));
            }
            if best.len() > MOST_CELLS {
                return None;
            }
            for (dx, dz) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)] {
                let next = (cell.0 + dx, cell.1 + dz);
                let length = CELL_M * f64::from(dx * dx + dz * dz).sqrt();
                let cost = cost + (1e6 * length) as u64;
                if best.get(&next).is_none_or(|b| cost < b.0) && self.is_free(next) {
                    best.insert(next, (cost, cell));
                    open.push(Reverse((cost + estimate(&self, next), cost, next)));
                }
            }
        }
        None
    }

    /// The path back to the start, pulled tight.
    fn shortened_path(&self, best: &HashMap<Cell, (u64, Cell)>, mut cell: Cell) -> Vec<DVec2> {
        let mut all = vec![self.ends[1]];
        while cell != (0, 0) {
            all.push(self.cell_position(cell));
            cell = best[&cell].1;
        }
        all.push(self.ends[0]);
        all.reverse();
        let mut out = vec![all[0]];
        let mut at = 0;
        while at + 1 < all.len() {
            let farthest = (at + 2..all.len()).rev().find(|k| self.is_line_free(all[at], all[*k]));
            at = farthest.unwrap_or(at + 1);
            out.push(all[at]);
        }
        out
    }
}

/// Cuts corners of a path, again and again; its ends stay.
fn cut_corners(path: &[DVec2], most_m: f64) -> Vec<DVec2> {
    let mut path = path.to_vec();
    for round in 0..CUTS {
        let most = most_m / f64::from(1u32 << round);
        let mut out = vec![path[0]];
        for w in path.windows(3) {
            let [a, b] = [w[0], w[2]].map(|p| w[1] + (p - w[1]).clamp_length_max(most.min(0.25 * p.distance(w[1]))));
            out.extend([a, b]);
        }
        out.push(path[path.len() - 1]);
        path = out;
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ground(things: &[(DVec3, DVec3)]) -> RouteObstacles {
        let things = things.iter().map(|(size, at)| (SolidShape::cuboid(*size), Rigid::from_position(*at))).collect();
        RouteObstacles { things, discs: Vec::new() }
    }

    #[test]
    fn ways_are_straight_or_go_round_with_room() {
        let (from, to) = (DVec2::new(0.0, -2.0), DVec2::new(0.0, 2.0));
        assert_eq!(ground(&[]).find_path(from, to), Some(vec![from, to]));
        // A wall, and a lamp that hangs above everybody.
        let wall = ground(&[
            (DVec3::new(2.0, 2.0, 0.1), DVec3::new(0.3, 1.0, 0.0)),
            (DVec3::splat(0.3), DVec3::new(-1.2, 2.4, 0.0)),
        ]);
        let path = wall.find_path(from, to).expect("a way");
        assert!(path[0] == from && path[path.len() - 1] == to && path.len() > 4);
        let length: f64 = path.windows(2).map(|w| w[0].distance(w[1])).sum();
        // Round the nearer end: at least as far as a string with the room that a walker needs.
        let corner = DVec2::new(-0.7 - 0.32, 0.0);
        assert!(length > 2.0 * corner.distance(to) - 0.2 && length < 2.0 * corner.distance(to) + 0.5, "{length}");
        for w in path.windows(2) {
            for i in 0..20 {
                let p = w[0].lerp(w[1], f64::from(i) / 20.0);
                let beside = DVec2::new((p.x - 0.3).abs() - 1.0, p.y.abs() - 0.05).max(DVec2::ZERO).length();
                assert!(beside > 0.3, "{p}: {beside}");
            }
        }
        // Nothing leads out of a room.
        let side = |x: f64, z: f64| (DVec3::new(4.0, 2.0, 0.1), DVec3::new(x, 1.0, z));
        let end = |x: f64| (DVec3::new(0.1, 2.0, 4.0), DVec3::new(x, 1.0, -2.0));
        assert_eq!(ground(&[side(0.0, 0.0), side(0.0, -4.0), end(-2.0), end(2.0)]).find_path(from, to), None);
    }
}
