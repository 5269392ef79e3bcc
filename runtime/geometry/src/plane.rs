//! Boxes, capsules and segments in the plane, which is mostly the ground.

use crate::nearest::distance_to_segment;
use glam::Vec2;

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds2d {
    /// Lowest x and z (m).
    pub min: Vec2,
    /// Highest x and z (m).
    pub max: Vec2,
}

impl Bounds2d {
    /// Empty box, which holds no point.
    pub const EMPTY: Self = Self { min: Vec2::INFINITY, max: Vec2::NEG_INFINITY };

    /// Bounding box of a disc.
    #[inline]
    pub fn around_disc(centre: Vec2, radius_m: f32) -> Self {
        Self { min: centre, max: centre }.expanded_by(radius_m)
    }

    /// Box expanded by `by_m` on every side.
    #[inline]
    pub fn expanded_by(self, by_m: f32) -> Self {
        Self { min: self.min - by_m, max: self.max + by_m }
    }

    /// Smallest box around both.
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// True where the two boxes share a point.
    #[inline]
    pub fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }
}

/// 2-D capsule: all points within a radius of a line segment; a disc where both ends are equal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Capsule2d {
    /// One end (m).
    pub from: Vec2,
    /// Other end (m).
    pub to: Vec2,
    /// Radius (m, >= 0).
    pub radius_m: f32,
}

impl Capsule2d {
    /// Bounding box.
    #[inline]
    pub fn bounds(&self) -> Bounds2d {
        Bounds2d { min: self.from.min(self.to), max: self.from.max(self.to) }.expanded_by(self.radius_m)
    }

    /// Signed distance of a point from its surface, negative inside (m).
    #[inline]
    pub fn distance_to(&self, place: Vec2) -> f32 {
        segment_distance_squared(self.from - place, self.to - place).sqrt() - self.radius_m
    }

    /// True where the two capsules overlap.
    #[inline]
    pub fn intersects(&self, other: &Self) -> bool {
        let reach = self.radius_m + other.radius_m;
        distance_between_segments_squared([self.from, self.to], [other.from, other.to]) < reach * reach
    }
}

/// Squared distance of a segment from the origin (m^2). The subtraction that places the origin comes first, so it is exact far away.
#[inline]
pub fn segment_distance_squared(from: Vec2, to: Vec2) -> f32 {
    let way = to - from;
    let share = (-from.dot(way) / way.length_squared().max(1e-12)).clamp(0.0, 1.0);
    (from + way * share).length_squared()
}

/// Squared distance between two line segments; 0 where they cross (m^2).
fn distance_between_segments_squared(a: [Vec2; 2], b: [Vec2; 2]) -> f32 {
    if segments_cross(a, b) {
        return 0.0;
    }
    let to_line = |p: Vec2, l: [Vec2; 2]| segment_distance_squared(l[0] - p, l[1] - p);
    to_line(a[0], b).min(to_line(a[1], b)).min(to_line(b[0], a)).min(to_line(b[1], a))
}

/// Distance between two segments in the plane; 0 where they cross (m).
#[inline]
pub fn segment_distance_2d(a: [Vec2; 2], b: [Vec2; 2]) -> f32 {
    if segments_cross(a, b) {
        return 0.0;
    }
    let ends = a.map(|p| distance_to_segment(p, b)).into_iter().chain(b.map(|p| distance_to_segment(p, a)));
    ends.fold(f32::INFINITY, f32::min)
}

/// True where two segments cross at a point that is an end of neither.
#[inline]
fn segments_cross(a: [Vec2; 2], b: [Vec2; 2]) -> bool {
    let side = |l: [Vec2; 2], p: Vec2| (l[1] - l[0]).perp_dot(p - l[0]);
    side(a, b[0]) * side(a, b[1]) < 0.0 && side(b, a[0]) * side(b, a[1]) < 0.0
}

/// True where a point is within a polygon: a ray from it crosses the outline an odd number of times.
///
/// - `corners`: in order around it (m).
#[inline]
pub fn polygon_contains(corners: impl Iterator<Item = Vec2> + Clone, p: Vec2) -> bool {
    let crosses =
        |(a, b): &(Vec2, Vec2)| (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x);
    corners.clone().zip(corners.cycle().skip(1)).filter(crosses).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn capsules_meet_where_dense_sampling_says_so(a in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, 0.0f32..1.0], b in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, 0.0f32..1.0]) {
            let capsule = |v: [f32; 5]| Capsule2d { from: Vec2::new(v[0], v[1]), to: Vec2::new(v[2], v[3]), radius_m: v[4] };
            let (a, b) = (capsule(a), capsule(b));
            let gap = (0..=400).map(|i| b.distance_to(a.from.lerp(a.to, i as f32 / 400.0)) - a.radius_m).fold(f32::INFINITY, f32::min);
            prop_assert_eq!(a.intersects(&b), b.intersects(&a));
            prop_assert!(gap >= 0.0 || a.intersects(&b), "{gap} m apart, and not seen");
            prop_assert!(gap <= 0.02 || !a.intersects(&b), "{gap} m apart, but seen");
            prop_assert!(!a.intersects(&b) || a.bounds().intersects(&b.bounds()));
        }

        #[test]
        fn distances_of_segments_are_those_of_a_dense_sampling(a in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0], b in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0]) {
            let [a, b] = [a, b].map(|v| [Vec2::new(v[0], v[1]), Vec2::new(v[2], v[3])]);
            let sampled = (0..=400).map(|i| distance_to_segment(a[0].lerp(a[1], i as f32 / 400.0), b)).fold(f32::INFINITY, f32::min);
            let found = segment_distance_2d(a, b);
            prop_assert!(found <= sampled + 1e-5 && sampled <= found + 0.02, "{found} {sampled}");
            prop_assert!((found * found - distance_between_segments_squared(a, b)).abs() < 1e-4);
        }
    }

    #[test]
    fn inside_of_a_polygon_with_a_notch() {
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]].map(Vec2::from_array);
        for (p, inside) in [([1.0, 1.0], true), ([2.0, 2.0], false), ([3.6, 3.0], true), ([5.0, 1.0], false)] {
            assert_eq!(polygon_contains(corners.iter().copied(), Vec2::from_array(p)), inside, "{p:?}");
        }
    }
}
