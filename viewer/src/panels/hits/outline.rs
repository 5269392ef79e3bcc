//! The volume of a behaviour from three sides: its active region, and the cells of its grid.

use super::view::{HitViewPlace, HitViewpoint};
use crate::volume::Volume;
use eframe::egui::{Color32, Painter, Pos2, Shape, Stroke};
use glam::{Vec2, Vec3};
use throng_core::policy::PolicyTable;

/// Paints the outline of a volume as a view sees it.
pub fn paint(painter: &Painter, place: &HitViewPlace, volume: &Volume, colour: Color32) {
    let mut points: Vec<Pos2> = volume.over_ground().iter().map(|p| ground_point(place, *p, 0.0)).collect();
    if place.view != HitViewpoint::Top {
        // A view from a side is as wide as the outline over ground and as high as the heights.
        let [low, high] = volume
            .over_ground()
            .iter()
            .map(|p| place.view.flat(Vec3::new(p.x, 0.0, p.y)).x)
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
        let [bottom, top] = volume.height;
        let corners = [(low, bottom), (high, bottom), (high, top), (low, top)];
        points = corners.map(|(x, y)| place.screen_of(Vec2::new(x, y))).to_vec();
    }
    points.extend(points.first().copied());
    painter.extend(Shape::dashed_line(&points, Stroke::new(1.6, colour), 6.0, 3.5));
}

/// Paints the cells of a grid as a view sees them: rings and rays from above, heights from the sides.
pub fn paint_cells(painter: &Painter, place: &HitViewPlace, policy: &PolicyTable, colour: Color32) {
    let (volume, r) = (Volume::of_grid(policy), policy.grid().record());
    let stroke = Stroke::new(0.7, colour);
    if place.view == HitViewpoint::Top {
        for line in volume.lines_over_ground([r.num_angles, r.num_rings]) {
            painter.add(Shape::line(line.iter().map(|p| ground_point(place, *p, 0.0)).collect(), stroke));
        }
        return;
    }
    let across = volume.over_ground().iter().map(|p| ground_point(place, *p, 0.0).x).collect::<Vec<_>>();
    let (low, high) = across.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    for i in 0..r.num_heights {
        let y = place.screen(Vec3::Y * (r.height_start + i as f32 * r.height_spacing)).y;
        painter.hline(low..=high, y, stroke);
    }
}

fn ground_point(place: &HitViewPlace, ground: Vec2, height: f32) -> Pos2 {
    place.screen(Vec3::new(ground.x, height, ground.y))
}
