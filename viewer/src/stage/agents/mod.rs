//! Agents of a scene: discs on the ground or balls in the air, their routes and bounds, and what happens to them.

mod blackboards;
mod marks;
mod selected;

pub(super) use blackboards::colour_by_message;
pub(super) use blackboards::lay_out as lay_out_blackboards;
pub use blackboards::{cell_at, colour_of_message};
pub use marks::colour_of as colour_of_event;
pub use selected::{TAKEN, colour_of_force};

use super::{StageLayout, StagePalette, cues};
use crate::command::{OverlayScope, SceneViewOptions};
use crate::document::{SceneDocument, SceneSurroundings};
use crate::render::{Rgba, ShapeList};
use crate::run::agents::{agent_bound, agent_path};
use crate::{model::Model, run::SceneRun};
use glam::Vec3;
use throng_base::thresholds::DIRECTION_SHOWN_MPS;
use throng_crowd::{Obstacle, Scheme};
use throng_geometry::BoundingBox;
use throng_precompute::run::position_on_timed_path;
use throng_simulation::agents::Disc;

/// Most agents whose routes are drawn.
const MAX_LINES: usize = 1500;
/// Heights of flat shapes above the ground, one over the other (m).
const ROUTE_Y: f32 = 0.004;
const DISC_Y: f32 = 0.01;
const EDGE_Y: f32 = 0.013;
const BOUND_Y: f32 = 0.018;
/// Height of the view that widths of lines on the ground are reckoned for (pixels).
const VIEW_HEIGHT: f32 = 700.0;

/// Drawing context shared by all parts.
pub(super) struct Brush<'a> {
    pub palette: &'a StagePalette,
    pub options: SceneViewOptions,
    /// Selected character.
    pub selected: Option<usize>,
    pub dark: bool,
    in_the_air: bool,
    has_regions: bool,
    /// Length that covers one pixel at the camera's target (m).
    pixel_m: f32,
}

impl<'a> Brush<'a> {
    pub fn new(model: &Model, scene: &SceneDocument, palette: &'a StagePalette, dark: bool) -> Self {
        let pixel_m = model.settings.camera.pixels_per_metre(model.settings.camera.distance, VIEW_HEIGHT).recip();
        let (in_the_air, has_regions) = (scene.surroundings.in_the_air, scene.choice.engine == Scheme::default());
        let (options, selected) = (model.selection.scene, model.selection.character);
        Self { palette, options, selected, dark, in_the_air, has_regions, pixel_m }
    }

    /// A circle on the ground, a ball that can be seen through in the air.
    fn round(&self, shapes: &mut ShapeList, at: Vec3, radius: f32, (width_px, colour): (f32, Rgba)) {
        if self.in_the_air {
            shapes.sphere(at, radius, colour.alpha(0.16 * f32::from(colour.0[3]) / 255.0));
        } else {
            let width = (width_px * self.pixel_m).min(radius);
            shapes.ring(at.with_y(BOUND_Y), radius - width, radius, colour);
        }
    }

    /// Line colour that stands out from the fill colour of agents.
    fn ink(&self) -> Rgba {
        if self.dark { Rgba::hex(0x0f1216) } else { Rgba::hex(0xffffff) }
    }
}

/// Routes, bounds and marks of agents, and details of the selected one.
pub(super) fn lay_out(out: &mut StageLayout, run: &SceneRun, brush: &Brush<'_>) {
    let (simulation, options) = (run.simulation(), &brush.options);
    let selected = brush.selected.filter(|&who| simulation.disc(who).is_some());
    let is_drawn = |scope: OverlayScope, who: usize, count: usize| match scope {
        OverlayScope::None => false,
        OverlayScope::Selected => selected == Some(who),
        OverlayScope::All => selected == Some(who) || count < MAX_LINES,
    };
    blackboards::lay_out_spread(&mut out.shapes, simulation, selected, brush);
    let mut count = 0;
    for (g, group) in simulation.groups().iter().enumerate() {
        for who in group.characters.clone().filter(|&who| simulation.disc(who).is_some()) {
            if is_drawn(options.paths, who, count) {
                route(out, &agent_path(simulation, who), colour_of_group(g), selected == Some(who));
            }
            if options.bounds == OverlayScope::All
                && selected != Some(who)
                && let Some((at, radius)) = agent_bound(simulation, who)
            {
                brush.round(&mut out.shapes, at, radius, (1.2, brush.palette.middle.alpha(0.4)));
            }
            count += 1;
        }
    }
    if options.marks {
        marks::lay_out(&mut out.shapes, run, brush);
    }
    if let Some(who) = selected {
        selected::lay_out(&mut out.shapes, simulation, who, brush);
    }
}

/// The colour of a group.
pub fn colour_of_group(group: usize) -> Rgba {
    cues::category(group)
}

/// A disc with its direction of motion, or a ball.
pub(super) fn disc(shapes: &mut ShapeList, brush: &Brush<'_>, disc: &Disc, colour: Rgba, is_selected: bool) {
    let (radius, speed) = (disc.radius, disc.velocity.length());
    let ahead = disc.velocity * (radius / speed.max(1e-6));
    if brush.in_the_air {
        shapes.sphere(disc.centre, radius, colour);
        if speed > DIRECTION_SHOWN_MPS {
            shapes.line(disc.centre + ahead, disc.centre + ahead * 2.0, 2.0, colour);
        }
        if is_selected {
            let here = shapes.on_top(true);
            here.circle(disc.centre, 1.25 * radius, 2.5, brush.palette.selected);
            shapes.on_top(false);
        }
        return;
    }
    shapes.disc(disc.centre.with_y(DISC_Y), radius, colour);
    if disc.knows {
        shapes.disc(disc.centre.with_y(EDGE_Y), 0.35 * radius, brush.palette.target);
    }
    if is_selected {
        let width = (3.0 * brush.pixel_m).max(0.12 * radius);
        shapes.ring(disc.centre.with_y(BOUND_Y), radius, radius + width, brush.palette.selected);
    }
    // From afar it would only hide the colour.
    if speed > DIRECTION_SHOWN_MPS && radius > 3.0 * brush.pixel_m {
        let at = disc.centre.with_y(EDGE_Y);
        shapes.line(at, at + ahead * 0.95, 2.0, brush.ink());
    }
}

/// Corners of a route, and the goal.
fn route(out: &mut StageLayout, corners: &[Vec3], colour: Rgba, is_selected: bool) {
    let lift = Vec3::Y * ROUTE_Y;
    let points: Vec<Vec3> = corners.iter().map(|&p| p + lift).collect();
    let (width, strength) = if is_selected { (2.5, 0.9) } else { (1.0, 0.3) };
    out.shapes.polyline(&points, width, colour.alpha(strength));
    if let Some(&goal) = points.last() {
        out.shapes.disc(goal, if is_selected { 0.2 } else { 0.08 }, colour.alpha(strength));
    }
}

/// Draws outlines of boxes in the air, and moving obstacles; all others have meshes.
pub(super) fn lay_out_obstacles(shapes: &mut ShapeList, standing: &SceneSurroundings, time_s: f64, brush: &Brush<'_>) {
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
pub(super) fn grey(dark: bool) -> Rgba {
    Rgba::hex(if dark { 0x77808d } else { 0x9aa1ab })
}

/// A moving obstacle, at its present position and with its path.
fn mover(shapes: &mut ShapeList, brush: &Brush<'_>, path: &[(f64, Vec3)], radius: f32, time_s: f64) {
    let at = position_on_timed_path(path, time_s);
    let lift = Vec3::Y * if brush.in_the_air { 0.0 } else { DISC_Y };
    let points: Vec<Vec3> = path.iter().map(|w| w.1 + lift).collect();
    shapes.polyline(&points, 1.5, brush.palette.target.alpha(0.5));
    if brush.in_the_air {
        shapes.sphere(at, radius, brush.palette.target);
    } else {
        shapes.disc(at + lift, radius, brush.palette.target);
    }
}

#[cfg(test)]
mod tests;
