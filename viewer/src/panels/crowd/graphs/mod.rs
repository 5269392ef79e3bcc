//! The state-transition graphs of the selected agent, level by level: its states, and the edges that it took last.

mod layout;
mod route;

use super::selected_brain;
use crate::run::agents::{StateEntry, first_agent};
use crate::{document::SceneDocument, model::Model, panels::paint::PanelWidget, theme::ThemePalette};
use eframe::egui::{
    Align2, Color32, CornerRadius, FontId, Painter, Pos2, Rect, Role, Sense, Shape as Drawn, Stroke, StrokeKind,
    TextStyle, Ui, Vec2, vec2,
};
use layout::{StateGraphShape, lay_out};
use throng_simulation::scenario::{AgentBrains, CurrentState};
use throng_simulation::scene::{EdgeConfig, StateGraphConfig};

/// Levels by their names, the highest first.
const LEVELS: [&str; 3] = ["social", "spatial", "primitive"];

/// Shows the graphs that the selected agent is in.
pub fn show(ui: &mut Ui, model: &Model, scene: &SceneDocument, brains: &AgentBrains) {
    let simulation = scene.run.simulation();
    let first = first_agent(simulation).unwrap_or(0);
    let Some(agent) = selected_brain(model, scene, brains) else { return drop(ui.weak("Select an agent.")) };
    let states = brains.states_of(agent);
    if states.iter().all(Option::is_none) {
        return drop(ui.weak("It is in no state: it follows its goal and rules."));
    }
    for (level, now) in states.iter().enumerate() {
        let entry = scene.run.entry(first + agent, level);
        let graph = now.and_then(|now| Some((now, simulation.scene().graphs.get(now.graph)?)));
        match graph {
            Some((now, graph)) => show_graph(ui, level, now, graph, entry),
            None => drop(ui.weak(format!("{}: no graph in this state", LEVELS[level]))),
        }
    }
}

/// Shows one graph, and how the agent came to its state.
fn show_graph(ui: &mut Ui, level: usize, now: CurrentState<'_>, graph: &StateGraphConfig, entry: Option<StateEntry>) {
    let since = entry.and_then(|e| e.since_s).map_or_else(String::new, |s| format!(", since {s:.1} s"));
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.strong(LEVELS[level]);
        ui.label(format!("{}: {}{since}", now.graph, now.state));
    });
    if let Some(above) = entry.and_then(|e| e.began_with) {
        ui.weak(format!("began anew as the {} state changed", LEVELS[above]));
    }
    let taken = entry.and_then(|e| e.edge).filter(|(edge, _)| *edge < graph.edges.len());
    let marks = StateGraphMarks {
        now: graph.states.keys().position(|s| s == now.state),
        taken: taken.map(|t| t.0),
        is_anew: entry.is_some_and(|e| e.began_with.is_some()),
    };
    paint_graph(ui, now.graph, graph, &StateGraphShape::from_config(graph), marks);
    if let Some((edge, at_s)) = taken {
        let stays = if graph.edges[edge].to == now.state { "" } else { " (before)" };
        ui.label(format!("took at {at_s:.1} s{stays}: {}", in_words(&graph.edges[edge])));
    }
    ui.add_space(4.0);
}

/// An edge as the scene file has it, in a line.
fn in_words(edge: &EdgeConfig) -> String {
    let from = edge.from.as_deref().unwrap_or("any state");
    let when = edge.when.as_ref().map_or_else(String::new, |w| format!(", when {w}"));
    let by_chance = edge.probability.map_or_else(String::new, |p| format!(", probability {p}"));
    format!("{from} > {}, on {}{when}{by_chance}", edge.to, edge.on)
}

/// Space around the name of a state (points).
const PADDING: Vec2 = vec2(8.0, 4.0);
/// Length of the heads of arrows (points).
const HEAD: f32 = 7.0;
/// An edge is pointed at within this distance (points).
const REACH: f32 = 5.0;

/// Highlighted parts of a graph.
#[derive(Clone, Copy, Debug, Default)]
pub struct StateGraphMarks {
    /// The present state.
    pub now: Option<usize>,
    /// The last edge taken.
    pub taken: Option<usize>,
    /// The graph began anew with a change at a higher level.
    pub is_anew: bool,
}

/// Shows a graph within the available width; a tooltip describes the edge or the state under the pointer.
fn paint_graph(ui: &mut Ui, name: &str, graph: &StateGraphConfig, shape: &StateGraphShape, marks: StateGraphMarks) {
    let font = TextStyle::Body.resolve(ui.style());
    let size = |state: &String| {
        let text = ui.painter().layout_no_wrap(state.clone(), font.clone(), Color32::PLACEHOLDER);
        text.size() + 2.0 * PADDING
    };
    let sizes: Vec<Vec2> = graph.states.keys().map(size).collect();
    let width = ui.available_width();
    let (boxes, height) = lay_out(shape, &sizes, width);
    // Edges from any state come in from above.
    let above = if shape.edges.iter().any(|e| e.0.is_none()) { 22.0 } else { 2.0 };
    let (rect, response) = ui.allocate_exact_size(vec2(width, height + above), Sense::hover());
    let response = response.named(Role::Image, format!("Graph {name}"));
    let boxes: Vec<Rect> = boxes.iter().map(|b| b.translate(rect.min.to_vec2() + vec2(0.0, above))).collect();
    let curves = route::curves(&shape.edges, &boxes, rect.shrink(1.0));
    let pointer = response.hover_pos();
    let on_state = pointer.and_then(|at| boxes.iter().position(|b| b.contains(at)));
    let near = |at: Pos2| {
        let all = curves.iter().enumerate().map(|(i, c)| (i, route::distance(c, at))).filter(|d| d.1 < REACH);
        all.min_by(|a, b| a.1.total_cmp(&b.1)).map(|d| d.0)
    };
    let on_edge = pointer.filter(|_| on_state.is_none()).and_then(near);
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let (visuals, palette) = (ui.visuals(), ThemePalette::for_visuals(ui.visuals()));
    for (i, curve) in curves.iter().enumerate() {
        if Some(i) != marks.taken {
            let is_on = Some(i) == on_edge || on_state.is_some_and(|s| shape.edges[i].0.is_none_or(|f| f == s));
            let colour = if is_on { visuals.strong_text_color() } else { visuals.weak_text_color() };
            arrow(&painter, curve, Stroke::new(if is_on { 1.8 } else { 1.0 }, colour));
        }
    }
    for (state, (name, place)) in graph.states.keys().zip(&boxes).enumerate() {
        let is_now = marks.now == Some(state);
        let fill = if is_now { palette.head } else { visuals.widgets.inactive.bg_fill };
        let corners = CornerRadius::same(4);
        painter.rect_filled(*place, corners, fill);
        let line = match (is_now && marks.is_anew, state == shape.start) {
            (true, _) => Stroke::new(2.0, palette.state),
            (_, true) => Stroke::new(1.5, visuals.text_color()),
            _ => Stroke::new(1.0, visuals.weak_text_color()),
        };
        painter.rect_stroke(*place, corners, line, StrokeKind::Inside);
        if graph.states[name].graph.is_some() {
            // A second frame marks a state that is a graph itself.
            let inner = if is_now { contrasting_colour(palette.head) } else { visuals.weak_text_color() };
            painter.rect_stroke(place.shrink(3.0), 2.0, Stroke::new(1.0, inner), StrokeKind::Inside);
        }
        let colour = if is_now { contrasting_colour(palette.head) } else { visuals.text_color() };
        painter.text(place.center(), Align2::CENTER_CENTER, name, font.clone(), colour);
    }
    // Over all else, so that it can be read.
    if let Some((curve, edge)) = marks.taken.and_then(|t| Some((curves.get(t)?, &graph.edges[t]))) {
        arrow(&painter, curve, Stroke::new(2.5, palette.character));
        label(&painter, rect, curve, &edge.on, (palette.character, visuals.panel_fill));
    }
    let lines = match (on_state, on_edge) {
        (Some(state), _) => state_lines(graph, state, shape),
        (None, Some(edge)) => vec![in_words(&graph.edges[edge])],
        (None, None) => return,
    };
    response.on_hover_ui_at_pointer(|ui| lines.iter().for_each(|line| drop(ui.label(line))));
}

/// A state, and where it leads.
fn state_lines(graph: &StateGraphConfig, state: usize, shape: &StateGraphShape) -> Vec<String> {
    let Some((name, config)) = graph.states.iter().nth(state) else { return Vec::new() };
    let below = config.graph.as_ref().map_or_else(String::new, |g| format!(", made of the graph {g}"));
    let start = if state == shape.start { ", where it begins" } else { "" };
    let edges = graph.edges.iter().zip(&shape.edges).filter(|(_, e)| e.0.is_none_or(|f| f == state));
    std::iter::once(format!("{name}{start}{below}")).chain(edges.map(|(edge, _)| in_words(edge))).collect()
}

/// A colour that is read on another.
fn contrasting_colour(colour: Color32) -> Color32 {
    let is_light = 299 * u32::from(colour.r()) + 587 * u32::from(colour.g()) + 114 * u32::from(colour.b()) > 128_000;
    if is_light { Color32::from_gray(20) } else { Color32::WHITE }
}

fn arrow(painter: &Painter, curve: &route::EdgeCurve, stroke: Stroke) {
    painter.add(Drawn::line(curve.clone(), stroke));
    let head = route::head(curve, HEAD).to_vec();
    painter.add(Drawn::convex_polygon(head, stroke.color, Stroke::NONE));
}

/// A label beside an edge, on the side to which it bends, on its own background, within the drawing.
fn label(painter: &Painter, within: Rect, curve: &route::EdgeCurve, text: &str, (colour, ground): (Color32, Color32)) {
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(11.0), colour);
    let half = 0.5 * galley.size() + vec2(3.0, 1.0);
    let room = Rect::from_min_max(within.min + half, (within.max - half).max(within.min + half));
    let (at, bend) = (route::middle(curve), route::bend(curve));
    let middle = room.clamp(at + bend * (vec2(half.x, half.y) * bend.abs()).length().max(half.y) + bend * 5.0);
    painter.rect_filled(Rect::from_center_size(middle, 2.0 * half), 3.0, ground.gamma_multiply(0.9));
    painter.galley(middle - 0.5 * galley.size(), galley, colour);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_is_told_with_its_predicate_and_probability() {
        let edge = EdgeConfig {
            from: Some("walk".into()),
            to: "bread".into(),
            on: "enters".into(),
            when: Some("place.free > 0".into()),
            probability: Some(0.3),
            alone: false,
        };
        assert_eq!(in_words(&edge), "walk > bread, on enters, when place.free > 0, probability 0.3");
        let any = EdgeConfig { from: None, when: None, probability: None, ..edge };
        assert_eq!(in_words(&any), "any state > bread, on enters");
    }
}
