//! The camera: parallel projection, so that a metre has the same length everywhere in a picture.

use glam::{Vec2, Vec3};

/// A camera with parallel projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureCamera {
    /// World direction to the right of the screen. Unit.
    pub right: Vec3,
    /// World direction upwards on the screen. Unit.
    pub up: Vec3,
    /// Direction the camera looks in. Unit.
    pub forward: Vec3,
    /// Point of the world that is seen at `screen` (m).
    pub target: Vec3,
    /// Position of `target` in the picture (px).
    pub screen: Vec2,
    /// Scale (px/m, > 0).
    pub px_per_m: f32,
}

impl PictureCamera {
    /// A camera that looks along `heading` (0 is +Z, +90 degrees is +X), tilted down by `elevation`
    /// (0 is level, 90 degrees is straight down) (rad).
    ///
    /// It looks at the world's origin, seen at the picture's origin, with one pixel a metre.
    pub fn looking_along(heading: f32, elevation: f32) -> Self {
        let (sh, ch) = heading.sin_cos();
        let (se, ce) = elevation.sin_cos();
        let level = Vec3::new(sh, 0.0, ch);
        let forward = level * ce - Vec3::Y * se;
        let right = Vec3::new(-ch, 0.0, sh);
        Self { right, up: right.cross(forward), forward, target: Vec3::ZERO, screen: Vec2::ZERO, px_per_m: 1.0 }
    }

    /// Copy of this camera that shows `target` at `screen` with the given scale.
    pub fn framed(self, target: Vec3, screen: Vec2, px_per_m: f32) -> Self {
        Self { target, screen, px_per_m, ..self }
    }

    /// Position of a point in the picture (px).
    pub fn project(&self, p: Vec3) -> Vec2 {
        let d = p - self.target;
        self.screen + self.px_per_m * Vec2::new(d.dot(self.right), -d.dot(self.up))
    }

    /// Distance of a point along the view, larger is farther away (m).
    pub fn depth(&self, p: Vec3) -> f32 {
        (p - self.target).dot(self.forward)
    }

    /// The point of the plane through `target` that is seen at `screen`.
    pub fn unproject(&self, screen: Vec2) -> Vec3 {
        let d = (screen - self.screen) / self.px_per_m;
        self.target + self.right * d.x - self.up * d.y
    }

    /// The ground point that is seen at `screen`; `None` for a level camera (m).
    pub fn ground_point(&self, screen: Vec2) -> Option<Vec3> {
        let p = self.unproject(screen);
        (self.forward.y.abs() > 1e-4).then(|| p - self.forward * (p.y / self.forward.y))
    }

    /// Half the width and half the height in the picture of a disc on the ground (px).
    pub fn ground_disc(&self, radius: f32) -> Vec2 {
        Vec2::new(radius, radius * self.forward.y.abs()) * self.px_per_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_orthonormal_and_up_is_up() {
        for (h, e) in [(0.0, 0.0), (1.0, 0.6), (-2.5, 1.2)] {
            let c = PictureCamera::looking_along(h, e);
            for (a, b) in [(c.right, c.up), (c.up, c.forward), (c.forward, c.right)] {
                assert!(a.dot(b).abs() < 1e-6 && (a.length() - 1.0).abs() < 1e-6);
            }
            assert!(c.project(Vec3::Y).y < c.project(Vec3::ZERO).y);
        }
    }

    #[test]
    fn looking_at_a_character_from_the_front_shows_its_left_side_on_the_right() {
        let c = PictureCamera::looking_along(std::f32::consts::PI, 0.0);
        assert!(c.project(Vec3::X).x > 0.99);
        assert!(c.depth(Vec3::Z) < c.depth(Vec3::ZERO));
    }

    #[test]
    fn ground_is_the_inverse_of_projection() {
        let c = PictureCamera::looking_along(0.4, 0.7).framed(Vec3::new(1.0, 2.0, 3.0), Vec2::new(100.0, 50.0), 20.0);
        let p = Vec3::new(4.0, 0.0, -1.0);
        assert!(c.ground_point(c.project(p)).is_some_and(|q| (q - p).length() < 1e-4));
        assert!(PictureCamera::looking_along(0.0, 0.0).ground_point(Vec2::ZERO).is_none());
    }
}
