//! What happens, the latest first; a click selects the member.

use super::{State, colour};
use crate::command::Command;
use crate::document::CrowdDocument;
use crate::model::Model;
use crate::run::members::{Happened, With};
use crate::stage::members::colour_of_event;
use eframe::egui::{
    Align, Label, Layout, RichText, Role, ScrollArea, Sense, TextStyle, Ui, UiBuilder, WidgetInfo, vec2,
};

/// Events that are listed at most.
const MOST: usize = 200;
/// Height of the list. [Unit: points]
const HEIGHT: f32 = 190.0;
/// Widths of the columns of time and kind. [Unit: points]
const TIME: f32 = 62.0;
const KIND: f32 = 72.0;

/// Shows the list.
pub fn show(ui: &mut Ui, model: &Model, crowd: &CrowdDocument, state: &mut State, commands: &mut Vec<Command>) {
    let (run, kinds) = (crowd.run(), &model.selection.crowd.kinds);
    ui.checkbox(&mut state.only_selected, "of the selected member only");
    let now = run.moment().time_s;
    let list = match state.only_selected {
        true => run.log().last_of_watched(kinds, now, MOST),
        false => run.log().last(kinds, now, MOST),
    };
    if list.is_empty() {
        ui.weak(match (state.only_selected, model.selection.character) {
            (true, None) => "Select a member to see what happens to it.",
            _ => "Nothing of what is shown has happened yet.",
        });
        return;
    }
    let height = ui.text_style_height(&TextStyle::Body) + 3.0;
    let area = ScrollArea::vertical().id_salt("events").max_height(HEIGHT).auto_shrink([false, true]);
    area.show_rows(ui, height, list.len(), |ui, rows| {
        for h in &list[rows] {
            if row(ui, crowd, h, model.selection.character, height) {
                commands.push(Command::SelectCharacter(Some(h.member)));
            }
        }
    });
}

/// One event; true where it was clicked.
fn row(ui: &mut Ui, crowd: &CrowdDocument, h: &Happened, selected: Option<usize>, height: f32) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click());
    let is_about = selected.is_some_and(|m| h.is_about(m));
    if is_about || response.hovered() {
        let fill = ui.visuals().selection.bg_fill.gamma_multiply(if is_about { 0.35 } else { 0.2 });
        ui.painter().rect_filled(rect, 2.0, fill);
    }
    let mut line = ui.new_child(UiBuilder::new().max_rect(rect).layout(Layout::left_to_right(Align::Center)));
    line.spacing_mut().item_spacing.x = 6.0;
    let cell = |ui: &mut Ui, width: f32, text: RichText| {
        ui.add_sized([width, height], Label::new(text).truncate().halign(Align::Min).selectable(false))
    };
    cell(&mut line, TIME, RichText::new(format!("{:>8.3} s", h.time_s)).monospace().small());
    let dark = line.visuals().dark_mode;
    cell(&mut line, KIND, RichText::new(h.what.name()).color(colour(colour_of_event(h.what, dark))));
    let rest = line.available_width().max(10.0);
    cell(&mut line, rest, RichText::new(in_words(crowd, h)));
    let name = format!("Event {} {}", h.what.name(), h.member);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    let clicked = response.clicked();
    response.on_hover_text(format!("{}. A click selects member {}.", h.what.meaning(), h.member));
    clicked
}

/// Whom it happened to, and with whom.
fn in_words(crowd: &CrowdDocument, h: &Happened) -> String {
    let member = super::who(crowd, h.member);
    match h.with {
        With::Nobody => member,
        With::Member(other) => format!("{member} – {}", super::who(crowd, other)),
        With::Obstacle(o) => format!("{member} – obstacle {o}"),
    }
}
