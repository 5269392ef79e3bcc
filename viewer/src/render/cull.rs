//! Which characters are in view: bounding spheres against the planes of the frustum.

use glam::{Mat4, Vec3, Vec4};
use throng_core::{Joint, Skeleton};

/// The planes that bound the camera's view; there is no far plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frustum([Vec4; 5]);

impl Frustum {
    /// From a world-to-clip matrix with reversed depth.
    pub fn new(view_proj: Mat4) -> Self {
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| view_proj.row(i));
        Self([w + x, w - x, w + y, w - y, w - z].map(|p| p / p.truncate().length().max(1e-12)))
    }

    /// False only where no point of the sphere is in view.
    pub fn intersects_sphere(&self, centre: Vec3, radius: f32) -> bool {
        self.0.iter().all(|p| p.dot(centre.extend(1.0)) >= -radius)
    }
}

/// Radius around the hips that no part of a body leaves in any pose (m).
pub(super) fn reach(skeleton: &Skeleton) -> f32 {
    let mut chain = [0.0_f32; throng_core::NUM_JOINTS];
    for joint in Joint::ALL {
        if let Some(parent) = joint.parent() {
            chain[joint.index()] = chain[parent.index()] + skeleton.offsets[joint.index()].length();
        }
    }
    let tip = skeleton.tips.iter().map(|t| t.length()).fold(0.0, f32::max);
    let longest = chain.into_iter().fold(0.0, f32::max);
    // Hands and the thickness of the body are in proportion; a foot lock may stretch a leg a little.
    1.04 * (longest + tip.max(0.15 * longest)) + 0.06
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{BodyStyle, OrbitCamera, mesh};
    use glam::{Quat, Vec2};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    #[test]
    fn nothing_that_can_be_seen_is_culled() {
        let mut rng = Pcg32::seed_from_u64(5);
        let size = Vec2::new(1600.0, 900.0);
        let (mut seen, mut culled) = (0, 0);
        for _ in 0..4000 {
            let mut camera = OrbitCamera {
                target: Vec3::new(0.0, 1.0, 0.0),
                distance: rng.random_range(0.5..20.0),
                yaw: rng.random_range(-3.0..3.0),
                pitch: rng.random_range(-0.2..1.5),
                fov_y: rng.random_range(0.3..1.2),
            };
            camera.limit();
            let frustum = Frustum::new(camera.view_proj(size.x / size.y));
            let mut within = |r: f32| rng.random_range(-r..r);
            let centre = Vec3::new(within(30.0), within(3.0), within(30.0));
            let offset = Vec3::new(within(1.0), within(1.0), within(1.0)).clamp_length_max(1.0);
            let visible =
                camera.project(centre + offset, size).is_some_and(|p| p.cmpge(Vec2::ZERO).all() && p.cmple(size).all());
            if visible {
                seen += 1;
                assert!(frustum.intersects_sphere(centre, 1.0), "{camera:?} {centre}");
            }
            culled += usize::from(!frustum.intersects_sphere(centre, 1.0));
        }
        assert!(seen > 200 && culled > 1000, "{seen} {culled}");
    }

    #[test]
    fn no_pose_reaches_out_of_its_sphere() {
        let skeleton = Skeleton::default();
        let rest = skeleton.rest_positions();
        let (bodies, reach) = ([BodyStyle::Capsules, BodyStyle::Mannequin], reach(&skeleton));
        let mut rng = Pcg32::seed_from_u64(6);
        for mesh in bodies.into_iter().flat_map(|b| mesh::build(b, &skeleton)) {
            for _ in 0..20 {
                let mut turn = || {
                    Quat::from_rotation_y(rng.random_range(-3.0..3.0))
                        * Quat::from_rotation_x(rng.random_range(-3.0..3.0))
                };
                let mut pose = [(Vec3::ZERO, Quat::IDENTITY); throng_core::NUM_JOINTS];
                for j in Joint::ALL {
                    let (p, q) = j.parent().map_or((Vec3::ZERO, Quat::IDENTITY), |p| pose[p.index()]);
                    let offset = if j == Joint::Hips { Vec3::ZERO } else { skeleton.offsets[j.index()] };
                    pose[j.index()] = (p + q * offset, q * turn());
                }
                for v in &mesh.vertices {
                    let moved = (0..4).map(|i| {
                        let j = v.joints[i] as usize;
                        let (p, q) = pose[j];
                        (p + q * (Vec3::from(v.position) - rest[j])) * (v.weights[i] as f32 / 255.0)
                    });
                    assert!(moved.sum::<Vec3>().length() < reach);
                }
            }
        }
    }
}
