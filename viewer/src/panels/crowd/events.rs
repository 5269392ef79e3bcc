//! List of events, the latest first; a click selects the agent.

use super::{CrowdPanelState, options_command};
use crate::command::{Commands, ViewerCommand};
use crate::panels::paint::{PanelWidget, choose};
use crate::run::agents::{AgentEvent, AgentEventKind, EventFilter, OtherParty};
use crate::{document::SceneDocument, model::Model, panels::colour_of_view, stage::agents::colour_of_event};
use eframe::egui::{Align2, Color32, Role, ScrollArea, Sense, TextStyle, Ui, pos2, vec2};

/// Events that are listed at most.
const MOST: usize = 200;
/// Height of the list (points).
const HEIGHT: f32 = 190.0;
/// Widths of the columns of time and kind (points).
const TIME: f32 = 86.0;
const KIND: f32 = 78.0;

/// Shows the list.
pub fn show(ui: &mut Ui, model: &Model, scene: &SceneDocument, state: &mut CrowdPanelState, commands: &mut Commands) {
    let run = &scene.run;
    ui.checkbox(&mut state.only_selected, "of the selected agent only");
    if let Some(brains) = run.simulation().brains() {
        ui.horizontal_wrapped(|ui| {
            choice(ui, "place", "any place", brains.place_names(), &mut state.place);
            choice(ui, "message", "any message", brains.event_names(), &mut state.message);
        });
        kinds(ui, model, commands);
    }
    let filter = EventFilter { kinds: model.selection.scene.kinds, place: state.place, message: state.message };
    let now = run.simulation().time_s();
    let list = match state.only_selected {
        true => run.log.last_of_watched(&filter, now, MOST),
        false => run.log.last(&filter, now, MOST),
    };
    if list.is_empty() {
        ui.weak(match (state.only_selected, model.selection.character) {
            (true, None) => "Select an agent to see what happens to it.",
            _ if state.place.is_some() || state.message.is_some() => "No event that the filters let through yet.",
            _ => "No event of these kinds has happened yet.",
        });
        return;
    }
    let height = ui.text_style_height(&TextStyle::Body) + 3.0;
    let area = ScrollArea::vertical().id_salt("events").max_height(HEIGHT).auto_shrink([false, true]);
    area.show_rows(ui, height, list.len(), |ui, rows| {
        for h in &list[rows] {
            if row(ui, scene, h, model.selection.character, height) {
                commands.push(ViewerCommand::SelectCharacter(Some(h.agent)));
            }
        }
    });
}

/// A filter by one of some names, or none of them.
fn choice(ui: &mut Ui, what: &str, any: &str, names: &[String], chosen: &mut Option<usize>) {
    *chosen = chosen.filter(|n| *n < names.len());
    if !names.is_empty() {
        let named = names.iter().enumerate().map(|(n, name)| (Some(n), name.clone()));
        let options = std::iter::once((None, any.to_owned())).chain(named);
        choose(ui, &format!("Events: {what}"), Some(130.0), chosen, options);
    }
}

/// Buttons that show all kinds, or hide the many kinds of the engine.
fn kinds(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    ui.horizontal(|ui| {
        ui.label("kinds").on_hover_text("Each kind can be shown and hidden above, below the rates");
        let mut button = |text: &str, kinds| {
            let button = ui.small_button(text);
            button.request(commands, options_command(model, |l| l.kinds = kinds));
            button
        };
        button("all", [true; AgentEventKind::COUNT]);
        let tip = "Hides what the engine of the crowd does, such as resetting bounds";
        button("without the engine's", AgentEventKind::all().map(|k| !k.is_of_engine())).on_hover_text(tip);
    });
}

/// One event; true if it was clicked.
fn row(ui: &mut Ui, scene: &SceneDocument, h: &AgentEvent, selected: Option<usize>, height: f32) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click());
    let is_about = selected.is_some_and(|m| h.is_about(m));
    if is_about || response.hovered() {
        let fill = ui.visuals().selection.bg_fill.gamma_multiply(if is_about { 0.35 } else { 0.2 });
        ui.painter().rect_filled(rect, 2.0, fill);
    }
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let visuals = ui.visuals();
    let write = |x: f32, text: String, style: TextStyle, colour: Color32| {
        let at = pos2(rect.left() + x, rect.center().y);
        painter.text(at, Align2::LEFT_CENTER, text, style.resolve(ui.style()), colour);
    };
    write(2.0, format!("{:>8.3} s", h.time_s), TextStyle::Monospace, visuals.weak_text_color());
    let kind = colour_of_view(colour_of_event(h.kind, visuals.dark_mode));
    write(TIME, h.kind.name().to_owned(), TextStyle::Body, kind);
    write(TIME + KIND, in_words(scene, h), TextStyle::Body, visuals.text_color());
    let response = response.named(Role::Button, format!("Event {} {}", h.kind.name(), h.agent));
    response.on_hover_text(format!("{}. A click selects agent {}.", h.kind.meaning(), h.agent)).clicked()
}

/// Agent of the event, and the other party.
fn in_words(scene: &SceneDocument, h: &AgentEvent) -> String {
    let agent = super::agent_name(scene, h.agent);
    let simulation = scene.run.simulation();
    let brains = simulation.brains();
    let place = h.place.and_then(|p| brains?.place_names().get(p)).map_or_else(String::new, |p| format!(" at {p}"));
    let message = h.message.and_then(|e| brains?.event_names().get(e));
    let on = message.map_or_else(String::new, |e| format!(", on {e}"));
    let named = |before: &str, other: Option<usize>| {
        other.map_or_else(String::new, |o| format!("{before}{}", super::agent_name(scene, o)))
    };
    let with = |other| named(", with ", other);
    match h.other_party {
        OtherParty::None => format!("{agent}{place}"),
        OtherParty::Message(how, other) => {
            format!("{agent} – {}, {how}{}", message.map_or("", String::as_str), named(" by ", other))
        }
        OtherParty::Rule(rule, other) => {
            format!("{agent} – \"{}\"{}{place}{on}", brains.map_or("", |m| m.rule_name(rule)), with(other))
        }
        OtherParty::Edge(graph, edge, other) => {
            let edge = simulation.scene().graphs.values().nth(graph).and_then(|g| g.edges.get(edge));
            let states =
                edge.map_or_else(String::new, |e| format!("{} > {}", e.from.as_deref().unwrap_or("any"), e.to));
            format!("{agent} – {states}{}{place}{on}", with(other))
        }
        OtherParty::Agent(other) => format!("{agent} – {}", super::agent_name(scene, other)),
        OtherParty::Obstacle(o) => format!("{agent} – obstacle {o}"),
    }
}
