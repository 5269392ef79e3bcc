//! Poses at their true places, older ones paler.

use super::super::canvas::Area;
use super::super::furniture::{grid, header, nice_step, scale_bar};
use super::super::text::{Align, TextStyle, draw_text};
use super::{PoseStrip, StripFrame, StripLayout, StripPose, draw_poses, steady_heading};
use crate::picture::{Picture, PictureCamera, colour};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Draws poses along the true path of the root, seen from the side of the whole path and a little from above.
pub fn onion_skin(strip: &PoseStrip<'_>) -> Picture {
    let unit = strip.width.clamp(200, 8000) as f32 / 1600.0;
    let layout = StripLayout::new(strip, unit);
    let poses: Vec<StripPose<'_>> = layout.poses(strip.frames).into_iter().flatten().collect();
    let (edge, top) = (16.0 * unit, 84.0 * unit);
    let (camera, height) = fit_camera(&poses, strip.frames, 1600.0 * unit - 2.0 * edge, unit);
    let mut page = Picture::new((1600.0 * unit) as u32, (top + height + edge) as u32, colour::PAPER);
    header(&mut page, unit, strip.title, strip.subtitle);
    let area = Area::new(edge, top, 1600.0 * unit - 2.0 * edge, height);
    let mut panel = Picture::new(area.size.x as u32, area.size.y as u32, colour::GROUND);
    grid(&mut panel, &camera, nice_step(0.05 * area.size.x / camera.px_per_m), unit);
    let way: Vec<Vec2> = strip.frames.iter().map(|f| camera.project(f.root.translation())).collect();
    panel.stroke_line(&way, 2.0 * unit, colour::MARK.alpha(0.45));
    let mut order: Vec<(usize, StripPose<'_>)> = poses.iter().copied().enumerate().collect();
    order.sort_by(|a, b| {
        let depth = |p: &StripPose<'_>| camera.depth(p.1.root.translation());
        depth(&b.1).total_cmp(&depth(&a.1)).then(a.0.cmp(&b.0))
    });
    let views: Vec<(PictureCamera, &StripFrame)> = order.iter().map(|(_, pose)| (camera, pose.1)).collect();
    draw_poses(&mut panel, &views, unit, |i| 0.62 * (1.0 - (order[i].0 as f32 + 1.0) / poses.len() as f32));
    draw_times(&mut panel, &camera, unit, &poses);
    scale_bar(&mut panel, &camera, unit);
    page.draw_picture(&panel, (edge as i32, top as i32));
    page
}

/// Distance of the times below the root on the floor (m).
const BELOW_M: f32 = 0.24;

/// Draws the time under every pose that leaves room for it.
fn draw_times(panel: &mut Picture, camera: &PictureCamera, unit: f32, poses: &[StripPose<'_>]) {
    let style = TextStyle { size: 18.0 * unit, colour: colour::INK_SOFT, align: Align::Centre, bold: false };
    let mut drawn: Vec<Vec2> = Vec::new();
    for (_, frame) in poses {
        let at = camera.project(frame.root.translation()) + Vec2::new(0.0, BELOW_M * camera.px_per_m + 14.0 * unit);
        if drawn.iter().all(|p| (*p - at).abs().cmpgt(Vec2::new(52.0, 20.0) * unit).any()) {
            draw_text(panel, at, &format!("{:.2} s", frame.time_s), style);
            drawn.push(at);
        }
    }
}

/// Camera of all poses, and the height that its view needs (px).
fn fit_camera(poses: &[StripPose<'_>], frames: &[StripFrame], width: f32, unit: f32) -> (PictureCamera, f32) {
    let tilt: f32 = 0.3;
    let (Some(first), Some(last)) = (poses.first(), poses.last()) else {
        let camera = PictureCamera::looking_along(0.0, tilt);
        return (camera.framed(Vec3::ZERO, 0.5 * Vec2::splat(width), 100.0 * unit), 200.0 * unit);
    };
    let way = last.1.root.translation() - first.1.root.translation();
    let heading = if way.length() > 0.5 { way.x.atan2(way.z) } else { steady_heading(frames, first.0) };
    let camera = PictureCamera::looking_along(heading + FRAC_PI_2, tilt);
    let (mut min, mut max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for (_, frame) in poses {
        max.y = max.y.max(camera.project(frame.root.translation()).y + BELOW_M);
        for p in frame.figure.joints.iter().chain(&frame.figure.tips).chain([&frame.root.translation()]) {
            let s = camera.project(*p);
            (min, max) = (min.min(s), max.max(s));
        }
    }
    let extent = (max - min + Vec2::new(0.5, 0.35)).max(Vec2::splat(1.0));
    let px_per_m = (width / extent.x).min(620.0 * unit / extent.y).clamp(0.01, 240.0 * unit);
    // The scale is below the times.
    let height = extent.y * px_per_m + 72.0 * unit;
    let middle = camera.unproject(0.5 * (min + max));
    (camera.framed(middle, Vec2::new(0.5 * width, 0.5 * (height - 56.0 * unit)), px_per_m), height)
}
