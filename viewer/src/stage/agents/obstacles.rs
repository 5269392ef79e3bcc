//! Static and moving obstacles of a crowd.

use super::Brush;
use crate::document::SceneSurroundings;
use crate::render::{Rgba, ShapeList};
use crate::stage::cues;
use glam::Vec3;
use throng_crowd::Obstacle;
use throng_geometry::BoundingBox;
use throng_precompute::run::position_on_timed_path;

/// Draws outlines of boxes in the air, and moving obstacles; all others have meshes.
pub(in crate::stage) fn lay_out(shapes: &mut ShapeList, standing: &SceneSurroundings, time_s: f64, brush: &Brush<'_>) {
    for obstacle in &standing.obstacles {
        match obstacle {
            Obstacle::Box { min, max } if brush.in_the_air => {
                let edges = cues::box_edges(BoundingBox { min: *min, max: *max }.corners());
                edges.for_each(|[a, b]| shapes.line(a, b, 1.0, grey(brush.dark).alpha(0.7)));
            }
            Obstacle::Mover { path, radius } => mover(shapes, brush, path, *radius, time_s),
            _ => {}
        }
    }
}

/// Colour of static obstacles.
pub(in crate::stage) fn grey(dark: bool) -> Rgba {
    Rgba::hex(if dark { 0x77808d } else { 0x9aa1ab })
}

/// A moving obstacle, at its present position and with its path.
fn mover(shapes: &mut ShapeList, brush: &Brush<'_>, path: &[(f64, Vec3)], radius: f32, time_s: f64) {
    let at = position_on_timed_path(path, time_s);
    let lift = Vec3::Y * if brush.in_the_air { 0.0 } else { super::DISC_Y };
    let points: Vec<Vec3> = path.iter().map(|w| w.1 + lift).collect();
    shapes.polyline(&points, 1.5, brush.palette.target.alpha(0.5));
    if brush.in_the_air {
        shapes.sphere(at, radius, brush.palette.target);
    } else {
        shapes.disc(at + lift, radius, brush.palette.target);
    }
}
