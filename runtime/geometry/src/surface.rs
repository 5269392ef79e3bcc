//! Nearest surface points of boxes and bars, in `f32`.

use crate::nearest::nearest_on_segment;
use glam::Vec3;

/// Distance from a surface below which rounding decides the direction away from it (m).
const AT_SURFACE: f32 = 1e-6;

/// Surface point of a solid that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Distance, negative inside boxes and bars (m).
    pub distance: f32,
    /// The nearest point of the surface (m).
    pub point: Vec3,
    /// Direction away from the solid there. Unit.
    pub normal: Vec3,
}

/// Nearest surface point of a box around the origin along the axes.
pub fn nearest_on_box(p: Vec3, half: Vec3) -> SurfacePoint {
    let over = p.abs() - half;
    let sign = |v: f32| if v < 0.0 { -1.0 } else { 1.0 };
    if over.max_element() > 0.0 {
        let away = std::array::from_fn(|k| if over[k] > 0.0 { sign(p[k]) } else { 0.0 });
        return distance_outside(p, p.clamp(-half, half), Vec3::from_array(away));
    }
    let axis = (0..3).fold(0, |best, k| if over[k] > over[best] { k } else { best });
    let mut normal = Vec3::ZERO;
    normal[axis] = sign(p[axis]);
    SurfacePoint { distance: over[axis], point: p - normal * over[axis], normal }
}

/// Surface point for a point outside; `otherwise` is the direction if both are too close to tell.
pub(crate) fn distance_outside(p: Vec3, point: Vec3, otherwise: Vec3) -> SurfacePoint {
    let d = p - point;
    let distance = d.length();
    let normal = if distance > AT_SURFACE { d / distance } else { otherwise.normalize_or(Vec3::Y) };
    SurfacePoint { distance, point, normal }
}

/// Nearest surface point of a bar: all points within a radius of a segment.
pub fn nearest_on_bar(p: Vec3, from: Vec3, to: Vec3, radius: f32) -> SurfacePoint {
    let axis = nearest_on_segment(p, [from, to]);
    let away = p - axis;
    let d = away.length();
    let normal = if d > AT_SURFACE {
        away / d
    } else {
        (to - from).try_normalize().map_or(Vec3::Y, |v| v.any_orthonormal_vector())
    };
    SurfacePoint { distance: d - radius, point: axis + normal * radius, normal }
}
