//! A body as capsules, each fixed to a joint.

use glam::DVec3;
use throng_base::thresholds::REFERENCE_LEG_M_F64;
use throng_core::{Joint, Skeleton};
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

/// The capsules of a body; change them at will where a character is thinner or thicker.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyCapsules {
    /// Capsules; a joint may have none, one or several.
    pub capsules: Vec<BodyCapsule>,
}

impl BodyCapsules {
    /// Fits capsules along a skeleton's segments, as thick as those of people with its leg length.
    pub fn fitted(skeleton: &Skeleton) -> Self {
        let scale = f64::from(skeleton.leg_length()) / REFERENCE_LEG_M_F64;
        let mut capsules = Vec::new();
        let mut add = |joint: Joint, a: DVec3, b: DVec3, radius: f64| {
            capsules.push(BodyCapsule { joint, core: Segment::new(a, b), radius: radius * scale });
        };
        let to = |j: Joint| skeleton.offsets[j.index()].as_dvec3();
        let [head, left_toe, right_toe] = skeleton.tips.map(|t| t.as_dvec3());
        let zero = DVec3::ZERO;
        add(Joint::Hips, 0.7 * to(Joint::LeftThigh), 0.7 * to(Joint::RightThigh), 0.1);
        let side = DVec3::X * 0.04 * scale;
        add(Joint::Spine, side, -side, 0.1);
        add(Joint::Chest, side, -side, 0.105);
        let up = 0.3 * to(Joint::Neck);
        add(Joint::UpperChest, up + 1.5 * side, up - 1.5 * side, 0.1);
        add(Joint::Neck, zero, to(Joint::Head), 0.05);
        add(Joint::Head, 0.35 * head, 0.55 * head, 0.095);
        for (upper, fore, hand) in [
            (Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand),
            (Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand),
        ] {
            add(upper, zero, to(fore), 0.045);
            add(fore, zero, to(hand), 0.036);
            let along = to(hand).normalize_or_zero();
            add(hand, 0.02 * scale * along, 0.1 * scale * along, 0.034);
        }
        for (thigh, shin, foot, toe, tip) in [
            (Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot, Joint::LeftToe, left_toe),
            (Joint::RightThigh, Joint::RightShin, Joint::RightFoot, Joint::RightToe, right_toe),
        ] {
            add(thigh, 0.2 * to(shin), to(shin), 0.065);
            add(shin, zero, to(foot), 0.048);
            add(foot, zero, 0.9 * to(toe), 0.033);
            add(toe, zero, 0.7 * tip, 0.022);
        }
        Self { capsules }
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
