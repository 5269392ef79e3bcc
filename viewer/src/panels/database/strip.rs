//! Poses of a clip at regular intervals along an axis, as an onion skin.

use super::timeline::TimelineInput;
use crate::panels::paint::{FigureStyle, FrameAxis, figure_of_pose, paint_figure};
use crate::{bundle::OpenBundle, document::RawMotion, theme::ThemePalette};
use eframe::egui::{Painter, Pos2, Rect, Stroke, Ui, pos2, vec2};
use glam::{Quat, Vec3};
use throng_core::{Contacts, Mat3x4, NUM_JOINTS, Planar, Skeleton};
use throng_precompute::annotate::contacts::FOOT_PARTS;
use throng_precompute::picture::{BodyFigure, step_up};

/// Least distance of two figures, as a share of the height of the strip.
const DISTANCE: f32 = 0.42;
/// Room below the ground, for contacts (points).
const BELOW: f32 = 7.0;
/// Height for which there is always room (m).
const LEAST_HEIGHT_M: f32 = 1.8;

/// Source of poses.
#[derive(Clone, Copy, Debug)]
pub enum PoseSource<'a> {
    /// A clip of a bundle.
    Bundle(&'a OpenBundle, usize),
    /// The clip that a build would make of a motion file.
    Raw(&'a RawMotion),
}

/// Poses as they were last sampled.
#[derive(Clone, Debug, Default)]
pub struct TimelineStrip {
    /// Document and clip of the poses.
    shown: Option<(u64, usize)>,
    /// The one at the play head comes last.
    figures: Vec<StripFigure>,
}

/// A body at a frame, and the parts of its feet that stand.
#[derive(Clone, Debug)]
struct StripFigure {
    frame: u32,
    figure: BodyFigure,
    contacts: Contacts,
}

impl TimelineStrip {
    /// Paints the poses within the axis and the one at the play head.
    pub fn show(&mut self, ui: &Ui, rect: Rect, axis: &FrameAxis, scene: &TimelineInput<'_>) {
        let step = step(DISTANCE * rect.height() / axis.points_per_frame());
        let seen = axis.seen();
        let (first, last) = (seen.start / step * step, seen.end.saturating_sub(1));
        let frames: Vec<u32> = (first..=last).step_by(step as usize).chain([scene.head]).collect();
        if self.shown != Some(scene.key()) || !self.figures.iter().map(|f| &f.frame).eq(&frames) {
            let sampled = frames.iter().zip(scene.source.sample(&frames));
            self.figures =
                sampled.map(|(&frame, (figure, contacts))| StripFigure { frame, figure, contacts }).collect();
            self.shown = Some(scene.key());
        }
        self.paint(ui, rect, axis);
    }

    fn paint(&self, ui: &Ui, rect: Rect, axis: &FrameAxis) {
        let palette = ThemePalette::for_visuals(ui.visuals());
        let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
        let ground = rect.bottom() - BELOW;
        let line = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
        painter.hline(rect.x_range(), ground, line);
        let highest = self.figures.iter().map(|f| top(&f.figure)).fold(LEAST_HEIGHT_M, f32::max);
        let scale = (ground - rect.top() - 2.0) / highest;
        let Some((head, others)) = self.figures.split_last() else { return };
        let paper = ui.visuals().extreme_bg_color;
        let sides = [palette.left, palette.right, palette.trunk];
        let paint = |f: &StripFigure, colours, grown_m| {
            let foot = pos2(axis.x_of(f.frame as f32), ground);
            let style = FigureStyle { per_m: scale, colours, grown_m };
            paint_figure(&painter, &f.figure, style, |p: Vec3| foot + vec2(p.z, -p.y) * scale);
            f.paint_contacts(&painter, foot, style);
        };
        for other in others.iter().filter(|o| o.frame != head.frame) {
            paint(other, sides.map(|c| c.lerp_to_gamma(paper, 0.5)), 0.0);
        }
        paint(head, [palette.head; 3], 0.07);
        paint(head, sides, 0.0);
    }
}

impl StripFigure {
    /// A bar on the ground under every part of a foot that stands.
    fn paint_contacts(&self, painter: &Painter, foot: Pos2, style: FigureStyle) {
        let [left, right, _] = style.colours;
        let sides = [(left, 3.5), (left, 3.5), (right, 1.5), (right, 1.5)];
        let parts = FOOT_PARTS.into_iter().zip(sides);
        for ((joint, _), (colour, below)) in parts.filter(|((_, part), _)| self.contacts.any(*part)) {
            let x = foot.x + self.figure.joint(joint).z * style.per_m;
            let half = (0.07 * style.per_m).max(2.0);
            painter.hline(x - half..=x + half, foot.y + below, Stroke::new(2.0, colour));
        }
    }
}

/// Highest point of a figure (m).
fn top(figure: &BodyFigure) -> f32 {
    figure.joints.iter().chain(&figure.tips).map(|p| p.y).fold(0.0, f32::max)
}

/// The least number of frames of a round series that is not below `least`.
fn step(least: f32) -> u32 {
    step_up(f64::from(least.clamp(1.0, 1e8).ceil())).round() as u32
}

impl PoseSource<'_> {
    /// Figures of frames of the clip, numbered from its start.
    fn sample(self, frames: &[u32]) -> Vec<(BodyFigure, Contacts)> {
        match self {
            Self::Bundle(bundle, clip) => sample_bundle(bundle, clip, frames).unwrap_or_default(),
            Self::Raw(raw) => sample_raw(raw, frames),
        }
    }
}

fn sample_bundle(bundle: &OpenBundle, clip: usize, frames: &[u32]) -> Option<Vec<(BodyFigure, Contacts)>> {
    let tables = bundle.tables();
    let record = tables.clips().get(clip)?;
    let rows: Vec<u32> = frames.iter().map(|f| record.first_frame + f.min(&(record.num_frames - 1))).collect();
    let poses = bundle.sample_rows(&rows)?;
    let figure =
        |(row, pose): (&u32, &[Mat3x4])| (figure_of_pose(tables.skeleton(), pose), tables.contacts()[*row as usize]);
    Some(rows.iter().zip(poses.chunks(NUM_JOINTS)).map(figure).collect())
}

fn sample_raw(raw: &RawMotion, frames: &[u32]) -> Vec<(BodyFigure, Contacts)> {
    let Some(clip) = raw.clips.clips.first().filter(|c| c.num_frames() > 0) else { return Vec::new() };
    let skeleton: &Skeleton = &raw.clips.skeleton;
    let figure = |f: &u32| {
        let frame = (*f as usize).min(clip.num_frames() - 1);
        let planar: Planar = clip.planar(frame);
        let turn = planar.rotation().inverse();
        let joints = clip
            .joint_transforms(skeleton, frame)
            .map(|(p, r): (Vec3, Quat)| (turn * (p - planar.translation()), turn * r));
        (BodyFigure::from_transforms(skeleton, &joints), clip.contacts.get(frame).copied().unwrap_or_default())
    };
    frames.iter().map(figure).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{golden, mocap::recording};

    #[test]
    fn steps_are_round_and_wide_enough() {
        for (least, expected) in
            [(0.1, 1), (1.0, 1), (1.5, 2), (3.0, 5), (6.0, 10), (11.0, 20), (45.0, 50), (51.0, 100)]
        {
            assert_eq!(step(least), expected, "{least}");
        }
    }

    #[test]
    fn poses_of_a_bundle_stand_on_the_ground() {
        let bundle = golden();
        for clip in 0..bundle.tables().clips().len() {
            for (figure, _) in PoseSource::Bundle(&bundle, clip).sample(&[0, 10, 1_000_000]) {
                assert!((1.0..2.2).contains(&top(&figure)), "{figure:?}");
            }
        }
        assert!(PoseSource::Bundle(&bundle, usize::MAX).sample(&[0]).is_empty());
    }

    #[test]
    fn poses_of_a_motion_file_face_ahead_wherever_the_body_goes() {
        let Some(path) = recording("bandai-1/dataset-1_walk_normal_001.bvh") else { return };
        let raw = RawMotion::open(&path).unwrap();
        let figures = PoseSource::Raw(&raw).sample(&[0, 20, 40, 60]);
        assert_eq!(figures.len(), 4);
        assert!(figures.iter().all(|f| (1.2..2.2).contains(&top(&f.0))));
    }
}
