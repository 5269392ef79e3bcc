//! Distances by search: the distance from a convex shape is convex along a segment, and so is its least over another one.

use crate::problem::Solid;
use crate::shape::Shape;
use glam::DVec3;

/// A capsule in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Core {
    pub a: DVec3,
    pub b: DVec3,
    pub radius: f64,
}

/// The least of a convex function over [0, 1].
fn least(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let third = (high - low) / 3.0;
        if f(low + third) < f(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    f(0.0).min(f(1.0)).min(f(0.5 * (low + high)))
}

fn point_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let d = b - a;
    let share = if d.length_squared() > 0.0 { ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + d * share)
}

/// Surface to surface; negative where they are in each other (m).
pub(super) fn to_capsule(c: &Core, other: &Core) -> f64 {
    least(|u| point_segment(c.a.lerp(c.b, u), other.a, other.b)) - c.radius - other.radius
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

/// Surface to surface; negative where they are in each other (m).
///
/// - `far`: triangles farther away may be left out, all of them giving infinity (m).
pub(super) fn to_solid(c: &Core, solid: &Solid, time_s: f64, far: f64) -> f64 {
    let place = solid.path.at(time_s);
    let inverse = place.rotation.inverse();
    let [a, b] = [c.a, c.b].map(|p| inverse * (p - place.position));
    let at = |u: f64| a.lerp(b, u);
    let core = match &solid.shape {
        Shape::Round { core, radius } => least(|u| point_segment(at(u), core.a, core.b)) - radius,
        Shape::Cuboid { half } => least(|u| at(u).distance(at(u).clamp(-*half, *half))),
        Shape::Mesh(mesh) => {
            let (middle, reach) = (at(0.5), 0.5 * a.distance(b) + c.radius + far);
            let mut nearest = f64::INFINITY;
            for triangle in mesh.corners() {
                let corners = triangle.map(|p| p.as_dvec3());
                // A triangle lies in the ball around its first corner that its longer side spans.
                let wide = corners[0].distance_squared(corners[1]).max(corners[0].distance_squared(corners[2])).sqrt();
                if corners[0].distance(middle) <= wide + reach {
                    nearest = nearest.min(least(|u| point_triangle(at(u), corners)));
                }
            }
            nearest
        }
    };
    core - c.radius
}
