//! Messages of agents: who knows of the one that is looked at, and cells of blackboards.

use super::Brush;
use crate::command::{BlackboardCell, BlackboardFilter, SceneViewOptions};
use crate::render::{Rgba, ShapeList};
use crate::run::agents::first_agent;
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

/// Height of lines above the ground (m).
const LINE_Y: f32 = 0.03;
/// Time within which a line from a sender fades (s).
const FADE_S: f64 = 8.0;
/// Strength after fading.
const FADED: f32 = 0.25;
/// Most lines that are drawn.
const MAX_LINES: usize = 1500;

/// The colour of an agent: whether it knows of a message (agent < number of agents).
pub(in crate::stage) fn colour_by_message(brains: &AgentBrains, agent: usize, event: usize, brush: &Brush<'_>) -> Rgba {
    match (brains.learnt_event(agent, event), brush.dark) {
        (Some(_), _) => super::colour_of_message(event),
        (None, true) => Rgba::hex(0x59616c),
        (None, false) => Rgba::hex(0xb4bac2),
    }
}

/// Draws lines from senders to receivers, and from the selected agent back to the origin of the message.
pub fn lay_out_spread(shapes: &mut ShapeList, simulation: &Simulation, selected: Option<usize>, brush: &Brush<'_>) {
    let (Some(event), Some(first)) = (brush.options.message, first_agent(simulation)) else { return };
    let Some(brains) = simulation.brains() else { return };
    let place = |agent: usize| {
        let lift = if brush.in_the_air { Vec3::ZERO } else { Vec3::Y * LINE_Y };
        simulation.disc(first + agent).map(|d| d.centre + lift)
    };
    let heard_from = |agent: usize| {
        let learnt = brains.learnt_event(agent, event)?;
        Some((learnt.source_agent()?, learnt.time_s))
    };
    let colour = super::colour_of_message(event);
    let all = (0..brains.len()).filter_map(|agent| {
        let (from, time_s) = heard_from(agent)?;
        Some((place(from)?, place(agent)?, time_s))
    });
    for (from, to, time_s) in all.take(MAX_LINES) {
        let age = ((simulation.time_s() - time_s) / FADE_S).clamp(0.0, 1.0) as f32;
        shapes.line(from, to, 1.5, colour.alpha(0.9 + (FADED - 0.9) * age));
    }
    let Some(selected) = selected.and_then(|who| who.checked_sub(first)).filter(|a| *a < brains.len()) else { return };
    for pair in sources(selected, heard_from).windows(2) {
        if let (Some(to), Some(from)) = (place(pair[0]), place(pair[1])) {
            shapes.line(from, to, 3.5, brush.palette.selected);
        }
    }
}

/// An agent, its sender, the sender of that one, and so on.
///
/// - `heard_from`: who passed the message on to an agent, and when (s).
fn sources(agent: usize, heard_from: impl Fn(usize) -> Option<(usize, f64)>) -> Vec<usize> {
    let (mut all, mut until_s) = (vec![agent], f64::INFINITY);
    // A sender may learn the message again later, from another agent.
    while let Some((from, time_s)) = heard_from(all[all.len() - 1]).filter(|t| t.1 <= until_s && !all.contains(&t.0)) {
        all.push(from);
        until_s = time_s;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_end_where_a_message_came_from() {
        let heard_from = [None, Some((0, 1.0)), Some((1, 2.0)), Some((4, 5.0)), Some((3, 3.0))];
        assert_eq!(sources(2, |a| heard_from[a]), [2, 1, 0]);
        assert_eq!(sources(4, |a| heard_from[a]), [4, 3], "3 felt it of itself then, and learnt of it from 4 later");
        assert_eq!(sources(3, |a| heard_from[a]), [3, 4]);
    }
}
