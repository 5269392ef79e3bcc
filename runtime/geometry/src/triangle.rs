//! Triangles: their distances from segments and points, and where rays cross their planes.

use crate::{nearest::nearest_on_segment, segment::Segment};
use glam::{DVec3, Vec3};

/// Squared distance between a segment and a triangle, which may be a line or a point (m^2).
///
/// The nearest points are an end of the segment and the inside of the triangle, or points of the segment and an edge; the
/// distance is 0 where the segment goes through the triangle.
pub fn square_distance(s: &Segment, &[a, b, c]: &[DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let square = normal.length_squared();
    let mut best = f64::INFINITY;
    if square > 1e-24 {
        let [p, q] = [s.a, s.b].map(|p| normal.dot(p - a));
        let inside = |p: DVec3| {
            let side = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal);
            side(a, b) >= 0.0 && side(b, c) >= 0.0 && side(c, a) >= 0.0
        };
        if (p < 0.0) != (q < 0.0) && inside(s.a + (s.b - s.a) * (p / (p - q))) {
            return 0.0;
        }
        for (end, height) in [(s.a, p), (s.b, q)] {
            if inside(end) {
                best = best.min(height * height / square);
            }
        }
    }
    for (from, to) in [(a, b), (b, c), (c, a)] {
        best = best.min(s.square_distance(&Segment::new(from, to)));
    }
    best
}

/// True where a triangle is no nearer to a segment than a limit, measured along the line from the segment to the triangle's
/// middle; false proves nothing.
///
/// - `over`: one over the square of the segment's length; 0 for a point.
/// - `square_limit`: (m^2)
#[inline]
pub fn is_farther(s: &Segment, over: f64, &[a, b, c]: &[DVec3; 3], square_limit: f64) -> bool {
    let along = s.b - s.a;
    let middle = (a + b + c) * (1.0 / 3.0);
    let near = s.a + along * ((middle - s.a).dot(along) * over).clamp(0.0, 1.0);
    let line = middle - near;
    // No point of the segment is farther along the line than the one nearest to the middle.
    let rest = (a - near).dot(line).min((b - near).dot(line)).min((c - near).dot(line));
    rest > 0.0 && rest * rest >= square_limit * line.length_squared()
}

/// Nearest point of a triangle to `p`.
///
/// # Source
/// Christer Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5.
pub fn nearest_on_triangle(p: Vec3, &[a, b, c]: &[Vec3; 3]) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    let (e1, e2) = (d4 - d3, d5 - d6);
    if va <= 0.0 && e1 >= 0.0 && e2 >= 0.0 {
        return b + (c - b) * (e1 / (e1 + e2));
    }
    let sum = va + vb + vc;
    if sum <= 0.0 {
        // So thin that rounding decides: the nearest point of the three edges.
        let edges = [[a, b], [b, c], [c, a]].map(|edge| nearest_on_segment(p, edge));
        return edges.into_iter().min_by(|q, r| q.distance(p).total_cmp(&r.distance(p))).unwrap_or(a);
    }
    a + ab * (vb / sum) + ac * (vc / sum)
}

/// Crossing of a ray and the plane of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayCrossing {
    /// Volume of the parallelepiped of the two edges at the first corner and the reversed direction: above 0 where the ray
    /// comes from the side from which the corners run counter-clockwise. The other fields mean nothing near 0.
    pub det: f32,
    /// Share of the edge from the first corner to the second.
    pub u: f32,
    /// Share of the edge from the first corner to the third.
    pub v: f32,
    /// Distance along the ray, in lengths of its direction.
    pub t: f32,
}

/// Crossing of a ray and the plane of a triangle, in `f32`; it is inside where `u`, `v` and `1 - u - v` are at least 0.
///
/// # Source
/// Möller and Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997.
#[inline]
pub fn ray_crossing(origin: Vec3, direction: Vec3, &[a, b, c]: &[Vec3; 3]) -> RayCrossing {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let det = ab.dot(across);
    let from = origin - a;
    let over = from.cross(ab);
    RayCrossing { det, u: from.dot(across) / det, v: direction.dot(over) / det, t: ac.dot(over) / det }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segment::tests::{least, points};
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-1.0f32..1.0).prop_map(Vec3::from)
    }

    proptest! {
        #[test]
        fn distances_are_those_of_a_search(p in points(), q in points(), a in points(), b in points(), c in points(), flat in 0..4) {
            let (b, c) = match flat { 1 => (a, c), 2 => (b, a.lerp(b, 0.4)), _ => (b, c) };
            let s = Segment::new(p, q);
            // A distance to a convex set is convex along lines, over and over.
            let searched = least(|u| least(|v| least(|w| (p.lerp(q, u) - a.lerp(b.lerp(c, w), v)).length())));
            let found = square_distance(&s, &[a, b, c]).sqrt();
            prop_assert!((found - searched).abs() < 1e-5, "{found} {searched}");
            let over = 1.0 / (q - p).length_squared();
            for limit in [0.5 * found, 1.001 * found + 1e-9] {
                prop_assert!(!is_farther(&s, over, &[a, b, c], limit * limit) || limit <= found, "{found} {limit}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn the_nearest_point_is_that_of_a_densely_sampled_triangle(corners in [vector(), vector(), vector()], p in vector()) {
            let ([a, b, c], n) = (corners, 60);
            let mut sampled = f32::INFINITY;
            for i in 0..=n {
                for j in 0..=n - i {
                    let q = a + (b - a) * (i as f32 / n as f32) + (c - a) * (j as f32 / n as f32);
                    sampled = sampled.min(q.distance(p));
                }
            }
            let found = nearest_on_triangle(p, &corners).distance(p);
            prop_assert!(found <= sampled + 1e-4 && sampled <= found + 0.06, "{} {}", found, sampled);
        }
    }

    #[test]
    fn a_triangle_without_an_area_is_a_line() {
        let t = [Vec3::ZERO, Vec3::X, Vec3::X * 0.5];
        assert!((nearest_on_triangle(Vec3::new(0.3, 1.0, 0.0), &t) - Vec3::X * 0.3).length() < 1e-6);
        assert_eq!(nearest_on_triangle(Vec3::ONE, &[Vec3::ZERO; 3]), Vec3::ZERO);
    }

    #[test]
    fn a_ray_crosses_where_it_was_aimed() {
        let corners = [Vec3::new(1.0, 0.0, 2.0), Vec3::new(3.0, 0.0, 2.0), Vec3::new(1.0, 4.0, 2.0)];
        let aim = corners[0] + 0.25 * (corners[1] - corners[0]) + 0.5 * (corners[2] - corners[0]);
        for (origin, det) in [(aim + 3.0 * Vec3::Z, 8.0), (aim - 3.0 * Vec3::Z, -8.0)] {
            let direction = (aim - origin).normalize();
            assert_eq!(ray_crossing(origin, direction, &corners), RayCrossing { det, u: 0.25, v: 0.5, t: 3.0 });
        }
    }
}
