//! Places on the ground nearest to points.

use crate::{Level, NONE};
use glam::{Vec2, Vec3, Vec3Swizzles};
use throng_geometry::nearest_on_segment;

/// Distance over which a point counts as inside (m).
const EDGE_M: f32 = 1e-4;
/// Vertical distance that counts as much as one metre along the ground: floors are told apart by it.
const VERTICAL: f32 = 2.0;

/// Difference of heights that are of one floor (m).
const ONE_FLOOR_M: f32 = 0.3;
/// Height over the ground within which a point is on it (m).
const UNDER_M: f32 = 0.75;

/// Place on the ground of a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelPoint {
    /// Position (m).
    pub at: Vec3,
    /// Polygon that it is on.
    pub polygon: u32,
}

impl Level {
    /// The place on the ground nearest to a point, on the floor nearest to it.
    ///
    /// - `within_m`: no farther away than that, along the ground and up or down (m).
    pub fn nearest(&self, at: Vec3, within_m: f32) -> Option<LevelPoint> {
        if !at.is_finite() {
            return None;
        }
        // Most points are on the ground: their own square tells.
        let on = self.nearest_in(at, 0.0, within_m.min(UNDER_M));
        on.or_else(|| self.nearest_in(at, within_m, within_m))
    }

    /// Height of the ground at a point, on the floor nearest to it; none beside the ground (m).
    pub fn height_at(&self, at: Vec3) -> Option<f32> {
        self.nearest_in(at, 0.0, f32::INFINITY).map(|p| p.at.y)
    }

    /// Adds the heights of the ground at a point, one for each floor there (m).
    pub fn add_heights(&self, at: Vec2, out: &mut Vec<f32>) {
        let first = out.len();
        for &polygon in self.polygons_in(self.square_at(at)) {
            if self.nearest_on(polygon, at).distance(at) <= EDGE_M {
                let height = self.height_on(polygon, at);
                if out[first..].iter().all(|h| (h - height).abs() > ONE_FLOOR_M) {
                    out.push(height);
                }
            }
        }
    }

    /// Square of the grid that a point is in, or the nearest one.
    fn square_at(&self, at: Vec2) -> [u32; 2] {
        let head = self.head();
        [0, 1].map(|axis| {
            let k = ((at[axis] - head.low[axis]) / head.square_m).floor();
            k.clamp(0.0, head.squares[axis] as f32 - 1.0) as u32
        })
    }

    /// Polygons in a square of the grid.
    fn polygons_in(&self, [x, z]: [u32; 2]) -> &[u32] {
        let k = (z * self.head().squares[0] + x) as usize;
        &self.0.listed[self.0.squares[k] as usize..self.0.squares[k + 1] as usize]
    }

    /// - `along_m`, `up_m`: no farther away along the ground, and up or down (m).
    fn nearest_in(&self, at: Vec3, along_m: f32, up_m: f32) -> Option<LevelPoint> {
        let flat = at.xz();
        let [low, high] = [-along_m, along_m].map(|off| self.square_at(flat + off));
        let mut best = (f32::INFINITY, None);
        for z in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                for &polygon in self.polygons_in([x, z]) {
                    let place = self.nearest_on(polygon, flat);
                    let away = place.distance(flat);
                    if away > along_m || away >= best.0 {
                        continue;
                    }
                    let height = self.height_on(polygon, place);
                    let up = (height - at.y).abs();
                    if away + VERTICAL * up < best.0 && up <= up_m {
                        let at = Vec3::new(place.x, height, place.y);
                        best = (away + VERTICAL * up, Some(LevelPoint { at, polygon }));
                    }
                }
            }
        }
        best.1
    }

    /// Point of a polygon nearest to a point, on the plane; the point itself where it is inside.
    fn nearest_on(&self, polygon: u32, p: Vec2) -> Vec2 {
        let edges = &self.0.polygons[polygon as usize];
        let corners = || self.vertices_of(polygon).map(|v| Vec3::from(self.0.vertices[v as usize].at).xz());
        let mut best = (f32::INFINITY, p);
        let mut is_inside = true;
        for (a, b) in corners().zip(corners().cycle().skip(1)).take(edges.num_edges as usize) {
            let along = b - a;
            if along.perp_dot(p - a) < -EDGE_M * along.length().max(1e-6) {
                is_inside = false;
            }
            let near = nearest_on_segment(p, [a, b]);
            let away = near.distance_squared(p);
            if away < best.0 {
                best = (away, near);
            }
        }
        if is_inside { p } else { best.1 }
    }

    /// Height of a polygon at a point of it (m).
    pub(crate) fn height_on(&self, polygon: u32, p: Vec2) -> f32 {
        let mut best = (f32::NEG_INFINITY, 0.0);
        for &[a, b, c] in self.triangles(polygon) {
            let [a, b, c] = [a, b, c].map(Vec3::from);
            let (ab, ac, ap) = (b.xz() - a.xz(), c.xz() - a.xz(), p - a.xz());
            let area = ab.perp_dot(ac);
            if area.abs() < 1e-9 {
                continue;
            }
            let (v, w) = (ap.perp_dot(ac) / area, ab.perp_dot(ap) / area);
            let inside = v.min(w).min(1.0 - v - w);
            if inside > best.0 {
                best = (inside, a.y + v * (b.y - a.y) + w * (c.y - a.y));
            }
            if inside >= 0.0 {
                return best.1;
            }
        }
        if best.0 == f32::NEG_INFINITY { self.triangles(polygon).first().map_or(0.0, |t| t[0][1]) } else { best.1 }
    }
}

impl LevelPoint {
    /// No place.
    pub(crate) const UNKNOWN: Self = Self { at: Vec3::ZERO, polygon: NONE };
}
