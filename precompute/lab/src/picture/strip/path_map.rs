//! The path of the root from above, oriented as the overview: +X right, +Z down.

use super::super::canvas::Area;
use super::super::furniture::{grid, nice_step, scale_bar};
use super::super::text::{Align, TextStyle, draw_text};
use super::{StripFrame, StripPose};
use crate::picture::{Picture, PictureCamera, colour};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};
use throng_geometry::BoundingBox;

/// Draws the root's path with an arrow at every pose.
pub(super) fn draw(page: &mut Picture, area: Area, unit: f32, frames: &[StripFrame], poses: &[Option<StripPose<'_>>]) {
    let mut map = Picture::new(area.size.x as u32, area.size.y as u32, colour::GROUND);
    let points: Vec<Vec3> = frames.iter().map(|f| f.root.translation()).filter(|p| p.is_finite()).collect();
    let bounds = BoundingBox::around_points(points.iter().copied());
    let (min, max) = if points.is_empty() { (Vec3::ZERO, Vec3::ZERO) } else { (bounds.min, bounds.max) };
    let size = Vec2::new(map.width() as f32, map.height() as f32);
    let room = size - Vec2::new(90.0, 160.0) * unit;
    let extent = (max - min).max(Vec3::splat(0.6));
    let px_per_m = (room.x / extent.x).min(room.y / extent.z).clamp(0.01, 150.0 * unit);
    let middle = 0.5 * size - Vec2::new(0.0, 4.0 * unit);
    let camera = PictureCamera::looking_along(PI, FRAC_PI_2).framed(0.5 * (min + max), middle, px_per_m);
    grid(&mut map, &camera, nice_step(size.x / px_per_m / 5.0), unit);
    let path: Vec<Vec2> = points.iter().map(|p| camera.project(*p)).collect();
    map.stroke_line(&path, 2.0 * unit, colour::INK_SOFT.alpha(0.7));
    for (_, frame) in poses.iter().flatten() {
        let at = camera.project(frame.root.translation());
        let (s, c) = frame.root.heading.sin_cos();
        let (ahead, aside) = (Vec2::new(s, c), Vec2::new(c, -s));
        let tip = [ahead * 11.0, aside * 5.0 - ahead * 5.0, ahead * -2.0, aside * -5.0 - ahead * 5.0];
        map.fill_polygon(&tip.map(|v| at + v * unit), colour::MARK);
    }
    let style = TextStyle { size: 19.0 * unit, colour: colour::INK, align: Align::Left, bold: true };
    let length: f32 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
    draw_text(&mut map, Vec2::new(12.0, 26.0) * unit, &format!("way of the root: {length:.1} m"), style);
    scale_bar(&mut map, &camera, unit);
    page.draw_picture(&map, (area.min.x as i32, area.min.y as i32));
}
