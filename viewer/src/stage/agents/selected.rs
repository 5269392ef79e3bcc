//! The selected agent: its bound, cells, stop region and forces.

use super::{BOUND_Y, Brush};
use crate::render::{Rgba, ShapeList};
use crate::run::agents::{AgentDetails, FORCE_TERMS, agent_bound, agent_details};
use crate::{command::OverlayScope, stage::cues};
use glam::Vec3;
use throng_geometry::BoundingBox;
use throng_simulation::Simulation;

/// Length of the arrow of the largest acceleration (radii).
const ARROW_RADII: f32 = 5.0;
/// Smaller forces have no arrow, as shares of the largest acceleration.
const LEAST_SHARE: f32 = 0.01;

/// Colour of the acceleration that was applied: on dark, on light.
pub const TAKEN: [u32; 2] = [0xffffff, 0x14171c];

/// Colour of a term of the force field, in the view and in the panel (term < 6).
pub fn colour_of_force(term: usize, dark: bool) -> Rgba {
    Rgba::hex(FORCE_TERMS[term].2[usize::from(!dark)])
}

pub(super) fn lay_out(shapes: &mut ShapeList, simulation: &Simulation, who: usize, brush: &Brush<'_>) {
    let Some((at, radius)) = agent_bound(simulation, who) else { return };
    let Some(details) = agent_details(simulation, who) else { return };
    let Some(disc) = simulation.disc(who) else { return };
    let options = &brush.options;
    if options.bounds != OverlayScope::None {
        brush.round(shapes, at, radius, (2.5, brush.palette.selected));
    }
    if options.cells && brush.has_regions {
        cells(shapes, &details, brush);
    }
    if options.forces {
        stop_region(shapes, &details, brush);
        forces(shapes, &details, disc.centre, brush);
    }
}

/// Cell C, region R about its centre, and the cells alpha(C) that are looked at.
fn cells(shapes: &mut ShapeList, d: &AgentDetails, brush: &Brush<'_>) {
    let (low, side) = (d.cell, d.cell_side);
    let squares = [(1.0, 1.0, 0.3), (0.5, 1.8, 0.6), (0.0, 2.5, 1.0)];
    for (beyond, width, strength) in squares {
        let from = low - Vec3::splat(beyond * side);
        let to = low + Vec3::splat((1.0 + beyond) * side);
        // Boxes in the air lie over much of the view.
        let strength = if brush.in_the_air { 0.6 * strength } else { strength };
        frame(shapes, from, to, (width, brush.palette.slow.alpha(strength)), brush);
    }
    for i in 1..3 {
        let from = low - Vec3::splat(side);
        let at = i as f32 * side;
        let (colour, y) = (brush.palette.slow.alpha(0.3), if brush.in_the_air { low.y } else { BOUND_Y });
        for (a, b) in [(Vec3::X, Vec3::Z), (Vec3::Z, Vec3::X)] {
            let start = (from + a * at).with_y(y);
            shapes.line(start, start + b * (3.0 * side), 1.0, colour);
        }
    }
}

/// A square on the ground, the edges of a box in the air.
fn frame(shapes: &mut ShapeList, from: Vec3, to: Vec3, (width, colour): (f32, Rgba), brush: &Brush<'_>) {
    let place = |p: Vec3| if brush.in_the_air { p } else { p.with_y(BOUND_Y) };
    let edges = cues::box_edges(BoundingBox { min: from, max: to }.corners());
    for [a, b] in edges.filter(|edge| brush.in_the_air || edge.iter().all(|p| p.y == from.y)) {
        shapes.line(place(a), place(b), width, colour);
    }
}

/// Path under full braking, and its width.
fn stop_region(shapes: &mut ShapeList, d: &AgentDetails, brush: &Brush<'_>) {
    let [from, to] = d.stop;
    let lift = Vec3::Y * if brush.in_the_air { 0.0 } else { BOUND_Y };
    let ahead = (to - from).normalize_or_zero();
    let side = ahead.cross(Vec3::Y) * d.radius;
    for side in [side, -side] {
        shapes.line(from + side + lift, to + side + lift, 1.5, brush.palette.target);
    }
    let radius = d.radius;
    if brush.in_the_air {
        shapes.circle(to, radius, 1.5, brush.palette.target);
    } else {
        shapes.ring(to + lift, radius - 1.5 * brush.pixel_m, radius, brush.palette.target);
    }
}

/// Draws an arrow for each term, and for the applied acceleration.
fn forces(shapes: &mut ShapeList, d: &AgentDetails, at: Vec3, brush: &Brush<'_>) {
    let radius = d.radius;
    let scale = ARROW_RADII * radius / d.limit.max(1e-6);
    let base = at + Vec3::Y * if brush.in_the_air { 0.0 } else { 0.05 };
    let thin = (1.6 * brush.pixel_m).clamp(0.03 * radius, 0.2 * radius);
    shapes.on_top(true);
    let taken = Rgba::hex(TAKEN[usize::from(!brush.dark)]);
    let terms = d.forces.iter().enumerate().map(|(i, f)| (*f, thin, colour_of_force(i, brush.dark)));
    for (force, thick, colour) in std::iter::once((d.taken, 1.7 * thin, taken.alpha(0.85))).chain(terms) {
        if force.length() > LEAST_SHARE * d.limit {
            // A term may exceed the largest acceleration; its arrow is cut before it leaves the view.
            shapes.arrow(base, base + (force * scale).clamp_length_max(3.0 * ARROW_RADII * radius), thick, colour);
        }
    }
    shapes.on_top(false);
}
