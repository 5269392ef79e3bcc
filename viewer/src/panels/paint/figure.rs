//! A body of chains of limbs, small.

use super::paint_chain;
use eframe::egui::{Color32, Painter, Pos2};
use glam::{Quat, Vec3};
use throng_core::{Joint, Mat3x4, Skeleton};
use throng_precompute::picture::BodyFigure;

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

/// A figure from joints in model space, above the planar root (NUM_JOINTS).
pub fn figure_of_pose(skeleton: &Skeleton, pose: &[Mat3x4]) -> BodyFigure {
    let joint = |j: usize| pose.get(j).map_or((Vec3::ZERO, Quat::IDENTITY), |m| (m.translation(), m.rotation()));
    BodyFigure::from_transforms(skeleton, &std::array::from_fn(joint))
}

/// Paints a figure in opaque colours, so that overlapping limbs do not show their joints: the left side first.
///
/// - `at`: where a point lies on the screen.
pub fn paint_figure(painter: &Painter, figure: &BodyFigure, style: FigureStyle, at: impl Fn(Vec3) -> Pos2) {
    use Joint::*;
    let FigureStyle { per_m, colours: [left, right, trunk], grown_m } = style;
    let limb = |joints: &[Joint], end: Option<Vec3>, metres: f32, colour: Color32| {
        let points: Vec<Pos2> = joints.iter().map(|j| figure.joint(*j)).chain(end).map(&at).collect();
        paint_chain(painter, &points, ((metres + grown_m) * per_m).max(1.0), colour);
    };
    limb(&[LeftUpperArm, LeftForearm, LeftHand], None, 0.06, left);
    limb(&[LeftThigh, LeftShin, LeftFoot, LeftToe], Some(figure.tips[1]), 0.08, left);
    limb(&[Hips, Spine, Chest, UpperChest, Neck], None, 0.14, trunk);
    limb(&[LeftUpperArm, UpperChest, RightUpperArm], None, 0.1, trunk);
    let head = 0.5 * (figure.joint(Head) + figure.tips[0]);
    limb(&[Neck], Some(head), 0.06, trunk);
    painter.circle_filled(at(head), ((0.1 + 0.5 * grown_m) * per_m).max(1.5), trunk);
    limb(&[RightThigh, RightShin, RightFoot, RightToe], Some(figure.tips[2]), 0.08, right);
    limb(&[RightUpperArm, RightForearm, RightHand], None, 0.06, right);
}
