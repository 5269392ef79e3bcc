//! The volume of a behaviour from three sides: its active region, and the cells of its grid.

use super::view::{HitViewPlace, HitViewpoint};
use crate::volume::Volume;
use eframe::egui::{Color32, Painter, Pos2, Rangef, Shape, Stroke, pos2};
use glam::{Vec2, Vec3};
use throng_core::policy::PolicyTable;

/// Paints the outline of a volume as a view sees it.
pub fn paint(painter: &Painter, place: &HitViewPlace, volume: &Volume, colour: Color32) {
    let mut points: Vec<Pos2> = volume.over_ground().iter().map(|p| ground_point(place, *p)).collect();
    if place.view != HitViewpoint::Top {
        // A view from a side is as wide as the outline over ground and as high as the heights.
        let x = width_over_ground(place, volume);
        let [bottom, top] = volume.height.map(|height| place.screen(Vec3::Y * height).y);
        points = vec![pos2(x.min, bottom), pos2(x.max, bottom), pos2(x.max, top), pos2(x.min, top)];
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
            painter.add(Shape::line(line.iter().map(|p| ground_point(place, *p)).collect(), stroke));
        }
        return;
    }
    let across = width_over_ground(place, &volume);
    for i in 0..r.num_heights {
        let y = place.screen(Vec3::Y * (r.height_start + i as f32 * r.height_spacing)).y;
        painter.hline(across, y, stroke);
    }
}

fn ground_point(place: &HitViewPlace, ground: Vec2) -> Pos2 {
    place.screen(Vec3::new(ground.x, 0.0, ground.y))
}

/// Range on the screen, from left to right, that a volume takes over ground (points).
fn width_over_ground(place: &HitViewPlace, volume: &Volume) -> Rangef {
    let across = volume.over_ground().into_iter().map(|p| ground_point(place, p).x);
    across.fold(Rangef::NOTHING, |range, x| Rangef::new(range.min.min(x), range.max.max(x)))
}
