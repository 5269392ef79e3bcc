//! One character's motion over time: poses side by side, or where they really were.

mod gait;
mod onion;
mod path_map;

pub use onion::onion_skin;

use super::camera::Camera;
use super::canvas::{Area, Picture};
use super::colour;
use super::figure::{BodyColours, Figure};
use super::furniture::header;
use super::shadow::Shadows;
use super::sprite;
use super::text::{Align, TextStyle, draw_text};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};
use throng_runtime::{Contacts, Joint, Planar};

/// One frame of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripFrame {
    /// Since the beginning. [Unit: s] Ascending from frame to frame.
    pub time_s: f32,
    /// Position and heading on the ground.
    pub root: Planar,
    /// The body, in the world.
    pub figure: Figure,
    /// Which parts of the feet are planted.
    pub contacts: Contacts,
}

/// What [`pose_strip`] and [`onion_skin`] draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseStrip<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line.
    pub subtitle: &'a str,
    /// Every frame of the motion; the poses are chosen from them, evenly in time.
    pub frames: &'a [StripFrame],
    /// Poses drawn. [Limit: 2 to 40]
    pub columns: usize,
    /// Adds a row with the same poses from the front ([`pose_strip`] only).
    pub front_row: bool,
    /// Width of the picture; the height follows. [Unit: px]
    pub width: u32,
}

/// Draws poses side by side as seen from the side of the motion, with contacts under the feet and in a gait
/// diagram below, and the way of the root as a small map. Left limbs are orange, right ones blue.
///
/// Every pose is seen from its own right, facing right, with the root in the middle of its column.
pub fn pose_strip(strip: &PoseStrip<'_>) -> Picture {
    let unit = strip.width.clamp(200, 8000) as f32 / 1600.0;
    let layout = Layout::new(strip, unit);
    let mut page = Picture::new(layout.width as u32, layout.height as u32, colour::PAPER);
    header(&mut page, unit, strip.title, strip.subtitle);
    let poses = layout.poses(strip.frames);
    for (row, &area) in layout.rows.iter().enumerate() {
        draw_row(&mut page, &layout, (row, area), strip.frames, &poses);
    }
    draw_labels(&mut page, &layout, strip.frames, &poses);
    gait::draw(&mut page, &layout, strip.frames);
    path_map::draw(&mut page, layout.map, unit, strip.frames, &poses);
    page
}

/// A pose that is drawn: the number of its frame, and the frame.
type Pose<'a> = (usize, &'a StripFrame);

/// Where things are on a strip. [Unit: px]
struct Layout {
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
    /// Map of the root's way.
    map: Area,
    px_per_m: f32,
}

impl Layout {
    fn new(strip: &PoseStrip<'_>, unit: f32) -> Self {
        let (width, edge, top) = (1600.0 * unit, 16.0 * unit, 84.0 * unit);
        let map_width = 250.0 * unit;
        let columns = strip.columns.clamp(2, 40);
        let row_width = width - 3.0 * edge - map_width;
        let px_per_m = (row_width / columns as f32 / 0.92).clamp(20.0 * unit, 150.0 * unit);
        let row_height = 2.12 * px_per_m;
        let num_rows = if strip.front_row { 2 } else { 1 };
        let rows = (0..num_rows)
            .map(|r| Area::new(edge, top + r as f32 * (row_height + 0.5 * edge), row_width, row_height))
            .collect::<Vec<_>>();
        let below = rows[num_rows - 1].max().y;
        let labels = Area::new(edge, below, row_width, 54.0 * unit);
        let gait = Area::new(edge, labels.max().y, row_width, 62.0 * unit);
        let map = Area::new(width - edge - map_width, top, map_width, gait.max().y - top);
        Self { unit, width, height: gait.max().y + edge, columns, rows, labels, gait, map, px_per_m }
    }

    /// Evenly chosen frames, the first and last among them; broken figures are left out.
    fn poses<'a>(&self, frames: &'a [StripFrame]) -> Vec<Option<Pose<'a>>> {
        (0..self.columns)
            .map(|c| {
                let i = c * frames.len().saturating_sub(1) / (self.columns - 1);
                frames.get(i).filter(|f| f.figure.is_drawable()).map(|f| (i, f))
            })
            .collect()
    }

    /// Horizontal middle of a column; fractions lie between columns.
    fn column_x(&self, column: f32) -> f32 {
        let area = self.rows[0];
        area.min.x + (column + 0.5) * area.size.x / self.columns as f32
    }
}

/// Heading of the motion around a frame: the mean over a quarter of a second on both sides. [Unit: rad]
fn steady_heading(frames: &[StripFrame], frame: usize) -> f32 {
    let time = frames[frame].time_s;
    let near = frames.iter().filter(|f| (f.time_s - time).abs() <= 0.25);
    let sum = near.fold(Vec2::ZERO, |s, f| s + Vec2::from_angle(f.root.heading));
    sum.to_angle()
}

fn draw_row(
    page: &mut Picture,
    layout: &Layout,
    (row, area): (usize, Area),
    frames: &[StripFrame],
    poses: &[Option<Pose<'_>>],
) {
    let unit = layout.unit;
    page.fill_rect(area, 6.0 * unit, colour::GROUND);
    let ground_y = area.max().y - 0.2 * layout.px_per_m;
    let ends = [Vec2::new(area.min.x, ground_y), Vec2::new(area.max().x, ground_y)];
    page.stroke_line(&ends, 1.2 * unit, colour::GRID);
    let views: Vec<(Camera, &StripFrame)> = poses
        .iter()
        .enumerate()
        .filter_map(|(column, pose)| {
            let (i, frame) = (*pose)?;
            let towards = steady_heading(frames, i) + if row == 0 { FRAC_PI_2 } else { PI };
            let screen = Vec2::new(layout.column_x(column as f32), ground_y);
            let camera = Camera::looking(towards, 0.1);
            Some((camera.framed(frame.root.translation(), screen, layout.px_per_m), frame))
        })
        .collect();
    draw_poses(page, &views, unit, |_| 1.0);
}

/// Figures with their shadows and contacts, in the order given.
fn draw_poses(page: &mut Picture, views: &[(Camera, &StripFrame)], unit: f32, opacity: impl Fn(usize) -> f32) {
    if let Some(mut shadows) = Shadows::new(page) {
        views.iter().for_each(|(camera, frame)| shadows.add(&frame.figure, camera));
        let px_per_m = views.first().map_or(0.0, |v| v.0.px_per_m);
        shadows.draw(page, (0.03 * px_per_m) as usize + 1, colour::INK.alpha(0.22));
    }
    let size = (page.width(), page.height());
    for (i, (camera, frame)) in views.iter().enumerate() {
        draw_contacts(page, camera, frame, unit, opacity(i));
        if let Some(sprite) = sprite::render(&frame.figure, &BodyColours::default(), camera, size, opacity(i)) {
            sprite.draw(page);
        }
    }
}

/// A bar on the ground under every planted heel and toe, in the colour of its side.
fn draw_contacts(page: &mut Picture, camera: &Camera, frame: &StripFrame, unit: f32, opacity: f32) {
    let f = &frame.figure;
    for (contact, joint, end, tint) in [
        (Contacts::LEFT_HEEL, Joint::LeftFoot, f.joint(Joint::LeftToe), colour::LEFT),
        (Contacts::LEFT_TOE, Joint::LeftToe, f.tips[1], colour::LEFT),
        (Contacts::RIGHT_HEEL, Joint::RightFoot, f.joint(Joint::RightToe), colour::RIGHT),
        (Contacts::RIGHT_TOE, Joint::RightToe, f.tips[2], colour::RIGHT),
    ] {
        if !frame.contacts.any(contact) {
            continue;
        }
        let flat = |p: Vec3| Vec3::new(p.x, 0.0, p.z);
        let along = (flat(end) - flat(f.joint(joint))).normalize_or_zero();
        let at = flat(f.joint(joint));
        let drop = Vec2::new(0.0, 0.085 * camera.px_per_m);
        let bar = [at - along * 0.045, at + along * 0.045].map(|p| camera.project(p) + drop);
        page.stroke_line(&bar, 4.0 * unit, tint.alpha(opacity));
    }
}

/// Time and speed of every pose.
fn draw_labels(page: &mut Picture, layout: &Layout, frames: &[StripFrame], poses: &[Option<Pose<'_>>]) {
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

/// Speed of the root over a fifth of a second around a frame. [Unit: m/s]
fn speed_mps(frames: &[StripFrame], frame: usize) -> Option<f32> {
    let time = frames[frame].time_s;
    let first = frames[..=frame].iter().find(|f| time - f.time_s <= 0.1 + 1e-4)?;
    let last = frames[frame..].iter().rev().find(|f| f.time_s - time <= 0.1 + 1e-4)?;
    let duration = last.time_s - first.time_s;
    (duration > 0.0).then(|| (last.root.translation() - first.root.translation()).length() / duration)
}
