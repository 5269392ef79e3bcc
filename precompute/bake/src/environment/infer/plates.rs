//! Level plates inferred under feet and seats.

use super::places::{InferredTouch, TouchKind};
use super::{super::UnitShape, InferredPiece, round_to_mm};
use throng_geometry::BoundingBox;

/// Largest height that counts as the ground (m).
pub const ON_GROUND: f32 = 0.05;
/// Largest difference in height of places on one plate from it (m).
const SAME_HEIGHT: f32 = 0.035;
/// Largest distance of places on one plate from it (m).
const REACH: f32 = 0.35;
/// Height difference below which a place off the plate bounds its extent, since it cannot be above or below. Rungs of
/// ladders are farther apart (m).
const STEP: f32 = 0.2;
/// Extent of plates beyond the skin that touched them (m).
const MARGIN: f32 = 0.04;
/// Thickness of plates (m).
const THICKNESS: f32 = 0.04;

/// A level plate.
#[derive(Clone, Debug, PartialEq)]
pub struct InferredPlate {
    /// Height of the upper side: the median of the places on it (m).
    pub height: f32,
    /// Bounds of the places on it; only x and z count.
    extent: BoundingBox,
    /// Heights of the places on it, ascending.
    pub heights: Vec<f32>,
    /// Total time for which something was on it (s).
    pub held_s: f32,
}

impl InferredPlate {
    fn new(touch: &InferredTouch) -> Self {
        let extent = BoundingBox { min: touch.extent.min.with_y(0.0), max: touch.extent.max.with_y(0.0) };
        Self { height: touch.point.y, extent, heights: vec![touch.point.y], held_s: touch.lasts_s }
    }

    /// Merges another plate into this one.
    fn merge(&mut self, other: &Self) {
        self.extent = self.extent.union(other.extent);
        self.held_s += other.held_s;
        self.heights.extend(&other.heights);
        self.heights.sort_by(f32::total_cmp);
        self.height = self.heights[self.heights.len() / 2];
    }

    /// True if the other plate may be part of this one: equal height, near, and no place between them contradicts.
    fn is_continued_by(&self, other: &Self, places: &[InferredTouch]) -> bool {
        let (low, high) = (self.heights[0].min(other.heights[0]), self.highest().max(other.highest()));
        let as_high = high - low < 2.0 * SAME_HEIGHT && (self.height - other.height).abs() < SAME_HEIGHT;
        if !(as_high && self.extent.expanded(REACH).overlaps(&other.extent)) {
            return false;
        }
        let both = self.extent.union(other.extent);
        let denies = |t: &InferredTouch| {
            let off = (t.point.y - self.height).abs();
            t.kind == TouchKind::Foot && off > 2.0 * SAME_HEIGHT && off < STEP && both.contains(t.point.with_y(0.0))
        };
        !places.iter().any(denies)
    }

    fn highest(&self) -> f32 {
        self.heights.last().copied().unwrap_or(self.height)
    }

    /// The plate as a box.
    pub fn piece(&self) -> InferredPiece {
        let b = BoundingBox { min: self.extent.min - MARGIN, max: self.extent.max + MARGIN };
        let (min, max) = (b.min.with_y(self.height - THICKNESS), b.max.with_y(self.height));
        let (at, size) = (0.5 * (min + max), round_to_mm(max - min));
        let shape = UnitShape::Box { at: at.to_array(), size: size.to_array(), heading_deg: 0.0, pitch_deg: 0.0 };
        (shape, BoundingBox { min, max })
    }
}

/// Plates under all places above the ground, from low to high.
pub fn find_plates(places: &[InferredTouch]) -> Vec<InferredPlate> {
    let mut raised: Vec<&InferredTouch> =
        places.iter().filter(|t| t.kind != TouchKind::Hand && t.point.y.abs() > ON_GROUND).collect();
    raised.sort_by(|a, b| a.point.y.total_cmp(&b.point.y));
    let mut plates: Vec<InferredPlate> = Vec::new();
    for touch in raised {
        let new = InferredPlate::new(touch);
        match plates.iter_mut().find(|p| p.is_continued_by(&new, places)) {
            Some(plate) => plate.merge(&new),
            None => plates.push(new),
        }
    }
    while let Some((i, j)) = joinable(&plates, places) {
        let other = plates.remove(j);
        plates[i].merge(&other);
    }
    plates
}

/// Indices of two plates that can be merged.
fn joinable(plates: &[InferredPlate], places: &[InferredTouch]) -> Option<(usize, usize)> {
    (0..plates.len())
        .flat_map(|i| (i + 1..plates.len()).map(move |j| (i, j)))
        .find(|&(i, j)| plates[i].is_continued_by(&plates[j], places))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn foot(x: f32, y: f32) -> InferredTouch {
        let point = Vec3::new(x, y, 0.0);
        let extent = BoundingBox::around_points([point]).expanded(0.05);
        InferredTouch { kind: TouchKind::Foot, point, extent, across: Vec3::X, lasts_s: 1.0 }
    }

    #[test]
    fn a_plate_does_not_reach_over_a_lower_place_but_rungs_lie_above_each_other() {
        let heights = |places: &[InferredTouch]| {
            find_plates(places).iter().map(|p| (p.height, p.heights.len())).collect::<Vec<_>>()
        };
        assert_eq!(heights(&[foot(0.0, 0.3), foot(0.4, 0.32), foot(0.9, 0.0)]), [(0.32, 2)]);
        assert_eq!(heights(&[foot(0.0, 0.3), foot(0.2, 0.15), foot(0.4, 0.3)]), [(0.15, 1), (0.3, 1), (0.3, 1)]);
        let ladder = [foot(0.0, 0.3), foot(0.2, 0.3), foot(0.1, 0.58), foot(0.0, 0.6), foot(0.2, 0.6)];
        assert_eq!(heights(&ladder), [(0.3, 2), (0.6, 3)]);
        assert_eq!(heights(&[foot(0.0, 0.3), foot(2.0, 0.3)]), [(0.3, 1), (0.3, 1)]);
    }
}
