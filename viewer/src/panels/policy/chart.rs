//! A target grid seen from above: ring sectors around its centre, for a character that faces up, with its left side at
//! the left. Places are in the frame of the grid; the character stands at minus the centre.

use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use std::ops::Range;
use throng_core::policy::{GridRecord, KIND_SPACE_TIME, TargetGrid};

/// The part of the ground that is nearest to a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartSector {
    /// Nearest and farthest distance (m).
    pub radii: [f32; 2],
    /// First and last angle, from straight ahead to the left (rad).
    pub angles: [f32; 2],
}

impl ChartSector {
    /// True for a place close to one of its edges.
    #[cfg(test)]
    fn is_edge(&self, p: Vec2) -> bool {
        let angle = p.x.atan2(p.y);
        let near = |v: f32, edges: [f32; 2]| edges.iter().any(|e| (v - e).abs() < 1e-5);
        near(p.length(), self.radii) || [-TAU, 0.0, TAU].iter().any(|turn| near(angle + turn, self.angles))
    }

    /// True for a place in it, the inner edges included.
    #[cfg(test)]
    fn contains(&self, p: Vec2) -> bool {
        let (distance, angle) = (p.length(), p.x.atan2(p.y));
        let within = |v: f32, [low, high]: [f32; 2]| v >= low && v < high;
        within(distance, self.radii) && [-TAU, 0.0, TAU].iter().any(|turn| within(angle + turn, self.angles))
    }
}

/// The cells of one height as sectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolicyChart {
    /// Record of the grid.
    pub record: GridRecord,
}

impl PolicyChart {
    /// The chart of a grid.
    pub fn new(grid: &TargetGrid) -> Self {
        Self { record: *grid.record() }
    }

    /// Numbers of the cells of a height.
    pub fn cells(&self, height: u32) -> Range<usize> {
        let plane = (self.record.num_rings * self.record.num_angles) as usize;
        height as usize * plane..(height as usize + 1) * plane
    }

    /// Distance of a ring number, fractions in between (m).
    pub fn radius(&self, number: f32) -> f32 {
        let r = &self.record;
        (r.ring_start + number * (r.ring_spacing + r.ring_growth * number.abs())).max(0.0)
    }

    /// Outer radius of the outermost cells (m).
    pub fn rim(&self) -> f32 {
        self.radius(self.record.num_rings as f32 - 0.5)
    }

    /// The sector of a cell, whatever its height.
    pub fn sector(&self, cell: usize) -> ChartSector {
        let r = &self.record;
        let ring = (cell / r.num_angles as usize % r.num_rings as usize) as f32;
        let angle = (cell % r.num_angles as usize) as f32;
        let [low, high] = self.angles();
        let at = |n: f32| (r.angle_start + n * r.angle_spacing).clamp(low, high);
        ChartSector {
            radii: [self.radius(ring - 0.5), self.radius(ring + 0.5)],
            angles: [at(angle - 0.5), at(angle + 0.5)],
        }
    }

    /// First and last angle of all sectors; never more than a full turn (rad).
    pub fn angles(&self) -> [f32; 2] {
        let r = &self.record;
        let half = 0.5 * r.num_angles as f32 * r.angle_spacing;
        let middle = r.angle_start + half - 0.5 * r.angle_spacing;
        [middle - half.min(PI), middle + half.min(PI)]
    }

    /// True where some sector covers a place.
    pub fn covers(&self, p: Vec2) -> bool {
        let [low, high] = self.angles();
        let angle = p.x.atan2(p.y);
        let inside = [-TAU, 0.0, TAU].iter().any(|t| (low..=high).contains(&(angle + t)));
        let distance = p.length();
        inside && distance >= self.radius(-0.5) && distance <= self.rim()
    }

    /// A box around all sectors and one more place: least and greatest left and ahead (m).
    pub fn bounds(&self, more: Vec2) -> [Vec2; 2] {
        let [from, to] = self.angles();
        let radii = [self.radius(-0.5), self.rim()];
        const PARTS: usize = 64;
        let angle = |i: usize| from + (to - from) * i as f32 / PARTS as f32;
        let places = (0..=PARTS).flat_map(|i| radii.map(|r| polar(angle(i), r)));
        places.fold([more, more], |[low, high], p| [low.min(p), high.max(p)])
    }

    /// Text of a plane's height or time.
    pub fn height_name(&self, index: u32) -> String {
        let h = self.height(index);
        if self.record.kind == KIND_SPACE_TIME { format!("{h:.2} s left") } else { format!("{h:.2} m high") }
    }

    /// The plane nearest to a height.
    pub fn nearest_height(&self, height: f32) -> u32 {
        let number = (height - self.record.height_start) / self.record.height_spacing;
        (number.round().max(0.0) as u32).min(self.record.num_heights - 1)
    }

    /// Height of a plane, or the time left that it stands for (m or s).
    pub fn height(&self, index: u32) -> f32 {
        self.record.height_start + index as f32 * self.record.height_spacing
    }

    /// A place of the ground at a height, as a target in the grid.
    pub fn target(&self, p: Vec2, height: u32) -> Vec3 {
        Vec3::new(p.x, self.height(height), p.y)
    }
}

/// Place at an angle and a distance: x to the left, y ahead.
pub fn polar(angle: f32, distance: f32) -> Vec2 {
    Vec2::new(angle.sin(), angle.cos()) * distance
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    fn grids() -> [TargetGrid; 4] {
        let sector = (Vec3::new(-1.1, 0.3, 1.2), Vec3::new(1.3, 1.3, 1.6));
        let wide = (Vec3::new(-3.0, 0.5, 1.2), Vec3::new(3.0, 1.5, 1.6));
        [
            TargetGrid::polar(16, 32, 8.0, 0.25, 2.5).unwrap(),
            TargetGrid::polar(5, 13, 2.0, 0.5, 2.5).unwrap(),
            TargetGrid::cylinder([10, 10, 4], sector.0, sector.1, 0.1).unwrap(),
            TargetGrid::cylinder([7, 5, 3], wide.0, wide.1, 0.1).unwrap(),
        ]
    }

    #[test]
    fn every_place_lies_in_one_sector_which_is_that_of_the_nearest_cell() {
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        for grid in grids() {
            let chart = PolicyChart::new(&grid);
            let height = grid.record().num_heights - 1;
            for _ in 0..3000 {
                let p = polar(rng.random_range(-PI..PI), rng.random_range(0.0..1.1) * chart.rim());
                let found: Vec<usize> = chart.cells(height).filter(|&c| chart.sector(c).contains(p)).collect();
                if chart.covers(p) {
                    assert_eq!(found.len(), 1, "{p}");
                    let nearest = grid.nearest_cell(chart.target(p, height));
                    // The grid's angles are off by up to 4e-6 rad, which tells at an edge.
                    assert!(found[0] == nearest || chart.sector(found[0]).is_edge(p), "{p} {found:?} {nearest}");
                } else {
                    assert!(found.is_empty(), "{p}");
                }
            }
        }
    }

    #[test]
    fn the_bounds_hold_every_sector_and_no_more() {
        for grid in grids() {
            let chart = PolicyChart::new(&grid);
            let [low, high] = chart.bounds(Vec2::ZERO);
            let mut reached = [Vec2::ZERO; 2];
            let edges = chart.cells(0).map(|c| chart.sector(c));
            let corners = edges.flat_map(|s| s.angles.map(|a| s.radii.map(|r| polar(a, r)))).flatten();
            for p in corners {
                assert!(p.cmpge(low - 0.01).all() && p.cmple(high + 0.01).all(), "{p}");
                reached = [reached[0].min(p), reached[1].max(p)];
            }
            assert!((reached[1] - high).abs().max_element() < 0.15 * chart.rim(), "{reached:?} {high}");
        }
    }

    #[test]
    fn the_nearest_height_is_found_within_the_grid() {
        let chart = PolicyChart::new(&grids()[2]);
        assert_eq!(chart.nearest_height(chart.height(2) + 0.01), 2);
        assert_eq!((chart.nearest_height(-9.0), chart.nearest_height(9.0)), (0, 3));
    }

    #[test]
    fn sectors_fill_the_disc() {
        for grid in grids().iter().filter(|g| g.is_polar()) {
            let chart = PolicyChart::new(grid);
            let area = |s: ChartSector| {
                0.5 * (s.angles[1] - s.angles[0]) * (s.radii[1] * s.radii[1] - s.radii[0] * s.radii[0])
            };
            let sum: f32 = chart.cells(0).map(|c| area(chart.sector(c))).sum();
            let disc = PI * chart.rim() * chart.rim();
            assert!((sum / disc - 1.0).abs() < 1e-4, "{sum} {disc}");
        }
    }
}
