//! Origin of motion: the import report of a motion file, the sources of a bundle.

mod bundle;
mod clip;

pub use bundle::ReportPanelState;

use super::paint::no_bundle;
use crate::command::Commands;
use crate::document::OpenDocument;
use crate::model::Model;
use eframe::egui::{Grid, Label, RichText, ScrollArea, TextWrapMode, Ui};

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut ReportPanelState, commands: &mut Commands) {
    match (&model.document, model.document.bundle()) {
        (OpenDocument::Clip(raw), _) => {
            ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| clip::show(ui, raw, commands));
        }
        (_, Some(bundle)) => bundle::show(ui, bundle, model.generation, state),
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

#[cfg(test)]
mod tests;
