//! Squares of ground around a character, with upper bounds of values in each of them.

use glam::{Vec2, Vec3};
use std::f32::consts::PI;
use throng_core::policy::{PolicyTable, Stencil};

/// A grid of squares centred on the middle of a policy's grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GroundSquares {
    /// Squares along a side.
    pub side: usize,
    /// Extent from the centre to each side (m).
    pub reach: f32,
}

impl GroundSquares {
    /// Length of a square's side (m).
    pub fn size(&self) -> f32 {
        2.0 * self.reach / self.side as f32
    }

    /// Distance of a square's corners from its centre, plus a margin for rounding (m).
    pub fn radius(&self) -> f32 {
        self.size() * std::f32::consts::FRAC_1_SQRT_2 * 1.001
    }

    /// Column and row of the square with a place, if any.
    pub fn square_at(&self, place: Vec2) -> Option<[usize; 2]> {
        let at = (place + self.reach) / self.size();
        let limit = self.side as f32;
        let within = at.x >= 0.0 && at.y >= 0.0 && at.x < limit && at.y < limit;
        within.then_some([at.x as usize, at.y as usize])
    }

    /// A square's centre (m).
    pub fn centre(&self, column: usize, row: usize) -> Vec2 {
        (Vec2::new(column as f32, row as f32) + 0.5) * self.size() - self.reach
    }
}

/// Candidate positions of the greatest value of a policy within a disc: its rim, and cell centres.
///
/// Values are linear along every axis of a cell, so that the greatest one in a range of distances, angles and heights
/// is at the ends of the ranges or at the centres of cells between them.
pub(super) struct PeakCandidates {
    stencils: Vec<Stencil>,
    /// Index of the lower height, and ratio to the next one.
    heights: Vec<(usize, f32)>,
    /// Largest factor on a positive value for a disc beyond the grid.
    scale: f32,
}

impl PeakCandidates {
    /// - `heights`: of the target, lowest and highest (m).
    pub fn new(table: &PolicyTable, centre: Vec2, radius: f32, heights: [f32; 2]) -> Self {
        let grid = table.grid();
        let r = grid.record();
        let [near, far] = [(centre.length() - radius).max(0.0), centre.length() + radius];
        let rings = (0..r.num_rings as usize).map(|k| grid.cell_coordinates(k * r.num_angles as usize).y);
        let distances = knots([near, far].map(|d| d.clamp(r.ring_start, grid.radius())), rings);
        // Angles relative to that of the disc's centre, so that a range never crosses the seam.
        let ahead = centre.x.atan2(centre.y);
        let half = if centre.length() > radius { (radius / centre.length()).asin() + 1e-4 } else { PI };
        let turn = |a: f32| throng_core::planar::wrap_angle(a - ahead);
        let of_cells = (0..r.num_angles as usize).map(|k| turn(grid.cell_coordinates(k).x));
        let angles = knots([-half, half], of_cells);
        let place = |angle: f32, distance: f32| {
            let (sin, cos) = (ahead + angle).sin_cos();
            Stencil { scale: 1.0, ..grid.stencil(distance * sin, distance * cos) }
        };
        let stencils = distances.iter().flat_map(|&d| angles.iter().map(move |&a| place(a, d))).collect();
        let of_heights = (0..r.num_heights).map(|h| r.height_start + h as f32 * r.height_spacing);
        let heights = knots(heights, of_heights).iter().map(|&y| grid.height_interval(y)).collect::<Vec<_>>();
        let heights = heights.into_iter().map(|(h, ratio)| (h as usize, ratio)).collect();
        let aside = if grid.is_polar() {
            0.0
        } else {
            let middle = r.angle_start + 0.5 * (r.num_angles - 1) as f32 * r.angle_spacing;
            let over = turn(middle).abs() - half - 0.5 * (r.num_angles - 1) as f32 * r.angle_spacing;
            over.max(0.0) * near
        };
        let beyond = (near - grid.radius()).max(0.0).max(r.ring_start - far) + aside;
        let u = beyond / r.falloff;
        Self { stencils, heights, scale: (1.0 + u + 0.5 * u * u).recip() }
    }

    /// Greatest value of a state (state exists).
    pub fn greatest_value(&self, table: &PolicyTable, state: u32) -> f32 {
        let (plane, angles) = (table.grid().num_plane_cells(), table.grid().record().num_angles);
        let values = table.values_of(state);
        let mut most = f32::NEG_INFINITY;
        if table.is_adaptive() {
            // The stencils are those of the finest grid; all of a state's values bound it in any grid.
            return values.iter().copied().fold(0.0, f32::max) * self.scale;
        }
        for stencil in &self.stencils {
            for &(height, ratio) in &self.heights {
                let at = |h: usize| stencil.interpolate(&values[h * plane..][..plane], angles);
                let low = at(height);
                most = most.max(if ratio > 0.0 { low + (at(height + 1) - low) * ratio } else { low });
            }
        }
        // Negative values shrink beyond the grid too.
        most.max(0.0) * self.scale
    }
}

/// Ends of a range, and the numbers within it.
fn knots(range: [f32; 2], all: impl Iterator<Item = f32>) -> Vec<f32> {
    range.into_iter().chain(all.filter(|v| (range[0]..=range[1]).contains(v))).collect()
}

/// Least and greatest distance of a sample from any point of a disc, including heights (m).
///
/// - `heights`: of the target, lowest and highest; `None` if they do not count (m).
pub(super) fn distances(centre: Vec2, radius: f32, heights: Option<[f32; 2]>, sample: Vec3) -> [f32; 2] {
    let away = centre.distance(Vec2::new(sample.x, sample.z));
    let [near, far] = [(away - radius).max(0.0), away + radius];
    let Some([low, high]) = heights else { return [near, far] };
    let nearest = (low - sample.y).max(sample.y - high).max(0.0);
    let farthest = (sample.y - low).abs().max((high - sample.y).abs());
    [near.hypot(nearest), far.hypot(farthest)]
}
