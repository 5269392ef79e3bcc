//! Surfaces of triangles with a tree of boxes over them.

use crate::segment::Segment;
use crate::triangle::{is_farther, square_distance};
use crate::triangle_tree::BoxTree;
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
#[derive(Clone)]
pub struct TriangleMesh {
    corners: Vec<[Vec3; 3]>,
    tree: BoxTree,
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
        let tree = BoxTree::new(&corners);
        let all = || corners.iter().flatten();
        let (low, high) =
            (all().fold(Vec3::INFINITY, |a, c| a.min(*c)), all().fold(Vec3::NEG_INFINITY, |a, c| a.max(*c)));
        let middle = 0.5 * (low.as_dvec3() + high.as_dvec3());
        let radius = all().map(|c| c.as_dvec3().distance(middle)).fold(0.0, f64::max);
        Ok(Self { corners, tree, ball: (middle, radius) })
    }

    /// Corners of every triangle (m).
    pub fn corners(&self) -> &[[Vec3; 3]] {
        &self.corners
    }

    /// Middle and radius of a ball that holds it (m).
    pub fn ball_around(&self) -> (DVec3, f64) {
        self.ball
    }

    /// Distance to a segment, where it is below `limit`, else infinite (m).
    pub fn distance(&self, s: &Segment, limit: f64) -> f64 {
        let mut best = f64::INFINITY;
        let mut nearest = limit;
        self.visit_near_triangles(s, limit, |_, d2| {
            let d = d2.sqrt();
            if d < nearest {
                (best, nearest) = (d, d);
            }
            Some(nearest)
        });
        best
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
        if limit.is_nan() || limit <= 0.0 {
            return;
        }
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
