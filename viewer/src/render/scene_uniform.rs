//! Data shared by all shaders: camera, light, colours, rest positions.

use super::{OrbitCamera, Rgba, SceneColours};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use throng_core::{NUM_JOINTS, Skeleton};

/// Towards the sun. Steep, so that shadows stay near their feet.
pub(super) const SUN: Vec3 = Vec3::new(0.34, 0.87, 0.36);

/// Distance at which the ground has faded into the horizon, at least (m).
const MIN_GROUND_RADIUS: f32 = 60.0;

/// The struct `Scene` of `shaders/scene.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct SceneUniform {
    view_proj: [[f32; 4]; 4],
    /// Eye, and the radius of the ground around it.
    eye: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    forward: [f32; 4],
    /// Width and height in pixels, tangents of half the opening angles.
    viewport: [f32; 4],
    sun: [f32; 4],
    colours: [[f32; 4]; 12],
    rest: [[f32; 4]; NUM_JOINTS],
}

impl SceneUniform {
    pub fn new(camera: &OrbitCamera, size: [u32; 2], colours: &SceneColours, skeleton: &Skeleton) -> Self {
        let [width, height] = size.map(|s| s.max(1) as f32);
        let aspect = width / height;
        let tan = (0.5 * camera.fov_y).tan();
        let [right, up, back] = camera.axes();
        let eye = camera.eye();
        let radius = MIN_GROUND_RADIUS.max(3.0 * camera.distance + 12.0 * eye.y);
        let vector = |v: Vec3, w: f32| v.extend(w).to_array();
        Self {
            view_proj: camera.view_proj(aspect).to_cols_array_2d(),
            eye: vector(eye, radius),
            right: vector(right, 0.0),
            up: vector(up, 0.0),
            forward: vector(-back, 0.0),
            viewport: [width, height, tan * aspect, tan],
            sun: vector(SUN.normalize(), 0.0),
            colours: bytemuck::cast::<_, [Rgba; 12]>(*colours).map(|c| c.linear().to_array()),
            rest: skeleton.rest_positions().map(|p| vector(p, 1.0)),
        }
    }
}
