//! The segment that a character with policies plays: its colour, and its path on the ground.

use super::{StageLayout, StagePalette, cues};
use crate::render::Rgba;
use crate::run::PolicyChooser;
use crate::settings::Colouring;
use glam::Vec3;
use throng_base::thresholds::RUN_SPEED_MPS;

/// By the speed or the clip of the segment that is played, or whether it is made.
pub(super) fn colour_of_segment(chooser: &PolicyChooser<'_>, colouring: Colouring, palette: &StagePalette) -> Rgba {
    let (segment, played) = chooser.characters.segment(chooser.number);
    let s = &chooser.bundle.tables().graph().segments[segment as usize];
    if colouring == Colouring::Clip {
        return cues::category(s.clip as usize);
    }
    if colouring == Colouring::Made {
        let row = s.start + (played as u32).min(s.num_frames);
        return if chooser.bundle.is_made(row) { palette.target } else { palette.plain };
    }
    let metres = s.displacement[0].hypot(s.displacement[1]);
    let speed = metres / s.num_frames as f32 * chooser.bundle.rate_hz();
    palette.slow.mix(palette.fast, (speed / RUN_SPEED_MPS).min(1.0))
}

/// Draws the ground path of the rest of the segment, and the final heading.
pub(super) fn trajectory(out: &mut StageLayout, chooser: &PolicyChooser<'_>, palette: &StagePalette) {
    let (bundle, characters) = (chooser.bundle, chooser.characters);
    let (segment, time) = characters.segment(chooser.number);
    let s = bundle.tables().graph().segments[segment as usize];
    let root = characters.root(chooser.number);
    let now = s.start + (time as u32).min(s.num_frames);
    let clip_to_world = root.compose(bundle.planar(now).inverse());
    let end = s.start + s.num_frames;
    let mut points = vec![root.translation().with_y(0.016)];
    let stride = (s.num_frames / 12).max(1) as usize;
    points
        .extend((now..end).step_by(stride).skip(1).map(|row| clip_to_world.compose(bundle.planar(row)).translation()));
    let goal = clip_to_world.compose(bundle.planar(end));
    points.push(goal.translation());
    points.iter_mut().for_each(|p| p.y = 0.016);
    out.shapes.polyline(&points, 2.5, palette.slow);
    let ahead = goal.rotation() * Vec3::Z * 0.22;
    let foot = goal.translation().with_y(0.02);
    out.shapes.arrow(foot, foot + ahead, 0.014, palette.slow);
}
