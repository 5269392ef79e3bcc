//! Surfaces of triangles with a tree of boxes over them.

use crate::surface::{SurfacePoint, distance_outside};
use crate::triangle::{is_farther, nearest_on_triangle, square_distance};
use crate::{bounds::BoundingBox, segment::Segment, triangle_tree::BoxTree};
use glam::{DVec3, Vec3};

/// Reason why triangles are not a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// There are no triangles.
    #[error("the mesh has no triangles; give it some, or leave it out")]
    Empty,
    /// A corner is not a valid position.
    #[error("triangle {triangle}: expected finite corners below {limit} m, found {corner}; export the mesh again")]
    Corner {
        /// Index of the triangle.
        triangle: usize,
        /// Its corner.
        corner: Vec3,
        /// Largest coordinate (m).
        limit: f32,
    },
}

/// A surface of triangles, which need not be closed: there is no inside, and nothing passes through its surface.
///
/// Segments are measured in `f64`, points in `f32`.
#[derive(Clone, PartialEq)]
pub struct TriangleMesh {
    corners: Vec<[Vec3; 3]>,
    tree: BoxTree,
    bounds: BoundingBox,
    ball: (DVec3, f64),
}

impl std::fmt::Debug for TriangleMesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Mesh({} triangles)", self.corners.len())
    }
}

/// Coordinates are smaller than this (m).
const MAX_POSITION: f32 = 1e5;

impl TriangleMesh {
    /// A mesh of triangles; those without an area are lines or points, and count.
    ///
    /// - `corners`: (m)
    ///
    /// # Errors
    /// [`MeshError`].
    pub fn new(corners: Vec<[Vec3; 3]>) -> Result<Self, MeshError> {
        if corners.is_empty() {
            return Err(MeshError::Empty);
        }
        for (triangle, corner) in corners.iter().enumerate().flat_map(|(i, t)| t.iter().map(move |c| (i, *c))) {
            if !corner.is_finite() || corner.abs().max_element() > MAX_POSITION {
                return Err(MeshError::Corner { triangle, corner, limit: MAX_POSITION });
            }
        }
        let bounds = BoundingBox::around_points(corners.iter().flatten().copied());
        let middle = 0.5 * (bounds.min.as_dvec3() + bounds.max.as_dvec3());
        let radius = corners.iter().flatten().map(|c| c.as_dvec3().distance(middle)).fold(0.0, f64::max);
        Ok(Self { tree: BoxTree::new(&corners), corners, bounds, ball: (middle, radius) })
    }

    /// Corners of every triangle (m).
    pub fn corners(&self) -> &[[Vec3; 3]] {
        &self.corners
    }

    /// Box around all triangles (m).
    pub fn bounds(&self) -> BoundingBox {
        self.bounds
    }

    /// Middle and radius of a ball that holds it (m).
    pub fn ball_around(&self) -> (DVec3, f64) {
        self.ball
    }

    /// Surface point that is nearest to a point; `None` at `limit` or farther. Of triangles at the same distance, the first
    /// (m).
    pub fn nearest(&self, p: Vec3, limit: f32) -> Option<SurfacePoint> {
        let t = &self.corners[self.find_below(p, limit)?.0 as usize];
        Some(distance_outside(p, nearest_on_triangle(p, t), (t[1] - t[0]).cross(t[2] - t[0])))
    }

    /// Distance of a point, where it is below `limit`, else infinite (m).
    pub fn point_distance(&self, p: Vec3, limit: f32) -> f32 {
        self.find_below(p, limit).map_or(f32::INFINITY, |(_, distance)| distance)
    }

    /// Triangle that is nearest to a point, and its distance; `None` at `limit` or farther (m).
    fn find_below(&self, p: Vec3, limit: f32) -> Option<(u32, f32)> {
        let mut best = (0, limit);
        let point = Segment::new(p.as_dvec3(), p.as_dvec3());
        self.tree.visit_near_triangles(&point, f64::from(limit), |i| {
            let d = nearest_on_triangle(p, &self.corners[i as usize]).distance(p);
            if d < best.1 || d == best.1 && i < best.0 {
                best = (i, d);
            }
            Some(f64::from(best.1))
        });
        (best.1 < limit).then_some(best)
    }

    /// Distance to a segment, where it is below `limit`, else infinite (m).
    pub fn distance(&self, s: &Segment, limit: f64) -> f64 {
        let mut nearest = limit;
        self.visit_near_triangles(s, limit, |_, d2| {
            nearest = nearest.min(d2.sqrt());
            Some(nearest)
        });
        if nearest < limit { nearest } else { f64::INFINITY }
    }

    /// True where a segment is nearer than `limit`; stops at the first such triangle (m).
    pub fn is_nearer(&self, s: &Segment, limit: f64) -> bool {
        self.first_nearer(s, limit).is_some()
    }

    /// A triangle that is nearer to a segment than `limit` (m).
    pub fn first_nearer(&self, s: &Segment, limit: f64) -> Option<u32> {
        let mut found = None;
        self.visit_near_triangles(s, limit, |triangle, d2| {
            found = (d2 < limit * limit).then_some(triangle);
            found.is_none().then_some(limit)
        });
        found
    }

    /// True where a given triangle is nearer to a segment than `limit`; false for one that does not exist (m).
    pub fn is_triangle_nearer(&self, triangle: u32, s: &Segment, limit: f64) -> bool {
        let corners = self.corners.get(triangle as usize).filter(|_| limit > 0.0);
        corners.is_some_and(|t| square_distance(s, &t.map(|c| c.as_dvec3())) < limit * limit)
    }

    /// Calls `look` with the squared distances of triangles that may be within a limit; it returns the new limit, or `None` to
    /// stop.
    fn visit_near_triangles(&self, s: &Segment, limit: f64, mut visit: impl FnMut(u32, f64) -> Option<f64>) {
        let length = (s.b - s.a).length_squared();
        let over = if length > 1e-18 { 1.0 / length } else { 0.0 };
        let mut limit = limit;
        self.tree.visit_near_triangles(s, limit, |i| {
            let triangle = self.corners[i as usize].map(|c| c.as_dvec3());
            if !is_farther(s, over, &triangle, limit * limit) {
                limit = visit(i, square_distance(s, &triangle))?;
            }
            Some(limit)
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segment::tests::points;
    use proptest::prelude::*;

    fn corners() -> impl Strategy<Value = Vec<[Vec3; 3]>> {
        let corner = || prop::array::uniform3(-1.0f32..1.0).prop_map(Vec3::from);
        let triangle = (prop::array::uniform3(corner()), 0..8).prop_map(|([a, b, c], kind)| match kind {
            0 => [a; 3],
            1 => [a, b, a + (b - a) * 0.3],
            2 => [a, a + 1e-4 * b, c],
            _ => [a, b, c],
        });
        let size = prop::sample::select(vec![0.1f32, 1.0, 30.0, 4000.0]);
        // Each is there twice, so that each distance is.
        (prop::collection::vec(triangle, 1..40), size)
            .prop_map(|(all, size)| all.iter().chain(&all).map(|t| t.map(|c| size * c)).collect())
    }

    /// A hilly sheet, `n` by `n` squares of two triangles, 2 m wide.
    fn hills(n: usize) -> TriangleMesh {
        let at = |i: usize, j: usize| {
            let (x, z) = (2.0 * i as f32 / n as f32 - 1.0, 2.0 * j as f32 / n as f32 - 1.0);
            Vec3::new(x, 0.2 * (3.0 * x).sin() * (4.0 * z).cos(), z)
        };
        let squares = (0..n * n).map(|k| (k % n, k / n));
        let corners = squares.flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        TriangleMesh::new(corners.collect()).expect("a mesh")
    }

    proptest! {
        #[test]
        fn the_nearest_of_all_triangles_is_found_from_points(
            corners in corners(), p in points(), out in prop::sample::select(vec![0.0f32, 1e-3, 0.3, 3.0]), share in 0.1f32..3.0
        ) {
            let mesh = TriangleMesh::new(corners).expect("a mesh");
            let p = mesh.bounds().centre() + out * mesh.bounds().max.abs() * p.as_vec3();
            let all = mesh.corners().iter().map(|t| nearest_on_triangle(p, t).distance(p)).enumerate();
            let first = all.min_by(|a, b| a.1.total_cmp(&b.1)).expect("a triangle");
            for limit in [f32::INFINITY, share * first.1, first.1.next_up(), first.1, -1.0, f32::NAN] {
                let expected = Some((first.0 as u32, first.1)).filter(|f| f.1 < limit);
                prop_assert_eq!(mesh.find_below(p, limit), expected);
                prop_assert_eq!(mesh.point_distance(p, limit), expected.map_or(f32::INFINITY, |e| e.1));
                prop_assert_eq!(mesh.nearest(p, limit).map(|s| s.distance), expected.map(|e| e.1));
            }
            let found = mesh.nearest(p, f32::INFINITY).expect("a triangle");
            let rounding = 1e-5 * (1.0 + mesh.bounds().max.abs().max_element() + p.abs().max_element());
            prop_assert!(mesh.bounds().expanded(rounding).contains(found.point));
            prop_assert!((found.point + found.normal * found.distance - p).length() <= rounding);
        }

        #[test]
        fn the_nearest_of_all_triangles_is_found_from_segments(
            corners in corners(), a in points(), b in points(), share in 0.1f64..3.0
        ) {
            let mesh = TriangleMesh::new(corners).expect("a mesh");
            let s = Segment::new(a, a + 0.3 * b);
            let distance = |t: &[Vec3; 3]| square_distance(&s, &t.map(|c| c.as_dvec3()));
            let square = mesh.corners().iter().map(distance).fold(f64::INFINITY, f64::min);
            let nearest = square.sqrt();
            prop_assert_eq!(mesh.distance(&s, f64::INFINITY), nearest);
            for limit in [1e-3, 0.1, share * nearest, nearest * (1.0 + 1e-9)] {
                let found = mesh.first_nearer(&s, limit);
                prop_assert_eq!(found.is_some(), square < limit * limit);
                prop_assert!(found.is_none_or(|i| distance(&mesh.corners()[i as usize]) < limit * limit));
                prop_assert_eq!(mesh.distance(&s, limit), if nearest < limit { nearest } else { f64::INFINITY });
            }
        }

        #[test]
        fn the_tree_finds_what_all_triangles_say(a in points(), b in points(), limit in 0.01f64..1.0) {
            let mesh = hills(12);
            let s = Segment::new(a, a + 0.3 * b);
            let all = mesh.corners().iter().map(|t| square_distance(&s, &t.map(|c| c.as_dvec3())).sqrt());
            let nearest = all.fold(f64::INFINITY, f64::min);
            let found = mesh.distance(&s, limit);
            prop_assert_eq!(found, if nearest < limit { nearest } else { f64::INFINITY });
            prop_assert_eq!(mesh.is_nearer(&s, limit), nearest < limit);
        }
    }

    #[test]
    fn an_infinite_limit_finds_a_triangle_around_the_middle_of_its_box() {
        let mesh = TriangleMesh::new(vec![[Vec3::NEG_ONE, Vec3::ONE, Vec3::X]]).expect("a mesh");
        assert_eq!(mesh.point_distance(Vec3::ZERO, f32::INFINITY), 0.0);
        assert_eq!(mesh.distance(&Segment::new(DVec3::ZERO, DVec3::ZERO), f64::INFINITY), 0.0);
    }

    #[test]
    fn large_triangles_are_found_nearby() {
        for (size, k) in [30.0f32, 700.0, 20_000.0].into_iter().flat_map(|size| (1..200).map(move |k| (size, k))) {
            let near_m = 0.37 * 0.01 * k as f32;
            let far = |side: f32| Vec3::new(side * size, side * size, 2.3 * size);
            let mesh = TriangleMesh::new(vec![[near_m * Vec3::Z, far(-1.0), far(1.0)]]).expect("a mesh");
            assert_eq!(mesh.point_distance(Vec3::ZERO, near_m.next_up()), near_m);
        }
    }

    #[test]
    fn what_is_no_mesh_is_refused() {
        assert_eq!(TriangleMesh::new(Vec::new()).unwrap_err(), MeshError::Empty);
        let nan =
            TriangleMesh::new(vec![[Vec3::ZERO; 3], [Vec3::ZERO, Vec3::X, Vec3::new(0.0, f32::NAN, 0.0)]]).unwrap_err();
        assert!(nan.to_string().starts_with("triangle 1: expected finite corners"), "{nan}");
        // One triangle, and one without an area.
        let one = TriangleMesh::new(vec![[Vec3::ZERO, Vec3::X, Vec3::Y]]).expect("a mesh");
        let s = Segment::new(DVec3::new(0.2, 0.2, 0.5), DVec3::new(0.2, 0.2, 1.0));
        assert_eq!((one.distance(&s, 1.0), one.is_nearer(&s, 0.4)), (0.5, false));
        let line = TriangleMesh::new(vec![[Vec3::ZERO, Vec3::X, Vec3::X]]).expect("a mesh");
        assert!((line.distance(&s, 1.0) - (0.04f64 + 0.25).sqrt()).abs() < 1e-12);
    }
}
