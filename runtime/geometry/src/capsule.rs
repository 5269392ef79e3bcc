//! Capsules, and how deep they overlap.

use crate::nearest::{distance_to_segment, segment_distance};
use crate::round_cone::ray_round_cone;
use glam::Vec3;

/// Capsule between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Ends of its axis (m).
    pub ends: [Vec3; 2],
    /// Radius (m).
    pub radius: f32,
}

impl Capsule {
    /// Length of its axis (m).
    #[inline]
    pub fn length(&self) -> f32 {
        self.ends[0].distance(self.ends[1])
    }

    /// Gap between the bounding balls of two capsules, which is never above the gap between the capsules; negative where
    /// the balls overlap (m).
    #[inline]
    pub fn bounding_gap(&self, other: &Self) -> f32 {
        let apart = (self.ends[0] + self.ends[1]).distance(other.ends[0] + other.ends[1]) * 0.5;
        apart - (self.radius + other.radius + 0.5 * (self.length() + other.length()))
    }

    /// Distance along a ray at which it meets the capsule; 0 where it starts inside (m).
    ///
    /// - `direction`: unit.
    pub fn meet_ray(&self, origin: Vec3, direction: Vec3) -> Option<f32> {
        let [a, b] = self.ends;
        if distance_to_segment(origin, self.ends) <= self.radius {
            return Some(0.0);
        }
        let hit = ray_round_cone(origin - a, direction, b - a, [self.radius; 2])?;
        (hit.distance >= 0.0).then_some(hit.distance)
    }
}

/// Overlap depth of two capsules; negative where they are apart (m).
#[inline]
pub fn overlap_depth(a: &Capsule, b: &Capsule) -> f32 {
    a.radius + b.radius - segment_distance(a.ends, b.ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parallel_capsules_overlap_by_their_radii_less_the_distance() {
        let a = [Vec3::ZERO, Vec3::X];
        let b = [Vec3::new(0.5, 0.3, 0.0), Vec3::new(4.0, 0.3, 0.0)];
        let capsules = [a, b].map(|ends| Capsule { ends, radius: 0.2 });
        assert!((overlap_depth(&capsules[0], &capsules[1]) - 0.1).abs() < 1e-6);
        // Balls of radii 0.7 and 1.95 m about (0.5, 0, 0) and (2.25, 0.3, 0).
        let apart = (1.75f32 * 1.75 + 0.3 * 0.3).sqrt();
        assert!((capsules[0].bounding_gap(&capsules[1]) - (apart - 2.65)).abs() < 1e-6);
    }
}
