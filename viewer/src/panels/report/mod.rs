//! Origin of motion: the import report of a motion file, the sources of a bundle.

mod clip;

use super::paint::{RowTable, TableCell, TableColumn, TableSort, no_bundle};
use crate::{bundle::OpenBundle, command::Commands, document::OpenDocument, model::Model};
use eframe::egui::{Grid, Label, RichText, ScrollArea, TextEdit, TextWrapMode, Ui};
use std::cmp::Ordering;
use throng_core::format::SourceMeta;
use throng_precompute::memory::bytes_text;

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut ReportPanelState, commands: &mut Commands) {
    match (&model.document, model.document.bundle()) {
        (OpenDocument::Clip(raw), _) => {
            ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| clip::show(ui, raw, commands));
        }
        (_, Some(bundle)) => show_bundle(ui, bundle, model.generation, state),
        (document, None) => no_bundle(ui, document),
    }
}

/// A heading with space above it.
fn section(ui: &mut Ui, title: &str) {
    ui.add_space(8.0);
    ui.label(RichText::new(title).strong().size(15.0));
    ui.add_space(2.0);
}

/// Names and values, the values to be copied.
fn facts<'a>(ui: &mut Ui, id: &str, facts: impl IntoIterator<Item = (&'a str, String)>) {
    Grid::new(id).num_columns(2).spacing([12.0, 3.0]).show(ui, |ui| {
        for (name, value) in facts {
            ui.label(RichText::new(name).weak());
            ui.add(Label::new(value).selectable(true).wrap_mode(TextWrapMode::Wrap));
            ui.end_row();
        }
    });
}

const COLUMNS: [TableColumn<'static>; 3] = [
    TableColumn::text("File", "As the configuration names it", 120.0, 1.0),
    TableColumn::number("Size", "Length of the file", 66.0),
    TableColumn::text("Hash", "XXH3 of its content; click a row to copy path and hash", 84.0, 0.3).spare(1),
];
/// Rows of sources that are seen at once.
const ROWS: usize = 9;

/// Orders of the rows, by column.
const ORDERS: [fn(&SourceMeta, &SourceMeta) -> Ordering; 3] =
    [|a, b| a.path.cmp(&b.path), |a, b| a.bytes.cmp(&b.bytes), |a, b| a.hash.cmp(&b.hash)];

/// State of the panel: that of the list of source files.
#[derive(Clone, Debug, Default)]
pub struct ReportPanelState {
    sort: TableSort,
    /// Document and number of the source that was copied last.
    copied: Option<(u64, usize)>,
}

/// Shows where a bundle comes from.
fn show_bundle(ui: &mut Ui, bundle: &OpenBundle, document: u64, sources: &mut ReportPanelState) {
    let meta = bundle.tables().meta();
    ScrollArea::vertical().id_salt("provenance").auto_shrink([false, false]).show(ui, |ui| {
        section(ui, "Bundle");
        let mirrored = bundle.clips().filter(|c| c.0.mirrored != 0).count();
        let kept = 100.0 * meta.frames_kept as f64 / meta.frames_in.max(1) as f64;
        let all = [
            ("File", bundle.path.display().to_string()),
            ("Name", meta.name.clone()),
            ("Written by", meta.generator.clone()),
            ("Rate", format!("{} Hz", meta.rate_hz)),
            ("Clips", format!("{}, {mirrored} of them mirrored copies", meta.clips.len())),
            ("Usable frames", meta.frames_in.to_string()),
            ("Kept by the graph", format!("{} frames, {kept:.0} %", meta.frames_kept)),
            ("Behaviours", if meta.behaviours.is_empty() { "none".into() } else { meta.behaviours.join(", ") }),
        ];
        facts(ui, "bundle", all);
        source_list(ui, &meta.sources, document, sources);
        config(ui, &meta.config);
    });
}

fn source_list(ui: &mut Ui, sources: &[SourceMeta], document: u64, state: &mut ReportPanelState) {
    let bytes: u64 = sources.iter().map(|s| s.bytes).sum();
    section(ui, &format!("Made from {} files, {}", sources.len(), bytes_text(bytes)));
    if sources.is_empty() {
        return drop(ui.weak("The bundle names no source files: it was made from generated motion."));
    }
    let mut rows: Vec<usize> = (0..sources.len()).collect();
    state.sort.sort(&mut rows, &ORDERS, sources);
    let table = RowTable {
        selected: rows.iter().position(|r| state.copied == Some((document, *r))),
        sort: Some(state.sort),
        most_rows: Some(ROWS),
        ..RowTable::new("sources", &COLUMNS, rows.len())
    };
    let response = table.show(ui, |row, column| {
        let s = &sources[rows[row]];
        match column {
            0 => TableCell::new(&s.path).ending(),
            1 => TableCell::new(bytes_text(s.bytes)),
            _ => TableCell::weak(format!("{:032x}", s.hash)),
        }
    });
    if let Some(source) = response.chosen.map(|row| rows[row]) {
        let s = &sources[source];
        ui.copy_text(format!("{} {:032x}", s.path, s.hash));
        state.copied = Some((document, source));
    }
    state.sort = response.sort.unwrap_or(state.sort);
}

fn config(ui: &mut Ui, toml: &str) {
    ui.add_space(8.0);
    let name = ui.horizontal(|ui| {
        let name = ui.label(RichText::new("Configuration").strong().size(15.0)).id;
        if ui.small_button("Copy").on_hover_text("Copy the configuration").clicked() {
            ui.copy_text(toml.to_owned());
        }
        name
    });
    ScrollArea::both().id_salt("config").max_height(420.0).auto_shrink([false, true]).show(ui, |ui| {
        // Text to select and copy; a borrowed string takes no changes.
        let mut text = toml;
        let edit = TextEdit::multiline(&mut text).code_editor().desired_width(f32::INFINITY);
        ui.add(edit).labelled_by(name.inner);
    });
}

#[cfg(test)]
mod tests;
