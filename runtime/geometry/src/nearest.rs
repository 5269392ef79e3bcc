//! Nearest points of segments, in `f32`.

use glam::{Vec2, Vec3};
use std::ops::{Add, Mul, Sub};

/// Vector of the plane or of space.
pub trait Vector: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f32, Output = Self> {
    /// Scalar product.
    fn dot(self, other: Self) -> f32;
}

impl Vector for Vec2 {
    #[inline]
    fn dot(self, other: Self) -> f32 {
        Vec2::dot(self, other)
    }
}

impl Vector for Vec3 {
    #[inline]
    fn dot(self, other: Self) -> f32 {
        Vec3::dot(self, other)
    }
}

/// Share of the way from `a` to `b` at which a segment is nearest to `p` (0 to 1); 0 for a segment without length.
///
/// Segments shorter than 1e-6 m count as points near `a`.
#[inline]
pub fn share_along<V: Vector>(p: V, [a, b]: [V; 2]) -> f32 {
    let along = b - a;
    ((p - a).dot(along) / along.dot(along).max(1e-12)).clamp(0.0, 1.0)
}

/// Point of a segment that is nearest to `p` (m).
#[inline]
pub fn nearest_on_segment<V: Vector>(p: V, [a, b]: [V; 2]) -> V {
    a + (b - a) * share_along(p, [a, b])
}

/// Distance of a point from a segment (m).
#[inline]
pub fn distance_to_segment<V: Vector>(p: V, segment: [V; 2]) -> f32 {
    let from_it = p - nearest_on_segment(p, segment);
    from_it.dot(from_it).sqrt()
}

/// Distance between two segments, at their [`nearest_points`] (m).
#[inline]
pub fn segment_distance(a: [Vec3; 2], b: [Vec3; 2]) -> f32 {
    let [p, q] = nearest_points(a, b);
    p.distance(q)
}

/// Nearest points of two segments, on the first and on the second (m).
///
/// # Source
/// Ericson, *Real-Time Collision Detection*, 2005, section 5.1.9.
#[inline]
pub fn nearest_points([p1, q1]: [Vec3; 2], [p2, q2]: [Vec3; 2]) -> [Vec3; 2] {
    let (d1, d2, r) = (q1 - p1, q2 - p2, p1 - p2);
    let (a, e, f) = (d1.length_squared().max(1e-12), d2.length_squared().max(1e-12), d2.dot(r));
    let (b, c) = (d1.dot(d2), d1.dot(r));
    let across = a * e - b * b;
    let s = if across > 1e-9 * a * e { ((b * f - c * e) / across).clamp(0.0, 1.0) } else { 0.0 };
    let t = (b * s + f) / e;
    let clamped = t.clamp(0.0, 1.0);
    let s = if t == clamped { s } else { ((b * clamped - c) / a).clamp(0.0, 1.0) };
    [p1 + d1 * s, p2 + d2 * clamped]
}

#[cfg(test)]
mod tests {
    use super::*;

    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-1.0f32..1.0).prop_map(Vec3::from_array)
    }

    proptest! {
        #[test]
        fn nearest_points_are_as_near_as_any_of_a_dense_sampling(a in point(), b in point(), c in point(), d in point()) {
            let [p, q] = nearest_points([a, b], [c, d]);
            let mut best = f32::MAX;
            for i in 0..=60 {
                for j in 0..=60 {
                    best = best.min(a.lerp(b, i as f32 / 60.0).distance(c.lerp(d, j as f32 / 60.0)));
                }
            }
            let got = p.distance(q);
            prop_assert!(got <= best + 1e-4 && got > best - 0.04, "{got} {best}");
            prop_assert!(distance_to_segment(p, [a, b]) < 1e-5 && distance_to_segment(q, [c, d]) < 1e-5);
        }

        #[test]
        fn nearest_point_of_a_segment_is_that_of_a_dense_sampling(a in point(), b in point(), p in point()) {
            let sampled = (0..=1000).map(|i| p.distance(a.lerp(b, i as f32 / 1000.0))).fold(f32::INFINITY, f32::min);
            let found = distance_to_segment(p, [a, b]);
            prop_assert!(found <= sampled + 1e-6 && sampled <= found + 2e-3, "{found} {sampled}");
            let (a, b, p) = (a.truncate(), b.truncate(), p.truncate());
            let sampled = (0..=1000).map(|i| p.distance(a.lerp(b, i as f32 / 1000.0))).fold(f32::INFINITY, f32::min);
            let found = distance_to_segment(p, [a, b]);
            prop_assert!(found <= sampled + 1e-6 && sampled <= found + 2e-3, "{found} {sampled}");
        }
    }

    #[test]
    fn shares_are_those_of_hand_solved_cases() {
        let segment = [Vec2::ZERO, Vec2::new(4.0, 0.0)];
        for (p, share) in [([1.0, 7.0], 0.25), ([-2.0, 0.0], 0.0), ([9.0, 1.0], 1.0)] {
            assert_eq!(share_along(Vec2::from_array(p), segment), share);
        }
        assert_eq!(nearest_on_segment(Vec3::ONE, [Vec3::X; 2]), Vec3::X);
    }

    #[test]
    fn segments_without_length_are_points() {
        let (a, b) = (Vec3::ZERO, Vec3::new(0.0, 3.0, 4.0));
        let [p, q] = nearest_points([a, a], [b, b]);
        assert_eq!((p, q), (a, b));
        assert_eq!(distance_to_segment(b, [a, a]), 5.0);
    }

    #[test]
    fn parallel_segments_have_the_distance_of_their_lines() {
        let a = [Vec3::ZERO, Vec3::X];
        let b = [Vec3::new(0.5, 0.3, 0.0), Vec3::new(4.0, 0.3, 0.0)];
        let [p, q] = nearest_points(a, b);
        assert!((p.distance(q) - 0.3).abs() < 1e-6, "{p} {q}");
    }
}
