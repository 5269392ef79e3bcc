//! Nearest points of segments, in `f32`.

use glam::Vec3;

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

    /// Distance of a point from a segment (m).
    fn point_to_segment(p: Vec3, [a, b]: [Vec3; 2]) -> f32 {
        let (along, to) = (b - a, p - a);
        let t = (to.dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
        (to - along * t).length()
    }
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
            prop_assert!(point_to_segment(p, [a, b]) < 1e-5 && point_to_segment(q, [c, d]) < 1e-5);
        }
    }

    #[test]
    fn segments_without_length_are_points() {
        let (a, b) = (Vec3::ZERO, Vec3::new(0.0, 3.0, 4.0));
        let [p, q] = nearest_points([a, a], [b, b]);
        assert_eq!((p, q), (a, b));
        assert_eq!(point_to_segment(b, [a, a]), 5.0);
    }

    #[test]
    fn parallel_segments_have_the_distance_of_their_lines() {
        let a = [Vec3::ZERO, Vec3::X];
        let b = [Vec3::new(0.5, 0.3, 0.0), Vec3::new(4.0, 0.3, 0.0)];
        let [p, q] = nearest_points(a, b);
        assert!((p.distance(q) - 0.3).abs() < 1e-6, "{p} {q}");
    }
}
