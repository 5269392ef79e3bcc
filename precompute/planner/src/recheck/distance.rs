//! Distances by search: the distance from a convex shape is convex along a segment, and so is its least over another one.
//! The check shares no geometry with what it checks, so the distances here are written anew.

use crate::problem::MovingSolid;
use glam::{DVec3, Vec3};
use throng_geometry::SolidShape;

/// A capsule in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RecheckCapsule {
    pub a: DVec3,
    pub b: DVec3,
    pub radius: f64,
}

/// The least of a convex function over [0, 1], by golden section (Kiefer, 1953, "Sequential minimax search for a maximum").
fn minimise(f: impl Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.0, 1.0);
    let (mut left, mut right) = (1.0 - golden, golden);
    let (mut at_left, mut at_right) = (f(left), f(right));
    // 0.618^42 is 2e-9.
    for _ in 0..42 {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - golden * (high - low);
            at_left = f(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + golden * (high - low);
            at_right = f(right);
        }
    }
    f(0.0).min(f(1.0)).min(f(0.5 * (low + high)))
}

fn point_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let d = b - a;
    let share = if d.length_squared() > 0.0 { ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + d * share)
}

/// Distance from surface to surface; negative where they penetrate (m).
pub(super) fn capsule_distance(c: &RecheckCapsule, other: &RecheckCapsule) -> f64 {
    minimise(|u| point_segment(c.a.lerp(c.b, u), other.a, other.b)) - c.radius - other.radius
}

fn point_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let rim = point_segment(p, a, b).min(point_segment(p, b, c)).min(point_segment(p, c, a));
    let (u, v, w) = (b - a, c - a, p - a);
    let (uu, uv, vv, wu, wv) = (u.dot(u), u.dot(v), v.dot(v), w.dot(u), w.dot(v));
    let area = uu * vv - uv * uv;
    if area <= 1e-20 {
        return rim;
    }
    let (s, t) = ((vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area);
    if s >= 0.0 && t >= 0.0 && s + t <= 1.0 { rim.min(p.distance(a + u * s + v * t)) } else { rim }
}

/// Triangles in one bounding ball, at most.
const BALL_TRIANGLES: usize = 32;

/// A solid, with bounds of its triangles.
pub(super) struct BoundedSolid<'a> {
    pub solid: &'a MovingSolid,
    /// Middle and radius of a ball around each run of triangles, as [`solid_distance`] goes through them; none but of a mesh (m).
    balls: Vec<(DVec3, f64)>,
}

impl<'a> BoundedSolid<'a> {
    pub fn new(solid: &'a MovingSolid) -> Self {
        let ball = |triangles: &[[Vec3; 3]]| {
            let points = || triangles.as_flattened().iter().map(|p| p.as_dvec3());
            let middle = points().sum::<DVec3>() / points().count() as f64;
            (middle, points().map(|p| p.distance(middle)).fold(0.0, f64::max))
        };
        let balls = match &solid.shape {
            SolidShape::Mesh(mesh) => mesh.corners().chunks(BALL_TRIANGLES).map(ball).collect(),
            _ => Vec::new(),
        };
        Self { solid, balls }
    }
}

/// Distance from surface to surface; negative where they penetrate (m).
///
/// - `far`: distances beyond it may be returned as infinity (m).
pub(super) fn solid_distance(c: &RecheckCapsule, bounded: &BoundedSolid, time_s: f64, far: f64) -> f64 {
    let BoundedSolid { solid, balls } = bounded;
    let place = solid.path.place_at(time_s);
    let inverse = place.rotation.inverse();
    let [a, b] = [c.a, c.b].map(|p| inverse * (p - place.position));
    let at = |u: f64| a.lerp(b, u);
    let (middle, half_length) = (at(0.5), 0.5 * a.distance(b));
    // The nearest point of the segment is at most half its length nearer than its midpoint.
    let within = |limit: f64, from: &dyn Fn(DVec3) -> f64| {
        if from(middle) - half_length > limit { f64::INFINITY } else { minimise(|u| from(at(u))) }
    };
    let limit = c.radius + far;
    let core = match &solid.shape {
        SolidShape::Round { core, radius } => within(limit + radius, &|p| point_segment(p, core.a, core.b)) - radius,
        SolidShape::Cuboid { half } => within(limit, &|p| p.distance(p.clamp(-*half, *half))),
        SolidShape::Mesh(mesh) => {
            let mut nearest = f64::INFINITY;
            for (triangles, (centre, radius)) in mesh.corners().chunks(BALL_TRIANGLES).zip(balls) {
                if middle.distance(*centre) - radius - half_length > nearest.min(limit) {
                    continue;
                }
                for triangle in triangles {
                    let corners = triangle.map(|p| p.as_dvec3());
                    nearest = nearest.min(within(nearest.min(limit), &|p| point_triangle(p, corners)));
                }
            }
            nearest
        }
    };
    core - c.radius
}
