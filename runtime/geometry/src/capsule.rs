//! Capsules, and how deep they overlap.

use crate::nearest::nearest_points;
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
}

/// Overlap depth of two capsules; negative where they are apart (m).
#[inline]
pub fn overlap_depth(a: &Capsule, b: &Capsule) -> f32 {
    let [p, q] = nearest_points(a.ends, b.ends);
    a.radius + b.radius - (p - q).length()
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
    }
}
