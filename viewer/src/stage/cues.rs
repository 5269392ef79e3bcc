//! Cues on bodies: contacts, joint axes, colours of categories.

use super::StagePalette;
use crate::render::{Rgba, ShapeList};
use crate::{bundle::OpenBundle, model::Model, settings::Overlays};
use glam::Vec3;
use throng_core::{Contacts, Mat3x4, Planar};
use throng_precompute::annotate::contacts::FOOT_PARTS;

/// Draws joint axes of a body, and a mark on the ground below every heel and toe, strong while it is planted, as far as
/// they are enabled.
///
/// - `pose`: joints in model space.
pub fn body(out: &mut ShapeList, o: Overlays, root: Planar, pose: &[Mat3x4], down: Contacts, palette: &StagePalette) {
    if o.contacts {
        for (joint, part) in FOOT_PARTS {
            let at = root.translation() + root.rotation() * pose[joint.index()].translation();
            if down.any(part) {
                out.disc(at.with_y(0.01), 0.055, palette.planted.alpha(0.85));
            } else {
                out.ring(at.with_y(0.01), 0.035, 0.042, palette.lifted);
            }
        }
    }
    if o.joint_axes {
        joint_axes(out, root, pose);
    }
}

/// A line through past places that fades towards the oldest.
pub(super) fn trail(shapes: &mut ShapeList, points: &[Vec3], width: f32, colour: Rgba) {
    let (last, strength) = (points.len().max(2) as f32 - 1.0, f32::from(colour.0[3]) / 255.0);
    for (i, pair) in points.windows(2).enumerate() {
        let share = 0.15 + 0.85 * (i as f32 + 1.0) / last;
        shapes.line(pair[0], pair[1], width, colour.alpha(strength * share));
    }
}

/// Time before and after a hit during which it is shown (s).
const HIT_S: f32 = 0.25;
/// Length of the arrow of a hit at full force (m).
const HIT_ARROW_M: f32 = 0.35;

/// Effective hits near the play head: positions and directions.
pub(super) fn hits(shapes: &mut ShapeList, model: &Model, bundle: &OpenBundle, row: u32, palette: &StagePalette) {
    let Some(clip) = bundle.tables().clips().get(model.selection.clip) else { return };
    let near = (HIT_S * bundle.rate_hz()).ceil();
    let all = bundle.tables().hits();
    let from = all.partition_point(|h| h.frame < row.saturating_sub(near as u32).max(clip.first_frame));
    let last = (row + near as u32).min(clip.first_frame + clip.num_frames - 1);
    for h in all[from..].iter().take_while(|h| h.frame <= last) {
        let root = bundle.planar(h.frame);
        let place = root.translation() + root.rotation() * h.position();
        let offset = root.rotation() * h.direction() * (HIT_ARROW_M * h.force);
        let strength = 1.0 - (h.frame.abs_diff(row) as f32 / (near + 1.0));
        shapes.on_top(true);
        shapes.sphere(place, 0.035, palette.target.alpha(strength));
        shapes.arrow(place, place + offset, 0.008, palette.target.alpha(strength));
        shapes.on_top(false);
    }
}

/// Axes of every joint, in front of the body.
pub(super) fn joint_axes(shapes: &mut ShapeList, root: Planar, pose: &[Mat3x4]) {
    let (turn, move_by) = (root.rotation(), root.translation());
    shapes.on_top(true);
    pose.iter().for_each(|m| shapes.axes(move_by + turn * m.translation(), turn * m.rotation(), 0.07, 1.5));
    shapes.on_top(false);
}

/// A colour for the n-th of many things; neighbours differ.
pub(super) fn category(n: usize) -> Rgba {
    const COLOURS: [u32; 10] =
        [0x4e79a7, 0xf28e2b, 0x59a14f, 0xe15759, 0x76b7b2, 0xedc948, 0xb07aa1, 0xff9da7, 0x9c755f, 0x8cd17d];
    Rgba::hex(COLOURS[n % COLOURS.len()])
}

/// The edges of a box, from its corners in the order of [`throng_geometry::BoundingBox::corners`].
pub(super) fn box_edges(corners: [Vec3; 8]) -> impl Iterator<Item = [Vec3; 2]> {
    let rising = |i: usize| [i | 1, i | 2, i | 4].into_iter().filter(move |&k| k != i).map(move |k| [i, k]);
    (0..8).flat_map(rising).map(move |ends| ends.map(|i| corners[i]))
}
