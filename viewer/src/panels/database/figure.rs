//! A body seen from its right side, small.

use crate::panels::paint::paint_chain;
use crate::theme::ThemePalette;
use eframe::egui::{Color32, Painter, Pos2, Stroke, Vec2, vec2};
use glam::Vec3;
use std::array::from_fn;
use throng_core::body::Mat3x4;
use throng_core::{Contacts, Joint, NUM_JOINTS, Skeleton};

/// A body in the plane in which it walks: x ahead, y up, from the point of the ground below its hips.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseFigure {
    /// Joints (m).
    joints: [Vec2; NUM_JOINTS],
    /// Top of the head, tips of the left and the right toe (m).
    tips: [Vec2; 3],
    /// Parts of the feet that stand.
    contacts: Contacts,
}

/// Style of a painted figure.
#[derive(Clone, Copy, Debug)]
pub struct FigureStyle {
    /// Points a metre.
    pub scale: f32,
    /// Background colour.
    pub paper: Color32,
    /// Fading into the background (0 to 1).
    pub fade: f32,
    /// A silhouette of one colour, larger than the body by this margin (m).
    pub halo: Option<(Color32, f32)>,
}

impl PoseFigure {
    /// From joints in model space, above the planar root (NUM_JOINTS).
    pub fn new(skeleton: &Skeleton, joints: &[Mat3x4], contacts: Contacts) -> Self {
        let flat = |p: Vec3| vec2(p.z, p.y);
        let joint = |j: usize| joints.get(j).map_or(Vec2::ZERO, |m| flat(m.translation()));
        let ends = [Joint::Head, Joint::LeftToe, Joint::RightToe].map(Joint::index);
        let tip = |k: usize| {
            let of = |m: &Mat3x4| flat(m.to_mat4().transform_point3(skeleton.tips[k]));
            joints.get(ends[k]).map_or(Vec2::ZERO, of)
        };
        Self { joints: from_fn(joint), tips: from_fn(tip), contacts }
    }

    /// Paints it with its place on the ground at `foot`: the far, left side first.
    pub fn paint(&self, painter: &Painter, foot: Pos2, style: FigureStyle, palette: &ThemePalette) {
        use Joint::*;
        // Opaque, so that limbs which lie over each other do not show their joints.
        let colour = |c: Color32| style.halo.map_or(c.lerp_to_gamma(style.paper, style.fade), |h| h.0);
        let grown = 2.0 * style.halo.map_or(0.0, |h| h.1);
        let (left, right, trunk) = (colour(palette.left), colour(palette.right), colour(palette.trunk));
        let at = |p: Vec2| foot + vec2(p.x, -p.y) * style.scale;
        let joint = |j: Joint| at(self.joints[j.index()]);
        let limb = |points: &[Pos2], metres: f32, colour: Color32| {
            paint_chain(painter, points, ((metres + grown) * style.scale).max(1.0), colour)
        };
        limb(&[joint(LeftUpperArm), joint(LeftForearm), joint(LeftHand)], 0.06, left);
        limb(&[joint(LeftThigh), joint(LeftShin), joint(LeftFoot), joint(LeftToe), at(self.tips[1])], 0.08, left);
        limb(&[joint(Hips), joint(Spine), joint(Chest), joint(UpperChest), joint(Neck)], 0.14, trunk);
        let head = joint(Head) + 0.5 * (at(self.tips[0]) - joint(Head));
        limb(&[joint(Neck), head], 0.06, trunk);
        painter.circle_filled(head, ((0.1 + 0.5 * grown) * style.scale).max(1.5), trunk);
        limb(&[joint(RightThigh), joint(RightShin), joint(RightFoot), joint(RightToe), at(self.tips[2])], 0.08, right);
        limb(&[joint(RightUpperArm), joint(RightForearm), joint(RightHand)], 0.06, right);
        self.paint_contacts(painter, foot, style, palette);
    }

    /// A bar on the ground under every part of a foot that stands.
    fn paint_contacts(&self, painter: &Painter, foot: Pos2, style: FigureStyle, palette: &ThemePalette) {
        use Joint::{LeftFoot, LeftToe, RightFoot, RightToe};
        let parts = [
            (Contacts::LEFT_HEEL, LeftFoot, palette.left, 3.5),
            (Contacts::LEFT_TOE, LeftToe, palette.left, 3.5),
            (Contacts::RIGHT_HEEL, RightFoot, palette.right, 1.5),
            (Contacts::RIGHT_TOE, RightToe, palette.right, 1.5),
        ];
        for (part, joint, colour, below) in parts {
            if self.contacts.any(part) {
                let x = foot.x + self.joints[joint.index()].x * style.scale;
                let half = (0.07 * style.scale).max(2.0);
                let stroke = Stroke::new(2.0, colour.lerp_to_gamma(style.paper, style.fade));
                painter.hline(x - half..=x + half, foot.y + below, stroke);
            }
        }
    }

    /// Highest point (m).
    pub fn top(&self) -> f32 {
        self.joints.iter().chain(&self.tips).map(|p| p.y).fold(0.0, f32::max)
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
        let figure = PoseFigure::new(&skeleton, &joints, Contacts::NONE);
        let head = skeleton.rest_positions()[Joint::Head.index()] + skeleton.tips[0];
        assert!((figure.top() - head.y).abs() < 1e-5);
        assert!(figure.tips[1].x > figure.joints[Joint::LeftToe.index()].x + 0.05);
    }
}
