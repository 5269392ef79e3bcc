//! The list of clips, with a search field.

use super::catalogue::{Catalogue, Entry, Field};
use crate::command::Command;
use crate::panels::paint::{Cell, Column, Sort, Table, time_text};
use eframe::egui::{Label, RichText, TextEdit, Ui};

const fn number(title: &'static str, hint: &'static str, width: f32) -> Column {
    Column { title, hint, width, grows: 0.0, is_number: true }
}

/// Columns, in the order of [`Field::ALL`].
const COLUMNS: [Column; Field::ALL.len()] = [
    Column {
        title: "Clip",
        hint: "Name; copies with left and right exchanged are dimmed and end in ~mirror",
        width: 100.0,
        grows: 3.0,
        is_number: false,
    },
    number("Length", "Duration", 62.0),
    number("Usable", "Share of the frames that are not left out", 52.0),
    number("Played", "Share of the frames that the motion graph plays", 52.0),
    number("States", "States of the motion graph that lie in the clip", 48.0),
    number("Actions", "Actions that leave these states", 54.0),
    Column { title: "Tags", hint: "Names of its tags", width: 48.0, grows: 1.0, is_number: false },
];

/// What the list remembers.
#[derive(Clone, Debug, Default)]
pub struct State {
    query: String,
    sort: Option<Sort>,
    /// What the rows were made of: document, query, order.
    made_of: Option<(u64, String, Option<Sort>)>,
    catalogue: Catalogue,
    rows: Vec<usize>,
    shown: Option<usize>,
}

impl State {
    /// Numbers of the clips that are listed, in order.
    #[cfg(test)]
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Finds the rows anew where something has changed.
    fn refresh(&mut self, document: u64, catalogue: impl FnOnce() -> Catalogue) {
        let now = (document, self.query.clone(), self.sort);
        if self.made_of.as_ref() == Some(&now) {
            return;
        }
        if self.made_of.as_ref().map(|m| m.0) != Some(document) {
            self.catalogue = catalogue();
            self.shown = None;
        }
        let in_file_order = Sort { column: usize::MAX, descending: false };
        self.rows = self.catalogue.select(&self.query, self.sort.unwrap_or(in_file_order));
        self.made_of = Some(now);
    }
}

/// Shows the list.
///
/// - `document`: tells one version of what is open from the next.
/// - `selected`: the clip that is looked at.
pub fn show(
    ui: &mut Ui,
    state: &mut State,
    document: u64,
    catalogue: impl FnOnce() -> Catalogue,
    selected: usize,
    commands: &mut Vec<Command>,
) {
    state.refresh(document, catalogue);
    search(ui, state);
    if state.rows.is_empty() {
        ui.add_space(12.0);
        ui.vertical_centered(|ui| {
            ui.label(format!("No clip matches \"{}\".", state.query.trim()));
            ui.label(RichText::new("Every word is looked for in names, tags and source files.").weak());
        });
        return;
    }
    let table = Table {
        id: "clips",
        columns: if state.catalogue.has_tags() { &COLUMNS } else { &COLUMNS[..Field::ALL.len() - 1] },
        num_rows: state.rows.len(),
        selected: state.rows.iter().position(|r| *r == selected),
        sort: Some(state.sort.unwrap_or(Sort { column: usize::MAX, descending: false })),
        scroll_to_selected: state.shown != Some(selected),
    };
    let response = table.show(ui, |row, column| cell(&state.catalogue.entries[state.rows[row]], Field::ALL[column]));
    state.shown = Some(selected);
    if let Some(sort) = response.sort {
        state.sort = Some(sort);
    }
    if let Some(clip) = response.chosen.map(|row| state.rows[row]) {
        commands.push(Command::ShowClip { clip, frame: 0 });
    }
}

fn search(ui: &mut Ui, state: &mut State) {
    ui.horizontal(|ui| {
        let total = state.catalogue.entries.len();
        let count = if state.rows.len() == total {
            format!("{total} clips")
        } else {
            format!("{} of {total}", state.rows.len())
        };
        let name = ui.label("Search");
        let width = (ui.available_width() - 120.0).max(60.0);
        let edit = TextEdit::singleline(&mut state.query).hint_text("name, tag, source").desired_width(width);
        ui.add(edit).labelled_by(name.id);
        let clear = eframe::egui::Button::new("Clear").small();
        if ui.add_enabled(!state.query.is_empty(), clear).on_hover_text("Clear the search").clicked() {
            state.query.clear();
        }
        ui.add(Label::new(RichText::new(count).weak()).truncate());
    });
}

fn cell(entry: &Entry, field: Field) -> Cell {
    let share = |v: f32| format!("{:.0} %", 100.0 * v);
    let count = |n: u32| if n == 0 { Cell::weak("0") } else { Cell::new(n.to_string()) };
    match field {
        Field::Name if entry.mirrored => Cell::weak(&entry.name).ending(),
        Field::Name => Cell::new(&entry.name).ending(),
        Field::Duration => Cell::new(time_text(entry.duration_s)),
        Field::Usable => Cell { text: share(entry.usable), weak: entry.usable >= 1.0, ..Cell::default() },
        Field::Played => Cell { text: share(entry.played), weak: entry.played <= 0.0, ..Cell::default() },
        Field::States => count(entry.states),
        Field::Actions => count(entry.actions),
        Field::Tags => Cell::new(&entry.tags),
    }
}
