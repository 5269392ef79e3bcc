//! The spread of a message: which agents know it, and from whom.

use super::Brush;
use crate::render::{Rgba, ShapeList};
use crate::run::agents::first_agent;
use glam::Vec3;
use throng_simulation::Simulation;
use throng_simulation::scenario::AgentBrains;

/// Height of lines above the ground (m).
const LINE_Y: f32 = 0.03;
/// Time within which a line from a sender fades (s).
const FADE_S: f64 = 8.0;
/// Strength after fading.
const FADED: f32 = 0.25;
/// Most lines that are drawn.
const MAX_LINES: usize = 1500;

/// The colour of an agent: whether it knows of a message (agent < number of agents).
pub(in crate::stage) fn colour(brains: &AgentBrains, agent: usize, event: usize, brush: &Brush<'_>) -> Rgba {
    match (brains.learnt_event(agent, event), brush.dark) {
        (Some(_), _) => super::colour_of_message(event),
        (None, true) => Rgba::hex(0x59616c),
        (None, false) => Rgba::hex(0xb4bac2),
    }
}

/// Draws lines from senders to receivers, and from the selected agent back to the origin of the message.
pub(super) fn lay_out(shapes: &mut ShapeList, simulation: &Simulation, selected: Option<usize>, brush: &Brush<'_>) {
    let (Some(event), Some(first)) = (brush.options.message, first_agent(simulation)) else { return };
    let Some(brains) = simulation.brains() else { return };
    let place = |agent: usize| {
        let lift = if brush.in_the_air { Vec3::ZERO } else { Vec3::Y * LINE_Y };
        simulation.disc(first + agent).map(|d| d.centre + lift)
    };
    let told = |agent: usize| {
        let learnt = brains.learnt_event(agent, event)?;
        Some((learnt.source_agent()?, learnt.time_s))
    };
    let colour = super::colour_of_message(event);
    let all = (0..brains.len()).filter_map(|agent| {
        let (from, time_s) = told(agent)?;
        Some((place(from)?, place(agent)?, time_s))
    });
    for (from, to, time_s) in all.take(MAX_LINES) {
        let age = ((simulation.time_s() - time_s) / FADE_S).clamp(0.0, 1.0) as f32;
        shapes.line(from, to, 1.5, colour.alpha(0.9 + (FADED - 0.9) * age));
    }
    let Some(selected) = selected.and_then(|who| who.checked_sub(first)).filter(|a| *a < brains.len()) else { return };
    for pair in sources(selected, told).windows(2) {
        if let (Some(to), Some(from)) = (place(pair[0]), place(pair[1])) {
            shapes.line(from, to, 3.5, brush.palette.selected);
        }
    }
}

/// An agent, its sender, the sender of that one, and so on.
///
/// - `told`: sender of an agent, and the time (s).
fn sources(agent: usize, told: impl Fn(usize) -> Option<(usize, f64)>) -> Vec<usize> {
    let (mut all, mut until_s) = (vec![agent], f64::INFINITY);
    // A sender may learn the message again later, from another agent.
    while let Some((from, time_s)) = told(all[all.len() - 1]).filter(|t| t.1 <= until_s && !all.contains(&t.0)) {
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
        let told = [None, Some((0, 1.0)), Some((1, 2.0)), Some((4, 5.0)), Some((3, 3.0))];
        assert_eq!(sources(2, |a| told[a]), [2, 1, 0]);
        assert_eq!(sources(4, |a| told[a]), [4, 3], "3 felt it of itself then, and learnt of it from 4 later");
        assert_eq!(sources(3, |a| told[a]), [3, 4]);
    }
}
