//! Solids of bodies: round cones (two spheres and the cone between them), flattened along one axis.

use glam::{Mat3, Vec3};
use throng_geometry::{SurfaceHit, ray_round_cone};

/// A round cone in the world, flattened along one axis.
///
/// One sphere (both ends the same) flattened is an ellipsoid, so limbs, trunks and heads are all of this kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RoundCone {
    a: Vec3,
    b: Vec3,
    radius_a: f32,
    radius_b: f32,
    /// Transform from the world to the space in which the solid is a plain round cone; symmetric.
    to_round: Mat3,
    /// Largest extent of either end beyond its centre (m).
    reach: f32,
}

impl RoundCone {
    /// A limb: spheres of two radii around two points and all between (m).
    pub fn limb(a: Vec3, b: Vec3, radius_a: f32, radius_b: f32) -> Self {
        Self { a, b, radius_a, radius_b, to_round: Mat3::IDENTITY, reach: radius_a.max(radius_b) }
    }

    /// A limb that is `factor` times as thick along the unit vector `axis` as across it (> 0).
    pub fn flattened(self, axis: Vec3, factor: f32) -> Self {
        let outer = Mat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
        let reach = self.radius_a.max(self.radius_b) * factor.max(1.0);
        Self { to_round: Mat3::IDENTITY + outer * (1.0 / factor - 1.0), reach, ..self }
    }

    /// The ends, and the greatest distance of the surface from the line between them (m).
    pub fn bounds(&self) -> (Vec3, Vec3, f32) {
        (self.a, self.b, self.reach)
    }

    /// First hit of the ray from `origin` along the unit vector `direction`.
    pub fn intersect(&self, origin: Vec3, direction: Vec3) -> Option<SurfaceHit> {
        let direction = self.to_round * direction;
        let stretch = direction.length();
        let direction = direction / stretch;
        let axis = self.to_round * (self.b - self.a);
        let from = self.to_round * (origin - self.a);
        let SurfaceHit { distance, normal } = ray_round_cone(from, direction, axis, [self.radius_a, self.radius_b])?;
        Some(SurfaceHit { distance: distance / stretch, normal: (self.to_round * normal).normalize_or_zero() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Signed distance to a round cone by dense sampling of its axis.
    fn distance(solid: &RoundCone, p: Vec3) -> f32 {
        let steps = 4000;
        let one = |i: usize| {
            let t = i as f32 / steps as f32;
            (p - solid.a.lerp(solid.b, t)).length() - (solid.radius_a + (solid.radius_b - solid.radius_a) * t)
        };
        (0..=steps).map(one).fold(f32::INFINITY, f32::min)
    }

    #[test]
    fn hits_lie_on_the_surface_and_misses_stay_outside() {
        let solid = RoundCone::limb(Vec3::new(-0.2, 0.1, 0.0), Vec3::new(0.3, 0.5, 0.2), 0.2, 0.08);
        let d = Vec3::new(0.1, -0.2, 1.0).normalize();
        let (mut hits, mut misses) = (0, 0);
        for i in 0..20 {
            for j in 0..20 {
                let o = Vec3::new(-0.6 + 0.06 * i as f32, -0.2 + 0.06 * j as f32, -2.0);
                match solid.intersect(o, d) {
                    Some(hit) => {
                        hits += 1;
                        let p = o + d * hit.distance;
                        assert!(distance(&solid, p).abs() < 1e-3, "{p}");
                        assert!(distance(&solid, p + hit.normal * 0.01) > 0.009);
                    }
                    None => {
                        misses += 1;
                        assert!((0..400).all(|k| distance(&solid, o + d * (0.01 * k as f32)) > -1e-3));
                    }
                }
                if i % 5 == 0 {
                    assert_eq!(solid.intersect(o + d * 4.0, -d).is_some(), solid.intersect(o, d).is_some());
                }
            }
        }
        assert!(hits > 30 && misses > 30);
    }

    #[test]
    fn a_flattened_sphere_is_an_ellipsoid() {
        let axis = Vec3::new(1.0, 1.0, 0.0).normalize();
        let e = RoundCone::limb(Vec3::ONE, Vec3::ONE, 0.3, 0.3).flattened(axis, 0.5);
        let near = |d: Vec3| e.intersect(Vec3::ONE - d * 2.0, d).map(|h| 2.0 - h.distance);
        assert!(near(axis).is_some_and(|r| (r - 0.15).abs() < 1e-4));
        assert!(near(Vec3::Z).is_some_and(|r| (r - 0.3).abs() < 1e-4));
        assert!(e.intersect(Vec3::ONE - axis * 2.0, axis).is_some_and(|h| (h.normal + axis).length() < 1e-4));
    }

    #[test]
    fn one_end_inside_the_other_is_a_sphere() {
        let s = RoundCone::limb(Vec3::ZERO, Vec3::X * 0.05, 0.3, 0.1);
        assert!(s.intersect(Vec3::Z * -1.0, Vec3::Z).is_some_and(|h| (h.distance - 0.7).abs() < 1e-5));
    }
}
