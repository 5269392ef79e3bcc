//! Static and moving obstacles of a crowd.

use super::Brush;
use crate::document::SceneSurroundings;
use crate::render::{Rgba, ShapeList};
use glam::Vec3;
use throng_crowd::Obstacle;
use throng_precompute::run::position_on_timed_path;

/// Draws outlines of boxes in the air, and moving obstacles; all others have meshes.
pub(in crate::stage) fn lay_out(shapes: &mut ShapeList, standing: &SceneSurroundings, time_s: f64, brush: &Brush<'_>) {
    for obstacle in &standing.obstacles {
        match obstacle {
            Obstacle::Box { min: low, max: high } if brush.in_the_air => edges(shapes, *low, *high, grey(brush.dark)),
            Obstacle::Mover { path, radius } => mover(shapes, brush, path, *radius, time_s),
            _ => {}
        }
    }
}

/// Colour of static obstacles.
pub(in crate::stage) fn grey(dark: bool) -> Rgba {
    Rgba::hex(if dark { 0x77808d } else { 0x9aa1ab })
}

fn edges(shapes: &mut ShapeList, low: Vec3, high: Vec3, colour: Rgba) {
    let corner = |i: usize| {
        let pick = |axis: usize, bit: usize| if i & bit == 0 { low[axis] } else { high[axis] };
        Vec3::new(pick(0, 1), pick(1, 2), pick(2, 4))
    };
    for i in 0..8usize {
        for bit in [1, 2, 4].into_iter().filter(|bit| i & bit == 0) {
            shapes.line(corner(i), corner(i | bit), 1.0, colour.alpha(0.7));
        }
    }
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
