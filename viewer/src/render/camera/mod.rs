//! The camera: it orbits a target, and keeps above the ground.

mod text;

pub use text::CameraPreset;

use glam::{Mat4, Vec2, Vec3};
use glam::{camera::rh::proj::directx::perspective_infinite_reverse, camera::rh::view::look_to_mat4};
use std::f32::consts::FRAC_PI_2;
use throng_geometry::BoundingBox;

/// The eye is never lower than this (m).
const MIN_EYE_HEIGHT: f32 = 0.04;
/// Allowed distances between eye and target (m).
const DISTANCES: std::ops::RangeInclusive<f32> = 0.15..=2000.0;
/// Turn for a drag of one pixel (rad).
const TURN_PER_PIXEL: f32 = 0.0065;

/// An orbit camera: `eye = target + distance * direction(yaw, pitch)`.
///
/// At yaw 0 the eye is on the +Z side and sees the face of a character at heading 0; the character's left is at the
/// right of the picture. Depth is reversed: 1 at the near plane, 0 at infinity.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct OrbitCamera {
    /// Point at the centre of the picture (m).
    pub target: Vec3,
    /// From eye to target (m).
    pub distance: f32,
    /// Angle of the eye about +Y, 0 is +Z, a quarter turn is +X (rad).
    pub yaw: f32,
    /// Angle of the eye above the horizon of the target (rad).
    pub pitch: f32,
    /// Vertical opening angle (rad).
    pub fov_y: f32,
}

impl Default for OrbitCamera {
    /// A character at the origin, seen from its front left and a little above.
    fn default() -> Self {
        CameraPreset::ThreeQuarter.camera()
    }
}

impl OrbitCamera {
    /// Turns around the target by a drag (pixels).
    pub fn orbit(&mut self, dx: f32, dy: f32) {
        self.yaw = throng_core::planar::wrap_angle(self.yaw - dx * TURN_PER_PIXEL);
        self.pitch += dy * TURN_PER_PIXEL;
        self.limit();
    }

    /// Moves the target so that it follows the pointer of a drag (pixels).
    pub fn pan(&mut self, dx: f32, dy: f32, viewport_height: f32) {
        let [right, up, _] = self.axes();
        let per_pixel = 2.0 * self.distance * (0.5 * self.fov_y).tan() / viewport_height.max(1.0);
        self.target += (up * dy - right * dx) * per_pixel;
        self.limit();
    }

    /// Multiplies the distance by `factor` (> 0).
    pub fn zoom(&mut self, factor: f32) {
        self.distance *= factor;
        self.limit();
    }

    /// Brings every number into its range: the eye above the ground, nothing infinite.
    pub fn limit(&mut self) {
        let fallback = Self { target: Vec3::Y, distance: 4.5, yaw: 0.0, pitch: 0.2, fov_y: 0.6 };
        let or = |v: f32, other: f32| if v.is_finite() { v } else { other };
        if !self.target.is_finite() {
            self.target = fallback.target;
        }
        self.target.y = self.target.y.clamp(0.0, *DISTANCES.end());
        self.distance = or(self.distance, fallback.distance).clamp(*DISTANCES.start(), *DISTANCES.end());
        self.yaw = or(self.yaw, fallback.yaw);
        self.fov_y = or(self.fov_y, fallback.fov_y).clamp(0.05, 2.4);
        let lowest = ((MIN_EYE_HEIGHT - self.target.y) / self.distance).clamp(-1.0, 1.0).asin();
        self.pitch = or(self.pitch, fallback.pitch).clamp(lowest.max(-1.4), FRAC_PI_2);
    }

    /// Position of the camera (m).
    pub fn eye(&self) -> Vec3 {
        self.target + self.axes()[2] * self.distance
    }

    /// Right, up and backward (from target to eye). Unit.
    pub fn axes(&self) -> [Vec3; 3] {
        let ((sy, cy), (sp, cp)) = (self.yaw.sin_cos(), self.pitch.sin_cos());
        let back = Vec3::new(sy * cp, sp, cy * cp);
        let right = Vec3::new(cy, 0.0, -sy);
        [right, back.cross(right), back]
    }

    /// Distance of the near plane (m).
    pub fn near_distance(&self) -> f32 {
        (self.distance * 0.02).clamp(0.004, 0.1)
    }

    /// World to clip space; `aspect` is width over height.
    pub fn view_proj(&self, aspect: f32) -> Mat4 {
        let [_, up, back] = self.axes();
        let projection = perspective_infinite_reverse(self.fov_y, aspect, self.near_distance());
        projection * look_to_mat4(self.eye(), -back, up)
    }

    /// The ray through a pixel position of a viewport, (0, 0) at its upper left corner (pixels).
    pub fn ray(&self, pixel: Vec2, size: Vec2) -> Ray {
        let [right, up, back] = self.axes();
        let ndc = (pixel / size.max(Vec2::ONE)) * 2.0 - Vec2::ONE;
        let tan = (0.5 * self.fov_y).tan();
        let aspect = size.x.max(1.0) / size.y.max(1.0);
        let direction = right * (ndc.x * tan * aspect) - up * (ndc.y * tan) - back;
        Ray { origin: self.eye(), direction: direction.normalize() }
    }

    /// Screen position of a point in a viewport; `None` behind the near plane (pixels).
    pub fn project(&self, point: Vec3, size: Vec2) -> Option<Vec2> {
        let size = size.max(Vec2::ONE);
        let clip = self.view_proj(size.x / size.y) * point.extend(1.0);
        (clip.w >= self.near_distance()).then(|| Vec2::new(clip.x / clip.w + 1.0, 1.0 - clip.y / clip.w) * 0.5 * size)
    }

    /// Height in pixels of something one metre tall at a distance from the eye.
    pub fn pixels_per_metre(&self, distance: f32, viewport_height: f32) -> f32 {
        viewport_height / (2.0 * (0.5 * self.fov_y).tan() * distance.max(self.near_distance()))
    }

    /// Frames a box from the present direction, from the least distance that shows all of it; `aspect` is width over
    /// height.
    pub fn frame_box(&mut self, min: Vec3, max: Vec3, aspect: f32) {
        let (low, high) = (min.min(max), min.max(max));
        if !(low.is_finite() && high.is_finite()) {
            return;
        }
        let [right, up, back] = self.axes();
        let centre = 0.5 * (low + high);
        let tan = (0.5 * self.fov_y).tan();
        let needed = BoundingBox { min: low, max: high }.corners().map(|corner| {
            let p = corner - centre;
            let across = (p.dot(right).abs() / aspect.max(0.05)).max(p.dot(up).abs());
            p.dot(back) + across / tan
        });
        self.target = centre;
        self.distance = 1.06 * needed.into_iter().fold(0.5, f32::max);
        self.limit();
    }
}

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
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    const SIZE: Vec2 = Vec2::new(1280.0, 720.0);

    fn any_camera(rng: &mut Pcg32) -> OrbitCamera {
        let mut c = OrbitCamera {
            target: Vec3::new(rng.random_range(-9.0..9.0), rng.random_range(0.0..2.0), rng.random_range(-9.0..9.0)),
            distance: rng.random_range(0.5..40.0),
            yaw: rng.random_range(-3.1..3.1),
            pitch: rng.random_range(-0.5..1.57),
            fov_y: rng.random_range(0.3..1.2),
        };
        c.limit();
        c
    }

    #[test]
    fn a_projected_point_lies_on_the_ray_through_its_pixel() {
        let mut rng = Pcg32::seed_from_u64(1);
        for _ in 0..500 {
            let camera = any_camera(&mut rng);
            let pixel = Vec2::new(rng.random_range(0.0..SIZE.x), rng.random_range(0.0..SIZE.y));
            let ray = camera.ray(pixel, SIZE);
            let point = ray.point_at(rng.random_range(0.5..60.0));
            let back = camera.project(point, SIZE).unwrap_or(Vec2::NAN);
            assert!((back - pixel).length() < 0.1, "{pixel} became {back}");
        }
    }

    #[test]
    fn no_gesture_moves_the_camera_below_the_ground() {
        let mut rng = Pcg32::seed_from_u64(2);
        let mut camera = OrbitCamera::default();
        for _ in 0..5000 {
            let (x, y) = (rng.random_range(-300.0..300.0), rng.random_range(-300.0..300.0));
            match rng.random_range(0..3) {
                0 => camera.orbit(x, y),
                1 => camera.pan(x, y, 700.0),
                _ => camera.zoom(1.5_f32.powf(x / 100.0)),
            }
            assert!(camera.eye().y > 0.0 && camera.eye().is_finite(), "{camera:?}");
        }
        camera.zoom(f32::NAN);
        assert!(camera.eye().is_finite());
    }

    #[test]
    fn panning_keeps_the_target_under_the_pointer() {
        let mut camera = OrbitCamera::default();
        let before = camera.target;
        camera.pan(100.0, 40.0, SIZE.y);
        let moved = camera.project(before, SIZE).unwrap_or(Vec2::NAN) - SIZE * 0.5;
        assert!((moved - Vec2::new(100.0, 40.0)).length() < 12.0, "{moved}");
    }

    #[test]
    fn a_framed_box_is_seen_whole() {
        let mut rng = Pcg32::seed_from_u64(3);
        for _ in 0..200 {
            let mut camera = any_camera(&mut rng);
            let low = Vec3::new(rng.random_range(-20.0..0.0), 0.0, rng.random_range(-20.0..0.0));
            let high = Vec3::new(rng.random_range(0.1..30.0), 1.8, rng.random_range(0.1..30.0));
            camera.frame_box(low, high, SIZE.x / SIZE.y);
            for corner in [low, high, Vec3::new(low.x, high.y, high.z), Vec3::new(high.x, low.y, high.z)] {
                let p = camera.project(corner, SIZE).unwrap_or(Vec2::NAN);
                assert!(p.cmpge(Vec2::splat(-0.5)).all() && p.cmple(SIZE + 0.5).all(), "{camera:?} {p}");
            }
        }
    }

    #[test]
    fn the_left_side_of_a_character_is_at_the_right_of_its_front_view() {
        let camera = CameraPreset::Front.camera();
        let at = |x: f32| camera.project(Vec3::new(x, 1.0, 0.0), SIZE).map_or(f32::NAN, |p| p.x);
        assert!(at(0.5) > at(-0.5));
        assert!(camera.ray(SIZE * 0.5, SIZE).direction.z < 0.0);
    }

    #[test]
    fn meets_the_ground_only_ahead() {
        let down = Ray { origin: Vec3::new(1.0, 2.0, 3.0), direction: Vec3::new(0.6, -0.8, 0.0) };
        assert!(down.intersect_ground().is_some_and(|p| p.abs_diff_eq(Vec3::new(2.5, 0.0, 3.0), 1e-5)));
        assert_eq!(Ray { direction: Vec3::Y, ..down }.intersect_ground(), None);
        assert_eq!(Ray { direction: Vec3::X, ..down }.intersect_ground(), None);
    }
}
