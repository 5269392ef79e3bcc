//! A body of chains of limbs, small.

use super::paint_chain;
use eframe::egui::{Color32, Painter, Pos2};
use glam::Vec3;
use throng_core::{Joint, Mat3x4, NUM_JOINTS, Skeleton};

/// A body as seen from its planar root.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseFigure {
    /// Joints (m).
    joints: [Vec3; NUM_JOINTS],
    /// Top of the head, tips of the left and the right toe (m).
    tips: [Vec3; 3],
}

/// Style of a painted figure.
#[derive(Clone, Copy, Debug)]
pub struct FigureStyle {
    /// Points a metre.
    pub per_m: f32,
    /// Colours of the left side, the right side, and the trunk.
    pub colours: [Color32; 3],
    /// Thickness beyond that of a body (m).
    pub grown_m: f32,
}

impl PoseFigure {
    /// From joints in model space, above the planar root.
    pub fn new(skeleton: &Skeleton, pose: &[Mat3x4]) -> Self {
        let joint = |j: usize| pose.get(j).map_or(Vec3::ZERO, |m| m.translation());
        let ends = [Joint::Head, Joint::LeftToe, Joint::RightToe].map(Joint::index);
        let tip = |k: usize| pose.get(ends[k]).map_or(Vec3::ZERO, |m| m.to_mat4().transform_point3(skeleton.tips[k]));
        Self { joints: std::array::from_fn(joint), tips: std::array::from_fn(tip) }
    }

    /// Position of a joint (m).
    pub fn joint(&self, joint: Joint) -> Vec3 {
        self.joints[joint.index()]
    }

    /// Highest point (m).
    pub fn top(&self) -> f32 {
        self.joints.iter().chain(&self.tips).map(|p| p.y).fold(0.0, f32::max)
    }

    /// Paints the figure in opaque colours, so that overlapping limbs do not show their joints: the left side first.
    ///
    /// - `at`: where a point lies on the screen.
    pub fn paint(&self, painter: &Painter, style: FigureStyle, at: impl Fn(Vec3) -> Pos2) {
        use Joint::*;
        let FigureStyle { per_m, colours: [left, right, trunk], grown_m } = style;
        let limb = |joints: &[Joint], end: Option<Vec3>, metres: f32, colour: Color32| {
            let points: Vec<Pos2> = joints.iter().map(|j| self.joint(*j)).chain(end).map(&at).collect();
            paint_chain(painter, &points, ((metres + grown_m) * per_m).max(1.0), colour);
        };
        limb(&[LeftUpperArm, LeftForearm, LeftHand], None, 0.06, left);
        limb(&[LeftThigh, LeftShin, LeftFoot, LeftToe], Some(self.tips[1]), 0.08, left);
        limb(&[Hips, Spine, Chest, UpperChest, Neck], None, 0.14, trunk);
        limb(&[LeftUpperArm, UpperChest, RightUpperArm], None, 0.1, trunk);
        let head = 0.5 * (self.joint(Head) + self.tips[0]);
        limb(&[Neck], Some(head), 0.06, trunk);
        painter.circle_filled(at(head), ((0.1 + 0.5 * grown_m) * per_m).max(1.5), trunk);
        limb(&[RightThigh, RightShin, RightFoot, RightToe], Some(self.tips[2]), 0.08, right);
        limb(&[RightUpperArm, RightForearm, RightHand], None, 0.06, right);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn a_standing_body_is_as_high_as_its_head_and_its_toes_point_ahead() {
        let skeleton = Skeleton::default();
        let joints = skeleton.rest_positions().map(|p| Mat3x4::from_rotation_translation(Quat::IDENTITY, p));
        let figure = PoseFigure::new(&skeleton, &joints);
        let head = skeleton.rest_positions()[Joint::Head.index()] + skeleton.tips[0];
        assert!((figure.top() - head.y).abs() < 1e-5);
        assert!(figure.tips[1].z > figure.joint(Joint::LeftToe).z + 0.05);
    }
}
