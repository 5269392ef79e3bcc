//! One view of the hits: axes, a body for scale, the volume of a behaviour, and the hits themselves.

use super::HitViewInput;
use crate::panels::paint::{FigureStyle, paint_figure};
use crate::volume::Volume;
use eframe::egui::epaint::Mesh;
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rangef, Rect, Shape, Stroke, StrokeKind, Visuals, pos2, vec2,
};
use glam::{Vec2, Vec3};
use std::{f32::consts::TAU, ops::RangeInclusive};
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
    // The smallest whose labels do not touch.
    let step = [0.1, 0.2, 0.5, 1.0].into_iter().find(|t| t * place.per_m >= 30.0).unwrap_or(2.0);
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

/// Room for the numbers at the left of a view, below it, and for its title above it (points).
const LEFT: f32 = 34.0;
const BELOW: f32 = 17.0;
const ABOVE: f32 = 17.0;
/// Space between views (points).
const GAP: f32 = 8.0;

/// From where the hits are seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HitViewpoint {
    /// Face to face: the left side of the body is at the right.
    Front,
    /// From above: ahead is up, the left side is at the left, as on the map of values.
    Top,
    /// From its right side: ahead is at the right.
    Side,
}

/// Titles of the viewpoints in their order, and labels of the left and the right edge.
const WORDS: [(&str, [&str; 2]); 3] =
    [("Front", ["right", "left"]), ("Top", ["left", "right"]), ("Side", ["behind", "ahead"])];

impl HitViewpoint {
    /// All of them, from left to right.
    pub const ALL: [Self; 3] = [Self::Front, Self::Top, Self::Side];

    /// Title above the view.
    pub fn title(self) -> &'static str {
        WORDS[self as usize].0
    }

    /// Labels of its left and its right edge.
    pub fn ends(self) -> [&'static str; 2] {
        WORDS[self as usize].1
    }

    /// Projection of a place: to the right and up (m).
    pub fn flat(self, p: Vec3) -> Vec2 {
        match self {
            Self::Front => Vec2::new(p.x, p.y),
            Self::Top => Vec2::new(-p.x, p.z),
            Self::Side => Vec2::new(p.z, p.y),
        }
    }

    /// The coordinate of the body's frame that a place along the horizontal axis stands for (m).
    pub fn across(self, right: f32) -> f32 {
        // Adding 0 makes the place of the root +0, not -0.
        if self == Self::Top { 0.0 - right } else { right }
    }
}

/// A box around all that is to be seen, as seen from the planar root (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitBounds {
    /// Least left, up, ahead.
    pub low: Vec3,
    /// Greatest.
    pub high: Vec3,
}

impl HitBounds {
    /// Room for all places and for as much of a standing body as is near them.
    pub fn around(places: impl Iterator<Item = Vec3> + Clone) -> Self {
        let lowest = places.clone().map(|p| p.y).fold(1.2, f32::min);
        let body = (Vec3::new(-0.4, (lowest - 0.3).max(0.0), -0.3), Vec3::new(0.4, 1.8, 0.5));
        let (mut low, mut high) = places.fold(body, |(l, h), p| (l.min(p), h.max(p)));
        let wide = low.x.abs().max(high.x);
        (low.x, high.x) = (-wide, wide);
        let margin = Vec3::splat(0.08);
        (low, high) = (low - margin, high + margin);
        Self { low: low.with_y(low.y.max(-0.08)), high }
    }
}

/// Placement of a view on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitViewPlace {
    /// Viewpoint.
    pub view: HitViewpoint,
    /// The part of the screen that shows places.
    pub rect: Rect,
    /// Points that a metre takes.
    pub per_m: f32,
    /// Screen position of the planar root, which may lie outside.
    origin: Pos2,
}

impl HitViewPlace {
    /// Lays the views side by side at the largest scale that fits all three.
    pub fn lay_out(bounds: HitBounds, rect: Rect) -> [Self; 3] {
        let corners = HitViewpoint::ALL.map(|v| {
            let (a, b) = (v.flat(bounds.low), v.flat(bounds.high));
            (a.min(b), a.max(b))
        });
        let width: f32 = corners.iter().map(|(low, high)| high.x - low.x).sum();
        let height = corners.iter().map(|(low, high)| high.y - low.y).fold(0.0, f32::max);
        let room = vec2(rect.width() - 3.0 * LEFT - 3.0 * GAP, rect.height() - ABOVE - BELOW);
        let per_m = (room.x / width).min(room.y / height).max(5.0);
        let mut x = rect.left() + 0.5 * (room.x - width * per_m).max(0.0);
        let bottom = rect.top() + ABOVE + 0.5 * (room.y + height * per_m).max(height * per_m);
        std::array::from_fn(|k| {
            let (view, (low, high)) = (HitViewpoint::ALL[k], corners[k]);
            let size = (high - low) * per_m;
            let rect = Rect::from_min_max(pos2(x + LEFT, bottom - size.y), pos2(x + LEFT + size.x, bottom));
            x += LEFT + size.x + GAP;
            Self { view, rect, per_m, origin: rect.left_bottom() + vec2(-low.x, low.y) * per_m }
        })
    }

    /// Screen position of a place.
    pub fn screen(&self, p: Vec3) -> Pos2 {
        self.screen_of(self.view.flat(p))
    }

    /// Screen position of a place in the plane that is seen (m).
    pub fn screen_of(&self, flat: Vec2) -> Pos2 {
        self.origin + vec2(flat.x, -flat.y) * self.per_m
    }

    /// Place in the plane that is seen (m).
    pub fn flat_at(&self, p: Pos2) -> Vec2 {
        let d = (p - self.origin) / self.per_m;
        Vec2::new(d.x, -d.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_is_seen_in_all_views_and_goes_back_to_itself() {
        let places = [Vec3::new(0.9, 1.6, 0.8), Vec3::new(-0.2, 2.1, 1.4), Vec3::new(0.0, 0.3, -0.6)];
        let bounds = HitBounds::around(places.into_iter());
        for rect in [
            Rect::from_min_size(pos2(10.0, 20.0), vec2(900.0, 260.0)),
            Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 500.0)),
        ] {
            let views = HitViewPlace::lay_out(bounds, rect);
            for view in views {
                assert!(rect.contains_rect(view.rect), "{view:?}");
                for p in places {
                    let at = view.screen(p);
                    assert!(view.rect.contains(at), "{view:?} {p}");
                    assert!((view.flat_at(at) - view.view.flat(p)).length() < 1e-4);
                }
            }
            assert!(views.windows(2).all(|v| v[0].rect.right() < v[1].rect.left() && v[0].per_m == v[1].per_m));
        }
    }

    #[test]
    fn sides_are_where_their_words_say() {
        let left = Vec3::X;
        assert!(HitViewpoint::Front.flat(left).x > 0.0 && HitViewpoint::Front.ends()[1] == "left");
        assert!(HitViewpoint::Top.flat(left).x < 0.0 && HitViewpoint::Top.ends()[0] == "left");
        assert!(HitViewpoint::Side.flat(Vec3::Z).x > 0.0 && HitViewpoint::Side.ends()[1] == "ahead");
        assert_eq!(HitViewpoint::Top.across(HitViewpoint::Top.flat(left).x), 1.0);
    }
}
