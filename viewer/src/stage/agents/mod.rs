//! A scene of a crowd: discs on the ground or balls in the air, what stands in their way, and what happens.

mod bodies;
mod marks;
pub(super) mod obstacles;
mod selected;

pub use bodies::of_body;
pub use marks::colour_of as colour_of_event;
pub use selected::{TAKEN, colour_of_force};

use super::{Layout, Palette, cues};
use crate::command::Whose;
use crate::document::CrowdDocument;
use crate::model::Model;
use crate::render::{Camera, Ray, Rgba, Shapes};
use crate::run::agents::{Cast, SeenAgent};
use crate::settings::Colouring;
use glam::{Vec2, Vec3};

/// Most agents whose trails and paths are drawn.
const MAX_LINES: usize = 1500;
/// Length of trails (s).
const TRAIL_S: f32 = 6.0;
/// What lies on the ground lies so much above it, one on the other (m).
const WAY_Y: f32 = 0.004;
const TRAIL_Y: f32 = 0.006;
const DISC_Y: f32 = 0.01;
const EDGE_Y: f32 = 0.013;
const BOUND_Y: f32 = 0.018;
/// How much of a disc is seen below a body.
const BELOW_BODIES: f32 = 0.35;
/// Height of the view that widths of lines on the ground are reckoned for (pixels).
const VIEW_HEIGHT: f32 = 700.0;
/// Slower ones show no heading (m/s).
const SLOW_MPS: f32 = 0.05;
/// A click selects an agent that it misses by so much (pixels).
const MISSED_PX: f32 = 8.0;

/// What every part draws with.
struct Brush<'a> {
    cast: &'a Cast,
    palette: &'a Palette,
    dark: bool,
    /// Length that looks as long as a pixel near what the camera looks at (m).
    pixel_m: f32,
}

impl Brush<'_> {
    /// A circle on the ground, a ball that can be seen through in the air.
    fn round(&self, shapes: &mut Shapes, at: Vec3, radius: f32, (width_px, colour): (f32, Rgba)) {
        if self.cast.in_the_air {
            shapes.sphere(at, radius, colour.alpha(0.16 * f32::from(colour.0[3]) / 255.0));
        } else {
            let width = (width_px * self.pixel_m).min(radius);
            shapes.ring(at.with_y(BOUND_Y), radius - width, radius, colour);
        }
    }

    /// Ink that stands out from what agents are filled with.
    fn ink(&self) -> Rgba {
        if self.dark { Rgba::hex(0x0f1216) } else { Rgba::hex(0xffffff) }
    }
}

pub(super) fn lay_out(out: &mut Layout, model: &Model, crowd: &CrowdDocument, palette: &Palette, dark: bool) {
    let (run, look) = (crowd.run(), &model.selection.crowd);
    let pixel_m = model.settings.camera.pixels_per_metre(model.settings.camera.distance, VIEW_HEIGHT).recip();
    let brush = Brush { cast: run.cast(), palette, dark, pixel_m };
    obstacles::lay_out(out, crowd, run.moment().time_s, &brush);
    let moment = run.moment();
    let n = moment.agents.len();
    let selected = model.selection.character.filter(|&m| m < n);
    let of = |whose: Whose| match whose {
        Whose::Nobody => (0, None),
        Whose::Selected => (0, selected),
        Whose::All => (n.min(MAX_LINES), selected),
    };
    let each = |(count, more): (usize, Option<usize>)| (0..count).chain(more.filter(move |&m| m >= count));
    for m in each(of(look.paths)) {
        way(out, &run.way(m), colour_of_group(brush.cast.groups[m]), selected == Some(m));
    }
    let o = model.settings.overlays;
    let trails = if o.trails { (if o.of_all { n.min(MAX_LINES) } else { 0 }, selected) } else { (0, None) };
    for m in each(trails) {
        let lift = if brush.cast.in_the_air { Vec3::ZERO } else { Vec3::Y * TRAIL_Y };
        let points: Vec<Vec3> = run.trail(m, TRAIL_S).map(|p| p + lift).collect();
        cues::trail(
            &mut out.shapes,
            &points,
            2.0,
            if selected == Some(m) { palette.selected } else { palette.middle.alpha(0.5) },
        );
    }
    let bodies = moment.bodies.as_ref().filter(|_| look.bodies);
    if let Some(bodies) = bodies {
        let colour = |m: usize| moment.agents[m].map_or(palette.plain, |seen| colour(model, &brush, m, &seen));
        bodies::lay_out(out, model, (crowd, bodies), &brush, colour);
    }
    for (m, seen) in moment.agents.iter().enumerate() {
        let Some(seen) = seen else { continue };
        let colour = colour(model, &brush, m, seen);
        let colour = if bodies.is_some() { colour.alpha(BELOW_BODIES) } else { colour };
        agent(&mut out.shapes, &brush, (m, seen), colour, selected == Some(m));
        if look.bounds == Whose::All && selected != Some(m) {
            brush.round(&mut out.shapes, seen.bound, seen.bound_radius, (1.2, palette.middle.alpha(0.4)));
        }
    }
    if look.marks {
        marks::lay_out(&mut out.shapes, run, look, &brush);
    }
    if let Some(m) = selected {
        selected::lay_out(&mut out.shapes, run, look, m, &brush);
    }
}

/// The colour of a group.
pub fn colour_of_group(group: usize) -> Rgba {
    cues::category(group)
}

/// By the group, or the speed.
fn colour(model: &Model, brush: &Brush<'_>, m: usize, seen: &SeenAgent) -> Rgba {
    match model.settings.colouring {
        Colouring::Plain => brush.palette.plain,
        Colouring::Speed => {
            let share = seen.velocity.length() / brush.cast.speeds[m].max(1e-3);
            brush.palette.slow.mix(brush.palette.fast, share.min(1.0))
        }
        Colouring::Target | Colouring::Clip => colour_of_group(brush.cast.groups[m]),
    }
}

/// A disc with the way it moves, or a ball.
fn agent(shapes: &mut Shapes, brush: &Brush<'_>, (m, seen): (usize, &SeenAgent), colour: Rgba, is_selected: bool) {
    let (radius, speed) = (brush.cast.radii[m], seen.velocity.length());
    let ahead = seen.velocity * (radius / speed.max(1e-6));
    if brush.cast.in_the_air {
        shapes.sphere(seen.at, radius, colour);
        if speed > SLOW_MPS {
            shapes.line(seen.at + ahead, seen.at + ahead * 2.0, 2.0, colour);
        }
        if is_selected {
            let here = shapes.on_top(true);
            here.circle(seen.at, 1.25 * radius, 2.5, brush.palette.selected);
            shapes.on_top(false);
        }
        return;
    }
    shapes.disc(seen.at.with_y(DISC_Y), radius, colour);
    if seen.knows {
        shapes.disc(seen.at.with_y(EDGE_Y), 0.35 * radius, brush.palette.target);
    }
    if is_selected {
        let width = (3.0 * brush.pixel_m).max(0.12 * radius);
        shapes.ring(seen.at.with_y(BOUND_Y), radius, radius + width, brush.palette.selected);
    }
    // From afar it would only hide the colour.
    if speed > SLOW_MPS && radius > 3.0 * brush.pixel_m {
        let at = seen.at.with_y(EDGE_Y);
        shapes.line(at, at + ahead * 0.95, 2.0, brush.ink());
    }
}

/// Corners of a way, and the goal.
fn way(out: &mut Layout, corners: &[Vec3], colour: Rgba, is_selected: bool) {
    let lift = Vec3::Y * WAY_Y;
    let points: Vec<Vec3> = corners.iter().map(|&p| p + lift).collect();
    let (width, strength) = if is_selected { (2.5, 0.9) } else { (1.0, 0.3) };
    out.shapes.polyline(&points, width, colour.alpha(strength));
    if let Some(&goal) = points.last() {
        out.shapes.disc(goal, if is_selected { 0.2 } else { 0.08 }, colour.alpha(strength));
    }
}

/// The agent that a ray meets, or nearly so.
pub fn pick(crowd: &CrowdDocument, camera: &Camera, ray: &Ray, view: Vec2) -> Option<usize> {
    let run = crowd.run();
    let missed = |(m, seen): (usize, &Option<SeenAgent>)| {
        let seen = seen.as_ref()?;
        let (radius, to) = (run.cast().radii[m], seen.at - ray.origin);
        let along = to.dot(ray.direction);
        let from = match run.cast().in_the_air {
            true => ray.at(along).distance(seen.at),
            false => ray.meets_ground()?.distance(seen.at.with_y(0.0)),
        };
        let slack = MISSED_PX / camera.pixels_per_metre(along, view.y);
        (along > 0.0 && from < radius + slack).then_some((m, (from - radius).max(0.0) / slack, along))
    };
    // The nearest to the eye of those hit; without a hit, the one missed least.
    let all = run.moment().agents.iter().enumerate().filter_map(missed);
    all.min_by(|a, b| a.1.total_cmp(&b.1).then(a.2.total_cmp(&b.2))).map(|f| f.0)
}

#[cfg(test)]
mod tests;
