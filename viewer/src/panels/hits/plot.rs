//! One view of the hits: axes, a body for scale, the volume of a behaviour, and the hits themselves.

use super::HitViewInput;
use super::view::{HitViewPlace, HitViewpoint};
use crate::panels::paint::{FigureStyle, paint_figure};
use crate::volume::Volume;
use eframe::egui::epaint::Mesh;
use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rangef, Shape, Stroke, StrokeKind, Visuals, pos2, vec2};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;
use std::ops::RangeInclusive;
use throng_precompute::annotate::hits::HitPoint;

/// Radius of a hit (points).
const DOT: f32 = 2.6;
/// A hit is pointed at within this distance (points).
const NEAR: f32 = 9.0;
/// Length of the arrow along a blow (m).
const ARROW_M: f32 = 0.22;

/// Paints everything but the highlighted hit.
pub fn paint(painter: &Painter, visuals: &Visuals, place: &HitViewPlace, scene: &HitViewInput<'_>, dots: Mesh) {
    axes(painter, visuals, place);
    let inside = painter.with_clip_rect(place.rect.intersect(painter.clip_rect()));
    if let Some(body) = scene.body {
        let faint = visuals.extreme_bg_color.lerp_to_gamma(visuals.text_color(), 0.2);
        let style = FigureStyle { per_m: place.per_m, colours: [faint; 3], grown_m: 0.02 };
        paint_figure(&inside, body, style, |p| place.screen(p));
    }
    if let Some(policy) = scene.outlined {
        let colour = visuals.strong_text_color();
        if !policy.grid().is_polar() {
            let outline = outline(place, &Volume::of_grid(policy));
            inside.add(Shape::line(outline, Stroke::new(0.9, colour.gamma_multiply(0.6))));
        }
        if let Some(region) = Volume::of_region(policy.region()) {
            let stroke = Stroke::new(1.6, colour.gamma_multiply(0.9));
            inside.extend(Shape::dashed_line(&outline(place, &region), stroke, 6.0, 3.5));
        }
    }
    inside.add(dots);
}

/// The hits as one mesh: a dot each.
pub fn dots(place: &HitViewPlace, hits: impl Iterator<Item = (Vec3, Color32)>) -> Mesh {
    const CORNERS: u32 = 8;
    let mut mesh = Mesh::default();
    for (position, colour) in hits {
        let (at, first) = (place.screen(position), mesh.vertices.len() as u32);
        for i in 0..CORNERS {
            let (s, c) = (TAU * i as f32 / CORNERS as f32).sin_cos();
            mesh.colored_vertex(at + vec2(c, s) * DOT, colour);
        }
        (2..CORNERS).for_each(|i| mesh.add_triangle(first, first + i - 1, first + i));
    }
    mesh
}

/// Highlights a hit under the pointer or shown as a clip, with its direction.
pub fn paint_mark(painter: &Painter, place: &HitViewPlace, e: &HitPoint, colour: Color32, visuals: &Visuals) {
    let painter = painter.with_clip_rect(place.rect.intersect(painter.clip_rect()));
    let (at, tip) = (place.screen(e.position), place.screen(e.position + e.direction * ARROW_M));
    if (tip - at).length() > 4.0 {
        painter.arrow(at, tip - at, Stroke::new(1.8, visuals.strong_text_color()));
    }
    painter.circle(at, DOT + 1.6, colour, Stroke::new(1.5, visuals.strong_text_color()));
}

/// The hit nearest to the pointer.
pub fn pointed_at(place: &HitViewPlace, at: Pos2, hits: impl Iterator<Item = (usize, Vec3)>) -> Option<usize> {
    let distances = hits.map(|(i, p)| (i, place.screen(p).distance(at))).filter(|d| d.1 < NEAR);
    distances.min_by(|a, b| a.1.total_cmp(&b.1)).map(|d| d.0)
}

/// Lines with numbers, in metres, and the words at the ends of the axes.
fn axes(painter: &Painter, visuals: &Visuals, place: &HitViewPlace) {
    let (rect, font) = (place.rect, FontId::proportional(10.5));
    let (line, weak) = (visuals.widgets.noninteractive.bg_stroke.color, visuals.weak_text_color());
    painter.rect_filled(rect, 0.0, visuals.extreme_bg_color);
    let (low, high) = (place.flat_at(rect.left_bottom()), place.flat_at(rect.right_top()));
    let step = place.tick_m();
    let strength = |i: i32| if i == 0 { 1.0 } else { 0.45 };
    let label = |v: f32| if step < 0.15 { format!("{v:.1}") } else { format!("{}", (v * 10.0).round() / 10.0) };
    for i in ticks(low.x, high.x, step) {
        let v = i as f32 * step;
        let x = place.screen_of(Vec2::new(v, 0.0)).x;
        painter.vline(x, rect.y_range(), Stroke::new(1.0, line.gamma_multiply(strength(i))));
        // The words at the ends need their room.
        if x > rect.left() + 36.0 && x < rect.right() - 36.0 {
            let text = label(place.view.across(v));
            painter.text(Pos2::new(x, rect.bottom() + 2.0), Align2::CENTER_TOP, text, font.clone(), weak);
        }
    }
    for i in ticks(low.y, high.y, step) {
        let v = i as f32 * step;
        let y = place.screen_of(Vec2::new(0.0, v)).y;
        painter.hline(rect.x_range(), y, Stroke::new(1.0, line.gamma_multiply(strength(i))));
        painter.text(Pos2::new(rect.left() - 3.0, y), Align2::RIGHT_CENTER, label(v), font.clone(), weak);
    }
    painter.rect_stroke(rect, 0.0, Stroke::new(1.0, line), StrokeKind::Outside);
    let [left, right] = place.view.ends();
    painter.text(rect.left_bottom() + vec2(0.0, 2.0), Align2::LEFT_TOP, left, font.clone(), weak);
    painter.text(rect.right_bottom() + vec2(0.0, 2.0), Align2::RIGHT_TOP, right, font.clone(), weak);
    let unit = if place.view == HitViewpoint::Top { "ahead, m" } else { "height, m" };
    painter.text(rect.right_top() - vec2(0.0, 2.0), Align2::RIGHT_BOTTOM, unit, font, weak);
    let title = FontId::proportional(12.5);
    let at = rect.left_top() - vec2(0.0, 2.0);
    painter.text(at, Align2::LEFT_BOTTOM, place.view.title(), title, visuals.strong_text_color());
}

fn ticks(low: f32, high: f32, step: f32) -> RangeInclusive<i32> {
    (low / step).ceil() as i32..=(high / step).floor() as i32
}

/// The outline of a volume as a view sees it: closed.
fn outline(place: &HitViewPlace, volume: &Volume) -> Vec<Pos2> {
    let ground = volume.over_ground().into_iter().map(|p| place.screen(Vec3::new(p.x, 0.0, p.y)));
    let mut points: Vec<Pos2> = ground.collect();
    if place.view != HitViewpoint::Top {
        // A view from a side is as wide as the outline over ground and as high as the heights.
        let x = points.iter().fold(Rangef::NOTHING, |x, p| Rangef::new(x.min.min(p.x), x.max.max(p.x)));
        let [bottom, top] = volume.height.map(|height| place.screen(Vec3::Y * height).y);
        points = vec![pos2(x.min, bottom), pos2(x.max, bottom), pos2(x.max, top), pos2(x.min, top)];
    }
    points.extend(points.first().copied());
    points
}
