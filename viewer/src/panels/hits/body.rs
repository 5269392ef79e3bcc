//! A body for scale: the pose of a frame, as a silhouette.

use super::view::HitViewPlace;
use crate::bundle::OpenBundle;
use crate::panels::paint::paint_chain;
use eframe::egui::{Color32, Painter};
use glam::Vec3;
use throng_core::characters::SampleJob;
use throng_core::{Joint, Mat3x4, NUM_JOINTS};

/// The pose of a frame, as seen from its planar root.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseSilhouette {
    /// Frame row of the pose.
    pub row: u32,
    /// (m)
    joints: [Vec3; NUM_JOINTS],
    /// Top of the head, tips of the left and the right toe (m).
    tips: [Vec3; 3],
}

impl PoseSilhouette {
    /// The pose of a frame; none if there is no such frame.
    pub fn sample_row(bundle: &OpenBundle, row: u32) -> Option<Self> {
        let mut matrices = [Mat3x4::default(); NUM_JOINTS];
        let motion_set = &bundle.motion_set;
        SampleJob { motion_set, frames: &[row], ratios: &[0.0], matrices: &mut matrices }.run().ok()?;
        let ends = [Joint::Head, Joint::LeftToe, Joint::RightToe];
        let tip = |k: usize| matrices[ends[k].index()].to_mat4().transform_point3(bundle.tables().skeleton().tips[k]);
        Some(Self { row, joints: matrices.map(|m| m.translation()), tips: [tip(0), tip(1), tip(2)] })
    }

    /// A frame at which the character stands, where the motion graph knows one; otherwise the first of all.
    pub fn standing_row(bundle: &OpenBundle) -> u32 {
        bundle.tables().graph().states.iter().find(|s| s.standing != 0).map_or(0, |s| s.frame)
    }

    /// Position of a joint (m).
    #[cfg(test)]
    pub fn joint(&self, joint: Joint) -> Vec3 {
        self.joints[joint.index()]
    }

    /// Paints the body in one opaque colour, so that overlapping limbs do not show.
    pub fn paint(&self, painter: &Painter, place: &HitViewPlace, colour: Color32) {
        use Joint::*;
        let at = |p: Vec3| place.screen(p);
        let joint = |j: Joint| at(self.joints[j.index()]);
        let head = at(0.5 * (self.joints[Head.index()] + self.tips[0]));
        let chains: [(&[_], f32); 7] = [
            (&[joint(Hips), joint(Spine), joint(Chest), joint(UpperChest), joint(Neck)], 0.17),
            (&[joint(LeftUpperArm), joint(UpperChest), joint(RightUpperArm)], 0.12),
            (&[joint(LeftUpperArm), joint(LeftForearm), joint(LeftHand)], 0.07),
            (&[joint(RightUpperArm), joint(RightForearm), joint(RightHand)], 0.07),
            (&[joint(LeftThigh), joint(LeftShin), joint(LeftFoot), joint(LeftToe), at(self.tips[1])], 0.1),
            (&[joint(RightThigh), joint(RightShin), joint(RightFoot), joint(RightToe), at(self.tips[2])], 0.1),
            (&[joint(Neck), head], 0.09),
        ];
        for (points, metres) in chains {
            paint_chain(painter, points, (metres * place.per_m).max(1.0), colour);
        }
        painter.circle_filled(head, (0.115 * place.per_m).max(1.5), colour);
    }
}
