//! Rays and round cones: two spheres and the cone between them.

use glam::Vec3;

/// A hit of a ray on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Distance along the ray (m).
    pub distance: f32,
    /// Outward direction of the surface. Unit.
    pub normal: Vec3,
}

/// First hit of a ray on a round cone whose first end is the origin; a capsule where the radii are the same. It is behind the
/// ray's start where the ray starts inside.
///
/// The cone that touches both spheres gives a quadratic in the distance; where its root lies beyond the touching circles, the
/// spheres decide.
///
/// - `from`: start of the ray; `direction`: unit; `axis`: second end; `radii`: at the two ends (m).
///
/// # Source
/// After Inigo Quilez, *Rounded cone, intersection* (iquilezles.org, intersectors).
pub fn ray_round_cone(from: Vec3, direction: Vec3, axis: Vec3, radii: [f32; 2]) -> Option<SurfaceHit> {
    let [ra, rb] = radii;
    let (oa, rd, ba) = (from, direction, axis);
    let ob = oa - ba;
    let rr = ra - rb;
    let length2 = ba.length_squared();
    let d2 = length2 - rr * rr;
    let sphere = |o: Vec3, r: f32| {
        let m = o.dot(rd);
        let h = m * m - o.length_squared() + r * r;
        (h >= 0.0).then(|| -m - h.sqrt()).map(|t| SurfaceHit { distance: t, normal: (o + rd * t) / r })
    };
    if d2 <= 1e-9 {
        return if ra >= rb { sphere(oa, ra) } else { sphere(ob, rb) };
    }
    let (m1, m2) = (ba.dot(oa), ba.dot(rd));
    let k2 = d2 - m2 * m2;
    let k1 = d2 * rd.dot(oa) - m1 * m2 + m2 * rr * ra;
    let k0 = d2 * oa.length_squared() - m1 * m1 + 2.0 * m1 * rr * ra - length2 * ra * ra;
    let h = k1 * k1 - k0 * k2;
    if h >= 0.0 && k2.abs() > 1e-9 {
        let t = (-h.sqrt() - k1) / k2;
        let y = m1 - ra * rr + t * m2;
        if y > 0.0 && y < d2 {
            return Some(SurfaceHit { distance: t, normal: (d2 * (oa + rd * t) - ba * y).normalize_or_zero() });
        }
    }
    match (sphere(oa, ra), sphere(ob, rb)) {
        (Some(p), Some(q)) => Some(if p.distance <= q.distance { p } else { q }),
        (p, q) => p.or(q),
    }
}
