//! Blackboards of cells as a map on the floor: cells with entries on their blackboards are tinted.

use super::Brush;
use crate::command::{BlackboardCell, BlackboardFilter, SceneViewOptions};
use crate::render::{Rgba, ShapeList};
use glam::{Vec2, Vec3};
use throng_simulation::Simulation;
use throng_simulation::scenario::{AgentBrains, BlackboardPost};

/// Height of cells above the ground, the smallest the highest (m).
const CELL_Y: f32 = 0.001;
/// Strength of the tint for one entry, and the largest one.
const TINT: f32 = 0.16;
const MOST_TINT: f32 = 0.5;
/// Most cells that are drawn.
const MAX_CELLS: usize = 2000;

/// Entries on the blackboards of cells, of the selected levels.
pub fn posted<'a>(
    brains: &'a AgentBrains,
    options: &SceneViewOptions,
) -> impl Iterator<Item = (BlackboardCell, BlackboardPost)> + 'a {
    let blackboards = options.blackboards;
    let of_cells = brains.posts().filter_map(|p| Some((BlackboardCell::from_cell(&p.cell?), p)));
    of_cells.filter(move |(cell, _)| match blackboards {
        BlackboardFilter::Nothing => false,
        BlackboardFilter::All => true,
        BlackboardFilter::Level(level) => cell.level == level,
    })
}

/// The smallest cell with an entry at a place on the ground.
pub fn cell_at(brains: &AgentBrains, options: &SceneViewOptions, at: Vec3) -> Option<BlackboardCell> {
    let is_in = |p: &BlackboardPost| {
        p.cell.is_some_and(|c| (Vec2::from(c.middle) - Vec2::new(at.x, at.z)).abs().max_element() * 2.0 <= c.side_m)
    };
    posted(brains, options).filter(|(_, p)| is_in(p)).map(|(cell, _)| cell).min_by_key(|c| c.level)
}

/// The colour of a message.
pub fn colour_of_message(event: usize) -> Rgba {
    // Groups use the first colours; messages on the floor start at others.
    super::super::cues::category(event + 4)
}

pub(in crate::stage) fn lay_out(shapes: &mut ShapeList, simulation: &Simulation, brush: &Brush<'_>) {
    let Some(brains) = simulation.brains().filter(|_| !brush.in_the_air) else { return };
    let mut all: Vec<(BlackboardCell, BlackboardPost)> = posted(brains, &brush.options).take(MAX_CELLS).collect();
    // From large to small, so that the small ones lie on the large ones.
    all.sort_by_key(|(cell, p)| (std::cmp::Reverse(cell.level), cell.at, p.event));
    for same in all.chunk_by(|a, b| a.0 == b.0) {
        let (cell, Some(c)) = (same[0].0, same[0].1.cell) else { continue };
        let y = CELL_Y * (1.0 + 1.0 / (1.0 + cell.level as f32));
        let (at, half) = (Vec3::new(c.middle[0], y, c.middle[1]), 0.5 * c.side_m);
        let colours = same.iter().map(|(_, p)| colour_of_message(p.event));
        let Some(colour) = colours.reduce(|sum, own| sum.mix(own, 0.5)) else { continue };
        shapes.square(at, half, colour.alpha((TINT * same.len() as f32).min(MOST_TINT)));
        let is_selected = brush.options.cell == Some(cell);
        let (line, width) = if is_selected { (brush.palette.selected, 2.5) } else { (colour.alpha(0.8), 1.0) };
        let corner = |x: f32, z: f32| at + Vec3::new(x, 0.0, z) * (half - 0.5 * brush.pixel_m);
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0)];
        shapes.polyline(&corners, width, line);
    }
}
