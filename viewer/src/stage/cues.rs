//! Cues on bodies: contacts, joint axes, colours of categories.

use super::Palette;
use crate::render::{Rgba, Shapes};
use glam::Vec3;
use throng_runtime::{Contacts, Joint, Mat3x4, NUM_JOINTS, Planar};

/// Heels and toes: the joint above, and how far in front of it the marker lies. [Unit: m]
const FEET: [(Joint, Contacts); 4] = [
    (Joint::LeftFoot, Contacts::LEFT_HEEL),
    (Joint::LeftToe, Contacts::LEFT_TOE),
    (Joint::RightFoot, Contacts::RIGHT_HEEL),
    (Joint::RightToe, Contacts::RIGHT_TOE),
];

/// A mark on the ground below every heel and toe, strong where it is planted.
pub(super) fn contacts(shapes: &mut Shapes, joints: &[Vec3; NUM_JOINTS], contacts: Contacts, palette: &Palette) {
    for (joint, part) in FEET {
        let at = joints[joint.index()].with_y(0.01);
        if contacts.any(part) {
            shapes.disc(at, 0.055, palette.planted.alpha(0.85));
        } else {
            shapes.ring(at, 0.035, 0.042, palette.lifted);
        }
    }
}

/// Axes of every joint, in front of the body.
pub(super) fn joint_axes(shapes: &mut Shapes, root: Planar, pose: &[Mat3x4]) {
    let (turn, move_by) = (root.rotation(), root.translation());
    shapes.on_top(true);
    for m in pose {
        shapes.axes(move_by + turn * m.translation(), turn * m.rotation(), 0.07, 1.5);
    }
    shapes.on_top(false);
}

/// A colour for the n-th of many things; neighbours differ.
pub(super) fn category(n: usize) -> Rgba {
    const COLOURS: [u32; 10] =
        [0x4e79a7, 0xf28e2b, 0x59a14f, 0xe15759, 0x76b7b2, 0xedc948, 0xb07aa1, 0xff9da7, 0x9c755f, 0x8cd17d];
    Rgba::hex(COLOURS[n % COLOURS.len()])
}
