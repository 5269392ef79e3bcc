//! The volume of a behaviour around a character: its active region, or the extent of its cells.

use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use throng_core::policy::{PolicyTable, RegionRecord, TargetGrid};

/// Longest piece of an arc that is drawn straight (rad).
const ARC: f32 = TAU / 90.0;
/// Bounds beyond this are none (m).
const NO_BOUND: f32 = 1e3;

/// A part of a ring, between two heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Middle of the ring, as seen from the planar root (m).
    pub centre: Vec3,
    /// (m)
    pub distance: [f32; 2],
    /// From straight ahead to the left (rad).
    pub angle: [f32; 2],
    /// (m)
    pub height: [f32; 2],
}

impl Volume {
    /// The active region of a behaviour; none if it has no bounds over ground. Without bounds of height, it reaches
    /// from the ground to above the head.
    pub fn of_region(region: &RegionRecord) -> Option<Self> {
        let bounded = region.distance[1] < NO_BOUND;
        let height = [region.height[0].max(0.0), region.height[1].min(2.0)];
        bounded.then_some(Self { centre: Vec3::ZERO, distance: region.distance, angle: region.angle, height })
    }

    /// The extent of the cells of a grid with heights, from centre to centre.
    pub fn of_grid(policy: &PolicyTable) -> Self {
        let grid: &TargetGrid = policy.grid();
        let (first, last) = (grid.cell_coordinates(0), grid.cell_coordinates(grid.num_cells() - 1));
        let angle = [first.x, last.x];
        Self { centre: policy.centre(), distance: [first.y, last.y], angle, height: [first.z, last.z] }
    }

    /// Outline over ground: to the left and ahead. A full turn is a circle (m).
    pub fn over_ground(&self) -> Vec<Vec2> {
        let [near, far] = self.distance;
        let is_circle = self.angle[1] - self.angle[0] > TAU - 0.01;
        let mut out = arc(far, if is_circle { [-PI, PI] } else { self.angle });
        if !is_circle {
            out.extend(arc(near, self.angle).into_iter().rev());
        }
        out.iter().map(|p| *p + Vec2::new(self.centre.x, self.centre.z)).collect()
    }
}

fn arc(radius: f32, [from, to]: [f32; 2]) -> Vec<Vec2> {
    let parts = ((to - from) / ARC).ceil().clamp(1.0, 360.0) as usize;
    let at = |i: usize| from + (to - from) * i as f32 / parts as f32;
    (0..=parts).map(|i| Vec2::new(at(i).sin(), at(i).cos()) * radius).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume() -> Volume {
        Volume { centre: Vec3::ZERO, distance: [0.3, 1.2], angle: [-1.0, 0.5], height: [1.1, 1.7] }
    }

    #[test]
    fn the_outline_lies_on_the_edges_of_the_region() {
        let v = volume();
        let region = RegionRecord { distance: v.distance, angle: v.angle, height: v.height };
        assert_eq!(Volume::of_region(&region), Some(v));
        let middle = Vec2::new((-0.25f32).sin(), (-0.25f32).cos()) * 0.75;
        for p in v.over_ground() {
            let inwards = p + 0.01 * (middle - p).normalize();
            let outwards = p - 0.01 * (middle - p).normalize();
            assert!(!region.contains(Vec3::new(outwards.x, 1.4, outwards.y)), "{p}");
            // Along the near edge the straight way to the middle leaves the ring for no more than a moment.
            assert!(region.contains(Vec3::new(inwards.x, 1.4, inwards.y)) || p.length() < 0.31, "{p}");
        }
        assert_eq!(Volume::of_region(&RegionRecord::EVERYWHERE), None);
    }
}
