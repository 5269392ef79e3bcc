//! The list of clips, with a search field.

use super::catalogue::{CatalogueClip, ClipCatalogue};
use crate::bundle::OpenBundle;
use crate::command::{Commands, ViewerCommand};
use crate::model::Model;
use crate::panels::paint::{RowTable, TableCell, TableColumn, TableSort, time_text};
use eframe::egui::{Button, Label, RichText, TextEdit, Ui};

/// Columns; that of tags is the last one, so that it can be left out.
const COLUMNS: [TableColumn<'static>; 7] = [
    TableColumn::text("Clip", "Name; copies with left and right exchanged are dimmed and end in ~mirror", 100.0, 3.0),
    TableColumn::number("Length", "Duration", 62.0),
    TableColumn::number("Usable", "Share of the frames that are not left out", 52.0).spare(1),
    TableColumn::number("Played", "Share of the frames that the motion graph plays", 52.0).spare(1),
    TableColumn::number("States", "States of the motion graph that lie in the clip", 48.0).spare(2),
    TableColumn::number("Actions", "Actions that leave these states", 54.0).spare(2),
    TableColumn::text("Tags", "Names of its tags", 48.0, 1.0),
];

/// State of the list.
#[derive(Clone, Debug, Default)]
pub struct ClipListState {
    query: String,
    sort: TableSort,
    /// Key of the rows: document, query, order.
    made_of: Option<(u64, String, TableSort)>,
    catalogue: ClipCatalogue,
    rows: Vec<usize>,
    shown: Option<usize>,
}

impl ClipListState {
    /// Numbers of the clips that are listed, in order.
    #[cfg(test)]
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Rebuilds the rows if something has changed.
    fn refresh(&mut self, document: u64, bundle: &OpenBundle) {
        let now = (document, self.query.clone(), self.sort);
        if self.made_of.as_ref() == Some(&now) {
            return;
        }
        if self.made_of.as_ref().map(|m| m.0) != Some(document) {
            self.catalogue = ClipCatalogue::from_bundle(bundle);
            self.shown = None;
        }
        self.rows = self.catalogue.select(&self.query, self.sort);
        self.made_of = Some(now);
    }
}

/// Shows the list.
pub fn show(ui: &mut Ui, state: &mut ClipListState, model: &Model, bundle: &OpenBundle, commands: &mut Commands) {
    let selected = model.selection.clip;
    state.refresh(model.generation, bundle);
    search(ui, state);
    if state.rows.is_empty() {
        ui.add_space(12.0);
        ui.vertical_centered(|ui| {
            ui.label(format!("No clip matches \"{}\".", state.query.trim()));
            ui.label(RichText::new("Every word is looked for in names, tags and source files.").weak());
        });
        return;
    }
    let has_tags = state.catalogue.entries.iter().any(|e| !e.tags.is_empty());
    let columns = if has_tags { &COLUMNS[..] } else { &COLUMNS[..COLUMNS.len() - 1] };
    let table = RowTable {
        selected: state.rows.iter().position(|r| *r == selected),
        sort: Some(state.sort),
        scroll_to_selected: state.shown != Some(selected),
        ..RowTable::new("clips", columns, state.rows.len())
    };
    let response = table.show(ui, |row, column| cell(&state.catalogue.entries[state.rows[row]], column));
    state.shown = Some(selected);
    state.sort = response.sort.unwrap_or(state.sort);
    commands.extend(response.chosen.map(|row| ViewerCommand::ShowClip { clip: state.rows[row], frame: 0 }));
}

fn search(ui: &mut Ui, state: &mut ClipListState) {
    ui.horizontal(|ui| {
        let (listed, total) = (state.rows.len(), state.catalogue.entries.len());
        let count = if listed == total { format!("{total} clips") } else { format!("{listed} of {total}") };
        let name = ui.label("Search");
        let width = (ui.available_width() - 120.0).max(60.0);
        let edit = TextEdit::singleline(&mut state.query).hint_text("name, tag, source").desired_width(width);
        ui.add(edit).labelled_by(name.id);
        let clear = Button::new("Clear").small();
        if ui.add_enabled(!state.query.is_empty(), clear).on_hover_text("Clear the search").clicked() {
            state.query.clear();
        }
        ui.add(Label::new(RichText::new(count).weak()).truncate());
    });
}

/// A clip in a column, which [`COLUMNS`] numbers.
fn cell(entry: &CatalogueClip, column: usize) -> TableCell {
    let share = |v: f32, weak| TableCell { text: format!("{:.0} %", 100.0 * v), weak, ..TableCell::default() };
    let count = |n: u32| if n == 0 { TableCell::weak("0") } else { TableCell::new(n.to_string()) };
    match column {
        0 if entry.mirrored => TableCell::weak(&entry.name).ending(),
        0 => TableCell::new(&entry.name).ending(),
        1 => TableCell::new(time_text(entry.duration_s)),
        2 => share(entry.usable, entry.usable >= 1.0),
        3 => share(entry.played, entry.played <= 0.0),
        4 => count(entry.states),
        5 => count(entry.actions),
        _ => TableCell::new(&entry.tags),
    }
}
