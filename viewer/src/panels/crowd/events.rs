//! What happens, the latest first; a click selects the agent.

use super::{State, colour};
use crate::command::Command;
use crate::document::SceneDocument;
use crate::model::Model;
use crate::run::agents::{Happened, With};
use crate::stage::agents::colour_of_event;
use eframe::egui::{Align2, Color32, Role, ScrollArea, Sense, TextStyle, Ui, WidgetInfo, pos2, vec2};

/// Events that are listed at most.
const MOST: usize = 200;
/// Height of the list (points).
const HEIGHT: f32 = 190.0;
/// Widths of the columns of time and kind (points).
const TIME: f32 = 86.0;
const KIND: f32 = 78.0;

/// Shows the list.
pub fn show(ui: &mut Ui, model: &Model, scene: &SceneDocument, state: &mut State, commands: &mut Vec<Command>) {
    let (run, kinds) = (scene.run(), &model.selection.scene.kinds);
    ui.checkbox(&mut state.only_selected, "of the selected agent only");
    let now = run.simulation().time_s();
    let list = match state.only_selected {
        true => run.log().last_of_watched(kinds, now, MOST),
        false => run.log().last(kinds, now, MOST),
    };
    if list.is_empty() {
        ui.weak(match (state.only_selected, model.selection.character) {
            (true, None) => "Select an agent to see what happens to it.",
            _ => "No event of these kinds has happened yet.",
        });
        return;
    }
    let height = ui.text_style_height(&TextStyle::Body) + 3.0;
    let area = ScrollArea::vertical().id_salt("events").max_height(HEIGHT).auto_shrink([false, true]);
    area.show_rows(ui, height, list.len(), |ui, rows| {
        for h in &list[rows] {
            if row(ui, scene, h, model.selection.character, height) {
                commands.push(Command::SelectCharacter(Some(h.agent)));
            }
        }
    });
}

/// One event; true where it was clicked.
fn row(ui: &mut Ui, scene: &SceneDocument, h: &Happened, selected: Option<usize>, height: f32) -> bool {
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
    let kind = colour(colour_of_event(h.what, visuals.dark_mode));
    write(TIME, h.what.name().to_owned(), TextStyle::Body, kind);
    write(TIME + KIND, in_words(scene, h), TextStyle::Body, visuals.text_color());
    let name = format!("Event {} {}", h.what.name(), h.agent);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    let clicked = response.clicked();
    response.on_hover_text(format!("{}. A click selects agent {}.", h.what.meaning(), h.agent));
    clicked
}

/// Agent of the event, and the other party.
fn in_words(scene: &SceneDocument, h: &Happened) -> String {
    let agent = super::who(scene, h.agent);
    match h.with {
        With::Nobody => agent,
        With::Agent(other) => format!("{agent} – {}", super::who(scene, other)),
        With::Obstacle(o) => format!("{agent} – obstacle {o}"),
    }
}
