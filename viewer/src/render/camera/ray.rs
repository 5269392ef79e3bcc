//! Rays, and where they meet the ground.

use glam::Vec3;

/// A half-line in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start of the ray (m).
    pub origin: Vec3,
    /// Direction of the ray. Unit.
    pub direction: Vec3,
}

impl Ray {
    /// The point at a distance along the ray (m).
    pub fn point_at(&self, distance: f32) -> Vec3 {
        self.origin + self.direction * distance
    }

    /// Intersection with the horizontal plane at `height`; `None` if the ray never reaches it (m).
    pub fn intersect_height(&self, height: f32) -> Option<Vec3> {
        let t = (height - self.origin.y) / self.direction.y;
        (t.is_finite() && t >= 0.0).then(|| {
            let p = self.point_at(t);
            Vec3::new(p.x, height, p.z)
        })
    }

    /// True where the ray passes a point within a distance (m).
    pub fn passes_within(&self, centre: Vec3, radius: f32) -> bool {
        let to = centre - self.origin;
        let along = to.dot(self.direction).max(0.0);
        (to - self.direction * along).length_squared() <= radius * radius
    }

    /// Intersection with the ground, y = 0 (m).
    pub fn intersect_ground(&self) -> Option<Vec3> {
        self.intersect_height(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meets_the_ground_only_ahead() {
        let down = Ray { origin: Vec3::new(1.0, 2.0, 3.0), direction: Vec3::new(0.6, -0.8, 0.0) };
        assert!(down.intersect_ground().is_some_and(|p| p.abs_diff_eq(Vec3::new(2.5, 0.0, 3.0), 1e-5)));
        assert_eq!(Ray { direction: Vec3::Y, ..down }.intersect_ground(), None);
        assert_eq!(Ray { direction: Vec3::X, ..down }.intersect_ground(), None);
    }
}
