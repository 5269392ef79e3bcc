//! One character's motion over time: poses side by side, or at their true places.

mod gait;
mod onion;
mod path_map;

pub use onion::onion_skin;

use super::canvas::Area;
use super::furniture::header;
use super::shadow::Shadows;
use super::text::{Align, TextStyle, draw_text};
use super::{BodyColours, BodyFigure, Picture, PictureCamera, colour, sprite};
use glam::Vec2;
use std::f32::consts::{FRAC_PI_2, PI};
use throng_core::{Contacts, Joint, Planar};

/// One frame of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripFrame {
    /// Time since the beginning, ascending from frame to frame (s).
    pub time_s: f32,
    /// Position and heading on the ground.
    pub root: Planar,
    /// The body, in the world.
    pub figure: BodyFigure,
    /// Planted parts of the feet.
    pub contacts: Contacts,
}

/// Input of [`pose_strip`] and [`onion_skin`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseStrip<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line.
    pub subtitle: &'a str,
    /// Every frame of the motion; the poses are chosen from them, evenly in time.
    pub frames: &'a [StripFrame],
    /// Number of drawn poses (2 to 40).
    pub columns: usize,
    /// Adds a row with the same poses from the front ([`pose_strip`] only).
    pub front_row: bool,
    /// Width of the picture; the height follows (px).
    pub width: u32,
}

/// Draws poses side by side as seen from the side of the motion, with contacts under the feet and in a gait
/// diagram below, and the path of the root as a small map. Left limbs are orange, right ones blue.
///
/// Every pose is seen from its own right, facing right, with the root in the middle of its column.
pub fn pose_strip(strip: &PoseStrip<'_>) -> Picture {
    let unit = strip.width.clamp(200, 8000) as f32 / 1600.0;
    let layout = StripLayout::new(strip, unit);
    let mut page = Picture::new(layout.width as u32, layout.height as u32, colour::PAPER);
    header(&mut page, unit, strip.title, strip.subtitle);
    let poses = layout.poses(strip.frames);
    (0..layout.rows.len()).for_each(|row| layout.draw_row(&mut page, row, strip.frames, &poses));
    draw_labels(&mut page, &layout, strip.frames, &poses);
    gait::draw(&mut page, &layout, strip.frames);
    path_map::draw(&mut page, layout.map, unit, strip.frames, &poses);
    page
}

/// A drawn pose: the number of its frame, and the frame.
type StripPose<'a> = (usize, &'a StripFrame);

/// Layout of a strip (px).
struct StripLayout {
    unit: f32,
    width: f32,
    height: f32,
    columns: usize,
    /// Rows of figures.
    rows: Vec<Area>,
    /// Times and speeds.
    labels: Area,
    /// Gait diagram.
    gait: Area,
    /// Map of the root's path.
    map: Area,
    px_per_m: f32,
}

impl StripLayout {
    fn new(strip: &PoseStrip<'_>, unit: f32) -> Self {
        let (width, edge, top) = (1600.0 * unit, 16.0 * unit, 84.0 * unit);
        let map_width = 250.0 * unit;
        let columns = strip.columns.clamp(2, 40);
        let row_width = width - 3.0 * edge - map_width;
        let px_per_m = (row_width / columns as f32 / 0.92).clamp(20.0 * unit, 150.0 * unit);
        let row_height = 2.12 * px_per_m;
        let num_rows = if strip.front_row { 2 } else { 1 };
        let row = |r| Area::new(edge, top + r as f32 * (row_height + 0.5 * edge), row_width, row_height);
        let rows: Vec<Area> = (0..num_rows).map(row).collect();
        let below = rows[num_rows - 1].max().y;
        let labels = Area::new(edge, below, row_width, 54.0 * unit);
        let gait = Area::new(edge, labels.max().y, row_width, 62.0 * unit);
        let map = Area::new(width - edge - map_width, top, map_width, gait.max().y - top);
        Self { unit, width, height: gait.max().y + edge, columns, rows, labels, gait, map, px_per_m }
    }

    /// Evenly chosen frames, the first and last among them; broken figures are left out.
    fn poses<'a>(&self, frames: &'a [StripFrame]) -> Vec<Option<StripPose<'a>>> {
        let chosen = (0..self.columns).map(|c| c * frames.len().saturating_sub(1) / (self.columns - 1));
        chosen.map(|i| frames.get(i).filter(|f| f.figure.is_drawable()).map(|f| (i, f))).collect()
    }

    /// Horizontal centre of a column; fractions lie between columns (px).
    fn column_x(&self, column: f32) -> f32 {
        let area = self.rows[0];
        area.min.x + (column + 0.5) * area.size.x / self.columns as f32
    }

    fn draw_row(&self, page: &mut Picture, row: usize, frames: &[StripFrame], poses: &[Option<StripPose<'_>>]) {
        let (unit, area) = (self.unit, self.rows[row]);
        let mut panel = Picture::new(area.size.x as u32, area.size.y as u32, colour::GROUND);
        let ground_y = area.size.y - 0.2 * self.px_per_m;
        let ends = [Vec2::new(0.0, ground_y), Vec2::new(area.size.x, ground_y)];
        panel.stroke_line(&ends, 1.2 * unit, colour::GRID);
        let views = poses.iter().enumerate().filter_map(|(column, pose)| {
            let (i, frame) = (*pose)?;
            let towards = steady_heading(frames, i) + if row == 0 { FRAC_PI_2 } else { PI };
            let screen = Vec2::new(self.column_x(column as f32) - area.min.x, ground_y);
            let camera = PictureCamera::looking_along(towards, 0.1);
            Some((camera.framed(frame.root.translation(), screen, self.px_per_m), frame))
        });
        let views: Vec<(PictureCamera, &StripFrame)> = views.collect();
        draw_poses(&mut panel, &views, unit, |_| 0.0);
        page.draw_picture(&panel, (area.min.x as i32, area.min.y as i32));
    }
}

/// Heading of the motion around a frame: the mean over a quarter of a second on both sides (rad).
fn steady_heading(frames: &[StripFrame], frame: usize) -> f32 {
    let time = frames[frame].time_s;
    let near = frames.iter().filter(|f| (f.time_s - time).abs() <= 0.25);
    let sum = near.fold(Vec2::ZERO, |s, f| s + Vec2::from_angle(f.root.heading));
    sum.to_angle()
}

/// Draws figures with their shadows and contacts, in the given order; `faded` is how pale each is (0 to 1).
fn draw_poses(page: &mut Picture, views: &[(PictureCamera, &StripFrame)], unit: f32, faded: impl Fn(usize) -> f32) {
    if let Some(mut shadows) = Shadows::new(page) {
        views.iter().for_each(|(camera, frame)| shadows.add(&frame.figure, camera));
        let px_per_m = views.first().map_or(0.0, |v| v.0.px_per_m);
        shadows.draw(page, (0.03 * px_per_m) as usize + 1, colour::INK.alpha(0.22));
    }
    for (i, (camera, frame)) in views.iter().enumerate() {
        draw_contacts(page, camera, frame, unit, faded(i));
        let colours = BodyColours::default().faded(colour::GROUND, faded(i));
        sprite::draw(page, &frame.figure, &colours, camera);
    }
}

/// Draws a bar below every planted heel and toe, in the colour of its side.
fn draw_contacts(page: &mut Picture, camera: &PictureCamera, frame: &StripFrame, unit: f32, faded: f32) {
    for (contact, joint, tint) in [
        (Contacts::LEFT_HEEL, Joint::LeftFoot, colour::LEFT),
        (Contacts::LEFT_TOE, Joint::LeftToe, colour::LEFT),
        (Contacts::RIGHT_HEEL, Joint::RightFoot, colour::RIGHT),
        (Contacts::RIGHT_TOE, Joint::RightToe, colour::RIGHT),
    ] {
        if frame.contacts.any(contact) {
            let p = camera.project(frame.figure.joint(joint).with_y(0.0)) + Vec2::new(0.0, 0.085 * camera.px_per_m);
            let half = Vec2::new(0.04 * camera.px_per_m, 0.0);
            page.stroke_line(&[p - half, p + half], 4.0 * unit, tint.mix(colour::GROUND, faded));
        }
    }
}

/// Draws time and speed of every pose.
fn draw_labels(page: &mut Picture, layout: &StripLayout, frames: &[StripFrame], poses: &[Option<StripPose<'_>>]) {
    let unit = layout.unit;
    let style = TextStyle { size: 20.0 * unit, colour: colour::INK, align: Align::Centre, bold: true };
    let soft = TextStyle { size: 17.0 * unit, colour: colour::INK_SOFT, align: Align::Centre, bold: false };
    for (column, pose) in poses.iter().enumerate() {
        let Some((i, frame)) = pose else { continue };
        let at = Vec2::new(layout.column_x(column as f32), layout.labels.min.y);
        draw_text(page, at + Vec2::new(0.0, 22.0 * unit), &format!("{:.2} s", frame.time_s), style);
        if let Some(speed) = speed_mps(frames, *i) {
            draw_text(page, at + Vec2::new(0.0, 43.0 * unit), &format!("{speed:.1} m/s"), soft);
        }
    }
}

/// Speed of the root over a fifth of a second around a frame (m/s).
fn speed_mps(frames: &[StripFrame], frame: usize) -> Option<f32> {
    let time = frames[frame].time_s;
    let first = frames[..=frame].iter().find(|f| time - f.time_s <= 0.1 + 1e-4)?;
    let last = frames[frame..].iter().rev().find(|f| f.time_s - time <= 0.1 + 1e-4)?;
    let duration = last.time_s - first.time_s;
    (duration > 0.0).then(|| (last.root.translation() - first.root.translation()).length() / duration)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use throng_core::Skeleton;

    /// A statue that glides along +X at 1.5 m/s, facing where it goes.
    fn gliding(num_frames: usize) -> Vec<StripFrame> {
        let joints = Skeleton::default().rest_positions();
        let frame = |i: usize| {
            let root = Planar::new(0.05 * i as f32, 0.0, FRAC_PI_2);
            let figure = BodyFigure::from_positions(&joints.map(|p| root.rotation() * p + root.translation()));
            StripFrame { time_s: i as f32 / 30.0, root, figure, contacts: Contacts::LEFT }
        };
        (0..num_frames).map(frame).collect()
    }

    fn strip(frames: &[StripFrame]) -> PoseStrip<'_> {
        PoseStrip { title: "t", subtitle: "s", frames, columns: 6, front_row: true, width: 400 }
    }

    #[test]
    fn speed_is_that_of_the_root() {
        let frames = gliding(40);
        for i in [0, 1, 20, 39] {
            assert!(speed_mps(&frames, i).is_some_and(|v| (v - 1.5).abs() < 1e-3), "frame {i}");
        }
        assert_eq!(speed_mps(&frames[..1], 0), None);
    }

    #[test]
    fn poses_are_even_and_hold_both_ends() {
        let frames = gliding(31);
        let chosen = StripLayout::new(&strip(&frames), 0.25).poses(&frames);
        let numbers: Vec<usize> = chosen.iter().flatten().map(|p| p.0).collect();
        assert_eq!(numbers, [0, 6, 12, 18, 24, 30]);
    }

    #[test]
    fn steady_heading_does_not_break_where_the_angle_wraps() {
        let mut frames = gliding(9);
        for (i, f) in frames.iter_mut().enumerate() {
            f.root.heading = if i % 2 == 0 { PI - 0.1 } else { -PI + 0.1 };
        }
        assert!(steady_heading(&frames, 4).abs() > 3.0);
    }

    #[test]
    fn pictures_repeat_and_their_height_follows_the_rows() {
        let frames = gliding(31);
        let two = pose_strip(&strip(&frames));
        assert_eq!(two, pose_strip(&strip(&frames)));
        let one = pose_strip(&PoseStrip { front_row: false, ..strip(&frames) });
        assert!(one.height() < two.height() && one.width() == two.width());
    }

    #[test]
    fn no_frames_and_broken_ones_are_drawn_without_a_panic() {
        let mut frames = gliding(3);
        frames[1].figure = frames[1].figure.translated(Vec3::NAN);
        frames[2].root.x = f32::NAN;
        for frames in [&frames[..], &frames[..1], &[]] {
            pose_strip(&strip(frames));
            onion_skin(&strip(frames));
        }
    }
}
