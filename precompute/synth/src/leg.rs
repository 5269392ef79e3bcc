//! Analytic leg IK: thigh and shin that bring an ankle to a position, with the knee bending forward.

use glam::{DMat3, DQuat, DVec3};
use throng_core::{Joint, Skeleton};

/// Result of leg IK: rotation of the thigh, and flexion of the knee.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegPose {
    /// World rotation of the thigh.
    pub thigh: DQuat,
    /// Flexion of the knee, never negative (rad).
    pub knee: f64,
}

/// Lengths of thigh and shin (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegShape {
    /// Distance from hip to knee.
    pub thigh: f64,
    /// Distance from knee to ankle.
    pub shin: f64,
}

/// Angles of a limb of two bones whose ends are `distance` apart: of the first bone from the line between the ends, and the
/// flexion at the joint; those of a straight limb for distances out of reach (rad).
///
/// `throng_geometry::two_bone_offsets` gives the same limb as offsets, but is not used here: with it, synthetic clips, and all that
/// is baked from them, would differ in their last bits.
pub(crate) fn two_bone_angles([a, b]: [f64; 2], distance: f64) -> [f64; 2] {
    let at_root = ((a * a + distance * distance - b * b) / (2.0 * a * distance)).clamp(-1.0, 1.0).acos();
    let flexion = ((distance * distance - a * a - b * b) / (2.0 * a * b)).clamp(-1.0, 1.0).acos();
    [at_root, flexion]
}

impl LegShape {
    /// Dimensions of a skeleton's left leg.
    pub fn from_skeleton(skeleton: &Skeleton) -> Self {
        let length = |j: Joint| f64::from(skeleton.offsets[j.index()].length());
        Self { thigh: length(Joint::LeftShin), shin: length(Joint::LeftFoot) }
    }

    /// Distance from hip to ankle with the knee bent by `flexion` (m).
    pub fn reach(&self, flexion: f64) -> f64 {
        let (a, b) = (self.thigh, self.shin);
        (a * a + b * b + 2.0 * a * b * flexion.cos()).sqrt()
    }

    /// Flexion of the knee at a distance from hip to ankle; that of a straight leg for distances out of reach (rad).
    pub fn flexion(&self, distance: f64) -> f64 {
        two_bone_angles([self.thigh, self.shin], distance)[1]
    }

    /// Bends the leg so that it reaches from `hip` to `ankle`, the knee towards `facing`.
    ///
    /// An ankle out of reach is pointed at with a straight leg.
    ///
    /// - `facing`: direction of the knee, not along the leg.
    pub fn solve(&self, hip: DVec3, ankle: DVec3, facing: DVec3) -> LegPose {
        let (a, b) = (self.thigh, self.shin);
        let d = ankle - hip;
        let length = d.length().clamp((a - b).abs() + 1e-6, a + b);
        let [at_hip, knee] = two_bone_angles([a, b], length);
        let down = d.normalize_or(DVec3::NEG_Y);
        let left = facing.cross(down).normalize_or(DVec3::X);
        let up = DQuat::from_axis_angle(left, -at_hip) * -down;
        let thigh = DQuat::from_mat3(&DMat3::from_cols(left, up, left.cross(up)));
        LegPose { thigh, knee }
    }
}

#[cfg(test)]
mod tests {
    use super::super::side::forward;
    use super::*;
    use proptest::prelude::*;

    const LEG: LegShape = LegShape { thigh: 0.42, shin: 0.41 };

    proptest! {
        #[test]
        fn reaches_the_ankle_with_the_knee_forward(x in -0.3f64..0.3, y in -0.75f64..-0.4, z in -0.3f64..0.3, facing in -3.0f64..3.0) {
            let (hip, ankle) = (DVec3::new(0.1, 0.9, 0.2), DVec3::new(0.1 + x, 0.9 + y, 0.2 + z));
            prop_assume!((ankle - hip).length() < 0.83);
            let f = forward(facing);
            let p = LEG.solve(hip, ankle, DVec3::new(f.x, 0.0, f.y));
            let knee = hip + p.thigh * DVec3::new(0.0, -LEG.thigh, 0.0);
            let shin = p.thigh * DQuat::from_rotation_x(p.knee);
            let reached = knee + shin * DVec3::new(0.0, -LEG.shin, 0.0);
            prop_assert!((reached - ankle).length() < 1e-9);
            prop_assert!((knee - 0.5 * (hip + ankle)).dot(DVec3::new(f.x, 0.0, f.y)) > 0.0);
        }

        #[test]
        fn reach_and_flexion_agree(flexion in 0.01f64..2.0) {
            let p = LEG.solve(DVec3::Y, DVec3::Y - DVec3::Y * LEG.reach(flexion), DVec3::Z);
            prop_assert!((p.knee - flexion).abs() < 1e-6);
            prop_assert!((LEG.flexion(LEG.reach(flexion)) - flexion).abs() < 1e-6);
        }
    }
}
