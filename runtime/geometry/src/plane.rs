//! Boxes, capsules and segments in the plane, which is mostly the ground.

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

/// Squared distance between two line segments (m2).
fn distance_between_segments_squared(a: [Vec2; 2], b: [Vec2; 2]) -> f32 {
    let side = |l: [Vec2; 2], p: Vec2| (l[1] - l[0]).perp_dot(p - l[0]);
    if side(a, b[0]) * side(a, b[1]) < 0.0 && side(b, a[0]) * side(b, a[1]) < 0.0 {
        return 0.0;
    }
    let to_line = |p: Vec2, l: [Vec2; 2]| segment_distance_squared(l[0] - p, l[1] - p);
    to_line(a[0], b).min(to_line(a[1], b)).min(to_line(b[0], a)).min(to_line(b[1], a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rods_meet_where_dense_sampling_says_so(a in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, 0.0f32..1.0], b in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, 0.0f32..1.0]) {
            let rod = |v: [f32; 5]| Capsule2d { from: Vec2::new(v[0], v[1]), to: Vec2::new(v[2], v[3]), radius_m: v[4] };
            let (a, b) = (rod(a), rod(b));
            let gap = (0..=400).map(|i| b.distance_to(a.from.lerp(a.to, i as f32 / 400.0)) - a.radius_m).fold(f32::INFINITY, f32::min);
            prop_assert_eq!(a.intersects(&b), b.intersects(&a));
            prop_assert!(gap >= 0.0 || a.intersects(&b), "{gap} m apart, and not seen");
            prop_assert!(gap <= 0.02 || !a.intersects(&b), "{gap} m apart, but seen");
            prop_assert!(!a.intersects(&b) || a.bounds().intersects(&b.bounds()));
        }
    }
}
