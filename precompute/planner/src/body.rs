//! A body as capsules, each fixed to a joint.

use glam::Vec3;
use throng_core::{BodyVolume, Joint, JointCapsule, Skeleton};
use throng_geometry::Segment;

/// A capsule of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyCapsule {
    /// The joint it is fixed to.
    pub joint: Joint,
    /// Core segment in the joint's frame (m).
    pub core: Segment,
    /// Radius (m, > 0).
    pub radius: f64,
}

/// Thickness that planned arms of the default skeleton lack, as grips bring palms nearer to things than flesh is thick (m).
/// Chosen.
const ARMS_SLIM_M: f32 = 0.008;

/// The capsules of a body; change them at will where a character is thinner or thicker.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyCapsules {
    /// Capsules; a joint may have none, one or several.
    pub capsules: Vec<BodyCapsule>,
}

impl BodyCapsules {
    /// Capsules of the [`BodyVolume`] of a skeleton, without the collar bones, which are in the chest's.
    pub fn fitted(skeleton: &Skeleton) -> Self {
        let is_apart = |c: &JointCapsule| !matches!(c.joint, Joint::LeftClavicle | Joint::RightClavicle);
        let one = |c: JointCapsule| {
            let [a, b] = c.ends.map(Vec3::as_dvec3);
            let slim_m = if (Joint::LeftClavicle..=Joint::RightHand).contains(&c.joint) { ARMS_SLIM_M } else { 0.0 };
            let radius = f64::from(c.radius - slim_m * BodyVolume::scale(skeleton));
            BodyCapsule { joint: c.joint, core: Segment::new(a, b), radius }
        };
        Self { capsules: BodyVolume::new(skeleton).capsules.into_iter().filter(is_apart).map(one).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_joint_that_is_flesh_has_a_capsule_near_it() {
        let skeleton = Skeleton::default();
        let shape = BodyCapsules::fitted(&skeleton);
        let rest = skeleton.rest_positions();
        for joint in Joint::ALL {
            let at = rest[joint.index()].as_dvec3();
            let point = Segment::new(at, at);
            let gaps = shape.capsules.iter().map(|c| {
                let from = rest[c.joint.index()].as_dvec3();
                c.core.map(|p| p + from).distance(&point) - c.radius
            });
            assert!(gaps.fold(9.0, f64::min) < 0.02, "{}", joint.name());
        }
        let low = shape.capsules.iter().map(|c| {
            let core = c.core.map(|p| p + rest[c.joint.index()].as_dvec3());
            core.a.y.min(core.b.y) - c.radius
        });
        assert!(low.fold(9.0, f64::min).abs() < 0.01);
    }

    #[test]
    fn a_child_is_thinner() {
        let mut small = Skeleton::default();
        for o in &mut small.offsets {
            *o *= 0.5;
        }
        let radius = |s: &Skeleton| BodyCapsules::fitted(s).capsules[0].radius;
        assert!((radius(&small) - 0.5 * radius(&Skeleton::default())).abs() < 1e-6);
    }
}
