//! Surfaces of triangles with a tree over them.

use crate::bounds::{BoundingBox, BoundsTree};
use crate::nearest::nearest_on_segment;
use crate::surface::{SurfacePoint, distance_outside};
use glam::Vec3;

/// A surface of triangles, without an inside, that is searched from points; [`TriangleMesh`](crate::TriangleMesh) is searched
/// from segments.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleSurface {
    corners: Vec<[Vec3; 3]>,
    tree: BoundsTree,
}

impl TriangleSurface {
    /// Surface of triangles; those without an area are kept as segments or points.
    pub fn new(corners: Vec<[Vec3; 3]>) -> Self {
        let bounds: Vec<BoundingBox> = corners.iter().map(|t| BoundingBox::around_points(*t)).collect();
        let tree = BoundsTree::new(&bounds);
        Self { corners, tree }
    }

    /// Corners of every triangle (m).
    pub fn corners(&self) -> &[[Vec3; 3]] {
        &self.corners
    }

    /// Bounds of the surface.
    pub fn bounds(&self) -> BoundingBox {
        self.tree.bounds()
    }

    /// Nearest surface point to `p`; `None` at `limit` or farther.
    pub fn nearest(&self, p: Vec3, limit: f32) -> Option<SurfacePoint> {
        let (i, _) = self.find_below(p, limit)?;
        let t = &self.corners[i];
        Some(distance_outside(p, nearest_on_triangle(p, t), (t[1] - t[0]).cross(t[2] - t[0])))
    }

    /// Distance of `p`; infinite at `limit` or farther (m).
    pub fn distance(&self, p: Vec3, limit: f32) -> f32 {
        self.find_below(p, limit).map_or(f32::INFINITY, |(_, distance)| distance)
    }

    /// The nearest triangle and its distance.
    fn find_below(&self, p: Vec3, limit: f32) -> Option<(usize, f32)> {
        self.tree.nearest(p, limit, |i| nearest_on_triangle(p, &self.corners[i]).distance(p))
    }
}

/// Nearest point of a triangle to `p`.
///
/// # Source
/// Christer Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5.
fn nearest_on_triangle(p: Vec3, &[a, b, c]: &[Vec3; 3]) -> Vec3 {
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
        return nearest_on_edges(p, a, b, c);
    }
    a + ab * (vb / sum) + ac * (vc / sum)
}

/// Nearest point of the three edges, for triangles so thin that rounding decides.
fn nearest_on_edges(p: Vec3, a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    let edges = [[a, b], [b, c], [c, a]].map(|edge| nearest_on_segment(p, edge));
    edges.into_iter().min_by(|q, r| q.distance(p).total_cmp(&r.distance(p))).unwrap_or(a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-1.0f32..1.0).prop_map(Vec3::from)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn distance_is_that_to_densely_sampled_triangles(
            corners in prop::collection::vec([vector(), vector(), vector()], 1..12), p in vector()
        ) {
            let surface = TriangleSurface::new(corners.clone());
            let n = 60;
            let mut sampled = f32::INFINITY;
            for [a, b, c] in &corners {
                for i in 0..=n {
                    for j in 0..=n - i {
                        let q = *a + (*b - *a) * (i as f32 / n as f32) + (*c - *a) * (j as f32 / n as f32);
                        sampled = sampled.min(q.distance(p));
                    }
                }
            }
            let found = surface.nearest(p, f32::INFINITY).unwrap();
            prop_assert!(found.distance <= sampled + 1e-4 && sampled <= found.distance + 0.06);
            prop_assert!((found.point.distance(p) - found.distance).abs() < 1e-4);
            prop_assert!(surface.bounds().expanded(1e-4).contains(found.point));
            prop_assert_eq!(surface.nearest(p, found.distance), None);
        }
    }

    #[test]
    fn a_triangle_without_an_area_is_a_line() {
        let t = [Vec3::ZERO, Vec3::X, Vec3::X * 0.5];
        assert!((nearest_on_triangle(Vec3::new(0.3, 1.0, 0.0), &t) - Vec3::X * 0.3).length() < 1e-6);
        assert_eq!(nearest_on_triangle(Vec3::ONE, &[Vec3::ZERO; 3]), Vec3::ZERO);
    }
}
