//! Marks where something happened, which fade.

use super::Brush;
use crate::render::{Rgba, ShapeList};
use crate::run::SceneRun;
use crate::run::agents::{AgentEvent, AgentEventKind, EventFilter};
use glam::Vec3;

/// Time that a mark stays (s).
const MARK_S: f64 = 0.6;
/// Time that marks of rare events stay (s).
const RARE_S: f64 = 2.5;
/// Most marks of frequent events that are drawn: more would hide the agents. Those of the selected agent are always
/// drawn.
const MAX_MARKS: usize = 120;
/// Most marks of rare events that are drawn.
const MAX_RARE: usize = 500;
/// Radius of marks of agents that have left (m).
const GONE_M: f32 = 0.3;
/// Height over the ground (m).
const MARK_Y: f32 = 0.022;

/// Colour of a kind of events, in the view and in the panel.
pub fn colour_of(what: AgentEventKind, dark: bool) -> Rgba {
    Rgba::hex(what.colours()[usize::from(!dark)])
}

/// Duration of a mark of a kind (s).
fn mark_duration_s(what: AgentEventKind) -> f64 {
    use AgentEventKind::*;
    if matches!(what, Arrived | Left | Struck | Stuck | Learnt) { RARE_S } else { MARK_S }
}

/// Frequent events of all agents.
fn is_frequent(what: AgentEventKind) -> bool {
    use AgentEventKind::*;
    matches!(what, Resetting | Entering | Leaving | EnteredPlace | LeftPlace | Edge)
}

pub(super) fn lay_out(shapes: &mut ShapeList, run: &SceneRun, brush: &Brush<'_>) {
    let now = run.simulation().time_s();
    let is_rare = AgentEventKind::all().map(|what| mark_duration_s(what) > MARK_S);
    let of_kinds =
        |rare: bool| EventFilter::of_kinds(std::array::from_fn(|k| brush.options.kinds[k] && is_rare[k] == rare));
    let usual = run.log.last(&of_kinds(false), now, MAX_MARKS);
    let first_s = usual.last().map_or(now, |h| h.time_s);
    let mut more = run.log.last_of_watched(&of_kinds(false), now, MAX_MARKS);
    more.retain(|h| h.time_s < first_s);
    for h in run.log.last(&of_kinds(true), now, MAX_RARE).iter().chain(&usual).chain(&more) {
        let age = ((now - h.time_s) / mark_duration_s(h.kind)) as f32;
        if age < 1.0 {
            let radius = run.simulation().disc(h.agent).map_or(GONE_M, |d| d.radius);
            draw_mark(shapes, brush, h, (radius, age));
        }
    }
}

/// A ring that grows and fades; between partners a line.
///
/// - `radius`: of the agent (m).
/// - `age`: 0 where it happens, 1 where the mark is gone.
fn draw_mark(shapes: &mut ShapeList, brush: &Brush<'_>, h: &AgentEvent, (radius, age): (f32, f32)) {
    let strength = (1.0 - age) * if is_frequent(h.kind) { 0.45 } else { 0.8 };
    let colour = colour_of(h.kind, brush.dark).alpha(strength);
    let lift = if brush.in_the_air { Vec3::ZERO } else { Vec3::Y * MARK_Y };
    if let Some(other) = h.other_at {
        shapes.line(h.at + lift, other + lift, 1.6, colour);
    }
    let grown = radius
        * match h.kind {
            what if is_frequent(what) => 1.0 + 0.25 * age,
            what if mark_duration_s(what) > MARK_S => 1.2 + 1.6 * age,
            _ => 1.05 + 0.6 * age,
        };
    if brush.in_the_air {
        shapes.circle(h.at, grown, 1.5, colour);
    } else {
        let width = (1.5 * brush.pixel_m).max(0.05 * radius).min(grown);
        shapes.ring(h.at + lift, grown - width, grown, colour);
    }
}
